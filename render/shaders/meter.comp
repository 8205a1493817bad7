#version 460
// The meter of the automatic exposure, first half: counts the pixels of the radiance by their luminance. Counts are
// integers, so their order does not matter. Light that is no number does not count.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/meter.glsl"

layout(local_size_x = FL_GROUP_METER, local_size_y = FL_GROUP_METER) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;

const uint kThreads = uint(FL_GROUP_METER * FL_GROUP_METER);
shared uint own_bins[FL_METER_BINS];

void main() {
  uint thread = gl_LocalInvocationIndex;
  for (uint i = thread; i < uint(FL_METER_BINS); i += kThreads) own_bins[i] = 0u;
  barrier();
  uvec2 low = gl_GlobalInvocationID.xy * 4u;
  for (uint i = 0u; i < 16u; ++i) {
    uvec2 pixel = low + uvec2(i & 3u, i >> 2);
    if (pixel.x >= params.width || pixel.y >= params.height) continue;
    float light = rgb_luminance(imageLoad(radiance, ivec2(pixel)).rgb);
    if (light >= kMeterLow && light <= 1e30) atomicAdd(own_bins[meter_bin(light)], 1u);
  }
  barrier();
  for (uint i = thread; i < uint(FL_METER_BINS); i += kThreads) {
    if (own_bins[i] > 0u) atomicAdd(meter.bins[i], own_bins[i]);
  }
}
