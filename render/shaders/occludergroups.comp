#version 460
// The spheres around groups of bodies that hide light (shared/shadow_map.h), a thread a group. Below 0: of nothing.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
layout(local_size_x = FL_GROUP_HEADS) in;
layout(set = 0, binding = FL_BINDING_OCCLUDERS, std430) readonly buffer OccludersBuffer { OccluderRow occluders[]; };
layout(set = 0, binding = FL_BINDING_BEAM_MAPS, std430) writeonly buffer ShadowMapsBuffer { uint shadow_maps[]; };
const uint kMapPx = 64u;
#include "render/shaders/lib/shadow_map_words.glsl"

vec3 center_of(OccluderRow body) { return vec3(body.center_x, body.center_y, body.center_z); }

void main() {
  uint all = uint(occluders.length());
  uint groups = occluder_groups(all);
  uint own = gl_GlobalInvocationID.x;
  if (own >= groups) return;
  uint first = own * uint(FL_OCCLUDER_GROUP);
  uint end = min(first + uint(FL_OCCLUDER_GROUP), all);
  vec3 low = vec3(FL_FAR_M);
  vec3 high = vec3(-FL_FAR_M);
  for (uint at = first; at < end; ++at) {
    float radius_m = occluders[at].half_edge_0.w;
    if (radius_m < 0.0) continue;
    low = min(low, center_of(occluders[at]) - radius_m);
    high = max(high, center_of(occluders[at]) + radius_m);
  }
  vec3 middle = 0.5 * (low + high);
  float most_m = -1.0;
  for (uint at = first; at < end; ++at) {
    float radius_m = occluders[at].half_edge_0.w;
    if (radius_m >= 0.0) most_m = max(most_m, length(center_of(occluders[at]) - middle) + radius_m);
  }
  uint place = uint(shadow_maps.length()) - 4u * (groups - own);
  shadow_maps[place] = floatBitsToUint(middle.x);
  shadow_maps[place + 1u] = floatBitsToUint(middle.y);
  shadow_maps[place + 2u] = floatBitsToUint(middle.z);
  shadow_maps[place + 3u] = floatBitsToUint(most_m);
}
