#version 460
// Depth of field: the widest blur in each tile of the picture, pixels. A workgroup a tile.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/blur.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;
layout(set = 0, binding = FL_BINDING_BLURS, std430) writeonly buffer BlursBuffer { float blurs[]; };

shared uint widest;  // bits of a float that is not negative: as integers they have the same order

void main() {
  uvec2 pixel = gl_GlobalInvocationID.xy;
  if (gl_LocalInvocationIndex == 0u) widest = 0u;
  barrier();
  if (pixel.x < params.width && pixel.y < params.height) {
    atomicMax(widest, floatBitsToUint(abs(blur_px(pixel, imageLoad(radiance, ivec2(pixel)).a))));
  }
  barrier();
  if (gl_LocalInvocationIndex == 0u) {
    blurs[gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x] = uintBitsToFloat(widest);
  }
}
