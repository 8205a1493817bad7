#version 460
// Light in the haze, 32 x 32 pixels a workgroup: the passes before have added beams as if nothing hid their light. Of
// those that have shadows here, subtracts what is dark of them where that is smooth over the tile, as one polynomial.
// The others are left to the beam pass, which subtracts it pixel by pixel: for them, and for beams that were not taken
// together, lists the shadows that reach what the tile shows of their light. A beam that was not taken and is dark in
// all of it leaves the mask.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_FINE_MASKS
#define FL_FINE_MASKS_ACCESS
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/lib/view.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#define FL_SERIES_NODES_MAX 6
#include "render/shaders/shared/shadow.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/shadow.glsl"
layout(constant_id = FL_SPEC_BOXES) const bool kBoxes = true;
layout(constant_id = FL_SPEC_BODIES) const bool kBodies = true;
const bool kSolids = kBoxes || kBodies;
layout(constant_id = FL_SPEC_NODES) const uint kNodes = 3;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
#include "render/shaders/lib/air_nodes.glsl"
#include "render/shaders/lib/shadow_row_light.glsl"
#define FL_DEPTHS_ACCESS readonly
#define FL_DEPTHS_READ
#include "render/shaders/lib/tile_depth.glsl"
#include "render/shaders/lib/shadow_rect.glsl"
#define FL_PICKS_ACCESS coherent
#define FL_PICKS_READ
#include "render/shaders/lib/shadow_picks.glsl"
#define FL_LIST_WORD(supertile, word) shadow_words[(supertile) * params.mask_words + (word)].beams
#include "render/shaders/lib/tile_list.glsl"
#include "render/shaders/lib/tile_team.glsl"
#include "render/shaders/lib/tile_sum.glsl"
#include "render/shaders/lib/tile_pixels.glsl"
#include "render/shaders/lib/tile_polynomial.glsl"

layout(local_size_x = FL_GROUP_TILE) in;
layout(set = 0, binding = FL_BINDING_COARSE, std430) readonly buffer CoarseBuffer { CoarseRow coarse[]; };
layout(set = 0, binding = FL_BINDING_SHADE_WORDS, std430) writeonly buffer ShadeWordsBuffer {
  ShadowWordRow shade_words[];
};

uint mask_word(uint word) {
  return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * params.mask_words + word;
}

shared uint rest_bits[FL_GROUP_TILE];    // of the words of one list: beams that the beam pass gets a list of
shared uint dark_bits[FL_GROUP_TILE];    // and beams that leave the mask
shared uint word_places[FL_GROUP_TILE];  // where the places of the lists of a word's beams stand
shared uint list_places[FL_LIST_MAX];    // of the beams of the list
shared bool any_light;                   // something is subtracted

// Of each team's beam, the shadows that reach what the tile shows of it.
const uint kTeamRoom = 4u * kTeam;
shared uint team_entries[4 * FL_GROUP_TILE];

// Bits of the team's lanes for which `is_one` is true.
uint team_ballot(bool is_one) {
  uvec4 ones = subgroupBallot(is_one);
  uint from = gl_SubgroupInvocationID & ~(kTeam - 1u);
  return ones[from >> 5] >> (from & 31u) & ((1u << kTeam) - 1u);
}

// Fills the team's entries. Returns their number, of which those past kTeamRoom are not kept. is_dark: the tile is all
// in one of them, which then is the only one; of a lens of several points: in one from each, and all are there. All
// lanes of a subgroup call it together.
uint list_team_entries(uint beam, ShadowPicks picks, ShadowCell cell, out bool is_dark) {
  if (kMaps) {
    uint entry = picks.count > 0u ? map_in_cell(beam, cell) : FL_NONE;
    is_dark = entry_darkens(entry) != 0u;
    return entry != FL_NONE ? 1u : 0u;
  }
  uint count = 0u;
  uint dark = 0u;
  uint rounds = subgroupMax((picks.count + kTeam - 1u) / kTeam);
  subgroupBarrier();  // the entries before these have been read
  for (uint round_of = 0u; round_of < rounds; ++round_of) {
    uint own = round_of * kTeam + team_lane();
    uint entry = own < picks.count ? shadow_in_cell(shadow_picked(picks, own), cell) : FL_NONE;
    uint ones = team_ballot(entry != FL_NONE);
    uint at = count + bitCount(ones & ((1u << team_lane()) - 1u));
    if (entry != FL_NONE && at < kTeamRoom) team_entries[team_number() * kTeamRoom + at] = entry;
    count += bitCount(ones);
    uint points = entry_darkens(entry);
    [[unroll]] for (uint point = 0u; point < kLensPoints; ++point) {
      dark |= team_ballot((points >> point & 1u) != 0u) != 0u ? 1u << point : 0u;
    }
  }
  is_dark = dark == kAllPoints;
  subgroupBarrier();
  if (kLensPoints > 1u) return count;
  if (is_dark && team_lane() == 0u) team_entries[team_number() * kTeamRoom] = shadow_entry(0u, 0u);
  subgroupBarrier();
  return is_dark ? 1u : count;
}

