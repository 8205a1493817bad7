#version 460
// Light in the haze, 32 x 32 pixels a workgroup: of the beams that the coarse pass has left, adds those that are smooth
// there, or smooth but for their rim or for what cuts them, as polynomials, and the coarse pass's polynomial. What is
// none of these stays in a mask for the beam pass. Lists keep the patch order.
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
#define FL_MASKS_ACCESS readonly
#define FL_USE_FINE_MASKS
#define FL_FINE_MASKS_ACCESS writeonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/tile_node.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/thin.glsl"
#include "render/shaders/lib/has_gobo.glsl"
layout(constant_id = FL_SPEC_BOXES) const bool kBoxes = true;
layout(constant_id = FL_SPEC_BODIES) const bool kBodies = true;
const bool kSolids = kBoxes || kBodies;
#define FL_DEPTHS_ACCESS readonly
#define FL_DEPTHS_READ
#include "render/shaders/lib/tile_depth.glsl"
#include "render/shaders/lib/tile_list.glsl"
#include "render/shaders/lib/tile_team.glsl"
#include "render/shaders/lib/tile_class.glsl"
#include "render/shaders/lib/tile_sum.glsl"

layout(local_size_x = FL_GROUP_TILE) in;
layout(set = 0, binding = FL_BINDING_COARSE, std430) readonly buffer CoarseBuffer { CoarseRow coarse[]; };
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

// Pixels of a thread, one below the other: a record is read once for all of them.
#define FL_ROWS (1024 / FL_GROUP_TILE)

// What is left of a beam for the pixels: polynomials of x and y, from -1 to 1 over the hull, each 6 coefficients of 1,
// T_1(x), T_1(y), T_2(x), T_1(x) T_1(y), T_2(y), in the order of tile_class()'s fits. Then its colour, and p of its
// profile for kRim, m for kCut.
#define FL_RECORDS 128
#define FL_RECORD_ROWS 10
shared vec4 records[FL_RECORD_ROWS * FL_RECORDS];
// The kinds of records, a bit each for every block of 16 x 8 pixels: those that it can touch.
shared uint rim_bits[8 * FL_RECORDS / 32];
shared uint cut_bits[8 * FL_RECORDS / 32];
shared uint record_kinds[FL_RECORDS];
shared uint rest_bits[FL_GROUP_TILE];  // of the words of one list

// Where a record's coefficient of node (m, n) stands; 6 and more: nowhere.
uint coefficient_slot(uvec2 place) {
  uint order = place.x + place.y;
  return order == 0u ? 0u : order == 1u ? 1u + place.y : order == 2u ? 3u + place.y : 6u;
}

void store_record(uint slot, uint kind, BeamRow row) {
  uint base = uint(FL_RECORD_ROWS) * slot;
  FL_LANE_NODES(k) {
    uvec2 place = node_place(k);
    uint at = coefficient_slot(place);
    if (at < 6u) {
      [[unroll]] for (uint f = 0u; f < 6u; ++f) {
        uint i = 6u * f + at;
        if (f < 2u || kind == kCut) records[base + (i >> 2)][i & 3u] = fits[f][k];
      }
    } else if (place.y == 3u) {
      uint color = base + (kind == kCut ? 9u : 3u);
      float profile = drawn_profile(row.eye.w);
      vec4 last = vec4(row.j0.rgb, kind == kCut ? profile : rim_power(profile));
      records[color][place.x] = last[place.x];
    }
  }
}

float coefficient(uint slot, uint i) { return records[uint(FL_RECORD_ROWS) * slot + (i >> 2)][i & 3u]; }

// A bit for each block of 16 x 8 pixels that |rho| < 1 can reach: blocks 2 q and 2 q + 1 are quarter q's.
uint record_blocks(uint slot, float half_px) {
  float c[6];
  [[unroll]] for (uint i = 0u; i < 6u; ++i) c[i] = coefficient(slot, i);
  vec2 reach = vec2(7.5, 3.5) / half_px;
  float bend = 2.0 * (abs(c[3]) * reach.x * reach.x + abs(c[5]) * reach.y * reach.y) + abs(c[4]) * reach.x * reach.y;
  uint bits = 0u;
  for (uint block = 0u; block < 8u; ++block) {
    uint quarter = block >> 1;
    vec2 at = vec2(float(quarter & 1u) * 16.0 - 8.0, float(quarter >> 1) * 16.0 + float(block & 1u) * 8.0 - 12.0) /
              half_px;
    vec4 x = chebyshev(at.x);
    vec4 y = chebyshev(at.y);
    float value = c[0] + c[1] * x.y + c[2] * y.y + c[3] * x.z + c[4] * x.y * y.y + c[5] * y.z;
    vec2 slope = vec2(c[1] + 4.0 * at.x * c[3] + at.y * c[4], c[2] + 4.0 * at.y * c[5] + at.x * c[4]);
    if (abs(value) < 1.0 + dot(abs(slope), reach) + bend) bits |= 1u << block;
  }
  return bits;
}

