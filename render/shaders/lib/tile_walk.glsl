// The walk of one workgroup over the beams that can touch its tile of 16 x 16 pixels, in patch order:
//
//   for (uint word = 0u; word < walk_words();) {
//     word = tile_walk(word);
//     FL_WALK_BEGIN(number, index, walk_bits[walk_w]) ... beams[index] ... FL_WALK_END
//   }
//
// tile_walk() lists up to FL_WALK_BEAMS beams of the masks from a word on, and puts them to the test of the including
// pass, bool tile_takes(uint beam, uint number), shared out among the threads; `number` is the beam's place in the
// list. It returns the word after those that it has listed. FL_WALK_ALSO(word): a word of bits of further beams.
// All threads of the group must call it together; it returns the same for all. FL_WALK_BEGIN takes the places of which
// its last argument has bits: words for walk_w from 0 on. Beams of different kinds have loops of their own, and words
// behind the list are not looked at: Mesa's lavapipe runs both sides of a branch, and the body of a loop that has no
// round once.
//
// A thread has FL_ROWS pixels, one below the other, so that a beam's row is read once for all of them: on an H200
// 10,000 beams at 3840 x 2160 take 45 ms with one pixel a thread, 41 ms with four (3 nodes). The including pass
// declares its workgroup as FL_TILE_PX x FL_TILE_PX / FL_ROWS.
#ifndef FL_ROWS
#define FL_ROWS 4
#endif
#define FL_WALK_BEAMS 256u
shared uint walk_bits[8];
shared uint walk_kind[8];  // what tile_takes() has set
shared uint walk_ids[FL_WALK_BEAMS];
shared uint walk_count;
shared uint walk_next;
const uint kThreads = uint(FL_TILE_PX * FL_TILE_PX / FL_ROWS);
shared uint walk_sums[kThreads / 4u];  // of subgroups

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

// The number of that word, of beams word * 32 and the following.
uint walk_word(uint word) {
  uint side = FL_WALK_FINE ? uint(FL_FINE_PX) : uint(FL_SUPERTILE_PX);
  uvec2 cell = gl_WorkGroupID.xy / (side / uint(FL_TILE_PX));
  uint across = FL_WALK_FINE ? (params.width + side - 1u) / side : params.supertiles_x;
  return (cell.y * across + cell.x) * params.mask_words + word;
}

uint walk_words() { return (counts.live_count + 31u) / 32u; }
uint walk_listed(uint first, uint word) { return walk_mask(first + word) | FL_WALK_ALSO(word); }

// In the order of subgroups, which gl_LocalInvocationIndex need not be.
uint walk_lane() { return gl_SubgroupID * gl_SubgroupSize + gl_SubgroupInvocationID; }

// The sum of `own` of all threads before this one, and of all. Called by all threads of the group together.
uint walk_before(uint own, out uint all) {
  uint before = subgroupExclusiveAdd(own);
  if (gl_SubgroupInvocationID == gl_SubgroupSize - 1u) walk_sums[gl_SubgroupID] = before + own;
  barrier();
  all = 0u;
  for (uint s = 0u; s < gl_NumSubgroups; ++s) {
    if (s < gl_SubgroupID) before += walk_sums[s];
    all += walk_sums[s];
  }
  return before;
}

// Lists all beams where there are no more than a list holds, a thread each.
void walk_list_few() {
  uint lane = walk_lane();
  uint words = walk_words();
  uint first = walk_word(0u);
  barrier();  // the list before this one has been read by all
  if (lane < 8u) walk_bits[lane] = walk_kind[lane] = 0u;
  uint all = 0u;
  [[dont_unroll]] for (uint word = 0u; word < words; ++word) {
    uint bits = walk_listed(first, word);
    uint bit = lane & 31u;
    if ((lane >> 5) == word % (kThreads / 32u) && (bits >> bit & 1u) != 0u) {
      walk_ids[all + uint(bitCount(bits & ((1u << bit) - 1u)))] = word * 32u + bit;
    }
    all += uint(bitCount(bits));
  }
  if (lane == 0u) {
    walk_count = all;
    walk_next = words;
  }
  barrier();
}

// Lists beams of as many whole words as fit. Each thread reads words beside each other.
void walk_list(uint from) {
  uint lane = walk_lane();
  uint words = walk_words();
  uint first = walk_word(0u);
  uint per = clamp((words - from + kThreads - 1u) / kThreads, 1u, 8u);
  uint begin = from + lane * per;
  uint end = min(begin + per, words);
  uint own = 0u;
  for (uint word = begin; word < end; ++word) own += uint(bitCount(walk_listed(first, word)));
  barrier();  // the list before this one has been read by all
  if (lane == 0u) {
    walk_count = 0u;
    walk_next = from;
  }
  if (lane < 8u) walk_bits[lane] = walk_kind[lane] = 0u;
  uint all;
  uint slot = walk_before(own, all);
  uint next = from;
  for (uint word = begin; word < end; ++word) {
    uint rest = walk_listed(first, word);
    if (slot + uint(bitCount(rest)) > FL_WALK_BEAMS) break;
    next = word + 1u;
    while (rest != 0u) {
      walk_ids[slot++] = word * 32u + uint(findLSB(rest));
      rest &= rest - 1u;
    }
  }
  if (next > from) {
    atomicMax(walk_next, next);
    atomicMax(walk_count, slot);
  }
  barrier();
}

uint tile_walk(uint from) {
  if (counts.live_count <= FL_WALK_BEAMS) walk_list_few();
  else walk_list(from);
  uint count = walk_count;
  for (uint number = walk_lane(); number < count; number += kThreads) {
    if (tile_takes(walk_ids[number], number)) atomicOr(walk_bits[number >> 5], 1u << (number & 31u));
  }
  barrier();
  return walk_next;
}

// The word is made uniform over the subgroup: compilers then keep its threads together through the loop.
#define FL_WALK_BEGIN(number, index, bits)                          \
  for (uint walk_w = 0u; 32u * walk_w < walk_count; ++walk_w) {     \
    uint walk_rest = subgroupBroadcastFirst(bits);                  \
    while (walk_rest != 0u) {                                       \
      uint number = walk_w * 32u + uint(findLSB(walk_rest));        \
      uint index = subgroupBroadcastFirst(walk_ids[number]);        \
      walk_rest &= walk_rest - 1u;
#define FL_WALK_END }}
