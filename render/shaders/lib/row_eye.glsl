// From where the rows of a beam's shadow map can be read (shadow_row_line.glsl). After tile_test.glsl.

// Whether the eye is so far beside the beam, over its radius, that each line through the disc is one row. Thin
// rectangles are drawn in a space of their own (thin.glsl).
bool has_rows(BeamRow row, float times) {
  float w = row.x_axis.w + row.y_axis.w * row.eye.z;
  if (row.squeeze > 0.0 && beam_thin(row) > 0.0) return false;
  return dot(row.eye.xy, row.eye.xy) > times * times * w * w;
}
const float kRowsFrom = 1.05;
const float kRowsReadFrom = 1.1;  // so that rounding does not matter
// Wider beams change too much along a chord for light at nodes of the whole chord.
const float kSeriesSpread = 0.6;
