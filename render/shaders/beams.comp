#version 460
// Light in the haze: adds the in-scattered light of every beam along the pixel's ray, up to the surface it shows. A
// workgroup has 32 x 32 pixels. Beams that are smooth there, or smooth but for their rim, are polynomials; what is
// neither is tried again in each quarter of 16 x 16 pixels, and the rest is computed pixel by pixel. Beams that are
// smooth over 64 x 64 pixels come as one polynomial from the coarse pass. Lists keep the patch order.
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_MASKS
#define FL_MASKS_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/lib/gobo.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/tile_node.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/thin.glsl"
layout(constant_id = FL_SPEC_METHOD) const uint kMethod = FL_METHOD_GAUSS;
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

#define FL_ROWS 4  // pixels a thread, one below the other, so that a beam's row is read once for all of them
const float kGroupPx = 32.0;
const float kQuarterPx = 16.0;

// A beam that is smooth but for its rim: rho and h as polynomials of pixels from the group's middle; its color; p of the
// profile in the lowest 3 bits, then a bit for each block of 16 x 8 pixels that it can touch.
shared vec4 rim_rows[4 * FL_GROUP_TILE];
shared uint general_ids[FL_GROUP_TILE];        // of the group, to be tried in the quarters
shared uint quarter_ids[FL_GROUP_TILE];        // 64 for each quarter, to be computed pixel by pixel
shared float group_light[FL_TILE_LIGHT];
shared float quarter_light[4 * FL_TILE_LIGHT];

