#version 460
// The meter of the automatic exposure, second half: the luminance that 1 % of the pixels exceed, and how far the
// exposure has come to it. Empties the bins. One workgroup.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/meter.glsl"

layout(local_size_x = FL_GROUP_EXPOSE) in;
// Share of the old luminance's logarithm that stays; 1: no time has passed.
layout(push_constant) uniform Push { float kept; } push;

const uint kBins = uint(FL_METER_BINS / FL_GROUP_EXPOSE);  // of a thread
shared uint sums[FL_GROUP_EXPOSE];

void main() {
  uint thread = gl_LocalInvocationIndex;
  uint sum = 0u;
  for (uint i = 0u; i < kBins; ++i) sum += meter.bins[thread * kBins + i];
  sums[thread] = sum;
  barrier();
  if (thread == 0u) {
    uint lit = 0u;
    for (uint t = 0u; t < uint(FL_GROUP_EXPOSE); ++t) lit += sums[t];
    // Where less than 2 % of the picture have light, the median of those.
    uint wanted = max(min(params.width * params.height / 100u, lit / 2u), 1u);
    uint above = 0u;  // pixels in brighter bins
    uint t = uint(FL_GROUP_EXPOSE) - 1u;
    for (; t > 0u && above + sums[t] < wanted; --t) above += sums[t];
    uint bin = t * kBins + kBins - 1u;
    for (; bin > t * kBins && above + meter.bins[bin] < wanted; --bin) above += meter.bins[bin];
    if (lit > 0u) {
      float down = (float(wanted - above) - 0.5) / float(meter.bins[bin]);
      float now = meter_luminance(bin, 1.0 - down);
      float old = meter.luminance;
      if (!(old > 0.0)) {
        meter.luminance = now;
      } else if (push.kept < 1.0) {
        meter.luminance = now * pow(old / now, push.kept);
      }
    }
  }
  barrier();
  for (uint i = 0u; i < kBins; ++i) meter.bins[thread * kBins + i] = 0u;
}
