// Shadows of the beams that a tile walks over: which of them reach the tile. After tile_walk.glsl, shadow_picks.glsl.

// The listed shadows of the walk's beams are pairs, in the order of the beams. As many beams at a time as have this
// many pairs are put to the test of the tile. A beam with more comes alone and is tested in parts; if too many of its
// shadows reach the tile, all that are listed count. More shared memory leaves room for fewer workgroups: on an H200
// the pass takes twice the time with 2048.
#define FL_WALK_PAIRS 512u
const uint kUntested = FL_NONE;
// Beams that were tested together, without those that the pass need not compute.
shared uint walk_now[FL_WALK_BEAMS / 32u];
shared uint walk_shaded[FL_WALK_BEAMS / 32u];  // of those that have shadows in the tile
shared uint walk_pairs[kShadows ? FL_WALK_BEAMS + 1u : 1u];  // of each beam its number of pairs; then the first of them
shared uint walk_found[kShadows ? FL_WALK_BEAMS : 1u];       // shadows of the beam that reach the tile
shared uint walk_entries[kShadows ? FL_WALK_PAIRS : 1u];     // those of a beam begin where its pairs do

// Whether the passes before have left the beam to this one.
bool is_left(uint beam) {
  return !FL_WALK_FINE || (walk_mask(walk_word(beam >> 5)) & (1u << (beam & 31u))) != 0u;
}

// The shadows of a beam that are listed for what holds the tile.
ShadowPicks picks_here(uint beam) {
  if (FL_WALK_LISTS) {
    ShadowWordRow word = shade_words[walk_word(beam >> 5)];
    if (!is_in_word(word, beam)) return ShadowPicks(0u, 0u, false);
    uint all = uint(shadow_picks.length());
    uint place = list_place(word, beam, max(shadow_words_used, shadow_words_used + shade_words_used) <= all);
    if (place != FL_NONE) return ShadowPicks(shadow_picks[place], place + 1u, true);
  }
  return shadow_picks_of(supertile(), beam);
}

// Numbers the pairs of the walk's beams. All threads call it together.
void walk_number_pairs() {
  const uint kRun = FL_WALK_BEAMS / kThreads;
  uint lane = walk_lane();
  uint own = 0u;
  for (uint i = 0u; i < kRun; ++i) {
    uint at = lane * kRun + i;
    if ((walk_bits[at >> 5] >> (at & 31u) & 1u) == 0u) walk_pairs[at] = 0u;
    own += walk_pairs[at];
  }
  uint all;
  uint before = walk_before(own, all);
  for (uint i = 0u; i < kRun; ++i) {
    uint at = lane * kRun + i;
    uint count = walk_pairs[at];
    walk_pairs[at] = before;
    before += count;
  }
  if (lane == 0u) walk_pairs[FL_WALK_BEAMS] = all;
  barrier();
}

// The last beam whose pairs begin at this one or before.
uint walk_beam_of(uint pair) {
  uint number = 0u;
  for (uint step_of = FL_WALK_BEAMS / 2u; step_of > 0u; step_of >>= 1) {
    if (walk_pairs[number + step_of] <= pair) number += step_of;
  }
  return number;
}

// Moves the entries from `begin` to `end` that reach the tile to `kept` and the following; returns how many there are
// then. One that holds all of the tile stands for all, where the lens has one point. dark: bits of the points from
// which one does.
uint walk_keep_entries(uint begin, uint end, uint first, uint kept, inout uint dark) {
  for (uint k = begin; k < end; ++k) {
    uint entry = walk_entries[k];
    if (entry == FL_NONE) continue;
    walk_entries[first + kept] = entry;
    ++kept;
    dark |= entry_darkens(entry);
  }
  if (kLensPoints > 1u || dark == 0u) return kept;
  walk_entries[first] = shadow_entry(0u, 0u);
  return 1u;
}

// What is dark in all of the tile adds nothing, and of a beam that was added as a whole nothing is subtracted where it
// has no shadow.
void walk_store(uint number, uint found, bool dark) {
  walk_found[number] = found;
  bool computes = is_left(walk_ids[number]) ? !dark : found > 0u;
  if (computes) atomicOr(walk_now[number >> 5], 1u << (number & 31u));
  if (computes && found > 0u) atomicOr(walk_shaded[number >> 5], 1u << (number & 31u));
}

uint walk_test_pair(uint beam, uint k, RectDepth depth) {
  vec2 low = vec2(gl_WorkGroupID.xy * uint(FL_TILE_PX));
  vec2 high = min(low + float(FL_TILE_PX), vec2(float(params.width), float(params.height)));
  ShadowCell cell = shadow_cell_before(beams[beam], low, high, depth);
  return kMaps ? map_in_cell(beam, cell) : shadow_in_cell(shadow_picked(picks_here(beam), k), cell);
}

