// Panes in their groups: what a group's plane lets through. After pane.glsl and shaft.h.
layout(set = 0, binding = FL_BINDING_PANE_GROUPS, std430) readonly buffer PaneGroupsBuffer { PaneGroupRow groups[]; };
layout(set = 0, binding = FL_BINDING_GROUP_PANES, std430) readonly buffer GroupPanesBuffer {
  GroupPaneRow group_panes[];
};

PaneImage pane_image(GroupPaneRow row) { return PaneImage(row.texel_first, ivec2(row.width, row.height), row.levels); }
// u, v and c (PaneRow) of a vector.
vec3 group_of(PaneGroupRow row, vec3 v) {
  return vec3(dot(row.across.xyz, v), dot(row.upward.xyz, v), dot(row.along.xyz, v));
}
// From u and v of the group to those of a pane.
vec2 on_pane(GroupPaneRow pane, vec2 at) {
  return vec2(dot(pane.to_u.xy, at) + pane.to_u.z, dot(pane.to_v.xy, at) + pane.to_v.z);
}
// Texels of the whole image that a step in u and v of the group covers.
vec2 texels_of(GroupPaneRow pane, vec2 way) {
  return vec2(dot(pane.to_u.xy, way), dot(pane.to_v.xy, way)) * 0.5 * vec2(pane.width, pane.height);
}
// Angle of a pixel in the middle of the picture, rad.
float pixel_rad() { return 2.0 * length(params.up.xyz) / float(params.height); }
