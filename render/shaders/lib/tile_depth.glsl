// Distances of the surfaces in a rectangle of the picture, from one row for each tile of 16 x 16 pixels (depths.comp).
// FL_DEPTHS_READ: the including pass reads the rows. kSolids: whether the picture has anything solid; without it,
// nothing ends a ray.
layout(set = 0, binding = FL_BINDING_TILE_DEPTHS, std430) FL_DEPTHS_ACCESS buffer TileDepthsBuffer {
  TileDepthRow tile_depths[];
};

// How far a plane may be from the pixels of one tile, and of several, as a share of 1 / depth.
const float kPlaneSlack = 2e-5;

struct RectDepth {
  float near_m;  // along the ray; FL_FAR_M where nothing is
  float far_m;
  bool is_plane;     // one plane, or nothing, over all of the rectangle
  vec2 origin;       // pixels
  vec3 per_depth_m;  // 1 / depth at the origin, and its change a pixel to the right and down, 1/m
};

// Distance along the ray through a place of the picture. ray: ray_through() there.
float plane_distance(RectDepth depth, vec2 p, float ray_length) {
  vec2 from = p - depth.origin;
  float inverse = depth.per_depth_m.x + depth.per_depth_m.y * from.x + depth.per_depth_m.z * from.y;
  return inverse > 1e-20 ? min(ray_length / inverse, FL_FAR_M) : FL_FAR_M;
}

uint tiles_across() { return (params.width + uint(FL_TILE_PX) - 1u) / uint(FL_TILE_PX); }

#ifdef FL_DEPTHS_READ
// Of side x side tiles, the first one given; tiles outside the picture do not count.
RectDepth rect_depth(uvec2 first, uint side) {
  RectDepth depth = RectDepth(FL_FAR_M, FL_FAR_M, true, vec2(0.0), vec3(0.0));
  if (!kSolids) return depth;
  uvec2 count = uvec2(tiles_across(), (params.height + uint(FL_TILE_PX) - 1u) / uint(FL_TILE_PX));
  uvec2 end = min(first + side, count);
  depth.far_m = 0.0;
  // The plane through the middles of the corner tiles, which keeps the error of a far tile small.
  uvec2 last = end - 1u;
  TileDepthRow corner = tile_depths[first.y * count.x + first.x];
  TileDepthRow right = tile_depths[first.y * count.x + last.x];
  TileDepthRow below = tile_depths[last.y * count.x + first.x];
  vec2 step = vec2(last - first) * float(FL_TILE_PX);
  depth.origin = (vec2(first) + 0.5) * float(FL_TILE_PX);
  depth.per_depth_m.x = corner.plane.x;
  depth.per_depth_m.y = step.x > 0.0 ? (right.plane.x - corner.plane.x) / step.x : corner.plane.y;
  depth.per_depth_m.z = step.y > 0.0 ? (below.plane.x - corner.plane.x) / step.y : corner.plane.z;
  const float reach = 0.5 * float(FL_TILE_PX);
  for (uint y = first.y; y < end.y; ++y) {
    for (uint x = first.x; x < end.x; ++x) {
      TileDepthRow tile = tile_depths[y * count.x + x];
      depth.near_m = min(depth.near_m, tile.near_m);
      depth.far_m = max(depth.far_m, tile.far_m);
      vec2 away = vec2(uvec2(x, y) - first) * float(FL_TILE_PX);
      float off = abs(depth.per_depth_m.x + dot(depth.per_depth_m.yz, away) - tile.plane.x) +
                  reach * (abs(depth.per_depth_m.y - tile.plane.y) + abs(depth.per_depth_m.z - tile.plane.z));
      depth.is_plane = depth.is_plane && tile.is_plane != 0u && off <= 2.0 * kPlaneSlack * abs(tile.plane.x);
    }
  }
  return depth;
}
#endif
