#version 460
// Glare: a level of the pyramid from the next finer one; the first from the radiance. Its first thread also writes the
// weights of all levels.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/shared/glare.h"
#include "render/shaders/lib/glare.glsl"

layout(local_size_x = FL_GROUP_GLARE_DOWN, local_size_y = FL_GROUP_GLARE_DOWN) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;
layout(constant_id = FL_SPEC_GLARE_FIRST) const bool kFirst = true;  // the level is made of the radiance

// Light that is no number, or so much that sums may not be one, does not spread.
const float kLightMax = 1e30;
vec3 spreading(vec3 light) {
  return vec3(light.r >= 0.0 && light.r <= kLightMax ? light.r : 0.0,
              light.g >= 0.0 && light.g <= kLightMax ? light.g : 0.0,
              light.b >= 0.0 && light.b <= kLightMax ? light.b : 0.0);
}

// Of the finer level. The screen's pixels are means, as in the tone map.
vec3 fine_light(ivec2 p) {
  int margin = kFirst ? 0 : FL_GLARE_MARGIN;
  ivec2 size = ivec2(push.fine_width, push.fine_height);
  if (any(lessThan(p, ivec2(-margin))) || any(greaterThanEqual(p, size + margin))) return vec3(0.0);
  if (!kFirst) return glare_at(ivec2(push.fine_x, push.fine_y), p);
  int side = int(FL_NOT_IN_CODE(params.supersample));
  vec3 sum = vec3(0.0);
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      sum += spreading(imageLoad(radiance, p * side + ivec2(column, row)).rgb);
    }
  }
  return sum / float(side * side);
}

// Levels beyond the last one are so wide that their light leaves the picture.
void write_weights() {
  float pixel = 2.0 * length(params.up.xyz) * float(params.supersample) / float(params.height);
  float all = 0.0;
  for (int level = 1; level < FL_GLARE_WEIGHTS; ++level) all += glare_level_weight(level, pixel);
  float scale = push.share / max(all, 1.0);
  imageStore(glare, ivec2(0, 0), vec4(1.0 - all * scale));
  for (int level = 1; level < FL_GLARE_WEIGHTS; ++level) {
    imageStore(glare, ivec2(level, 0), vec4(scale * glare_level_weight(level, pixel)));
  }
}

// The filter is 1 5 10 10 5 1 over 32 in each direction.
const float kFilter[6] = float[6](0.03125, 0.15625, 0.3125, 0.3125, 0.15625, 0.03125);

// What the workgroup's pixels take light from, a channel after the other.
const int kSide = 2 * FL_GROUP_GLARE_DOWN + 4;
shared float fine[3 * kSide * kSide];

void main() {
  if (kFirst && gl_GlobalInvocationID.xy == uvec2(0u)) write_weights();
  ivec2 from = 2 * (FL_GROUP_GLARE_DOWN * ivec2(gl_WorkGroupID.xy) - FL_GLARE_MARGIN) - 2;
  for (int i = int(gl_LocalInvocationIndex); i < kSide * kSide; i += FL_GROUP_GLARE_DOWN * FL_GROUP_GLARE_DOWN) {
    vec3 light = fine_light(from + ivec2(i % kSide, i / kSide));
    fine[i] = light.r;
    fine[kSide * kSide + i] = light.g;
    fine[2 * kSide * kSide + i] = light.b;
  }
  barrier();
  ivec2 own = ivec2(gl_GlobalInvocationID.xy) - FL_GLARE_MARGIN;
  if (!in_level(own, ivec2(push.coarse_width, push.coarse_height))) return;
  vec3 sum = vec3(0.0);
  for (int y = 0; y < 6; ++y) {
    int first = (2 * int(gl_LocalInvocationID.y) + y) * kSide + 2 * int(gl_LocalInvocationID.x);
    vec3 row = vec3(0.0);
    for (int x = 0; x < 6; ++x) {
      row += kFilter[x] * vec3(fine[first + x], fine[kSide * kSide + first + x], fine[2 * kSide * kSide + first + x]);
    }
    sum += kFilter[y] * row;
  }
  imageStore(glare, ivec2(push.coarse_x, push.coarse_y) + own, vec4(sum, 0.0));
}
