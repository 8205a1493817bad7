#version 460
// Light in the haze, supertile by supertile. Beams whose light is smooth over its 64 x 64 pixels are added as one
// polynomial and leave the supertile's mask; those that are smooth but for their rim or for what cuts them become
// records for the records pass, as long as there is room. Beams that do not reach it leave the mask as well. The fine
// pass and the beam pass compute the rest. This pass also computes the error that one beam may have there.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_KHR_shader_subgroup_shuffle : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_MASKS
#define FL_MASKS_ACCESS
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/lib/view.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/shared/tile_node.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/tile_gobo.glsl"
#include "render/shaders/lib/thin.glsl"
#include "render/shaders/lib/shadow.glsl"
layout(constant_id = FL_SPEC_BOXES) const bool kBoxes = true;
layout(constant_id = FL_SPEC_BODIES) const bool kBodies = true;
const bool kSolids = kBoxes || kBodies;
#define FL_DEPTHS_ACCESS readonly
#define FL_DEPTHS_READ
#include "render/shaders/lib/tile_depth.glsl"
#define FL_PICKS_ACCESS readonly
#define FL_PICKS_READ
#include "render/shaders/lib/shadow_picks.glsl"
#include "render/shaders/lib/tile_list.glsl"
#include "render/shaders/lib/tile_team.glsl"
#include "render/shaders/lib/tile_class.glsl"
#include "render/shaders/lib/tile_sum.glsl"
#include "render/shaders/lib/tile_entry.glsl"

layout(local_size_x = FL_GROUP_TILE) in;
layout(set = 0, binding = FL_BINDING_COARSE, std430) writeonly buffer CoarseBuffer { CoarseRow coarse[]; };
layout(set = 0, binding = FL_BINDING_RIMS, std430) writeonly buffer RimsBuffer { RimRow rims[]; };
layout(set = 0, binding = FL_BINDING_CUTS, std430) writeonly buffer CutsBuffer { CutRow cuts[]; };
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;

shared uint rest_bits[FL_GROUP_TILE];  // of the words of one list
shared vec2 estimates[FL_SUBGROUPS_MAX];             // of subgroups: light, and beams that give some
shared uint beam_count;
const uint kEntryWords = (uint(FL_ENTRIES_MAX) + 31u) / 32u;
// Entries that have become records, a bit each: those with a rim, which come first, and those that are cut.
shared uint record_bits[kEntryWords];

// How many of the entries before this one have. Between two rounds the words of the next one may get bits: of later
// entries only, which do not count.
uint records_before(uint entry) {
  uint sum = bitCount(record_bits[entry >> 5] & ~(0xffffffffu << (entry & 31u)));
  for (uint w = 0u; w < entry >> 5; ++w) sum += bitCount(record_bits[w]);
  return sum;
}

// How many of the beams in the supertile's mask can be taken together.
uint count_beams(uint supertile) {
  uint number = thread_number();
  uint words = (counts.live_count + 31u) / 32u;
  if (number == 0u) beam_count = 0u;
  barrier();
  uint bits = 0u;
  for (uint w = number; w < words; w += uint(FL_GROUP_TILE)) {
    uint rest = masks[supertile * params.mask_words + w];
    while (rest != 0u) {
      BeamRow row = beams[w * 32u + uint(findLSB(rest))];
      if (tile_knows(row) || tile_knows_gobo(row)) ++bits;
      rest &= rest - 1u;
    }
  }
  bits = subgroupAdd(bits);
  if (subgroupElect()) atomicAdd(beam_count, bits);
  barrier();
  return beam_count;
}

// What an image lets through, where the light is estimated: few are darker.
const float kOpenShare = 0.2;

