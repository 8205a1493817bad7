// Sizes of the passes that follow, for so many beams. After frame.glsl with FL_USE_COUNTS.
void write_beam_counts(uint live) {
  uint supertiles_y = (params.height + uint(FL_SUPERTILE_PX) - 1u) / uint(FL_SUPERTILE_PX);
  counts.live_count = live;
  counts.tiles_groups[0] = (live + uint(FL_GROUP_MASK) - 1u) / uint(FL_GROUP_MASK);
  const uint kBlock = uint(FL_BLOCK_SUPERTILES);
  counts.tiles_groups[1] = (params.supertiles_x + kBlock - 1u) / kBlock * ((supertiles_y + kBlock - 1u) / kBlock);
  counts.tiles_groups[2] = 1u;
  bool any = live > 0u;
  counts.beams_groups[0] = any ? (params.width + uint(FL_TILE_PX) - 1u) / uint(FL_TILE_PX) : 0u;
  counts.beams_groups[1] = any ? (params.height + uint(FL_TILE_PX) - 1u) / uint(FL_TILE_PX) : 0u;
  counts.beams_groups[2] = 1u;
  bool tiles = any && live >= params.tile_beams;
  counts.depths_groups[0] = tiles ? counts.beams_groups[0] : 0u;
  counts.depths_groups[1] = tiles ? counts.beams_groups[1] : 0u;
  counts.depths_groups[2] = 1u;
  counts.fine_groups[0] = tiles ? (params.width + uint(FL_FINE_PX) - 1u) / uint(FL_FINE_PX) : 0u;
  counts.fine_groups[1] = tiles ? (params.height + uint(FL_FINE_PX) - 1u) / uint(FL_FINE_PX) : 0u;
  counts.fine_groups[2] = 1u;
  counts.coarse_groups[0] = tiles ? params.supertiles_x : 0u;
  counts.coarse_groups[1] = tiles ? supertiles_y : 0u;
  counts.coarse_groups[2] = 1u;
  counts.shadow_groups[0] = min(live, uint(FL_SHADOWS_X));
  counts.shadow_groups[1] = (live + uint(FL_SHADOWS_X) - 1u) / uint(FL_SHADOWS_X);
  counts.shadow_groups[2] = 1u;
}
