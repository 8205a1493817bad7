// Ordered lists of a workgroup of at most FL_SUBGROUPS_MAX subgroups. They keep the patch order, so that sums do not
// depend on the order in which threads run. They are filled batch by batch, so that none can overflow.
//
// All functions are called by all threads of the group together.
#define FL_LIST_MAX 768
#define FL_SUBGROUPS_MAX (FL_GROUP_TILE / 4)

shared uint list_ids[FL_LIST_MAX];
shared uint list_count;
shared uint list_words;
shared uint slot_counts[2 * FL_SUBGROUPS_MAX];  // of subgroups, two buffers in turn
uint slot_turn = 0u;

#include "render/shaders/lib/thread_number.glsl"

// The rank of this thread among the threads for which `a` is true, and among those for which `b` is, and the numbers of
// these threads. Groups have less than 65536 threads.
uvec2 ordered_slots(bool a, bool b, out uvec2 count) {
  uvec4 first = subgroupBallot(a);
  uvec4 second = subgroupBallot(b);
  slot_turn = uint(FL_SUBGROUPS_MAX) - slot_turn;
  if (subgroupElect()) {
    slot_counts[slot_turn + gl_SubgroupID] = subgroupBallotBitCount(first) | subgroupBallotBitCount(second) << 16;
  }
  barrier();
  uint before = 0u;
  uint all = 0u;
  for (uint s = 0u; s < gl_NumSubgroups; ++s) {
    uint there = slot_counts[slot_turn + s];
    if (s < gl_SubgroupID) before += there;
    all += there;
  }
  count = uvec2(all & 0xffffu, all >> 16);
  return uvec2((before & 0xffffu) + subgroupBallotExclusiveBitCount(first),
               (before >> 16) + subgroupBallotExclusiveBitCount(second));
}

// The rank of this thread among the threads for which `is_in` is true, and the number of these threads.
uint ordered_slot(bool is_in, out uint count) {
  uvec2 counts;
  uint slot = ordered_slots(is_in, false, counts).x;
  count = counts.x;
  return slot;
}

// A word of bits to be listed: by default of the supertile's mask.
#ifndef FL_LIST_WORD
#define FL_LIST_WORD(supertile, word) masks[(supertile) * params.mask_words + (word)]
#endif

// Reads the supertile's mask from its word `from` on and lists its beams, as many whole words as fit. Returns the word
// after the last one.
uint list_fill(uint supertile, uint from) {
  uint number = thread_number();
  uint words = (counts.live_count + 31u) / 32u;
  uint at = from + number;
  uint bits = at < words ? FL_LIST_WORD(supertile, at) : 0u;
  uint here = bitCount(bits);
  uint before = subgroupExclusiveAdd(here);
  barrier();  // the list before this one has been read by all
  if (number == 0u) {
    list_count = 0u;
    list_words = 0u;
  }
  slot_turn = uint(FL_SUBGROUPS_MAX) - slot_turn;
  if (gl_SubgroupInvocationID == gl_SubgroupSize - 1u) slot_counts[slot_turn + gl_SubgroupID] = before + here;
  barrier();
  for (uint s = 0u; s < gl_SubgroupID; ++s) before += slot_counts[slot_turn + s];
  bool fits = before + here <= uint(FL_LIST_MAX) && at < words;
  if (fits) {
    uint slot = before;
    uint rest = bits;
    while (rest != 0u) {
      list_ids[slot++] = at * 32u + uint(findLSB(rest));
      rest &= rest - 1u;
    }
  }
  uint last = subgroupMax(fits ? number + 1u : 0u);
  uint filled = subgroupMax(fits ? before + here : 0u);
  if (subgroupElect()) {
    atomicMax(list_words, last);
    atomicMax(list_count, filled);
  }
  barrier();
  return from + list_words;
}
