#version 460
// The pyramid of the mirrored camera's picture. First, with its parameters, the picture becomes level 0. Then, with
// those of the camera's own picture, pixels get their weight: those that show no floor there are of places behind or
// inside of other things. Then each level is made of the one before, with the weights 1 3 3 1 across and down.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/mirror_levels.glsl"
#include "render/shaders/lib/gloss.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;
layout(set = 0, binding = FL_BINDING_OWN_RADIANCE, rgba32f) uniform readonly image2D own_radiance;
layout(set = 0, binding = FL_BINDING_MIRROR, rgba32f) uniform image2D mirror;
// stage: -1: take the picture; 0: weights; else the level that is made.
layout(push_constant) uniform Push { int stage; int width; int height; uint count; } push;

void take(ivec2 pixel) {
  vec3 ray = normalize(ray_through(vec2(pixel) + 0.5));
  float before = 1.0 - min(ray_begin(ray) / surface_at(pixel, ray).t_m, 1.0);
  vec3 light = imageLoad(radiance, pixel).rgb;
  imageStore(mirror, mirror_texel(pixel, 0), vec4(any(isnan(light)) || any(isinf(light)) ? vec3(0.0) : light, 1.0));
  imageStore(mirror, mirror_texel(pixel, 1), vec4(before, 0.0, 0.0, 0.0));
}

void weigh(ivec2 pixel) {
  // All pixels that it is a part of.
  ivec2 own = ivec2(int(params.width), int(params.height));
  ivec2 size = ivec2(push.width, push.height);
  ivec2 first = pixel * own / size;
  ivec2 end = min(((pixel + 1) * own + size - 1) / size, own);
  float shown = 0.0;
  float all_px = 0.0;
  for (int y = first.y; y < end.y; ++y) {
    for (int x = first.x; x < end.x; ++x) {
      vec3 ray = normalize(ray_through(vec2(x, y) + 0.5));
      shown += floor_at(ray, imageLoad(own_radiance, ivec2(x, y)).a, push.count) != FL_NONE ? 1.0 : 0.0;
      all_px += 1.0;
    }
  }
  // A pixel that is not all floor counts little: its ray may be one of those that show none.
  float weight = shown > 0.0 ? max(pow(shown / all_px, 8.0), 1e-4) : 0.0;
  for (int i = 0; i < 2; ++i) {
    ivec2 texel = mirror_texel(pixel, i);
    imageStore(mirror, texel, weight * imageLoad(mirror, texel));
  }
}

void main() {
  ivec2 size = ivec2(push.width, push.height);
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  ivec4 to = mirror_level(size, max(push.stage, 0));
  if (any(greaterThanEqual(pixel, to.zw))) return;
  if (push.stage < 0) {
    take(pixel);
  } else if (push.stage == 0) {
    weigh(pixel);
  } else {
    ivec4 from = mirror_level(size, push.stage - 1);
    const float kWeights[4] = float[4](0.125, 0.375, 0.375, 0.125);
    vec4 sums[2] = vec4[2](vec4(0.0), vec4(0.0));
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 4; ++x) {
        ivec2 at = from.xy + clamp(2 * pixel + ivec2(x, y) - 1, ivec2(0), from.zw - 1);
        for (int i = 0; i < 2; ++i) sums[i] += kWeights[x] * kWeights[y] * imageLoad(mirror, mirror_texel(at, i));
      }
    }
    for (int i = 0; i < 2; ++i) imageStore(mirror, mirror_texel(to.xy + pixel, i), sums[i]);
  }
}
