// The walk of one workgroup over the beams that can touch its tile of 16 x 16 pixels, in patch order:
//
//   for (uint base = 0u; base < counts.live_count; base += FL_WALK_BEAMS) {
//     if (!tile_walk(base)) continue;
//     FL_WALK_BEGIN(base, index) ... beams[index] ... FL_WALK_END
//   }
//
// tile_walk() puts 256 beams of the supertile's mask to the test of the including pass, bool tile_takes(uint beam, uint
// number), shared out among the threads; `number` counts from `base`. FL_WALK_ALSO(word): a word of bits of further
// beams. FL_WALK_BITS(word): a word of the beams that FL_WALK_BEGIN takes.
// All threads of the group must call it together; it returns the same for all.
//
// A thread has FL_ROWS pixels, one below the other, so that a beam's row is read once for all of them: on an H200
// 10,000 beams at 3840 x 2160 take 45 ms with one pixel a thread, 41 ms with four (3 nodes). The including pass
// declares its workgroup as FL_TILE_PX x FL_TILE_PX / FL_ROWS.
#ifndef FL_ROWS
#define FL_ROWS 4
#endif
#define FL_WALK_BEAMS 256u
shared uint walk_bits[8];

// Pixel number i of this thread, 0 to FL_ROWS - 1.
ivec2 tile_pixel(int i) {
  return ivec2(gl_WorkGroupID.xy * uint(FL_TILE_PX)) + ivec2(gl_LocalInvocationID.xy) +
         ivec2(0, i * (FL_TILE_PX / FL_ROWS));
}
bool in_picture(ivec2 pixel) { return pixel.x < int(params.width) && pixel.y < int(params.height); }

// A word of the masks that are walked: those of tiles of FL_FINE_PX where FL_WALK_FINE is true, else of supertiles.
#ifdef FL_USE_FINE_MASKS
uint walk_mask(uint word) { return FL_WALK_FINE ? fine_masks[word] : masks[word]; }
#else
#define FL_WALK_FINE false
uint walk_mask(uint word) { return masks[word]; }
#endif
#ifndef FL_WALK_ALSO
#define FL_WALK_ALSO(word) 0u
#endif
#ifndef FL_WALK_BITS
#define FL_WALK_BITS(word) walk_bits[word]
#endif

// The number of that word, of beams word * 32 and the following.
uint walk_word(uint word) {
  uint side = FL_WALK_FINE ? uint(FL_FINE_PX) : uint(FL_SUPERTILE_PX);
  uvec2 cell = gl_WorkGroupID.xy / (side / uint(FL_TILE_PX));
  uint across = FL_WALK_FINE ? (params.width + side - 1u) / side : params.supertiles_x;
  return (cell.y * across + cell.x) * params.mask_words + word;
}

bool tile_walk(uint base) {
  uint lane = gl_LocalInvocationIndex;
  uint first = walk_word(base / 32u);
  uint words = min((counts.live_count - base + 31u) / 32u, 8u);
  uint any = 0u;
  for (uint w = 0u; w < words; ++w) any |= walk_mask(first + w) | FL_WALK_ALSO(base / 32u + w);
  if (any == 0u) return false;
  barrier();  // the walk before this one has been read by all
  if (lane < 8u) walk_bits[lane] = 0u;
  barrier();
  for (uint at = lane; at < FL_WALK_BEAMS; at += uint(FL_TILE_PX * FL_TILE_PX / FL_ROWS)) {
    uint beam = base + at;
    if (beam >= counts.live_count) continue;
    uint bits = walk_mask(first + (at >> 5)) | FL_WALK_ALSO(beam >> 5);
    if ((bits & (1u << (at & 31u))) != 0u) {
      if (tile_takes(beam, at)) atomicOr(walk_bits[at >> 5], 1u << (at & 31u));
    }
  }
  barrier();
  return true;
}

// The word is made uniform over the subgroup: compilers then keep its threads together through the loop.
#define FL_WALK_BEGIN(base, index)                                 \
  for (uint walk_w = 0u; walk_w < 8u; ++walk_w) {                  \
    uint walk_rest = subgroupBroadcastFirst(FL_WALK_BITS(walk_w)); \
    while (walk_rest != 0u) {                                      \
      uint index = base + walk_w * 32u + uint(findLSB(walk_rest)); \
      walk_rest &= walk_rest - 1u;
#define FL_WALK_END }}