// Mean light of the supertile's pixels over sigma_s, and how many beams light one: each beam at 1 to 16 of 16 places.
vec2 estimate(uint supertile, vec2 low, vec2 size) {
  uint number = thread_number();
  uint words = (counts.live_count + 31u) / 32u;
  uint places = clamp(1024u / max(beam_count, 1u), 1u, 16u);
  Medium medium = Medium(params.anisotropy, params.position.w);
  vec2 sum = vec2(0.0);
  for (uint from = 0u; from < words;) {
    from = list_fill(supertile, from);
    for (uint e = number; e < list_count * places; e += uint(FL_GROUP_TILE)) {
      uint which = e / places;
      BeamRow row = beams[list_ids[which]];
      bool gobo = tile_knows_gobo(row);
      if (!tile_knows(row) && !gobo) continue;
      uint place = ((e - which * places) * (16u / places) + which * 5u) & 15u;
      uvec2 cell = uvec2(place & 3u, place >> 2);
      vec2 at = low + size * (vec2(cell) + vec2((cell.y * 5u + 3u) & 15u, (cell.x * 5u + 2u) & 15u) / 16.0) / 4.0;
      ivec2 pixel = min(ivec2(at), ivec2(int(params.width), int(params.height)) - 1);
      vec3 d = normalize(ray_through(vec2(pixel) + 0.5));
      float end_m = kSolids ? imageLoad(radiance, pixel).a : FL_FAR_M;
      BeamShape beam = beam_shape(row);
      beam.profile_power = drawn_profile(beam.profile_power);
#ifdef FL_HAZE_FIELD
      haze_begin(vec2(pixel) + 0.5);
#endif
      Chord chord;
      vec3 ray = to_light(row, d);
      if (!beam_chord(beam, row.eye.xyz, ray, 0.0, end_m, chord)) continue;
      vec3 middle = chord.base + ray * (0.5 * (chord.t_from_m + chord.t_to_m));
      if (kShadows && is_in_picked(supertile, list_ids[which], middle)) continue;
      float light = chord_inscatter_gauss(beam, medium, chord, ray, 2u, kExtinction);
      sum += vec2(brightest(row.j0.rgb) * light * (gobo ? kOpenShare : 1.0), 1.0);
    }
  }
  sum = subgroupAdd(sum);
  if (subgroupElect()) estimates[gl_SubgroupID] = sum;
  barrier();
  sum = vec2(0.0);
  for (uint s = 0u; s < gl_NumSubgroups; ++s) sum += estimates[s];
  return sum / float(places);
}

