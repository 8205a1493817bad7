#version 460
// Light in the haze, 32 x 32 pixels a workgroup: the passes before have added beams as if nothing hid their light. Of
// those that have shadows here, subtracts what is dark of them where that is smooth over the tile, as one polynomial.
// The others are left to the beam pass, which subtracts it pixel by pixel.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_FINE_MASKS
#define FL_FINE_MASKS_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/lib/view.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/shadow.glsl"
layout(constant_id = FL_SPEC_BOXES) const bool kBoxes = true;
layout(constant_id = FL_SPEC_BODIES) const bool kBodies = true;
const bool kSolids = kBoxes || kBodies;
layout(constant_id = FL_SPEC_NODES) const uint kNodes = 3;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
#include "render/shaders/lib/air_nodes.glsl"
#define FL_DEPTHS_ACCESS readonly
#define FL_DEPTHS_READ
#include "render/shaders/lib/tile_depth.glsl"
#define FL_PICKS_ACCESS readonly
#define FL_PICKS_READ
#include "render/shaders/lib/shadow_picks.glsl"
uint taken_word(uint supertile, uint word);
#define FL_LIST_WORD(supertile, word) taken_word(supertile, word)
#include "render/shaders/lib/tile_list.glsl"
#include "render/shaders/lib/tile_team.glsl"
#include "render/shaders/lib/tile_sum.glsl"
#include "render/shaders/lib/tile_pixels.glsl"
#include "render/shaders/lib/tile_polynomial.glsl"

layout(local_size_x = FL_GROUP_TILE) in;
layout(set = 0, binding = FL_BINDING_COARSE, std430) readonly buffer CoarseBuffer { CoarseRow coarse[]; };
layout(set = 0, binding = FL_BINDING_SHADE_MASKS, std430) writeonly buffer ShadeMasksBuffer { uint shade_masks[]; };

uint mask_word(uint word) {
  return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * params.mask_words + word;
}
// Beams with shadows in the supertile that are not left to the beam pass.
uint taken_word(uint supertile, uint word) {
  return shadow_words[supertile * params.mask_words + word].beams & ~fine_masks[mask_word(word)];
}

shared uint rest_bits[FL_GROUP_TILE];  // of the words of one list

// The dark part of a beam's light on the ray through a place, over J0 and sigma_s. known: false where the place's ray
// may end at another surface than those of the pixels round it.
float dark_light(BeamRow row, BeamShape beam, ShadowPicks picks, RectDepth depth, Medium medium, uint nodes, vec2 at,
                 inout bool known) {
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
  ShadowParts parts = chord_shadows(picks, ~0u, row, beam, chord, ray);
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
  Medium medium = Medium(params.anisotropy, params.position.w);
  vec3 light_here[kPer];
  FL_LANE_NODES(k) light_here[k] = vec3(0.0);
  bool any = false;
  for (uint from = 0u; from < words;) {
    uint first = from;
    from = list_fill(supertile, from);
    rest_bits[number] = 0u;
    barrier();
    any = any || list_count > 0u;
    for (uint e = 0u; e < list_count; e += kTeams) {
      uint entry = e + team_number();
      bool is_beam = entry < list_count;
      uint id = list_ids[min(entry, list_count - 1u)];
      BeamRow row = beams[id];
      BeamShape beam = beam_shape(row);
      beam.profile_power = drawn_profile(beam.profile_power);
      uint nodes = air_nodes(beam.profile_power);
      ShadowPicks picks = shadow_picks_of(supertile, id);
      if (!is_beam) picks.count = 0u;
      bool known = true;
      float dark[kPer];
      float f[kPer];
      float most = 0.0;
      FL_LANE_NODES(k) {
        vec2 at = middle + FL_HULL * kHalf * node_position(k);
        dark[k] = dark_light(row, beam, picks, depth, medium, nodes, at, known);
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
      FL_LANE_NODES(k) {
        vec2 at = check_position(k);
        float there = dark_light(row, beam, picks, depth, medium, nodes, middle + FL_HULL * kHalf * at, known);
        most = max(most, there);
        off = max(off, abs(there - polynomial(f, at)));
      }
      off = team_max(known ? off : FL_FAR_M);
      most = team_max(most);
      // A shadow that none of the places meets may still be between them.
      bool close = off <= tolerance / max(row.j0.r, max(row.j0.g, row.j0.b)) && most > 0.0;
      if (is_beam && close) {
        FL_LANE_NODES(k) light_here[k] -= dark[k] * row.j0.rgb;
      } else if (is_beam && team_lane() == 0u) {
        atomicOr(rest_bits[id / 32u - first], 1u << (id & 31u));
      }
    }
    barrier();
    if (first + number < from) shade_masks[mask_word(first + number)] = rest_bits[number];
    barrier();
  }
  if (!any) return;
  sum_light(light_here);
  vec3 total[FL_ROWS];
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) total[i] = vec3(0.0);
  add_group_light(total);
  add_to_pixels(total);
}
