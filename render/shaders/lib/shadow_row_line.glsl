// Rows of a shadow map: all camera rays draw lines in the gobo plane that come from one place, the eye's. A row has the
// places of one such line, in the order in which rays pass them. All rays of a row come from the eye, so where they are
// behind the body at a place depends on one number alone: each place has its least value. After shadow_map_words.glsl,
// beam.h, tile_test.glsl.

// The number is z where the line enters the disc, which every ray passes. Along a ray z over w is linear in the line's
// places and all rays of a row have the same at the eye, so at each place z grows with this number.
struct RowLine {
  float offset;  // of the line from the axis, -1 to 1; 2: the eye is in or near the beam, and there are no rows for it
  float s_from;  // of the chord on it
  float s_to;
  float z_m;
};
const RowLine kNoRow = RowLine(2.0, 0.0, 0.0, 0.0);

#include "render/shaders/lib/row_eye.glsl"

const float kRowFar = 65000.0;
RowLine row_line_of(Chord chord, vec3 ray) {
  float ds = -sqrt(max(1.0 - chord.offset * chord.offset, 0.0)) - chord.s_base;
  float below = chord.v_length - ds * chord.w_base * chord.w_slope;
  float z_m = chord.base.z + ray.z * ds * chord.w_base * chord.w_base / max(below, 1e-12);
  return RowLine(chord.offset, chord.s_from, chord.s_to, below > 1e-6 * chord.v_length ? z_m : kRowFar);
}
RowLine row_line(BeamRow row, Chord chord, vec3 ray) {
  if (!has_rows(row, kRowsReadFrom)) return kNoRow;
  return row_line_of(chord, ray);
}
// Numbers of 15 bits in the order of z: bits of half floats from 1/64 m on, and below that, which is next to the lens
// and behind it, from 0x23ff down with a fourth of their steps. 0 stands for places without any light.
uint row_key(float z_m) {
  const float kNear = 1.0 / 64.0;
  if (z_m >= kNear) return packHalf2x16(vec2(min(z_m, kRowFar), 0.0)) & 0x7fffu;
  return 0x23ffu - ((packHalf2x16(vec2(min(kNear - z_m, kRowFar), 0.0)) & 0x7fffu) >> 2);
}
