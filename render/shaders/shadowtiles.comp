#version 460
// For each supertile and each beam in its mask: which of the beam's shadows reach what the supertile's pixels see of it
// in the haze. Beams that are dark in all of it leave the mask. A thread has all shadows of a beam where these are few;
// else the threads of a subgroup have one each.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_MASKS
#define FL_MASKS_ACCESS
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/shadow.glsl"
layout(constant_id = FL_SPEC_BOXES) const bool kBoxes = true;
layout(constant_id = FL_SPEC_BODIES) const bool kBodies = true;
const bool kSolids = kBoxes || kBodies;
#define FL_DEPTHS_ACCESS readonly
#define FL_DEPTHS_READ
#include "render/shaders/lib/tile_depth.glsl"
#include "render/shaders/lib/shadow_rect.glsl"
#include "render/shaders/lib/tile_list.glsl"
#define FL_PICKS_ACCESS coherent
#include "render/shaders/lib/shadow_picks.glsl"

layout(local_size_x = FL_GROUP_TILE) in;

shared uint some_bits[FL_GROUP_TILE];    // of the words of one list: beams with a shadow, but not all of them in it
shared uint dark_bits[FL_GROUP_TILE];    // and beams that are all in one
shared uint word_places[FL_GROUP_TILE];  // where the places of the lists of a word's beams stand
shared uint list_places[FL_LIST_MAX];    // of the beams of the list

// Room for so many words; FL_NONE: there is none. Then more words are in use than there are, whatever the order of
// threads, and no list of the frame is read.
uint take_words(uint count) {
  uint all = uint(shadow_picks.length());
  if (shadow_words_used > all) return FL_NONE;  // so that the number does not overflow
  uint place = atomicAdd(shadow_words_used, count);
  return place + count <= all ? place : FL_NONE;
}

const uint kShadowNone = 0u;  // the beam has none in the cell
const uint kShadowSome = 1u;
const uint kShadowAll = 2u;   // all of the cell is in one
// any: a shadow reaches the cell; dark: bits of the lens points from which one holds all of it.
uint found_of(bool any, uint dark) { return dark == kAllPoints ? kShadowAll : any ? kShadowSome : kShadowNone; }

// Planes of a thread's first shadows, 16 bits each. A mask that is not kept counts as all planes.
const uint kKept = 8u;
void keep_planes(inout uvec4 kept, uint at, uint entry) {
  if (at < kKept) kept[at >> 1] |= entry_planes(entry) << 16u * (at & 1u);
}
uint kept_entry(uvec4 kept, uint at, uint shadow) {
  if (at >= kKept) return shadow_whole(shadow);
  return shadow_entry(shadow, kept[at >> 1] >> 16u * (at & 1u) & kAllPlanes);
}

// For each of these functions: returns whether the beam has shadows in the cell, and where those that reach it are
// listed.
const uint kFewShadows = kKept;
uint list_few_shadows(ShadowListRow list, ShadowCell cell, out uint place) {
  uint bits = 0u;
  uvec4 kept = uvec4(0u);
  uint dark = 0u;
  place = FL_NONE;
  for (uint own = 0u; own < list.count; ++own) {
    uint entry = shadow_in_cell(shadow_whole(list.first + own), cell);
    if (entry != FL_NONE) bits |= 1u << own;
    keep_planes(kept, own, entry);
    dark |= entry_darkens(entry);
  }
  uint most = found_of(bits != 0u, dark);
  if (most != kShadowSome) return most;
  place = take_words(bitCount(bits) + 1u);
  if (place == FL_NONE) return most;
  shadow_picks[place] = bitCount(bits);
  for (uint at = place + 1u; bits != 0u; ++at) {
    uint own = uint(findLSB(bits));
    shadow_picks[at] = kept_entry(kept, own, list.first + own);
    bits &= bits - 1u;
  }
  return most;
}

