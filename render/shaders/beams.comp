#version 460
// Light in the haze, pixel by pixel: adds the in-scattered light of every beam along the pixel's ray, up to the surface
// it shows. With tile classes, of the beams that the fine pass has left. FL_GOBO_BEAMS: beams may have gobos.
// FL_USE_HAZE: haze is not even.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_MASKS
#define FL_MASKS_ACCESS readonly
#define FL_USE_FINE_MASKS
#define FL_FINE_MASKS_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/lib/view.glsl"
#ifdef FL_GOBO_BEAMS
#include "render/shaders/lib/gobo.glsl"
#else
#include "render/shaders/lib/blades.glsl"
#endif
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#ifdef FL_GOBO_BEAMS
#include "render/shaders/lib/gobo_chord.glsl"
#endif
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/thin.glsl"
#include "render/shaders/lib/shadow.glsl"

// The tile itself, 16 x 16 pixels.
bool tile_touches(BeamRow row) {
  vec2 low = vec2(gl_WorkGroupID.xy * uint(FL_TILE_PX));
  vec2 high = min(low + float(FL_TILE_PX), vec2(float(params.width), float(params.height)));
  return beam_touches(row, beam_bound(row, 1.0), low, high);
}
layout(constant_id = FL_SPEC_TILES) const bool kTiles = false;
#define FL_WALK_FINE (kTiles && counts.fine_groups[0] > 0u)
#include "render/shaders/lib/tile_walk.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX / FL_ROWS) in;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
layout(constant_id = FL_SPEC_METHOD) const uint kMethod = FL_METHOD_GAUSS;
layout(constant_id = FL_SPEC_NODES) const uint kNodes = 3;
layout(constant_id = FL_SPEC_BOXES) const bool kBoxes = true;
layout(constant_id = FL_SPEC_BODIES) const bool kBodies = true;

layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

// The code of gobos is long: once in the shader, and not once a row.
#if defined(FL_GOBO_BEAMS) && !defined(FL_UNROLLED)
#define FL_EACH_ROW [[dont_unroll]]
#else
#define FL_EACH_ROW [[unroll]]
#endif

// Those of a beam's shadows that can reach the tile, a bit each.
shared uint shadow_bits[FL_BEAM_SHADOWS_MAX / 32];
shared uint shadow_found;  // the largest kShadow...
shared uint tile_far_m;    // bits of the largest depth that a pixel shows

// Tests the shadows of a beam against the tile, shared out among the threads. All threads call it together.
uint tile_shadows(uint index, BeamRow row) {
  uint lane = gl_LocalInvocationIndex;
  const uint kThreads = uint(FL_TILE_PX * FL_TILE_PX / FL_ROWS);
  uint first = shadow_lists[index].first;
  uint count = shadow_lists[index].count;
  if (count == 0u) return kShadowNone;
  barrier();  // the bits before have been read
  for (uint w = lane; w < (count + 31u) / 32u; w += kThreads) shadow_bits[w] = 0u;
  if (lane == 0u) shadow_found = kShadowNone;
  barrier();
  vec2 low = vec2(gl_WorkGroupID.xy * uint(FL_TILE_PX));
  vec2 high = min(low + float(FL_TILE_PX), vec2(float(params.width), float(params.height)));
  ShadowCell cell = shadow_cell(row, low, high, uintBitsToFloat(tile_far_m));
  bool widened = beam_thin(row) > 0.0;  // its shadows may be anywhere
  for (uint s = lane; s < count; s += kThreads) {
    uint found = widened ? kShadowSome : shadow_in_cell(first + s, cell);
    if (found != kShadowNone) {
      atomicOr(shadow_bits[s >> 5], 1u << (s & 31u));
      atomicMax(shadow_found, found);
    }
  }
  barrier();
  return shadow_found;
}

// The shadows of one chord.
ShadowParts chord_shadows(uint index, BeamRow row, BeamShape beam, Chord chord, vec3 ray) {
  ShadowParts parts;
  shadow_parts_clear(parts);
  ShadowChord ends = shadow_chord(row, beam, chord, ray);
  uint first = shadow_lists[index].first;
  uint words = (shadow_lists[index].count + 31u) / 32u;
  for (uint w = 0u; w < words; ++w) {
    for (uint bits = subgroupBroadcastFirst(shadow_bits[w]); bits != 0u; bits &= bits - 1u) {
      float x0;
      float x1;
      if (shadow_part(first + w * 32u + uint(findLSB(bits)), ends, x0, x1)) shadow_parts_add(parts, x0, x1);
    }
  }
  return parts;
}

