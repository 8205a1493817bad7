// Records: quadratics over a rectangle of pixels, 6 coefficients of 1, T_1(x), T_1(y), T_2(x), T_1(x) T_1(y), T_2(y), x
// and y from -1 to 1 over the hull. low: the first four; high: the others.

// Along a column of pixels: 1, T_1(y), T_2(y). x2: T_2(x).
vec3 record_column(vec4 low, vec2 high, float x, float x2) {
  return vec3(low.x + x * low.y + x2 * low.w, low.z + x * high.x, high.y);
}
// Whether rho can be in -1..1 within `reach` of a place.
bool record_reaches(vec4 low, vec2 high, vec2 at, vec2 reach) {
  vec2 second = 2.0 * at * at - 1.0;
  float value = low.x + low.y * at.x + low.z * at.y + low.w * second.x + high.x * at.x * at.y + high.y * second.y;
  vec2 slope = vec2(low.y + 4.0 * at.x * low.w + at.y * high.x, low.z + 4.0 * at.y * high.y + at.x * high.x);
  float bend = 2.0 * (abs(low.w) * reach.x * reach.x + abs(high.y) * reach.y * reach.y) +
               abs(high.x) * reach.x * reach.y;
  return abs(value) < 1.0 + dot(abs(slope), reach) + bend;
}
// The light of a beam with a rim, over its colour. rho, h: columns; y: 1, T_1, T_2 of the row.
float record_rim(vec3 rho, vec3 h, vec3 y, float power) {
  float r = dot(rho, y);
  float q = max(1.0 - r * r, 0.0);
  return dot(h, y) * (kProfile ? rim_factor(q, power) : q * sqrt(q));
}
// The light of a beam that something cuts, over its colour. Columns of rho, g_0, g_1, g_2, s_a and s_b.
struct CutColumns {
  vec3 of[6];
};
float record_cut(CutColumns columns, vec3 y) {
  float r = dot(columns.of[0], y);
  vec3 moments = cut_moments(max(1.0 - r * r, 0.0), dot(columns.of[4], y), dot(columns.of[5], y));
  return dot(moments, vec3(dot(columns.of[1], y), dot(columns.of[2], y), dot(columns.of[3], y)));
}
