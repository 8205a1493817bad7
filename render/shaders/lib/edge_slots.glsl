// Where the samples of a pixel with an edge are. After frame.glsl.
layout(set = 0, binding = FL_BINDING_EDGE_MASKS, std430) readonly buffer EdgeMasksBuffer { uint edge_masks[]; };

// Its words are FL_EDGE_WORDS from there on.
uint words_of_tile(uvec2 tile) {
  uint tiles_x = (params.width + uint(FL_TILE_PX - 1)) / uint(FL_TILE_PX);
  return (tile.y * tiles_x + tile.x) * FL_EDGE_WORDS;
}
// Of a pixel in column x of a tile: its number among those with samples. word: of its row.
uint edge_slot(uint words, uint word, uint x) {
  return edge_masks[words + FL_TILE_PX] + (word >> 16) + uint(bitCount(word & ((1u << x) - 1u)));
}
