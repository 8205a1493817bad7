// Polynomials of light, added to the pixels of a workgroup. After tile_sum.glsl and tile_pixels.glsl.

// Adds a polynomial of light over a hull whose middle is `from` from the group's middle.
void add_light(vec3 light[16], vec2 from, float half_px, inout vec3 total[FL_ROWS]) {
  vec2 first_px = first_place();
  vec4 tx = chebyshev((first_px.x - from.x) / half_px);
  vec3 rows[4];
  [[unroll]] for (int n = 0; n < 4; ++n) {
    rows[n] = light[4 * n] * tx.x + light[4 * n + 1] * tx.y + light[4 * n + 2] * tx.z + light[4 * n + 3] * tx.w;
  }
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
    vec4 ty = chebyshev((first_px.y + float(i) - from.y) / half_px);
    total[i] += rows[0] * ty.x + rows[1] * ty.y + rows[2] * ty.z + rows[3] * ty.w;
  }
}

// The polynomial that sum_light() has left, over the group's own pixels.
void add_group_light(inout vec3 total[FL_ROWS]) {
  vec3 light[16];
  [[unroll]] for (int k = 0; k < 16; ++k) {
    light[k] = vec3(group_light[3 * k], group_light[3 * k + 1], group_light[3 * k + 2]);
  }
  add_light(light, vec2(0.0), FL_HULL * 0.5 * float(FL_FINE_PX), total);
}
