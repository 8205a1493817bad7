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

// A rectangle of the picture makes a pyramid of rays; one of its four side planes, turned inwards, unit.
vec3 side_of(vec2 low, vec2 high, uint side) {
  vec2 corner[4] = vec2[4](low, vec2(high.x, low.y), high, vec2(low.x, high.y));
  vec3 inwards = normalize(cross(ray_through(corner[side]), ray_through(corner[(side + 1u) & 3u])));
  return dot(inwards, ray_through(0.5 * (low + high))) < 0.0 ? -inwards : inwards;
}
// False only where no ray of the pyramid meets the group or what lies behind it.
bool group_meets(PaneGroupRow row, vec3 sides[4]) {
  mat3 axes = inverse(transpose(mat3(row.across.xyz, row.upward.xyz, row.along.xyz)));  // of u, v and c, m
  vec3 center = row.center.xyz - params.position.xyz;
  float slack = 1e-5 * (length(center) + length(axes[0]) + length(axes[1]) + params.up.w * length(axes[2]));
  bool meets = true;
  for (uint side = 0u; side < 4u; ++side) {
    vec3 reach = vec3(dot(sides[side], axes[0]), dot(sides[side], axes[1]), dot(sides[side], axes[2]) * params.up.w);
    float most = dot(sides[side], center) + abs(reach.x) + abs(reach.y) + max(reach.z, 0.0);
    meets = meets && !(most < -slack);  // what is not a number meets
  }
  return meets;
}
