// Records of the light of displays (frame_io.h): where they lie, and their polynomials. After frame.glsl.
layout(constant_id = FL_SPEC_TILES) const bool kTiles = true;  // else each pixel is computed by itself
layout(set = 0, binding = FL_BINDING_DISPLAY_TILES, std430) FL_DISPLAY_TILES_ACCESS buffer DisplayTilesBuffer {
  DisplayTileRow display_tiles[];
};
layout(set = 0, binding = FL_BINDING_DISPLAY_RECORDS, std430) FL_DISPLAY_RECORDS_ACCESS buffer DisplayRecordsBuffer {
  DisplayListsHead display_lists;
  DisplayRecordRow display_records[];
};

// Things that are no planes are taken together with the nearest of them up to so many times its depth.
#define FL_DISPLAY_REST 1.15

uvec2 tiles_of_picture() { return (uvec2(params.width, params.height) + uint(FL_TILE_PX) - 1u) / uint(FL_TILE_PX); }

// The first record of a level.
uint first_of_level(uint level) {
  uint first = 0u;
  for (uint i = 0u; i < level; ++i) first += display_lists.counts[i];
  return first;
}
// A level without room for all of its records has none: which of them came first must not show.
bool has_room(uint level) { return first_of_level(level + 1u) <= uint(display_records.length()); }

uint packed_box(uvec2 low, uvec2 high) { return low.x | low.y << 8 | high.x << 16 | high.y << 24; }
uvec4 unpacked_box(uint box) { return uvec4(box & 255u, box >> 8 & 255u, box >> 16 & 255u, box >> 24); }

const uint kNodes = 16u;  // Chebyshev's, 4 x 4
const float kNodeNear = 0.3826834323650898;
const float kNodeFar = 0.9238795325112867;
float node_at(uint i) { return (i < 2u ? -1.0 : 1.0) * (i == 0u || i == 3u ? kNodeFar : kNodeNear); }
vec2 node_place(uint node) { return vec2(node_at(node & 3u), node_at(node >> 2)); }

// Weights of the values at the nodes; x is between -1 and 1.
vec4 weights_at(float x) {
  const float kFarOver = 1.0 / (2.0 * kNodeFar * (kNodeFar * kNodeFar - kNodeNear * kNodeNear));
  const float kNearOver = 1.0 / (2.0 * kNodeNear * (kNodeFar * kNodeFar - kNodeNear * kNodeNear));
  float near = (x * x - kNodeNear * kNodeNear) * kFarOver;
  float far = (x * x - kNodeFar * kNodeFar) * kNearOver;
  return vec4(-near * (x - kNodeFar), far * (x - kNodeNear), -far * (x + kNodeNear), near * (x + kNodeFar));
}