// A beam with more pairs than have room. Its entries begin at 0.
void walk_test_many(uint number, uint lane, RectDepth depth) {
  uint all = walk_pairs[number + 1u] - walk_pairs[number];
  uint kept = 0u;
  uint dark = 0u;
  for (uint at = 0u; at < all;) {
    uint count = min(FL_WALK_PAIRS - kept, all - at);
    if (count < min(FL_WALK_PAIRS / 8u, all - at)) break;
    for (uint k = lane; k < count; k += kThreads) {
      walk_entries[kept + k] = walk_test_pair(walk_ids[number], at + k, depth);
    }
    at += count;
    barrier();
    if (lane == 0u) {
      kept = walk_keep_entries(kept, kept + count, 0u, kept, dark);
      walk_found[number] = at < all && FL_WALK_PAIRS - kept < min(FL_WALK_PAIRS / 8u, all - at) ? kUntested : kept;
      if (kLensPoints == 1u && dark != 0u) walk_found[number] = 1u;
    }
    barrier();
    if (walk_found[number] == kUntested) break;
    if (kLensPoints == 1u && walk_entries[0] == shadow_entry(0u, 0u) && walk_found[number] == 1u) break;
    kept = walk_found[number];
  }
  // Only this thread has seen all entries.
  if (lane == 0u) walk_store(number, walk_found[number], dark == kAllPoints);
}

// Fills walk_now, walk_found and walk_entries for beams from `begin` on. Returns the beam after the last one.
// All threads call it together.
uint walk_test_shadows(uint begin, RectDepth depth) {
  uint lane = walk_lane();
  uint first_pair = walk_pairs[begin];
  // No beam without pairs is left behind by the search: it ends at the last of equal ones.
  uint end = walk_pairs[FL_WALK_BEAMS] - first_pair <= FL_WALK_PAIRS ? FL_WALK_BEAMS
                                                                     : walk_beam_of(first_pair + FL_WALK_PAIRS);
  end = max(end, begin + 1u);
  uint pairs = walk_pairs[end] - first_pair;
  barrier();  // what is filled here has been read
  if (lane < FL_WALK_BEAMS / 32u) walk_now[lane] = walk_shaded[lane] = 0u;
  barrier();
  if (pairs > FL_WALK_PAIRS) {
    walk_test_many(begin, lane, depth);
    barrier();
    return end;
  }
  for (uint pair = lane; pair < pairs; pair += kThreads) {
    uint number = walk_beam_of(first_pair + pair);
    walk_entries[pair] = walk_test_pair(walk_ids[number], first_pair + pair - walk_pairs[number], depth);
  }
  barrier();
  for (uint number = begin + lane; number < end; number += kThreads) {
    if ((walk_bits[number >> 5] >> (number & 31u) & 1u) == 0u) continue;
    uint dark = 0u;
    uint first = walk_pairs[number] - first_pair;
    uint found = walk_keep_entries(first, walk_pairs[number + 1u] - first_pair, first, 0u, dark);
    walk_store(number, found, dark == kAllPoints);
  }
  barrier();
  return end;
}

// The shadows of one beam of the walk: entries of walk_entries, or of the lists where it is untested.
struct WalkShadows {
  uint count;
  uint first;
  bool tested;
  ShadowPicks picks;
};
// begin: of the beams that are tested together.
WalkShadows walk_shadows_of(uint number, uint begin) {
  uint found = walk_found[number];
  WalkShadows shadows_of = WalkShadows(found, walk_pairs[number] - walk_pairs[begin], found != kUntested,
                                       ShadowPicks(0u, 0u, false));
  if (found == kUntested) {
    shadows_of.picks = picks_here(walk_ids[number]);
    shadows_of.count = shadows_of.picks.count;
  }
  return shadows_of;
}
uint walk_shadow(WalkShadows from, uint k) {
  return from.tested ? walk_entries[from.first + k] : shadow_picked(from.picks, k);
}

// The shadows from one point of the lens, which stand from entry `at` on; then `at` is the first one from the next
// point. point: its bit.
ShadowParts chord_shadows(uint beam, WalkShadows from, ShadowChord ends, inout uint at, out uint point) {
  point = kLensPoints > 1u ? entry_point(walk_shadow(from, at)) : 1u;
  if (kMaps) {
    at = from.count;
    return map_parts(beam, ends);
  }
  ShadowParts parts;
  shadow_parts_clear(parts);
  for (; at < from.count; ++at) {
    uint entry = walk_shadow(from, at);
    if (kLensPoints > 1u && entry_point(entry) != point) break;
    shadow_parts_join(parts, entry, ends);
  }
  return parts;
}
