// The pixels with an edge of the workgroup's tile, in the order of their samples. After frame.glsl and edge_masks.
shared uint masks[FL_TILE_PX];                     // the words of its rows
shared uint edge_pixels[FL_TILE_PX * FL_TILE_PX];  // y * FL_TILE_PX + x

// With all threads, and a barrier after it. words: where the tile's are.
void load_edge_masks(uint words) {
  uint own = gl_LocalInvocationIndex;
  if (own < FL_TILE_PX) masks[own] = edge_masks[words + own];
}
uint edge_pixel_count() {
  uint last = masks[FL_TILE_PX - 1];
  return (last >> 16) + uint(bitCount(last & 0xffffu));
}
// With all threads, and a barrier after it.
void list_edge_pixels() {
  for (uint i = gl_LocalInvocationIndex; i < FL_TILE_PX * FL_TILE_PX; i += FL_GROUP_EDGES) {
    uint word = masks[i / FL_TILE_PX];
    uint bit = 1u << (i % FL_TILE_PX);
    if ((word & bit) != 0u) edge_pixels[(word >> 16) + uint(bitCount(word & (bit - 1u)))] = i;
  }
}