void main() {
  Medium medium = Medium(params.anisotropy, params.position.w);
  vec3 d[FL_ROWS];
  float t_max_m[FL_ROWS];
  vec3 total[FL_ROWS];
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
    ivec2 pixel = tile_pixel(i);
    bool inside = in_picture(pixel);
    d[i] = normalize(ray_through(vec2(pixel) + 0.5));
    t_max_m[i] = inside ? FL_FAR_M : 0.0;
    if ((kBoxes || kBodies) && inside) t_max_m[i] = imageLoad(radiance, pixel).a;  // the surface pass left it there
    total[i] = vec3(0.0);
  }
  if (kShadows) {
    if (gl_LocalInvocationIndex == 0u) tile_far_m = 0u;
    barrier();
    float far_m = 0.0;
    [[unroll]] for (int i = 0; i < FL_ROWS; ++i) far_m = max(far_m, t_max_m[i] * dot(d[i], params.forward.xyz));
    atomicMax(tile_far_m, floatBitsToUint(far_m));
    barrier();
  }
  for (uint base = 0u; base < counts.live_count; base += FL_WALK_BEAMS) {
    if (!tile_walk(base)) continue;
    FL_WALK_BEGIN(base, index)
      BeamRow row = beams[index];
      BeamShape shape = beam_shape(row);
      shape.profile_power = drawn_profile(shape.profile_power);
      // A flat profile 1 - rho^(2m) is a polynomial of degree 2m in s: m = 3 and 4 need one and two nodes more. So do
      // the soft ones, of degree 2/m.
      uint nodes = kNodes;
      if (kProfile) {
        float degree = max(shape.profile_power, 1.0 / shape.profile_power);
        nodes = min(nodes + (degree > 2.5 ? 1u : 0u) + (degree > 3.5 ? 1u : 0u), 8u);
      }
      uint shadowed = kShadows ? tile_shadows(index, row) : kShadowNone;
      if (shadowed == kShadowAll) continue;
      bool measured = kMeasured && row.measured != 0u;
      // A rectangle's profile is the product of two.
      if (kRectangle && row.squeeze > 0.0) nodes = min(kNodes + 5u, 8u);
#ifdef FL_GOBO_BEAMS
      gobo_begin(index);
      bool gobo = has_gobo(row);
#else
      const bool gobo = false;
#endif
      bool plain = thin_is_plain(row, gobo);
      bool thin = thin_in_haze_applies(row);
      if (thin && plain) nodes = min(max(nodes, kNodes + 1u), 8u);  // (1 - rho^2)^3
      FL_EACH_ROW for (int i = 0; i < FL_ROWS; ++i) {
        vec3 eye = row.eye.xyz;
        vec3 ray = to_light(row, d[i]);
        BeamShape beam = shape;
        float gain = 1.0;
        if (thin) {
          gain = thin_in_haze(beam, row, eye, ray, dot(d[i], params.forward.xyz), t_max_m[i], plain);
        }
#ifdef FL_HAZE_FIELD
        haze_begin(vec2(tile_pixel(i)) + 0.5);
#endif
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
          ShadowParts parts;
          shadow_parts_clear(parts);
          if (kShadows && shadowed != kShadowNone) parts = chord_shadows(index, row, beam, chord, ray);
          Chord whole = chord;
          vec3 value = vec3(0.0);
          // The lit parts, one after the other. Without shadows there is one.
          float from = 0.0;
          bool more = true;
          while (more) {
            float to = 1.0;
            float next = 1.0;
            if (kShadows) {
              more = shadow_parts_next(parts, from, to, next);
              to = min(to, 1.0);
              chord = shadowed != kShadowNone ? chord_part(whole, from, to) : whole;
            } else {
              more = false;
            }
            vec3 part = vec3(0.0);
#ifdef FL_GOBO_BEAMS
            if (gobo) {
              if (kMethod == uint(FL_METHOD_MARCH)) {
                gobo_sample = 0u;
                const vec2 as_it_is = vec2(1.0, 0.0);  // each wheel turns by itself
                part = chord_inscatter_march_gobo(beam, medium, chord, ray, kNodes, kExtinction, row.gobo, as_it_is);
              } else {
                part = gobo_inscatter(beam, medium, chord, ray, kExtinction);
              }
            } else
#endif
            if (kMethod == uint(FL_METHOD_MARCH)) {
              part = vec3(chord_inscatter_march(beam, medium, chord, ray, kNodes, kExtinction));
            } else if (measured) {
              part = vec3(chord_inscatter_measured(beam, medium, chord, ray, kNodes, kExtinction));
            } else if (kWide && beam.spread > kWideSpread) {
              part = vec3(chord_inscatter_wide(beam, medium, chord, ray, kNodes > 3u ? 2u : 1u, kExtinction));
            } else {
              part = vec3(chord_inscatter_gauss(beam, medium, chord, ray, nodes, kExtinction));
            }
            value += to > from ? part : vec3(0.0);
            from = next;
          }
          total[i] += kShowsClasses ? kClassPixel : row.j0.rgb * (gain * value);
        }
      }
    FL_WALK_END
  }
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
    ivec2 pixel = tile_pixel(i);
    if (!in_picture(pixel)) continue;
    vec3 behind = kBoxes || kBodies || kTiles ? imageLoad(radiance, pixel).rgb : vec3(0.0);
    imageStore(radiance, pixel, vec4(behind + light_scale() * total[i], 1.0));
  }
}
