// What may hide the sun from the light of panes. After shaft.h.
layout(set = 0, binding = FL_BINDING_OCCLUDERS, std430) readonly buffer OccludersBuffer { OccluderRow occluders[]; };
layout(set = 0, binding = FL_BINDING_PANE_MASKS, std430) readonly buffer PaneMasksBuffer { uint pane_masks[]; };

const float kSlackM = 1e-4;  // of a body that light has passed, which does not hide it on a surface
const float kLeastFacing = 0.02;

// From the camera.
ShaftSolid solid_of(OccluderRow row) {
  return ShaftSolid(vec3(row.center_x, row.center_y, row.center_z) - params.position.xyz, row.half_edge_0.xyz,
                    row.half_edge_1.xyz, row.half_edge_2.xyz);
}
uint mask_words() { return (uint(occluders.length()) + 31u) / 32u; }
