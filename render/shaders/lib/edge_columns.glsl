// Pixels with an edge, by threads of a tile that have a column of four pixels each. After frame.glsl.
layout(set = 0, binding = FL_BINDING_EDGE_MASKS, std430) readonly buffer EdgeMasksBuffer { uint edge_masks[]; };
#define FL_EDGE_COLUMN_ROWS (FL_TILE_PX / 4)

// Those of this thread: 0 and 16 are bits of the first of two words, 1 and 17 those of the second.
uint edges_of_column(uint tile) {
  uint at = tile * uint(FL_EDGE_WORDS) + gl_LocalInvocationID.y * 2u;
  uint column = gl_LocalInvocationID.x;
  return (edge_masks[at] >> column & 0x10001u) | (edge_masks[at + 1u] >> column & 0x10001u) << 1;
}
// The pixel of the lowest bit. first_row: of the workgroups' tiles.
ivec2 edge_pixel(uint bits, int first_row) {
  uint bit = uint(findLSB(bits));
  uvec2 first = gl_WorkGroupID.xy * uint(FL_TILE_PX) + gl_LocalInvocationID.xy * uvec2(1u, 4u);
  return ivec2(first + uvec2(0u, (bit & 1u) * 2u + (bit >> 4))) + ivec2(0, first_row);
}
