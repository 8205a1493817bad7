#version 460
// Writes the colours of pixels with edges (edgemix.comp) into the picture.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/edge_columns.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_EDGE_COLUMN_ROWS) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;
layout(set = 0, binding = FL_BINDING_EDGES, rgba32f) uniform readonly image2D edges;

void main() {
  uint tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  for (uint bits = edges_of_column(tile); bits != 0u; bits &= bits - 1u) {
    ivec2 pixel = edge_pixel(bits);
    imageStore(radiance, pixel, vec4(imageLoad(edges, pixel).rgb, imageLoad(radiance, pixel).a));
  }
}
