#version 460
// From radiance to the screen: the mean of the pixels that one of the screen stands for, exposure, tone map, dither.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/shared/agx.h"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;
layout(set = 0, binding = FL_BINDING_SCREEN, rgba8) uniform writeonly image2D screen;

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  int side = int(params.supersample);
  if (pixel.x * side >= int(params.width) || pixel.y * side >= int(params.height)) return;
  vec3 sum = vec3(0.0);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) sum += imageLoad(radiance, pixel * side + ivec2(x, y)).rgb;
  }
  vec3 shown = agx(sum * (params.exposure / float(side * side)));
  imageStore(screen, pixel, vec4(dithered(shown, uint(pixel.x), uint(pixel.y)), 1.0));
}