// All threads of a subgroup call it together.
uint list_shadows(ShadowListRow list, ShadowCell cell, out uint place) {
  uint lane = gl_SubgroupInvocationID;
  uint bits = 0u;  // of this thread's shadows, one a round
  uvec4 kept = uvec4(0u);
  uint dark = 0u;
  place = FL_NONE;
  uint rounds = (list.count + gl_SubgroupSize - 1u) / gl_SubgroupSize;
  for (uint round_of = 0u; round_of < rounds; ++round_of) {
    uint own = round_of * gl_SubgroupSize + lane;
    uint entry = own < list.count ? shadow_in_cell(shadow_whole(list.first + own), cell) : FL_NONE;
    if (entry != FL_NONE) bits |= 1u << round_of;
    keep_planes(kept, round_of, entry);
    dark |= entry_darkens(entry);
  }
  uint most = found_of(subgroupOr(bits) != 0u, subgroupOr(dark));
  if (most != kShadowSome) return most;
  uint total = subgroupAdd(bitCount(bits));
  if (subgroupElect()) place = take_words(total + 1u);
  place = subgroupBroadcastFirst(place);
  if (place == FL_NONE) return most;
  if (subgroupElect()) shadow_picks[place] = total;
  uint at = place + 1u;
  for (uint round_of = 0u; round_of < rounds; ++round_of) {
    bool is_one = (bits >> round_of & 1u) != 0u;
    uvec4 ones = subgroupBallot(is_one);
    if (is_one) {
      shadow_picks[at + subgroupBallotExclusiveBitCount(ones)] =
          kept_entry(kept, round_of, list.first + round_of * gl_SubgroupSize + lane);
    }
    at += subgroupBallotBitCount(ones);
  }
  return most;
}

// Stores what the functions above found of entry e of the list. first: word of the list.
void store_found(uint e, uint first, uint found, uint place) {
  uint id = list_ids[e];
  list_places[e] = place;
  uint bit = 1u << (id & 31u);
  if (found == kShadowSome) atomicOr(some_bits[id / 32u - first], bit);
  if (found == kShadowAll) atomicOr(dark_bits[id / 32u - first], bit);
}

void main() {
  uint number = thread_number();
  uvec2 cell_at = gl_WorkGroupID.xy;
  uint supertile = cell_at.y * params.supertiles_x + cell_at.x;
  vec2 low = vec2(cell_at * uint(FL_SUPERTILE_PX));
  vec2 high = min(low + float(FL_SUPERTILE_PX), vec2(float(params.width), float(params.height)));
  const uint kSide = uint(FL_SUPERTILE_PX / FL_TILE_PX);
  RectDepth depth = rect_depth(cell_at * kSide, kSide);
  uint words = (counts.live_count + 31u) / 32u;
  for (uint from = 0u; from < words;) {
    uint first = from;
    from = list_fill(supertile, from);
    some_bits[number] = 0u;
    dark_bits[number] = 0u;
    barrier();
    for (uint e = number; e < list_count; e += uint(FL_GROUP_TILE)) {
      ShadowListRow list = shadow_lists[list_ids[e]];
      if (list.count == 0u || (!kMaps && list.count > kFewShadows)) continue;
      uint place = FL_NONE;
      ShadowCell cell = shadow_cell_before(beams[list_ids[e]], low, high, depth);
      uint found;
      if (kMaps) {
        uint entry = map_in_cell(list_ids[e], cell);
        found = found_of(entry != FL_NONE, entry_darkens(entry));
      } else {
        found = list_few_shadows(list, cell, place);
      }
      store_found(e, first, found, place);
    }
    barrier();  // the threads of a subgroup are together again
    for (uint e = kMaps ? list_count : gl_SubgroupID; e < list_count; e += gl_NumSubgroups) {
      ShadowListRow list = shadow_lists[list_ids[e]];
      if (list.count <= kFewShadows) continue;
      uint place = FL_NONE;
      uint found = kShadowSome;
      // More do not fit into the bits of a thread.
      if (list.count <= 32u * gl_SubgroupSize) {
        found = list_shadows(list, shadow_cell_before(beams[list_ids[e]], low, high, depth), place);
      }
      if (subgroupElect()) store_found(e, first, found, place);
    }
    barrier();
    if (first + number < from) {
      uint some = some_bits[number];
      uint place = some != 0u && !kMaps ? take_words(bitCount(some)) : FL_NONE;
      uint word = supertile * params.mask_words + first + number;
      shadow_words[word] = ShadowWordRow(some, place);
      word_places[number] = place;
      if (dark_bits[number] != 0u) masks[word] &= ~dark_bits[number];
    }
    barrier();
    for (uint e = number; e < list_count; e += uint(FL_GROUP_TILE)) {
      uint id = list_ids[e];
      uint word = id / 32u - first;
      uint bit = 1u << (id & 31u);
      if ((some_bits[word] & bit) == 0u || word_places[word] == FL_NONE) continue;
      shadow_picks[word_places[word] + bitCount(some_bits[word] & (bit - 1u))] = list_places[e];
    }
  }
}
