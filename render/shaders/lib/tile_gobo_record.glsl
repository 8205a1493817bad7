// A beam with an image in a tile whose chords all cross the whole disc: V and rho of the eye give the line in the image
// at each pixel, quadratics g, and the table of whole chords does the rest. After tile_surfaces.glsl, tile_record.glsl
// and tile_gobo.glsl.

// g is fitted with few nodes, and the eye is not so near the plane of the beam's apex that float loses the line: a
// distance of the image's radius times 1e3 leaves 1e-4 of it.
bool gobo_known(BeamRow row) {
  return kNodes <= 3u && length(row.eye.xy) < 1e3 * abs(row.x_axis.w + row.y_axis.w * row.eye.z);
}

#ifdef FL_GOBO_TILES
const bool kGoboTiles = true;
#include "render/shaders/lib/gobo_whole.glsl"

// V along the image's x, of 1, x, y, and x of rho of the eye; the same of y; the table's first layer, plus 1, and its
// planes. surface: surface_rows().
PlaceRows gobo_rows(BeamRow row, PlaceRows surface) {
  vec4 across = surface.of[0];
  vec4 down = surface.of[1];
  vec4 radius = surface.of[2];
  vec3 v_x = across.xyz * radius.w - across.w * radius.xyz;
  vec3 v_y = down.xyz * radius.w - down.w * radius.xyz;
  vec2 eye = vec2(across.w, down.w) / radius.w;
  GoboImage only = gobo_only_image(row);
  vec2 turn = only.turn;
  PlaceRows rows;
  rows.of[0] = vec4(turn.x * v_x + turn.y * v_y, turn.x * eye.x + turn.y * eye.y);
  rows.of[1] = vec4(turn.x * v_y - turn.y * v_x, turn.x * eye.y - turn.y * eye.x);
  rows.of[2] = vec4(float(gobo_whole_layer(row, only)), float(gobo_tables[only.image - 1u].planes), 0.0, 0.0);
  return rows;
}

// The light over the beam's colour. columns: rho, g_0, g_1, g_2. y: 1, T_1, T_2 of the row.
vec3 record_gobo(PlaceRows rows, CutColumns columns, float x, vec3 y) {
  vec2 v = vec2(rows.of[0].x + rows.of[0].y * x + rows.of[0].z * y.y,
                rows.of[1].x + rows.of[1].y * x + rows.of[1].z * y.y);
  v *= inversesqrt(max(dot(v, v), 1e-30));
  float offset = rows.of[0].w * v.y - rows.of[1].w * v.x;
  float q = 1.0 - offset * offset;
  if (!(q > 0.0)) return vec3(0.0);
  float c = sqrt(q);
  // The nodes lie at s = c y, y = -outer, -inner, inner, outer.
  const vec2 kAt = vec2(0.8611363115940526, 0.3399810435848563);
  vec3 g = vec3(dot(columns.of[1], y), dot(columns.of[2], y), dot(columns.of[3], y));
  vec2 even = g.x + q * g.z * kAt * kAt;
  vec2 odd = c * g.y * kAt;
  vec4 w = vec4(even - odd, even.yx + odd.yx);
  return 2.0 * c * gobo_whole_mean(uint(rows.of[2].x), uint(rows.of[2].y), offset, v, w);
}
#else
const bool kGoboTiles = false;
PlaceRows gobo_rows(BeamRow row, PlaceRows surface) { return surface; }
vec3 record_gobo(PlaceRows rows, CutColumns columns, float x, vec3 y) { return vec3(0.0); }
#endif
