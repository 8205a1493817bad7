#version 460
// Writes the colours of pixels with edges (edges.comp) into the picture.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX / 4) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;
layout(set = 0, binding = FL_BINDING_EDGES, rgba32f) uniform readonly image2D edges;
layout(set = 0, binding = FL_BINDING_EDGE_MASKS, std430) readonly buffer EdgeMasksBuffer { uint edge_masks[]; };

void main() {
  uint tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  // Each thread has a column of four pixels: their bits are in two words.
  uvec2 first = gl_WorkGroupID.xy * uint(FL_TILE_PX) + gl_LocalInvocationID.xy * uvec2(1u, 4u);
  uint at = tile * uint(FL_EDGE_WORDS) + gl_LocalInvocationID.y * 2u;
  uint column = gl_LocalInvocationID.x;
  uint bits = (edge_masks[at] >> column & 0x10001u) | (edge_masks[at + 1u] >> column & 0x10001u) << 1;
  for (; bits != 0u; bits &= bits - 1u) {
    uint bit = uint(findLSB(bits));  // 0 and 16: of the first word, 1 and 17: of the second
    ivec2 pixel = ivec2(first + uvec2(0u, (bit & 1u) * 2u + (bit >> 4)));
    imageStore(radiance, pixel, vec4(imageLoad(edges, pixel).rgb, imageLoad(radiance, pixel).a));
  }
}
