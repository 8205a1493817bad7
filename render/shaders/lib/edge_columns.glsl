// Pixels with an edge, by threads of a tile that have a column of four pixels each. After frame.glsl.
layout(set = 0, binding = FL_BINDING_EDGE_MASKS, std430) readonly buffer EdgeMasksBuffer { uint edge_masks[]; };
#define FL_EDGE_COLUMN_ROWS (FL_TILE_PX / 4)

// Those of this thread, a bit each.
uint edges_of_column(uint tile) {
  uint at = tile * uint(FL_EDGE_WORDS) + gl_LocalInvocationID.y * 4u;
  uint bits = 0u;
  for (uint y = 0u; y < 4u; ++y) bits |= (edge_masks[at + y] >> gl_LocalInvocationID.x & 1u) << y;
  return bits;
}
// The pixel of the lowest bit.
ivec2 edge_pixel(uint bits) {
  return ivec2(gl_WorkGroupID.xy * uint(FL_TILE_PX) + gl_LocalInvocationID.xy * uvec2(1u, 4u)) +
         ivec2(0, findLSB(bits));
}
