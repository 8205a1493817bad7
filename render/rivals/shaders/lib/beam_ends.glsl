// The middles of a beam's two end discs, from the camera, and what holds their radii. After beam.h and tile_test.glsl.
struct BeamEnds {
  vec3 lens_m;
  vec3 end_m;
  float lens_radius_m;
  float end_radius_m;
};

// A rectangle's light space is stretched along y.
vec3 from_light(BeamRow row, vec3 p) {
  float shrink = row.squeeze > 0.0 ? row.squeeze : 1.0;
  return row.x_axis.xyz * p.x + row.y_axis.xyz * (p.y * shrink) + row.axis.xyz * p.z;
}

BeamEnds beam_ends(BeamRow row) {
  float stretch = row.squeeze > 0.0 ? max(1.0, sqrt(row.squeeze)) : 1.0;
  BeamEnds ends;
  ends.lens_m = -from_light(row, row.eye.xyz);
  ends.end_m = ends.lens_m + row.axis.xyz * row.axis.w;
  ends.lens_radius_m = stretch * row.x_axis.w;
  ends.end_radius_m = stretch * (row.x_axis.w + row.y_axis.w * row.axis.w);
  return ends;
}

// How far a disc across `axis` reaches along each of the stage's axes, over its radius.
vec3 disc_reach(vec3 axis) { return sqrt(max(1.0 - axis * axis, 0.0)); }
