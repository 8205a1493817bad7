#version 460
// Adds the splats of small lenses to the picture, in the order of the heads. A pixel that shows something nearer than a
// lens gets nothing of it. A workgroup has 32 x 32 pixels, 2 x 2 a thread.
#extension GL_GOOGLE_include_directive : require
#define FL_LENSES_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/lens_row.glsl"

#define FL_SIDE (FL_SPLAT_PX / 2)
layout(local_size_x = FL_SIDE, local_size_y = FL_SIDE) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

const uint kThreads = uint(FL_SIDE * FL_SIDE);
shared uint near_bits[kThreads / 32u];  // of so many heads: those whose splat reaches the pixels

void main() {
  uint thread = gl_LocalInvocationIndex;
  uvec2 low = gl_WorkGroupID.xy * uint(FL_SPLAT_PX);
  vec2 from_px = vec2(low);
  vec2 to_px = from_px + float(FL_SPLAT_PX);
  uvec2 size = uvec2(params.width, params.height);
  vec3 sums[4] = vec3[4](vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
  float shown_m[4] = float[4](0.0, 0.0, 0.0, 0.0);
  bool ready = false;
  for (uint from = 0u; from < FL_NOT_IN_CODE(params.head_count); from += kThreads) {
    barrier();
    if (thread < kThreads / 32u) near_bits[thread] = 0u;
    barrier();
    uint head = from + thread;
    if (head < params.head_count) {
      vec4 place = lenses[head].place;
      bool reaches = place.w > 0.0 && all(greaterThan(place.xy + place.w, from_px)) &&
                     all(lessThan(place.xy - place.w, to_px));
      if (reaches) atomicOr(near_bits[thread / 32u], 1u << (thread % 32u));
    }
    barrier();
    // Words without heads take time on lavapipe: it runs the body of a loop once if the loop has no round.
    uint words = (min(FL_NOT_IN_CODE(params.head_count) - from, kThreads) + 31u) / 32u;
    uint any_bits = 0u;
    for (uint w = 0u; w < words; ++w) any_bits |= near_bits[w];
    // Here and not beside each lens, since lavapipe runs both sides of a branch.
    if (any_bits != 0u && !ready) {
      for (uint i = 0u; i < 4u; ++i) {
        uvec2 pixel = min(low + gl_LocalInvocationID.xy + uint(FL_SIDE) * uvec2(i & 1u, i >> 1), size - 1u);
        shown_m[i] = surface_at(ivec2(pixel), normalize(ray_through(vec2(pixel) + 0.5))).t_m;
      }
      ready = true;
    }
    for (uint w = 0u; w < words; ++w) {
      for (uint bits = near_bits[w]; bits != 0u; bits &= bits - 1u) {
        LensRow row = lenses[from + 32u * w + uint(findLSB(bits))];
        for (uint i = 0u; i < 4u; ++i) {
          uvec2 pixel = low + gl_LocalInvocationID.xy + uint(FL_SIDE) * uvec2(i & 1u, i >> 1);
          sums[i] += lens_splat(row, vec2(pixel) + 0.5, shown_m[i]);
        }
      }
    }
  }
  for (uint i = 0u; i < 4u; ++i) {
    uvec2 pixel = low + gl_LocalInvocationID.xy + uint(FL_SIDE) * uvec2(i & 1u, i >> 1);
    if (any(greaterThanEqual(pixel, size)) || !any(greaterThan(sums[i], vec3(0.0)))) continue;
    vec4 before = imageLoad(radiance, ivec2(pixel));
    imageStore(radiance, ivec2(pixel), vec4(before.rgb + sums[i], before.a));
  }
}