// The pixels of this thread.
vec2 first_px;  // the middle of the first one, from the group's middle
vec3 total[FL_ROWS];

// A polynomial along this thread's column: 1, T_1(y), T_2(y).
vec3 column(uint slot, uint first, float x, float x2) {
  return vec3(coefficient(slot, first) + x * coefficient(slot, first + 1u) + x2 * coefficient(slot, first + 3u),
              coefficient(slot, first + 2u) + x * coefficient(slot, first + 4u), coefficient(slot, first + 5u));
}

void add_records(uint block, float half_px) {
  float x = first_px.x / half_px;
  float x2 = 2.0 * x * x - 1.0;
  vec3 y[FL_ROWS];
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
    float at = (first_px.y + float(i)) / half_px;
    y[i] = vec3(1.0, at, 2.0 * at * at - 1.0);
  }
  const uint kWords = uint(FL_RECORDS / 32);
  for (uint w = 0u; w < kWords; ++w) {
    uint bits = subgroupBroadcastFirst(rim_bits[block * kWords + w]);
    while (bits != 0u) {
      uint slot = 32u * w + uint(findLSB(bits));
      bits &= bits - 1u;
      vec3 rho = column(slot, 0u, x, x2);
      vec3 h = column(slot, 6u, x, x2);
      vec4 color = records[uint(FL_RECORD_ROWS) * slot + 3u];
      [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
        float r = dot(rho, y[i]);
        float q = max(1.0 - r * r, 0.0);
        float rim = q * sqrt(q);
        if (kProfile) rim = rim_factor(q, color.w);
        total[i] += (dot(h, y[i]) * rim) * color.rgb;
      }
    }
    bits = subgroupBroadcastFirst(cut_bits[block * kWords + w]);
    while (bits != 0u) {
      uint slot = 32u * w + uint(findLSB(bits));
      bits &= bits - 1u;
      vec3 rho = column(slot, 0u, x, x2);
      vec3 g0 = column(slot, 6u, x, x2);
      vec3 g1 = column(slot, 12u, x, x2);
      vec3 g2 = column(slot, 18u, x, x2);
      vec3 from = column(slot, 24u, x, x2);
      vec3 to = column(slot, 30u, x, x2);
      vec3 color = records[uint(FL_RECORD_ROWS) * slot + 9u].rgb;
      [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
        float r = dot(rho, y[i]);
        vec3 moments = cut_moments(max(1.0 - r * r, 0.0), dot(from, y[i]), dot(to, y[i]));
        total[i] += dot(moments, vec3(dot(g0, y[i]), dot(g1, y[i]), dot(g2, y[i]))) * color;
      }
    }
  }
}

// Adds a polynomial of light over a hull about `middle`, which is `from` from the group's middle.
void add_light(vec3 light[16], vec2 from, float half_px) {
  vec4 tx = chebyshev((first_px.x - from.x) / half_px);
  vec3 rows[4];
  [[unroll]] for (int n = 0; n < 4; ++n) {
    rows[n] = light[4 * n] * tx.x + light[4 * n + 1] * tx.y + light[4 * n + 2] * tx.z + light[4 * n + 3] * tx.w;
  }
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
    vec4 ty = chebyshev((first_px.y + float(i) - from.y) / half_px);
    total[i] += rows[0] * ty.x + rows[1] * ty.y + rows[2] * ty.z + rows[3] * ty.w;
  }
}