// Room for so many words behind the lists of supertiles; FL_NONE: there is none, and no list of this pass is read.
uint take_words(uint count) {
  uint all = uint(shadow_picks.length());
  if (shade_words_used > all) return FL_NONE;  // so that the number does not overflow
  uint place = shadow_words_used + atomicAdd(shade_words_used, count);
  return place + count <= all ? place : FL_NONE;
}

// Stores the team's entries as the list of entry e; all lanes of a subgroup call it together.
void store_team_entries(bool stores, uint e, uint count, ShadowPicks picks, ShadowCell cell) {
  uint place = FL_NONE;
  if (stores && team_lane() == 0u) place = take_words(count + 1u);
  place = subgroupShuffle(place, gl_SubgroupInvocationID & ~(kTeam - 1u));
  if (stores && team_lane() == 0u) {
    list_places[e] = place;
    if (place != FL_NONE) shadow_picks[place] = count;
  }
  stores = stores && place != FL_NONE;
  bool is_long = stores && count > kTeamRoom;
  if (stores && !is_long) {
    for (uint k = team_lane(); k < count; k += kTeam) {
      shadow_picks[place + 1u + k] = team_entries[team_number() * kTeamRoom + k];
    }
  }
  // Entries that had no room are found again.
  uint rounds = subgroupMax(is_long ? (picks.count + kTeam - 1u) / kTeam : 0u);
  uint kept = 0u;
  for (uint round_of = 0u; round_of < rounds; ++round_of) {
    uint own = round_of * kTeam + team_lane();
    uint entry = is_long && own < picks.count ? shadow_in_cell(shadow_picked(picks, own), cell) : FL_NONE;
    uint ones = team_ballot(entry != FL_NONE);
    uint at = kept + bitCount(ones & ((1u << team_lane()) - 1u));
    if (entry != FL_NONE && at < count) shadow_picks[place + 1u + at] = entry;
    kept += bitCount(ones);
  }
  // What the first search has found and this one has not would stand there from another frame.
  if (is_long && team_lane() == 0u) shadow_picks[place] = min(kept, count);
}

// What shadows from several points of the lens take from a chord, at nodes of the whole chord. first, count: of team
// entries.
float soft_dark_light(BeamShape beam, Medium medium, Chord chord, vec3 ray, uint nodes, ShadowChord ends, uint first,
                      uint count) {
  ShadowWeights weights;
  shadow_weights_clear(weights);
  for (uint k = first; k < first + count;) {
    uint point = entry_point(team_entries[k]);
    ShadowParts parts;
    shadow_parts_clear(parts);
    for (; k < first + count; ++k) {
      if (entry_point(team_entries[k]) != point) break;
      shadow_parts_join(parts, team_entries[k], ends);
    }
    shadow_parts_weigh(parts, point_share(point), weights);
  }
  if (count == 0u) return 0.0;
  return chord_inscatter_shaded(beam, medium, chord, ray, soft_nodes(nodes), weights, kExtinction);
}

// The dark part of a beam's light on the ray through a place, over J0 and sigma_s; its shadows are `count` team entries
// from `first` on. known: false where the place's ray may end at another surface than those of the pixels round it.
float dark_light(uint id, BeamRow row, BeamShape beam, uint first, uint count, RectDepth depth, Medium medium,
                 uint nodes, vec2 at, inout bool known) {
#ifdef FL_HAZE_FIELD
  haze_begin(at);
#endif
  vec3 through = ray_through(at);
  float ray_length = length(through);
  vec3 ray = to_light(row, through / ray_length);
  float end_m = FL_FAR_M;
  if (kSolids) end_m = depth.is_plane ? plane_distance(depth, at, ray_length) : depth.far_m;
  Chord chord;
  if (!beam_chord(beam, row.eye.xyz, ray, 0.0, end_m, chord)) return 0.0;
  known = known && (!kSolids || depth.is_plane || chord.t_base_m + chord.t_to_m <= depth.near_m);
  ShadowChord ends = shadow_chord(row, beam, chord, ray);
  if (count > 0u && has_series(row, ends.line)) return row_light(id, beam, medium, chord, ray, ends.line, true);
  if (kLensPoints > 1u) return soft_dark_light(beam, medium, chord, ray, nodes, ends, first, count);
  ShadowParts parts;
  shadow_parts_clear(parts);
  if (kMaps && count > 0u) parts = map_parts(id, ends);
  for (uint k = first; !kMaps && k < first + count; ++k) shadow_parts_join(parts, team_entries[k], ends);
  float value = 0.0;
  float from = 0.0;
  float to = 0.0;
  while (shadow_parts_next(parts, to, from, to)) {
    value += chord_inscatter_gauss(beam, medium, chord_part(chord, from, to), ray, nodes, kExtinction);
  }
  return value;
}

