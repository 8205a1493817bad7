#version 460
// Glare: a level of the pyramid from the next finer one; the first from the radiance. Its first thread also writes the
// weights of all levels.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/shared/glare.h"
#include "render/shaders/lib/glare.glsl"

layout(local_size_x = FL_GROUP_GLARE, local_size_y = FL_GROUP_GLARE) in;
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
vec3 fine_light(int x, int y, bool row_inside) {
  int margin = kFirst ? 0 : FL_GLARE_MARGIN;
  bool inside = row_inside && x >= -margin && x < push.fine_width + margin;
  ivec2 p = ivec2(clamp(x, -margin, push.fine_width + margin - 1), y);
  vec3 sum = vec3(0.0);
  if (kFirst) {
    int side = int(params.supersample);
    for (int row = 0; row < side; ++row) {
      for (int column = 0; column < side; ++column) {
        sum += spreading(imageLoad(radiance, p * side + ivec2(column, row)).rgb);
      }
    }
    sum /= float(side * side);
  } else {
    sum = glare_at(ivec2(push.fine_x, push.fine_y), p);
  }
  return inside ? sum : vec3(0.0);
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
vec3 filtered(vec3 a, vec3 b, vec3 c, vec3 d, vec3 e, vec3 f) {
  return 0.3125 * (c + d) + 0.15625 * (b + e) + 0.03125 * (a + f);
}
float weight_of(int tap) {
  float from_middle = abs(float(tap) - 2.5);
  return from_middle > 2.6 ? 0.0 : from_middle > 2.0 ? 0.03125 : from_middle > 1.0 ? 0.15625 : 0.3125;
}

// A thread has 4 x 4 pixels: 12 x 12 of the finer level hold what they take light from.
void main() {
  if (kFirst && gl_GlobalInvocationID.xy == uvec2(0u)) write_weights();
  ivec2 p = FL_GLARE_BLOCK * ivec2(gl_GlobalInvocationID.xy) - FL_GLARE_MARGIN;
  int margin = kFirst ? 0 : FL_GLARE_MARGIN;
  vec3 sums[16];
  for (int i = 0; i < 16; ++i) sums[i] = vec3(0.0);
  int x = 2 * p.x - 2;
  for (int tap = 0; tap < 12; ++tap) {
    int y = 2 * p.y - 2 + tap;
    bool inside = y >= -margin && y < push.fine_height + margin;
    y = clamp(y, -margin, push.fine_height + margin - 1);
    vec3 c0 = fine_light(x, y, inside);
    vec3 c1 = fine_light(x + 1, y, inside);
    vec3 c2 = fine_light(x + 2, y, inside);
    vec3 c3 = fine_light(x + 3, y, inside);
    vec3 c4 = fine_light(x + 4, y, inside);
    vec3 c5 = fine_light(x + 5, y, inside);
    vec3 c6 = fine_light(x + 6, y, inside);
    vec3 c7 = fine_light(x + 7, y, inside);
    vec3 c8 = fine_light(x + 8, y, inside);
    vec3 c9 = fine_light(x + 9, y, inside);
    vec3 c10 = fine_light(x + 10, y, inside);
    vec3 c11 = fine_light(x + 11, y, inside);
    vec3 row0 = filtered(c0, c1, c2, c3, c4, c5);
    vec3 row1 = filtered(c2, c3, c4, c5, c6, c7);
    vec3 row2 = filtered(c4, c5, c6, c7, c8, c9);
    vec3 row3 = filtered(c6, c7, c8, c9, c10, c11);
    for (int r = 0; r < 4; ++r) {
      float weight = weight_of(tap - 2 * r);
      sums[4 * r] += weight * row0;
      sums[4 * r + 1] += weight * row1;
      sums[4 * r + 2] += weight * row2;
      sums[4 * r + 3] += weight * row3;
    }
  }
  for (int i = 0; i < 16; ++i) {
    ivec2 own = p + ivec2(i & 3, i >> 2);
    if (!in_level(own, ivec2(push.coarse_width, push.coarse_height))) continue;
    imageStore(glare, ivec2(push.coarse_x, push.coarse_y) + own, vec4(sums[i], 0.0));
  }
}