void main() {
  uint number = thread_number();
  const uint kPart = uint(FL_GROUP_TILE / 4);  // threads of a quarter
  uint quarter = number / kPart;
  uint block = number / (kPart / 2u);
  uvec2 group_low = gl_WorkGroupID.xy * uint(FL_FINE_PX);
  vec2 middle = vec2(group_low) + 0.5 * float(FL_FINE_PX);
  uvec2 pixel_low = group_low + uvec2((quarter & 1u) * 16u + (number & 15u),
                                      (quarter >> 1) * 16u + (number % kPart / 16u) * uint(FL_ROWS));
  first_px = vec2(pixel_low) + 0.5 - middle;
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) total[i] = vec3(0.0);
  uvec2 cell = gl_WorkGroupID.xy / uint(FL_SUPERTILE_PX / FL_FINE_PX);
  uint supertile = cell.y * params.supertiles_x + cell.x;
  uint fine_tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  float tolerance = coarse[supertile].tolerance;
  uint words = (counts.live_count + 31u) / 32u;
  if (!(tolerance > 0.0)) {
    for (uint w = number; w < words; w += uint(FL_GROUP_TILE)) {
      fine_masks[fine_tile * params.mask_words + w] = masks[supertile * params.mask_words + w];
    }
    return;
  }
  const uint kSide = uint(FL_FINE_PX / FL_TILE_PX);
  Rect rect = Rect(middle, FL_HULL * 0.5 * float(FL_FINE_PX), rect_depth(gl_WorkGroupID.xy * kSide, kSide));
  vec2 low = vec2(group_low);
  vec2 high = min(low + float(FL_FINE_PX), vec2(float(params.width), float(params.height)));
  vec3 light_here[kPer];  // of smooth beams, at this lane's nodes
  FL_LANE_NODES(k) light_here[k] = vec3(0.0);
  for (uint from = 0u; from < words;) {
    uint first = from;
    from = list_fill(supertile, from);
    uint listed = list_count;
    rest_bits[number] = 0u;
    // Those that can touch the group, at the front of the list.
    uint touching = 0u;
    for (uint at = 0u; at < listed; at += uint(FL_GROUP_TILE)) {
      uint id = 0u;
      bool touches = false;
      if (at + number < listed) {
        id = list_ids[at + number];
        BeamRow row = beams[id];
        touches = beam_touches(row, beam_bound(row, 1.0), low, high);
      }
      uint count;
      uint slot = ordered_slot(touches, count);
      if (touches) list_ids[touching + slot] = id;  // not past what has been read
      touching += count;
    }
    barrier();
    for (uint at = 0u; at < touching; at += uint(FL_RECORDS)) {
      uint count = min(touching - at, uint(FL_RECORDS));
      if (at % uint(FL_GROUP_TILE) == 0u) {
        if (at + number < touching) {
          BeamRow row = beams[list_ids[at + number]];
          if (tile_knows(row)) store_middle(number, light_at_middle(row, rect));
        }
      }
      if (number < uint(FL_RECORDS / 4)) {
        rim_bits[number] = 0u;
        cut_bits[number] = 0u;
      }
      if (number < uint(FL_RECORDS)) record_kinds[number] = kDark;
      barrier();
      for (uint e = 0u; e < count; e += kTeams) {
        uint entry = e + team_number();
        bool is_beam = entry < count;
        uint slot = at + min(entry, count - 1u);
        uint id = list_ids[slot];
        BeamRow row = beams[id];
        bool known = tile_knows(row);
        uint kind = tile_class(row, is_beam && known, stored_middle(slot % uint(FL_GROUP_TILE)), rect, tolerance, true);
        if (is_beam && !known) kind = kGeneral;
        if (kind == kSmooth) FL_LANE_NODES(k) light_here[k] += node_light[k] * row.j0.rgb;
        if (kind == kRim || kind == kCut) store_record(entry, kind, row);
        if (team_lane() == 0u) {
          if (kind == kRim || kind == kCut) record_kinds[entry] = kind;
          if (kind == kGeneral) atomicOr(rest_bits[id / 32u - first], 1u << (id & 31u));
        }
      }
      barrier();
      if (number < count && record_kinds[number] != kDark) {
        uint blocks = record_blocks(number, rect.half_px);
        bool is_rim = record_kinds[number] == kRim;
        while (blocks != 0u) {
          uint word = uint(findLSB(blocks)) * uint(FL_RECORDS / 32) + number / 32u;
          blocks &= blocks - 1u;
          if (is_rim) {
            atomicOr(rim_bits[word], 1u << (number & 31u));
          } else {
            atomicOr(cut_bits[word], 1u << (number & 31u));
          }
        }
      }
      barrier();
      add_records(block, rect.half_px);
      barrier();
    }
    barrier();
    if (first + number < from) fine_masks[fine_tile * params.mask_words + first + number] = rest_bits[number];
    barrier();
  }
  sum_light(light_here);
  vec3 light[16];
  [[unroll]] for (int k = 0; k < 16; ++k) {
    light[k] = vec3(group_light[3 * k], group_light[3 * k + 1], group_light[3 * k + 2]);
  }
  add_light(light, vec2(0.0), rect.half_px);
  [[unroll]] for (int k = 0; k < 16; ++k) {
    light[k] = vec3(coarse[supertile].light[3 * k], coarse[supertile].light[3 * k + 1],
                    coarse[supertile].light[3 * k + 2]);
  }
  const float kSuper = float(FL_SUPERTILE_PX);
  add_light(light, (vec2(cell) + 0.5) * kSuper - middle, FL_HULL * 0.5 * kSuper);
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
    ivec2 pixel = ivec2(pixel_low) + ivec2(0, i);
    if (pixel.x >= int(params.width) || pixel.y >= int(params.height)) continue;
    vec4 behind = kSolids ? imageLoad(radiance, pixel) : vec4(0.0);  // its distance stays for the beam pass
    imageStore(radiance, pixel, vec4(behind.rgb + params.forward.w * total[i], behind.a));
  }
}
