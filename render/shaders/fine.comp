#version 460
// Light in the haze, 32 x 32 pixels a workgroup: of the beams that the coarse pass has left, adds those that are smooth
// there, or smooth but for their rim, as polynomials, and the coarse pass's polynomial. What is neither stays in a mask
// for the beam pass. Lists keep the patch order.
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
#include "render/shaders/lib/tile_class.glsl"
#include "render/shaders/lib/tile_list.glsl"
#include "render/shaders/lib/tile_sum.glsl"

layout(local_size_x = FL_GROUP_TILE) in;
layout(set = 0, binding = FL_BINDING_COARSE, std430) readonly buffer CoarseBuffer { CoarseRow coarse[]; };
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

// Pixels of a thread, one below the other: a record is read once for all of them.
#define FL_ROWS (1024 / FL_GROUP_TILE)

// A beam that is smooth except at its rim: rho and h as polynomials of pixels from the group's middle, its colour, p of
// its profile in the lowest 3 bits, then a bit for each block of 16 x 8 pixels that it can touch.
#define FL_RIMS_MAX 256
shared vec4 rim_rows[4 * FL_RIMS_MAX];
shared uint rest_bits[FL_GROUP_TILE];  // of the words of one list
shared float group_light[FL_TILE_LIGHT];

// From x, y in half hulls to pixels from the middle.
void to_pixels(inout float c[6], float half_px) {
  float inverse = 1.0 / half_px;
  c[1] *= inverse;
  c[2] *= inverse;
  c[3] *= inverse * inverse;
  c[4] *= inverse * inverse;
  c[5] *= inverse * inverse;
}

// A bit for each block of 16 x 8 pixels that |rho| < 1 can reach: blocks 2 q and 2 q + 1 are quarter q's.
uint rim_blocks(float c[6]) {
  const vec2 reach = vec2(7.5, 3.5);
  float bend = abs(c[3]) * reach.x * reach.x + abs(c[4]) * reach.x * reach.y + abs(c[5]) * reach.y * reach.y;
  uint bits = 0u;
  for (uint block = 0u; block < 8u; ++block) {
    uint quarter = block >> 1;
    vec2 at = vec2(float(quarter & 1u) * 16.0 - 8.0, float(quarter >> 1) * 16.0 + float(block & 1u) * 8.0 - 12.0);
    float value = c[0] + at.x * (c[1] + at.x * c[3] + at.y * c[4]) + at.y * (c[2] + at.y * c[5]);
    vec2 slope = vec2(c[1] + 2.0 * at.x * c[3] + at.y * c[4], c[2] + 2.0 * at.y * c[5] + at.x * c[4]);
    if (abs(value) < 1.0 + dot(abs(slope), reach) + bend) bits |= 1u << block;
  }
  return bits;
}

void store_rim(uint slot, BeamRow row, Rect rect) {
  to_pixels(fit_rho, rect.half_px);
  to_pixels(fit_h, rect.half_px);
  // With the exponent of 1: a float that is not denormal keeps its bits.
  uint bits = 0x3f800000u | uint(rim_power(drawn_profile(row.eye.w))) | rim_blocks(fit_rho) << 3;
  rim_rows[4u * slot] = vec4(fit_rho[0], fit_rho[1], fit_rho[2], fit_rho[3]);
  rim_rows[4u * slot + 1u] = vec4(fit_rho[4], fit_rho[5], fit_h[0], fit_h[1]);
  rim_rows[4u * slot + 2u] = vec4(fit_h[2], fit_h[3], fit_h[4], fit_h[5]);
  rim_rows[4u * slot + 3u] = vec4(row.j0.rgb, uintBitsToFloat(bits));
}

// The pixels of this thread.
vec2 first_px;  // the middle of the first one, from the group's middle
vec3 total[FL_ROWS];

void add_rims(uint count, uint block) {
  float x = first_px.x;
  for (uint r = 0u; r < count; ++r) {
    vec4 last = rim_rows[4u * r + 3u];
    uint bits = floatBitsToUint(last.w);
    if ((bits & (8u << block)) == 0u) continue;
    vec4 a = rim_rows[4u * r];
    vec4 b = rim_rows[4u * r + 1u];
    vec4 c = rim_rows[4u * r + 2u];
    float rho_0 = a.x + x * (a.y + x * a.w);
    float rho_1 = a.z + x * b.x;
    float h_0 = b.z + x * (b.w + x * c.y);
    float h_1 = c.x + x * c.z;
    [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
      float y = first_px.y + float(i);
      float rho = rho_0 + y * (rho_1 + y * b.y);
      float q = max(1.0 - rho * rho, 0.0);
      float rim = q * sqrt(q);
      if (kProfile) rim = rim_factor(q, float(bits & 7u));
      total[i] += ((h_0 + y * (h_1 + y * c.w)) * rim) * last.rgb;
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
  float sum = 0.0;  // of thread k < 48: a coefficient of the smooth beams' light
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
    for (uint at = 0u; at < touching; at += uint(FL_GROUP_TILE)) {
      uint kind = kDark;
      uint id = 0u;
      vec3 color = vec3(0.0);
      BeamRow row;
      if (at + number < touching) {
        id = list_ids[at + number];
        row = beams[id];
        kind = tile_knows(row) ? tile_class(row, rect, tolerance) : kGeneral;
        if (kind == kSmooth) color = row.j0.rgb;
      }
      if (kind == kGeneral) atomicOr(rest_bits[id / 32u - first], 1u << (id & 31u));
      sum += tile_light_sum(color);
      uint rim_count;
      uint slot = ordered_slot(kind == kRim, rim_count);
      for (uint base = 0u; base < rim_count; base += uint(FL_RIMS_MAX)) {
        if (kind == kRim && slot - base < uint(FL_RIMS_MAX)) store_rim(slot - base, row, rect);
        barrier();
        add_rims(min(rim_count - base, uint(FL_RIMS_MAX)), block);
        barrier();
      }
    }
    barrier();
    if (first + number < from) fine_masks[fine_tile * params.mask_words + first + number] = rest_bits[number];
    barrier();
  }
  if (number < uint(FL_TILE_LIGHT)) group_light[number] = sum;
  barrier();
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
