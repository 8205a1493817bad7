// What follows for beams from the camera and the size of its picture. After tile_test.glsl, with FL_USE_COUNTS.

#include "render/shaders/lib/row_eye.glsl"

// Whether the beam is drawn wider than it is at some place (lib/thin.glsl). The distance of a place is convex along the
// axis and the radius is linear, so an end decides. A tenth is for the softest profile.
bool thin_somewhere(BeamRow beam) {
  float reach = 1.1 * params.thin * beam_stretch(beam.squeeze);
  float range_m = beam.axis.w;
  return reach * length(beam.eye.xyz) > beam.x_axis.w ||
         reach * length(beam.eye.xyz - vec3(0.0, 0.0, range_m)) > beam.x_axis.w + beam.y_axis.w * range_m;
}

// The flags of a beam that follow from the camera beside the others that it has.
uint view_flags(BeamRow beam) {
  uint flags = beam.flags & ~(FL_BEAM_THIN | FL_BEAM_ROWS);
  bool plain = (flags & FL_BEAM_PLAIN) != 0u;
  if (thin_somewhere(beam)) flags |= FL_BEAM_THIN;
  if (plain && beam.y_axis.w <= kSeriesSpread && has_rows(beam, kRowsReadFrom)) flags |= FL_BEAM_ROWS;
  return flags;
}

// The indirect arguments of the passes that follow. live: beams.
void set_view_groups(uint live) {
  uint supertiles_y = (params.height + uint(FL_SUPERTILE_PX) - 1u) / uint(FL_SUPERTILE_PX);
  counts.tiles_groups[0] = (live + uint(FL_GROUP_MASK) - 1u) / uint(FL_GROUP_MASK);
  const uint kBlock = uint(FL_BLOCK_SUPERTILES);
  counts.tiles_groups[1] = (params.supertiles_x + kBlock - 1u) / kBlock * ((supertiles_y + kBlock - 1u) / kBlock);
  counts.tiles_groups[2] = 1u;
  bool any = live > 0u;
  counts.beams_groups[0] = any ? (params.width + uint(FL_TILE_PX) - 1u) / uint(FL_TILE_PX) : 0u;
  counts.beams_groups[1] = any ? (params.height + uint(FL_TILE_PX) - 1u) / uint(FL_TILE_PX) : 0u;
  counts.beams_groups[2] = 1u;
  bool tiles = any && live >= params.tile_beams;
  counts.depths_groups[0] = tiles ? counts.beams_groups[0] : 0u;
  counts.depths_groups[1] = tiles ? counts.beams_groups[1] : 0u;
  counts.depths_groups[2] = 1u;
  counts.fine_groups[0] = tiles ? (params.width + uint(FL_FINE_PX) - 1u) / uint(FL_FINE_PX) : 0u;
  counts.fine_groups[1] = tiles ? (params.height + uint(FL_FINE_PX) - 1u) / uint(FL_FINE_PX) : 0u;
  counts.fine_groups[2] = 1u;
  counts.coarse_groups[0] = tiles ? params.supertiles_x : 0u;
  counts.coarse_groups[1] = tiles ? supertiles_y : 0u;
  counts.coarse_groups[2] = 1u;
}
