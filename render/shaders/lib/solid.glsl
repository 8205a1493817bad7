// What hides light, in the light space of a beam. After shadow.h and tile_test.glsl.
layout(set = 0, binding = FL_BINDING_OCCLUDERS, std430) readonly buffer OccludersBuffer { OccluderRow occluders[]; };

ShadowSolid solid_of(OccluderRow occluder, BeamRow row) {
  ShadowSolid solid;
  vec3 center = vec3(occluder.center_x, occluder.center_y, occluder.center_z);
  solid.center = row.eye.xyz + to_light(row, center - params.position.xyz);
  solid.half_edge[0] = to_light(row, occluder.half_edge_0.xyz);
  solid.half_edge[1] = to_light(row, occluder.half_edge_1.xyz);
  solid.half_edge[2] = to_light(row, occluder.half_edge_2.xyz);
  return solid;
}
