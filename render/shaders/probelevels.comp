#version 460
// The levels of reflection probes above the first: a thread has a texel, and sums level 0 as a surface of the level's
// roughness would mirror it (probe_lobe()).
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/shared/probe.h"

layout(local_size_x = FL_GROUP_PROBES) in;
layout(set = 0, binding = FL_BINDING_PROBE_LIGHT, std430) buffer ProbeLightBuffer { vec4 probe_light[]; };

void main() {
  uint own = uint(FL_PROBE_TEXELS) + gl_GlobalInvocationID.x;
  if (own >= uint(FL_PROBE_ALL)) return;
  uint level = 1u;
  while (level + 1u < uint(FL_PROBE_LEVELS) && own >= probe_first(level + 1u)) ++level;
  uint texel = own - probe_first(level);
  uint side = probe_side(level);
  vec3 way = normalize(probe_way((vec2(texel % side, texel / side) + 0.5) / float(side)));
  float alpha = probe_level_alpha(level);
  uint first = uint(FL_PROBE_SHARES * FL_PROBE_SHARES) + gl_WorkGroupID.y * uint(FL_PROBE_ALL);
  vec4 sum = vec4(0.0);
  uint from_side = 1u << uint(FL_PROBE_SIDE_LOG2);
  for (uint y = 0u; y < from_side; ++y) {
    for (uint x = 0u; x < from_side; ++x) {
      vec3 from = probe_way((vec2(x, y) + 0.5) / float(from_side));
      float facing = dot(from, way) * inversesqrt(dot(from, from));
      float weight = probe_lobe(alpha, facing) * probe_texel_share(from);
      sum += weight * vec4(probe_light[first + y * from_side + x].rgb, 1.0);
    }
  }
  probe_light[first + own] = vec4(sum.rgb / max(sum.w, 1e-20), 0.0);
}
