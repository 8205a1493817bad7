// Which stage boxes a tile of FL_TILE_PX x FL_TILE_PX pixels may show. After frame.glsl.
const float kHalfTile = 0.5 * float(FL_TILE_PX);

// Whether a ray of the tile's pixels may meet a box; never false where one does.
bool may_show(ivec2 low, vec3 box_low, vec3 box_high) {
  vec2 size = vec2(float(params.width), float(params.height));
  vec2 middle = (vec2(low) + kHalfTile) * vec2(2.0, -2.0) / size + vec2(-1.0, 1.0);
  vec2 half_tile = (kHalfTile + 0.01) * 2.0 / size;
  vec3 across = params.right.xyz / dot(params.right.xyz, params.right.xyz);
  vec3 up = params.up.xyz / dot(params.up.xyz, params.up.xyz);
  vec3 ahead = params.forward.xyz;
  vec3 from = 0.5 * (box_low + box_high) - params.position.xyz;
  // What float may lose of a difference.
  vec3 half_box = 0.5 * (box_high - box_low) * 1.00001 + 1e-6 * (abs(from) + abs(params.position.xyz));
  float depth = dot(from, ahead);
  float nearest = depth + dot(half_box, abs(ahead));  // the farthest corner, which is nearest to being in the picture
  // In the space of rays through the tile's middle: x - middle times depth, which the tile bounds by its half size.
  vec3 to_x = across - ahead * middle.x;
  vec3 to_y = up - ahead * middle.y;
  vec2 at = vec2(dot(from, to_x), dot(from, to_y));
  vec2 reach = vec2(dot(half_box, abs(to_x)), dot(half_box, abs(to_y))) + half_tile * (nearest - depth);
  return nearest > 0.0 && all(lessThanEqual(-half_tile * depth, at + reach)) &&
         all(lessThanEqual(at - reach, half_tile * depth));
}
