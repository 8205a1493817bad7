#version 460
// Light in the haze, pixel by pixel: adds the in-scattered light of every beam along the pixel's ray, up to the surface
// it shows. With tile classes, of the beams that the fine pass has left. FL_GOBO_BEAMS: beams may have gobos.
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
#ifdef FL_GOBO_BEAMS
#include "render/shaders/lib/gobo_chord.glsl"
#endif
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/thin.glsl"

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
#ifdef FL_GOBO_BEAMS
          if (gobo) {
            if (kMethod == uint(FL_METHOD_MARCH)) {
              gobo_sample = 0u;
              const vec2 as_it_is = vec2(1.0, 0.0);  // each wheel turns by itself
              value = chord_inscatter_march_gobo(beam, medium, chord, ray, kNodes, kExtinction, row.gobo, as_it_is);
            } else {
              value = gobo_inscatter(beam, medium, chord, ray, kExtinction);
            }
          } else
#endif
          if (kMethod == uint(FL_METHOD_MARCH)) {
            value = vec3(chord_inscatter_march(beam, medium, chord, ray, kNodes, kExtinction));
          } else if (measured) {
            value = vec3(chord_inscatter_measured(beam, medium, chord, ray, kNodes, kExtinction));
          } else if (kWide && beam.spread > kWideSpread) {
            value = vec3(chord_inscatter_wide(beam, medium, chord, ray, kNodes > 3u ? 2u : 1u, kExtinction));
          } else {
            value = vec3(chord_inscatter_gauss(beam, medium, chord, ray, nodes, kExtinction));
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
