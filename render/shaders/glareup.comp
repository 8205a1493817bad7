#version 460
// Glare: adds a level of the pyramid, made finer, to the next finer one.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/glare.glsl"

layout(local_size_x = FL_GROUP_GLARE, local_size_y = FL_GROUP_GLARE) in;

vec3 coarse_light(ivec2 p) {
  ivec2 size = ivec2(push.coarse_width, push.coarse_height);
  ivec2 inside = clamp(p, ivec2(-FL_GLARE_MARGIN), size + FL_GLARE_MARGIN - 1);
  vec3 light = glare_at(ivec2(push.coarse_x, push.coarse_y), inside);
  return in_level(p, size) ? light : vec3(0.0);
}

// A thread has the 2 x 2 fine pixels of a coarse one. The filter is 1 5 10 10 5 1 over 16 in each direction: of the
// coarse pixel itself 10, of the nearer neighbour 5, of the other one 1.
void main() {
  ivec2 own = ivec2(gl_GlobalInvocationID.xy) - FL_GLARE_MARGIN / 2;
  vec3 left[3];  // of the three rows
  vec3 right[3];
  for (int y = 0; y < 3; ++y) {
    vec3 before = coarse_light(own + ivec2(-1, y - 1));
    vec3 middle = 0.625 * coarse_light(own + ivec2(0, y - 1));
    vec3 after = coarse_light(own + ivec2(1, y - 1));
    left[y] = 0.3125 * before + middle + 0.0625 * after;
    right[y] = 0.0625 * before + middle + 0.3125 * after;
  }
  float above = push.is_last != 0u ? imageLoad(glare, ivec2(push.level, 0)).r : 1.0;
  float weight = imageLoad(glare, ivec2(push.level - 1, 0)).r;
  for (int i = 0; i < 4; ++i) {
    ivec2 p = 2 * own + ivec2(i & 1, i >> 1);
    if (!in_level(p, ivec2(push.fine_width, push.fine_height))) continue;
    vec3 upper = (i & 1) == 0 ? left[0] : right[0];
    vec3 middle = (i & 1) == 0 ? left[1] : right[1];
    vec3 lower = (i & 1) == 0 ? left[2] : right[2];
    bool is_upper = (i >> 1) == 0;
    vec3 sum = 0.625 * middle + (is_upper ? 0.3125 : 0.0625) * upper + (is_upper ? 0.0625 : 0.3125) * lower;
    ivec2 at = ivec2(push.fine_x, push.fine_y) + p;
    imageStore(glare, at, vec4(weight * imageLoad(glare, at).rgb + above * sum, 0.0));
  }
}