// Where the polynomial is compared with the light: not at its nodes, and inside the tile.
vec2 check_position(uint k) {
  const float kX[4] = float[4](-0.68, -0.14, 0.24, 0.66);
  const float kY[4] = float[4](-0.62, -0.24, 0.14, 0.70);
  uvec2 place = node_place(k);
  return vec2(kX[place.x], kY[place.y]);
}

// The polynomial of a team's coefficients at a place. All lanes of a subgroup call it together.
float polynomial(float f[kPer], vec2 at) {
  vec4 x = chebyshev(at.x);
  vec4 y = chebyshev(at.y);
  float sum = 0.0;
  [[unroll]] for (uint node = 0u; node < 16u; ++node) {
    float own = subgroupShuffle(f[node / kTeam], (gl_SubgroupInvocationID & ~(kTeam - 1u)) + node % kTeam);
    sum += own * x[node & 3u] * y[node >> 2];
  }
  return sum;
}

// Dark parts are those of beams with nothing in them: beams with gobos are left to the beam pass.
bool may_be_smooth(BeamRow row) { return (row.flags & FL_BEAM_PLAIN) != 0u; }

// With maps: sorts the beams of the list, a thread each. Those whose dark parts may be smooth over the tile are listed
// in list_places, in their order; returns their number. first: word of the list. All threads call it together.
uint list_tried(uint supertile, uint first, vec2 low, vec2 high, RectDepth depth) {
  uint tried_count = 0u;
  for (uint base = 0u; base < list_count; base += uint(FL_GROUP_TILE)) {
    uint e = base + thread_number();
    bool is_tried = false;
    uint id = 0u;
    if (e < list_count) {
      id = list_ids[e];
      BeamRow row = beams[id];
      uint entry = map_in_cell(id, shadow_cell_before(row, low, high, depth));
      bool is_taken = (fine_masks[mask_word(id >> 5)] >> (id & 31u) & 1u) == 0u;
      is_tried = entry != FL_NONE && is_taken && may_be_smooth(row);
      bool leaves = entry_darkens(entry) != 0u && !is_taken;
      uint bit = 1u << (id & 31u);
      if (leaves) atomicOr(dark_bits[id / 32u - first], bit);
      if (entry != FL_NONE && !is_tried && !leaves) atomicOr(rest_bits[id / 32u - first], bit);
    }
    uint count;
    uint slot = ordered_slot(is_tried, count);
    if (is_tried) list_places[tried_count + slot] = id;
    tried_count += count;
  }
  barrier();
  return tried_count;
}

