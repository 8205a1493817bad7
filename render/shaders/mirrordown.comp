#version 460
// The pyramid of the mirrored camera's picture: its level 0 from the picture, each other one from the level before,
// with the weights 1 3 3 1 across and down.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/mirror_levels.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;
layout(set = 0, binding = FL_BINDING_MIRROR, rgba32f) uniform image2D mirror;
layout(push_constant) uniform Push { int level; } push;

void main() {
  ivec2 size = ivec2(int(params.width), int(params.height));
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  ivec4 to = mirror_level(size, push.level);
  if (any(greaterThanEqual(pixel, to.zw))) return;
  vec4 sum = vec4(0.0);
  if (push.level == 0) {
    vec3 ray = normalize(ray_through(vec2(pixel) + 0.5));
    float behind = 1.0 - min(ray_begin(ray) / surface_at(pixel, ray).t_m, 1.0);
    vec3 light = imageLoad(radiance, pixel).rgb;
    sum = vec4(any(isnan(light)) || any(isinf(light)) ? vec3(0.0) : light, behind);
  } else {
    ivec4 from = mirror_level(size, push.level - 1);
    const float kWeights[4] = float[4](0.125, 0.375, 0.375, 0.125);
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 4; ++x) {
        ivec2 at = clamp(2 * pixel + ivec2(x, y) - 1, ivec2(0), from.zw - 1);
        sum += kWeights[x] * kWeights[y] * imageLoad(mirror, from.xy + at);
      }
    }
  }
  imageStore(mirror, to.xy + pixel, sum);
}
