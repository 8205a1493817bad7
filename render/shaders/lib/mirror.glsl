// Where rays begin. Those of a mirrored camera, which stands below a floor that mirrors, begin on the floor: what is
// below it is not there for them. After frame.glsl.
layout(constant_id = FL_SPEC_GLOSS) const bool kGloss = false;

// Along a unit ray, m; FL_FAR_M: a ray of the mirrored camera that does not come through the floor.
float ray_begin(vec3 ray) {
  if (!kGloss || !(params.mirror_m > 0.0)) return 0.0;
  return ray.z > 1e-6 ? min(params.mirror_m / ray.z, FL_FAR_M) : FL_FAR_M;
}
