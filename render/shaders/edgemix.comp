#version 460
// Mixes the colours of pixels with an edge (edges.comp): each sample has that of the pixel or of one of its neighbours.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/edge_columns.glsl"
#include "render/shaders/lib/edge_samples.glsl"
layout(local_size_x = FL_TILE_PX, local_size_y = FL_EDGE_COLUMN_ROWS) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;
layout(set = 0, binding = FL_BINDING_EDGES, rgba32f) uniform writeonly image2D edges;
layout(set = 0, binding = FL_BINDING_EDGE_SAMPLES, std430) readonly buffer EdgeSamplesBuffer { uint edge_samples[]; };
// The rows of the picture that are mixed: whole tiles.
layout(push_constant) uniform RowsPush {
  int first;
  int end;
} rows;

vec3 color_of(ivec2 pixel) {
  uint first = (uint(pixel.y - rows.first) * params.width + uint(pixel.x)) * kSamples;
  uvec2 counts = uvec2(0u);  // of samples with the colour of each of the nine: six bits each
  for (uint n = 0u; n < kSamples; ++n) {
    uint best = edge_samples[first + n] & 15u;
    counts += best < 5u ? uvec2(1u << (6u * best), 0u) : uvec2(0u, 1u << (6u * (best - 5u)));
  }
  vec3 sum = vec3(0.0);
  for (int n = 0; n < 9; ++n) {
    uint count = (n < 5 ? counts.x >> (6 * n) : counts.y >> (6 * (n - 5))) & 63u;
    if (count == 0u) continue;
    sum += imageLoad(radiance, pixel + ivec2(n % 3, n / 3) - 1).rgb * (float(count) / float(kSamples));
  }
  return sum;
}

void main() {
  uint tile = (uint(rows.first) / FL_TILE_PX + gl_WorkGroupID.y) * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  for (uint bits = edges_of_column(tile); bits != 0u; bits &= bits - 1u) {
    ivec2 pixel = edge_pixel(bits, rows.first);
    imageStore(edges, pixel, vec4(color_of(pixel), 1.0));
  }
}
