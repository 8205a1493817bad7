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

// Whether all of the body is beyond the side of the beam towards `way`, a direction across it.
bool is_beside(ShadowSolid solid, BeamShape beam, vec2 way) {
  float most = dot(way, way) > 1e-30 ? inversesqrt(dot(way, way)) : 0.0;
  vec2 u = way * most;
  float nearest = dot(u, solid.center.xy) - beam.lens_radius_m - beam.spread * solid.center.z;
  [[unroll]] for (int i = 0; i < 3; ++i) {
    nearest -= abs(dot(u, solid.half_edge[i].xy) - beam.spread * solid.half_edge[i].z);
  }
  return nearest > 0.0;
}

// False only where the body has no shadow in the beam.
bool may_hide(OccluderRow occluder, BeamRow row, BeamShape beam, uint fixture) {
  if (occluder.half_edge_0.w < 0.0 || occluder.fixture == fixture) return false;
  ShadowSolid solid = solid_of(occluder, row);
  float reach_z = abs(solid.half_edge[0].z) + abs(solid.half_edge[1].z) + abs(solid.half_edge[2].z);
  bool may = solid.center.z + reach_z > 0.0 && solid.center.z - reach_z < beam.range_m;
  // Towards its centre, and across each of its edges.
  may = may && !is_beside(solid, beam, solid.center.xy);
  [[unroll]] for (int i = 0; i < 3; ++i) {
    vec2 across = vec2(solid.half_edge[i].y, -solid.half_edge[i].x);
    may = may && !is_beside(solid, beam, dot(across, solid.center.xy) < 0.0 ? -across : across);
  }
  return may;
}
