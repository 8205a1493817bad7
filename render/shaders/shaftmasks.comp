#version 460
// For each pane, or each group of panes, one bit an occluder: does it reach into the light behind? One thread a word.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"

layout(local_size_x = FL_GROUP_SHAFTS) in;
layout(constant_id = FL_SPEC_BODIES) const bool kBodies = true;
layout(constant_id = FL_SPEC_TILES) const bool kTables = true;
layout(constant_id = FL_SPEC_HAZE) const bool kHaze = false;
const bool kGroups = kTables && !kHaze;  // as the pass
layout(set = 0, binding = FL_BINDING_OCCLUDERS, std430) readonly buffer OccludersBuffer { OccluderRow occluders[]; };
layout(set = 0, binding = FL_BINDING_PANES, std430) readonly buffer PanesBuffer { PaneRow panes[]; };
layout(set = 0, binding = FL_BINDING_PANE_GROUPS, std430) readonly buffer PaneGroupsBuffer { PaneGroupRow groups[]; };
layout(set = 0, binding = FL_BINDING_PANE_MASKS, std430) writeonly buffer PaneMasksBuffer { uint pane_masks[]; };

void main() {
  uint count = uint(occluders.length());
  uint words = (count + 31u) / 32u;
  uint word = gl_GlobalInvocationID.x;
  if (word >= words) return;
  if (!kBodies) count = min(count, params.box_count);
  uint which = gl_WorkGroupID.y;
  vec3 center = kGroups ? groups[which].center.xyz : panes[which].center.xyz;
  vec3 across = kGroups ? groups[which].across.xyz : panes[which].across.xyz;
  vec3 upward = kGroups ? groups[which].upward.xyz : panes[which].upward.xyz;
  vec3 along = kGroups ? groups[which].along.xyz : panes[which].along.xyz;
  uint bits = 0u;
  for (uint i = 32u * word; i < min(count, 32u * word + 32u); ++i) {
    if (occluders[i].half_edge_0.w < 0.0) continue;
    // From the solid's middle to its corners, in u, v and c.
    vec3 reach = vec3(0.0);
    vec3 half_edges[3] = vec3[3](occluders[i].half_edge_0.xyz, occluders[i].half_edge_1.xyz,
                                 occluders[i].half_edge_2.xyz);
    for (int k = 0; k < 3; ++k) {
      reach += abs(vec3(dot(across, half_edges[k]), dot(upward, half_edges[k]), dot(along, half_edges[k])));
    }
    vec3 at = vec3(occluders[i].center_x, occluders[i].center_y, occluders[i].center_z) - center;
    vec3 place = vec3(dot(across, at), dot(upward, at), dot(along, at));
    // What ends at the glass hides nothing. NaN: it counts.
    vec3 slack = 1e-5 * (abs(place) + reach);
    bool apart = abs(place.x) > 1.0 + reach.x + slack.x || abs(place.y) > 1.0 + reach.y + slack.y ||
                 place.z <= slack.z - reach.z || place.z > params.up.w + reach.z + slack.z;
    if (!apart) bits |= 1u << (i & 31u);
  }
  pane_masks[gl_WorkGroupID.y * words + word] = bits;
}
