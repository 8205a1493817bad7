#version 460
// From radiance to the screen: exposure, then the tone map.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/shared/agx.h"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;
layout(set = 0, binding = FL_BINDING_SCREEN, rgba8) uniform writeonly image2D screen;

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(params.width) || pixel.y >= int(params.height)) return;
  imageStore(screen, pixel, vec4(agx(imageLoad(radiance, pixel).rgb * params.exposure), 1.0));
}
