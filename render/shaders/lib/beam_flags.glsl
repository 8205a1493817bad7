// What a beam row says of itself (FL_BEAM_...). After beam.h.

// Whether tile_node() of shared/tile_node.h has its light.
bool is_plain(BeamRow beam) {
  bool gobo = (beam.gobo | beam.gobo_2 | beam.animation) != 0u || beam.offset_1 != 0.0 || beam.offset_2 != 0.0;
  return !gobo && (beam.flags & FL_BEAM_BLADES) == 0u && beam.j0.w == 0.0 && beam.measured == 0u &&
         beam.squeeze == 0.0 && beam.y_axis.w <= kWideSpread;
}

// A beam without anything in it.
void open_beam(inout BeamRow beam) {
  beam.gobo = 0u;
  beam.gobo_cos = 1.0;
  beam.gobo_sin = 0.0;
  beam.gobo_2 = 0u;
  beam.gobo_2_cos = 1.0;
  beam.gobo_2_sin = 0.0;
  beam.gobo_scale = 1.0;
  beam.gobo_blur = 0.0;
  beam.flags = 0u;
  beam.next_1 = 0u;
  beam.next_2 = 0u;
  beam.offset_1 = 0.0;
  beam.offset_2 = 0.0;
  beam.focus = -1.0;
  beam.animation = 0u;
  beam.animation_cos = 1.0;
  beam.animation_sin = 0.0;
}
