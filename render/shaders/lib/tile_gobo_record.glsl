// A beam with an image in a tile whose chords all cross the whole disc: V and rho of the eye give the line in the image
// at each pixel, quadratics g, and the table of whole chords does the rest. After tile_surfaces.glsl, tile_record.glsl
// and tile_gobo.glsl.

// g is fitted with few nodes, and the eye is not so near the plane of the beam's apex that float loses the line: a
// distance of the image's radius times 1e3 leaves 1e-4 of it.
bool gobo_known(BeamRow row) {
  return kNodes <= 3u && length(row.eye.xy) < 1e3 * abs(row.x_axis.w + row.y_axis.w * row.eye.z);
}

#ifdef FL_GOBO_TILES
#include "render/shaders/lib/gobo_whole.glsl"

struct GoboRecord {
  vec4 across;  // V along the image's x, of 1, x, y; x of rho of the eye
  vec4 down;    // the same of y
  vec4 table;   // first layer, plus 1; planes
};
GoboRecord gobo_record(BeamRow row, SurfaceEnd end) {
  vec3 v_x = end.of[0].xyz * end.of[2].w - end.of[0].w * end.of[2].xyz;
  vec3 v_y = end.of[1].xyz * end.of[2].w - end.of[1].w * end.of[2].xyz;
  vec2 eye = vec2(end.of[0].w, end.of[1].w) / end.of[2].w;
  GoboImage only = gobo_only_image(row);
  vec2 turn = only.turn;
  GoboRecord record;
  record.across = vec4(turn.x * v_x + turn.y * v_y, turn.x * eye.x + turn.y * eye.y);
  record.down = vec4(turn.x * v_y - turn.y * v_x, turn.x * eye.y - turn.y * eye.x);
  record.table = vec4(float(gobo_whole_layer(row, only)), float(gobo_tables[only.image - 1u].planes), 0.0, 0.0);
  return record;
}

// The light over the beam's colour. columns: rho, g_0, g_1, g_2. y: 1, T_1, T_2 of the row.
vec3 record_gobo(GoboRecord record, CutColumns columns, float x, vec3 y) {
  vec2 v = vec2(record.across.x + record.across.y * x + record.across.z * y.y,
                record.down.x + record.down.y * x + record.down.z * y.y);
  v *= inversesqrt(max(dot(v, v), 1e-30));
  float offset = record.across.w * v.y - record.down.w * v.x;
  float q = 1.0 - offset * offset;
  if (!(q > 0.0)) return vec3(0.0);
  float c = sqrt(q);
  // The nodes lie at s = c y, y = -outer, -inner, inner, outer.
  const vec2 kAt = vec2(0.8611363115940526, 0.3399810435848563);
  vec3 g = vec3(dot(columns.of[1], y), dot(columns.of[2], y), dot(columns.of[3], y));
  vec2 even = g.x + q * g.z * kAt * kAt;
  vec2 odd = c * g.y * kAt;
  vec4 w = vec4(even - odd, even.yx + odd.yx);
  return 2.0 * c * gobo_whole_mean(uint(record.table.x), uint(record.table.y), offset, v, w);
}
#endif
