#version 460
// For each pane one bit an occluder: does the sphere around it reach into the shaft behind the pane? One thread a word.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"

layout(local_size_x = FL_GROUP_SHAFTS) in;
layout(constant_id = FL_SPEC_BODIES) const bool kBodies = true;
layout(set = 0, binding = FL_BINDING_OCCLUDERS, std430) readonly buffer OccludersBuffer { OccluderRow occluders[]; };
layout(set = 0, binding = FL_BINDING_PANES, std430) readonly buffer PanesBuffer { PaneRow panes[]; };
layout(set = 0, binding = FL_BINDING_PANE_MASKS, std430) writeonly buffer PaneMasksBuffer { uint pane_masks[]; };

void main() {
  uint count = uint(occluders.length());
  uint words = (count + 31u) / 32u;
  uint word = gl_GlobalInvocationID.x;
  if (word >= words) return;
  if (!kBodies) count = min(count, params.box_count);
  PaneRow row = panes[gl_WorkGroupID.y];
  uint bits = 0u;
  for (uint i = 32u * word; i < min(count, 32u * word + 32u); ++i) {
    float radius_m = occluders[i].half_edge_0.w * 1.0001;
    vec3 at = vec3(occluders[i].center_x, occluders[i].center_y, occluders[i].center_z) - row.center.xyz;
    vec3 reach = radius_m * vec3(length(row.across.xyz), length(row.upward.xyz), length(row.along.xyz));
    vec3 place = vec3(dot(row.across.xyz, at), dot(row.upward.xyz, at), dot(row.along.xyz, at));
    bool touches = radius_m >= 0.0 && abs(place.x) <= 1.0 + reach.x && abs(place.y) <= 1.0 + reach.y &&
                   place.z >= -reach.z && place.z <= params.up.w + reach.z;
    if (touches) bits |= 1u << (i & 31u);
  }
  pane_masks[gl_WorkGroupID.y * words + word] = bits;
}
