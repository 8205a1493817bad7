// The walk of one workgroup (16 x 16 pixels) over the beams that can touch its tile, in patch order:
//
//   for (uint base = 0u; base < counts.live_count; base += FL_WALK_BEAMS) {
//     if (!tile_walk(base)) continue;
//     FL_WALK_BEGIN(base, index) ... beams[index] ... FL_WALK_END
//   }
//
// tile_walk() puts 256 beams of the supertile's mask to the test of the including pass, bool tile_touches(BeamRow), one a
// thread. All threads of the group must call it together; it returns the same for all.
#define FL_WALK_BEAMS 256u
shared uint walk_bits[8];

bool tile_walk(uint base) {
  uint lane = gl_LocalInvocationIndex;
  uvec2 cell = gl_WorkGroupID.xy / uint(FL_SUPERTILE_PX / FL_TILE_PX);
  uint supertile = cell.y * params.supertiles_x + cell.x;
  uint first = supertile * params.mask_words + base / 32u;
  uint words = min((counts.live_count - base + 31u) / 32u, 8u);
  uint any = 0u;
  for (uint w = 0u; w < words; ++w) any |= masks[first + w];
  if (any == 0u) return false;
  barrier();  // the walk before this one has been read by all
  if (lane < 8u) walk_bits[lane] = 0u;
  barrier();
  uint beam = base + lane;
  if (beam < counts.live_count && (masks[first + (lane >> 5)] & (1u << (lane & 31u))) != 0u) {
    if (tile_touches(beams[beam])) atomicOr(walk_bits[lane >> 5], 1u << (lane & 31u));
  }
  barrier();
  return true;
}

#define FL_WALK_BEGIN(base, index)                         \
  for (uint walk_w = 0u; walk_w < 8u; ++walk_w) {          \
    uint walk_rest = walk_bits[walk_w];                    \
    while (walk_rest != 0u) {                              \
      uint index = base + walk_w * 32u + uint(findLSB(walk_rest)); \
      walk_rest &= walk_rest - 1u;
#define FL_WALK_END }}
