#version 460
// Adds what a rasteriser has summed up, in units of the exposure, to the radiance.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/rivals/shared/rival_io.h"

layout(local_size_x = FL_GROUP_FROXELS, local_size_y = FL_GROUP_FROXELS) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;
layout(set = 0, binding = FL_BINDING_BLENDED, rgba16f) uniform readonly image2D blended;

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(params.width) || pixel.y >= int(params.height)) return;
  vec4 behind = imageLoad(radiance, pixel);
  imageStore(radiance, pixel, vec4(behind.rgb + imageLoad(blended, pixel).rgb / params.exposure, behind.a));
}
