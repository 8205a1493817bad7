// Rows of a shadow map: all camera rays draw lines in the gobo plane that come from one place, the eye's. A row has the
// places of one such line, in the order in which rays pass them. All rays of a row come from the eye, so where they are
// behind the body at a place depends on one number alone: each place has its least value. After shadow_map_words.glsl,
// beam.h.

// The number is z where the ray's line is nearest the axis (s = 0 of chord_t()), which grows with z everywhere.
struct RowLine {
  float offset;  // of the line from the axis, -1 to 1; 2: the eye is in or near the beam, and there are no rows for it
  float s_from;  // of the chord on it
  float s_to;
  float z_m;
};

// Whether the eye is so far beside the beam, over its radius, that each line through the disc is one row.
bool has_rows(BeamRow row, float times) {
  float w = row.x_axis.w + row.y_axis.w * row.eye.z;
  return dot(row.eye.xy, row.eye.xy) > times * times * w * w;
}
const float kRowsFrom = 1.05;
const float kRowsReadFrom = 1.1;  // so that rounding does not matter

// The least z of a row that its place has a bit for, and what stands for infinity; half floats.
const float kRowFar = 65000.0;
RowLine row_line(BeamRow row, Chord chord, vec3 ray) {
  // The same pictures of the mirrored camera have another eye.
  if (params.mirror_m > 0.0 || !has_rows(row, kRowsReadFrom)) return RowLine(2.0, 0.0, 0.0, 0.0);
  float below = chord.v_length + chord.s_base * chord.w_base * chord.w_slope;
  float t_m = -chord.s_base * chord.w_base * chord.w_base / max(below, 1e-12);
  float z_m = below > 1e-6 * chord.v_length ? chord.base.z + ray.z * t_m : kRowFar;
  return RowLine(chord.offset, chord.s_from, chord.s_to, clamp(z_m, 0.0, kRowFar));
}
// In the order of their bits; 0 stands for places without any light.
uint row_key(float z_m) { return max(packHalf2x16(vec2(clamp(z_m, 0.0, kRowFar), 0.0)) & 0x7fffu, 1u); }