// From x, y in half hulls about a rectangle's middle to pixels about the group's. away: the rectangle's middle from it.
void to_pixels(inout float c[6], vec2 away, float half_px) {
  float inverse = 1.0 / half_px;
  float a = c[3] * inverse * inverse;
  float b = c[4] * inverse * inverse;
  float e = c[5] * inverse * inverse;
  float p = c[1] * inverse;
  float q = c[2] * inverse;
  c[0] += -p * away.x - q * away.y + a * away.x * away.x + b * away.x * away.y + e * away.y * away.y;
  c[1] = p - 2.0 * a * away.x - b * away.y;
  c[2] = q - 2.0 * e * away.y - b * away.x;
  c[3] = a;
  c[4] = b;
  c[5] = e;
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

void store_rim(uint slot, BeamRow row, Rect rect, vec2 middle, uint blocks_allowed) {
  to_pixels(fit_rho, rect.middle - middle, rect.half_px);
  to_pixels(fit_h, rect.middle - middle, rect.half_px);
  uint bits = uint(rim_power(drawn_profile(row.eye.w))) | (rim_blocks(fit_rho) & blocks_allowed) << 3;
  rim_rows[4u * slot] = vec4(fit_rho[0], fit_rho[1], fit_rho[2], fit_rho[3]);
  rim_rows[4u * slot + 1u] = vec4(fit_rho[4], fit_rho[5], fit_h[0], fit_h[1]);
  rim_rows[4u * slot + 2u] = vec4(fit_h[2], fit_h[3], fit_h[4], fit_h[5]);
  rim_rows[4u * slot + 3u] = vec4(row.j0.rgb, uintBitsToFloat(bits));
}

// The pixels of this thread.
vec2 first_px;  // the middle of the first one, from the group's middle
vec3 d[FL_ROWS];
float t_max_m[FL_ROWS];
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
    for (int i = 0; i < FL_ROWS; ++i) {
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
  for (int n = 0; n < 4; ++n) {
    rows[n] = light[4 * n] * tx.x + light[4 * n + 1] * tx.y + light[4 * n + 2] * tx.z + light[4 * n + 3] * tx.w;
  }
  for (int i = 0; i < FL_ROWS; ++i) {
    vec4 ty = chebyshev((first_px.y + float(i) - from.y) / half_px);
    total[i] += rows[0] * ty.x + rows[1] * ty.y + rows[2] * ty.z + rows[3] * ty.w;
  }
}

// One beam, pixel by pixel.
void add_general(uint index, Medium medium) {
  BeamRow row = beams[index];
  BeamShape shape = beam_shape(row);
  shape.profile_power = drawn_profile(shape.profile_power);
  // A flat profile 1 - rho^(2m) is a polynomial of degree 2m in s: m = 3 and 4 need one and two nodes more. So do the
  // soft ones, of degree 2/m.
  uint nodes = kNodes;
  if (kProfile) {
    float degree = max(shape.profile_power, 1.0 / shape.profile_power);
    nodes = min(nodes + (degree > 2.5 ? 1u : 0u) + (degree > 3.5 ? 1u : 0u), 8u);
  }
  bool measured = kMeasured && row.measured != 0u;
  // A rectangle's profile is the product of two.
  if (kRectangle && row.squeeze > 0.0) nodes = min(kNodes + 5u, 8u);
  gobo_begin(row);
  bool gobo = has_gobo(row);
  bool plain = thin_is_plain(row, gobo);
  bool thin = thin_in_haze_applies(row);
  if (thin && plain) nodes = min(max(nodes, kNodes + 1u), 8u);  // (1 - rho^2)^3
  for (int i = 0; i < FL_ROWS; ++i) {
    vec3 eye = row.eye.xyz;
    vec3 ray = to_light(row, d[i]);
    BeamShape beam = shape;
    float gain = 1.0;
    if (thin) {
      gain = thin_in_haze(beam, row, eye, ray, dot(d[i], params.forward.xyz), t_max_m[i], plain);
    }
    Chord chord;
    bool seen = beam_chord(beam, eye, ray, 0.0, t_max_m[i], chord);
    if (kRectangle && row.squeeze > 0.0 && seen) seen = chord_in_rectangle(chord);
    if (kBlades && (row.flags & FL_BEAM_BLADES) != 0u && seen) {
      for (int e = 0; e < 4; ++e) {
        seen = chord_cut(chord, blades[index].edge[e].xy, blades[index].edge[e].z) && seen;
      }
      chord_close(chord);
    }
    if (seen) {
      vec3 value;
      if (gobo) {
        gobo_sample = 0u;
        const vec2 as_it_is = vec2(1.0, 0.0);  // each wheel turns by itself
        value = kMethod == uint(FL_METHOD_MARCH)
                    ? chord_inscatter_march_gobo(beam, medium, chord, ray, kNodes, kExtinction, row.gobo, as_it_is)
                    : chord_inscatter_gobo(beam, medium, chord, ray, kGoboTaps, kExtinction, row.gobo, as_it_is);
      } else if (kMethod == uint(FL_METHOD_MARCH)) {
        value = vec3(chord_inscatter_march(beam, medium, chord, ray, kNodes, kExtinction));
      } else if (measured) {
        value = vec3(chord_inscatter_measured(beam, medium, chord, ray, kNodes, kExtinction));
      } else if (kWide && beam.spread > kWideSpread) {
        value = vec3(chord_inscatter_wide(beam, medium, chord, ray, kNodes > 3u ? 2u : 1u, kExtinction));
      } else {
        value = vec3(chord_inscatter_gauss(beam, medium, chord, ray, nodes, kExtinction));
      }
      total[i] += row.j0.rgb * (gain * value);
    }
  }
}

void main() {
  uint number = thread_number();
  uint quarter = number >> 6;
  uint block = number >> 5;
  uvec2 group_low = gl_WorkGroupID.xy * uint(2 * FL_TILE_PX);
  vec2 middle = vec2(group_low) + 0.5 * kGroupPx;
  uvec2 pixel_low = group_low + uvec2((quarter & 1u) * 16u + (number & 15u),
                                      (quarter >> 1) * 16u + ((number >> 4) & 3u) * uint(FL_ROWS));
  first_px = vec2(pixel_low) + 0.5 - middle;
  Medium medium = Medium(params.anisotropy, params.position.w);
  for (int i = 0; i < FL_ROWS; ++i) {
    ivec2 pixel = ivec2(pixel_low) + ivec2(0, i);
    bool inside = pixel.x < int(params.width) && pixel.y < int(params.height);
    d[i] = normalize(ray_through(vec2(pixel) + 0.5));
    t_max_m[i] = inside ? FL_FAR_M : 0.0;
    if (kSolids && inside) t_max_m[i] = imageLoad(radiance, pixel).a;  // the surface pass left it there
    total[i] = vec3(0.0);
  }
  uvec2 cell = gl_WorkGroupID.xy / uint(FL_SUPERTILE_PX / (2 * FL_TILE_PX));
  uint supertile = cell.y * params.supertiles_x + cell.x;
  float tolerance = kTiles ? coarse[supertile].tolerance : 0.0;
  uvec2 picture = uvec2(params.width, params.height);
  // Two rectangles: the group's, and the quarter's of this thread. A quarter outside the picture has no pixel.
  Rect group_rect = Rect(middle, FL_HULL * 0.5 * kGroupPx, RectDepth(0.0, 0.0, true, vec2(0.0), vec3(0.0)));
  uvec2 quarter_low = group_low + uvec2(quarter & 1u, quarter >> 1) * uint(FL_TILE_PX);
  Rect quarter_rect = Rect(vec2(quarter_low) + 0.5 * kQuarterPx, FL_HULL * 0.5 * kQuarterPx, group_rect.depth);
  bool has_pixels = quarter_low.x < picture.x && quarter_low.y < picture.y;
  if (kTiles) {
    group_rect.depth = rect_depth(gl_WorkGroupID.xy * 2u, 2u);
    if (has_pixels) quarter_rect.depth = rect_depth(quarter_low / uint(FL_TILE_PX), 1u);
  }
  float group_sum = 0.0;    // of thread k < 48: a coefficient of the group's light
  float quarter_sum = 0.0;  // of thread k < 48 of a quarter: of the quarter's
  uint words = (counts.live_count + 31u) / 32u;
  for (uint from = 0u; from < words;) {
    from = list_fill(supertile, from);
    uint listed = list_count;
    // Those that can touch the group, at the front of the list.
    uint touching = 0u;
    for (uint at = 0u; at < listed; at += uint(FL_GROUP_TILE)) {
      uint id = 0u;
      bool touches = false;
      if (at + number < listed) {
        id = list_ids[at + number];
        BeamRow row = beams[id];
        vec2 high = min(vec2(group_low) + kGroupPx, vec2(picture));
        touches = beam_touches(row, beam_bound(row, 1.0), vec2(group_low), high);
      }
      uint count;
      uint slot = ordered_slot(touches, 1u, count);
      if (touches) list_ids[touching + slot] = id;  // not past what has been read
      touching += count;
    }
    barrier();
    for (uint at = 0u; at < touching; at += uint(FL_GROUP_TILE)) {
      // Round 0: the group. Rounds 1 on: 64 beams in each quarter.
      uint general_count = 0u;
      uint rounds = 1u;
      for (uint round = 0u; round < rounds; ++round) {
        bool in_quarters = round > 0u;
        uint kind = kDark;
        uint id = 0u;
        vec3 color = vec3(0.0);
        uint task = in_quarters ? (round - 1u) * 64u + (number & 63u) : at + number;
        bool has_task = task < (in_quarters ? general_count : touching) && (has_pixels || !in_quarters);
        BeamRow row;
        Rect rect = group_rect;
        if (in_quarters) rect = quarter_rect;
        if (has_task) {
          id = in_quarters ? general_ids[task] : list_ids[task];
          row = beams[id];
          if (in_quarters) {
            vec2 high = min(vec2(quarter_low) + kQuarterPx, vec2(picture));
            has_task = beam_touches(row, beam_bound(row, 1.0), vec2(quarter_low), high);
          }
        }
        if (has_task) {
          kind = kGeneral;
          if (kTiles && tile_knows(row)) kind = tile_class(row, rect, tolerance);
          if (kind == kSmooth) color = row.j0.rgb;
        }
        uint rim_count = 0u;
        if (kTiles) {
          float sum = tile_light_sum(color, in_quarters ? 4u : 1u);
          if (in_quarters) {
            quarter_sum += sum;
          } else {
            group_sum += sum;
          }
          uint slot = ordered_slot(kind == kRim, 1u, rim_count);
          if (kind == kRim) store_rim(slot, row, rect, middle, in_quarters ? 3u << (2u * quarter) : 255u);
        }
        uint count;
        uint slot = ordered_slot(kind == kGeneral, in_quarters ? 4u : 1u, count);
        if (kind == kGeneral) {
          if (in_quarters) {
            quarter_ids[quarter * 64u + slot] = id;
          } else {
            general_ids[slot] = id;
          }
        }
        barrier();
        if (kTiles) add_rims(rim_count, block);
        if (in_quarters) {
          for (uint g = 0u; g < count; ++g) {
            add_general(subgroupBroadcastFirst(quarter_ids[quarter * 64u + g]), medium);
          }
        } else {
          general_count = count;
          rounds = 1u + (count + 63u) / 64u;
        }
        barrier();
      }
    }
  }
  if (kTiles) {
    if (number < uint(FL_TILE_LIGHT)) group_light[number] = group_sum;
    if ((number & 63u) < uint(FL_TILE_LIGHT)) quarter_light[quarter * uint(FL_TILE_LIGHT) + (number & 63u)] = quarter_sum;
    barrier();
    vec3 light[16];
    for (int k = 0; k < 16; ++k) {
      uint at = quarter * uint(FL_TILE_LIGHT) + 3u * uint(k);
      light[k] = vec3(quarter_light[at], quarter_light[at + 1u], quarter_light[at + 2u]);
    }
    add_light(light, quarter_rect.middle - middle, quarter_rect.half_px);
    for (int k = 0; k < 16; ++k) {
      light[k] = vec3(group_light[3 * k], group_light[3 * k + 1], group_light[3 * k + 2]);
    }
    add_light(light, vec2(0.0), group_rect.half_px);
    for (int k = 0; k < 16; ++k) {
      light[k] = vec3(coarse[supertile].light[3 * k], coarse[supertile].light[3 * k + 1],
                      coarse[supertile].light[3 * k + 2]);
    }
    const float kSuper = float(FL_SUPERTILE_PX);
    add_light(light, (vec2(cell) + 0.5) * kSuper - middle, FL_HULL * 0.5 * kSuper);
  }
  for (int i = 0; i < FL_ROWS; ++i) {
    ivec2 pixel = ivec2(pixel_low) + ivec2(0, i);
    if (pixel.x >= int(params.width) || pixel.y >= int(params.height)) continue;
    vec3 behind = kSolids ? imageLoad(radiance, pixel).rgb : vec3(0.0);
    imageStore(radiance, pixel, vec4(behind + params.forward.w * total[i], 1.0));
  }
}