void main() {
  uint number = thread_number();
  uvec2 cell = gl_WorkGroupID.xy / uint(FL_SUPERTILE_PX / FL_FINE_PX);
  uint supertile = cell.y * params.supertiles_x + cell.x;
  float tolerance = coarse[supertile].tolerance;
  uint words = (counts.live_count + 31u) / 32u;
  const uint kSide = uint(FL_FINE_PX / FL_TILE_PX);
  RectDepth depth = rect_depth(gl_WorkGroupID.xy * kSide, kSide);
  const float kHalf = 0.5 * float(FL_FINE_PX);
  vec2 middle = vec2(gl_WorkGroupID.xy * uint(FL_FINE_PX)) + kHalf;
  vec2 low = vec2(gl_WorkGroupID.xy * uint(FL_FINE_PX));
  vec2 high = low + float(FL_FINE_PX);  // also past the edge of the picture, where nodes may be
  Medium medium = Medium(params.anisotropy, params.position.w);
  vec3 light_here[kPer];
  FL_LANE_NODES(k) light_here[k] = vec3(0.0);
  bool any = false;
  for (uint from = 0u; from < words;) {
    uint first = from;
    from = list_fill(supertile, from);
    rest_bits[number] = 0u;
    dark_bits[number] = 0u;
    barrier();
    uint tried_count = kMaps ? list_tried(supertile, first, low, high, depth) : list_count;
    for (uint e = 0u; e < tried_count; e += kTeams) {
      uint entry = e + team_number();
      bool is_beam = entry < tried_count;
      uint id = kMaps ? list_places[min(entry, tried_count - 1u)] : list_ids[min(entry, list_count - 1u)];
      BeamRow row = beams[id];
      BeamShape beam = beam_shape(row);
      beam.profile_power = drawn_profile(beam.profile_power);
      uint nodes = air_nodes(beam.profile_power);
      ShadowCell cell_of;
      ShadowPicks picks = shadow_picks_of(supertile, id);
      if (!is_beam) picks.count = 0u;
      bool is_taken = (fine_masks[mask_word(id >> 5)] >> (id & 31u) & 1u) == 0u;
      bool is_dark = false;
      uint count = picks.count;
      if (!kMaps) {
        cell_of = shadow_cell_before(row, low, high, depth);
        count = list_team_entries(id, picks, cell_of, is_dark);
      }
      bool fits = count <= kTeamRoom;
      uint first_entry = team_number() * kTeamRoom;
      uint tried = is_taken && fits && may_be_smooth(row) ? count : 0u;
      float tolerated = tolerance / max(row.j0.r, max(row.j0.g, row.j0.b));
      bool known = true;
      float dark[kPer];
      float f[kPer];
      float most = 0.0;
      FL_LANE_NODES(k) {
        vec2 at = middle + FL_HULL * kHalf * node_position(k);
        dark[k] = dark_light(id, row, beam, first_entry, tried, depth, medium, nodes, at, known);
        f[k] = dark[k];
        most = max(most, dark[k]);
      }
      to_coefficients(f);
      float off = 0.0;
      FL_LANE_NODES(k) {
        uvec2 place = node_place(k);
        if (max(place.x, place.y) == 3u) off += abs(f[k]);
      }
      off = team_sum(vec2(off, 0.0)).x;
      off = team_max(known ? off : FL_FAR_M);
      if (subgroupAny(tried > 0u && off <= tolerated)) {
        FL_LANE_NODES(k) {
          vec2 at = check_position(k);
          float there = dark_light(id, row, beam, first_entry, tried, depth, medium, nodes,
                                   middle + FL_HULL * kHalf * at, known);
          most = max(most, there);
          off = max(off, abs(there - polynomial(f, at)));
        }
        off = team_max(known ? off : FL_FAR_M);
      }
      most = team_max(most);
      // A shadow that none of the places meets may still be between them.
      bool close = off <= tolerated && most > 0.0;
      bool leaves = is_dark && !is_taken;
      bool stores = count > 0u && !close && !leaves;
      if (close) {
        FL_LANE_NODES(k) light_here[k] -= dark[k] * row.j0.rgb;
        any = true;
      }
      if (!kMaps) store_team_entries(stores, entry, count, picks, cell_of);
      if (team_lane() == 0u) {
        if (stores) atomicOr(rest_bits[id / 32u - first], 1u << (id & 31u));
        if (leaves) atomicOr(dark_bits[id / 32u - first], 1u << (id & 31u));
      }
    }
    barrier();
    if (first + number < from) {
      uint rest = rest_bits[number];
      uint place = rest != 0u && !kMaps ? take_words(bitCount(rest)) : FL_NONE;
      word_places[number] = place;
      uint word = mask_word(first + number);
      shade_words[word] = ShadowWordRow(rest, place);
      if (dark_bits[number] != 0u) fine_masks[word] &= ~dark_bits[number];
    }
    barrier();
    for (uint e = number; e < list_count; e += uint(FL_GROUP_TILE)) {
      uint id = list_ids[e];
      uint word = id / 32u - first;
      uint bit = 1u << (id & 31u);
      if ((rest_bits[word] & bit) == 0u || word_places[word] == FL_NONE) continue;
      shadow_picks[word_places[word] + bitCount(rest_bits[word] & (bit - 1u))] = list_places[e];
    }
    barrier();
  }
  if (number == 0u) any_light = false;
  barrier();
  if (any) any_light = true;
  barrier();
  if (!any_light) return;
  sum_light(light_here);
  vec3 total[FL_ROWS];
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) total[i] = vec3(0.0);
  add_group_light(total);
  add_to_pixels(total);
}