void main() {
  uint number = thread_number();
  uvec2 cell = gl_WorkGroupID.xy;
  uint supertile = cell.y * params.supertiles_x + cell.x;
  vec2 low = vec2(cell * uint(FL_SUPERTILE_PX));
  vec2 size = min(vec2(float(FL_SUPERTILE_PX)), vec2(float(params.width), float(params.height)) - low);
  float tolerance = 0.0;
  if (count_beams(supertile) > uint(FL_FEW_BEAMS)) {
    vec2 mean = estimate(supertile, low, size);
    tolerance = params.tile_error * mean.x * inversesqrt(max(mean.y, 1.0));
  }
  if (!(tolerance > 0.0)) {
    if (number < uint(FL_TILE_LIGHT)) coarse[supertile].light[number] = 0.0;
    if (number == 0u) {
      coarse[supertile].tolerance = 0.0;
      coarse[supertile].rims = 0u;
      coarse[supertile].cuts = 0u;
    }
    return;
  }
  const uint kSide = uint(FL_SUPERTILE_PX / FL_TILE_PX);
  Rect rect = Rect(low + 0.5 * float(FL_SUPERTILE_PX), FL_HULL * 0.5 * float(FL_SUPERTILE_PX),
                   rect_depth(cell * kSide, kSide));
  uint words = (counts.live_count + 31u) / 32u;
  vec3 light[kPer];
  FL_LANE_NODES(k) light[k] = vec3(0.0);
  uint rim_count = 0u;
  uint cut_count = 0u;
  for (uint from = 0u; from < words;) {
    uint first = from;
    from = list_fill(supertile, from);
    rest_bits[number] = 0u;
    barrier();
    for (uint at = 0u; at < list_count; at += uint(FL_GROUP_TILE)) {
      bool tries = false;
      uint id = 0u;
      TileGuess guess;
      if (at + number < list_count) {
        id = list_ids[at + number];
        BeamRow row = beams[id];
        bool known = tile_knows(row);
        if (known) guess = tile_guess(row, rect);
        tries = known && guess.bits != 0u;
        if (tries && has_shadows(supertile, id)) guess.bits |= kGuessShadowed;
        bool is_dark = known && guess.is_dark;
        if (!tries && !is_dark) atomicOr(rest_bits[id / 32u - first], 1u << (id & 31u));
        if (tries) guess.middle = light_at_middle(row, rect);
      }
      if (number < kEntryWords) record_bits[number] = 0u;
      uvec2 entries = add_entry(tries, id, guess);
      for (uint e = 0u; e < entries.y; e += kTeams) {
        uint entry = e + team_number();
        TileEntry own = entry_at(min(entry, entries.y - 1u));
        bool is_beam = entry < entries.y && own.bits != 0u;
        BeamRow row = beams[own.id];
        float allowed = tolerance / brightest(row.j0.rgb);
        bool whole = (own.bits & kGuessWhole) != 0u;
        compute_nodes(row, rect, whole, own.fit);
        bool is_smooth_beam = is_beam && (own.bits & kGuessSmooth) != 0u;
        if (subgroupAny(is_smooth_beam)) {
          bool close = is_smooth(allowed, own.bits, own.middle);
          is_smooth_beam = is_smooth_beam && close;
        }
        if (is_smooth_beam) {
          FL_LANE_NODES(k) light[k] += kShowsClasses ? kClassSmooth : node_light[k] * row.j0.rgb;
        }
        bool is_rim = is_beam && !is_smooth_beam && whole;
        bool is_cut = is_beam && !is_smooth_beam && !whole && (own.bits & kGuessRecord) != 0u;
        float rho[kPer];
        float h[kPer];
        if (subgroupAny(is_rim)) {
          bool close = fit_rim(allowed, own.bits, own.middle, rho, h);
          is_rim = is_rim && close;
        }
        CutFits fits;
        if (subgroupAny(is_cut)) {
          bool close = fit_cut(allowed, own.bits, own.middle, fits);
          is_cut = is_cut && close;
        }
        if ((is_rim || is_cut) && team_lane() == 0u) atomicOr(record_bits[entry >> 5], 1u << (entry & 31u));
        barrier();
        if (is_rim) {
          uint slot = rim_count + records_before(entry);
          is_rim = slot < params.rims_max;
          slot += supertile * params.rims_max;
          if (is_rim) {
            FL_LANE_NODES(k) {
              uint i = coefficient_slot(node_place(k));
              if (i < 6u) {
                rims[slot].fits[i >> 2][i & 3u] = rho[k];
                rims[slot].fits[(6u + i) >> 2][(6u + i) & 3u] = h[k];
              }
            }
            if (team_lane() == 0u) rims[slot].color = vec4(row.j0.rgb, rim_power(drawn_profile(row.eye.w)));
          }
        }
        if (is_cut) {
          uint slot = cut_count + records_before(entry) - records_before(entries.x);
          is_cut = slot < params.cuts_max;
          slot += supertile * params.cuts_max;
          if (is_cut) {
            FL_LANE_NODES(k) {
              uint i = coefficient_slot(node_place(k));
              [[unroll]] for (uint which = 0u; which < 6u; ++which) {
                uint at = 6u * which + i;
                if (i < 6u) cuts[slot].fits[at >> 2][at & 3u] = fits.of[which][k];
              }
            }
            if (team_lane() == 0u) cuts[slot].color = vec4(row.j0.rgb, 1.0);
          }
        }
        if (is_beam && !is_smooth_beam && !is_rim && !is_cut && team_lane() == 0u) {
          atomicOr(rest_bits[own.id / 32u - first], 1u << (own.id & 31u));
        }
      }
      uint rims_here = records_before(entries.x);
      rim_count += rims_here;
      cut_count += records_before(entries.y) - rims_here;
      barrier();
    }
    if (first + number < from) masks[supertile * params.mask_words + first + number] = rest_bits[number];
    barrier();
  }
  sum_light(light);
  if (number < uint(FL_TILE_LIGHT)) coarse[supertile].light[number] = group_light[number];
  if (number == 0u) {
    coarse[supertile].tolerance = tolerance;
    coarse[supertile].rims = min(rim_count, params.rims_max);
    coarse[supertile].cuts = min(cut_count, params.cuts_max);
  }
}
