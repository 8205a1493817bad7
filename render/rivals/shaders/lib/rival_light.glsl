// What every rival that samples light shares: the beams' forms, gobos and blades, and the light that a place in the
// haze sends to the eye. The law of light is that of beam.h, so that rivals differ in where they sample it, not in what
// they compute. Includes frame.glsl and all that it needs; the including shader has its FL_USE_... and extensions.
#include "render/shaders/lib/frame.glsl"
#include "render/rivals/shared/rival_io.h"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/lib/gobo.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/lib/tile_test.glsl"

layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;

// Before the first sample of a beam: its shape as it is drawn.
BeamShape begin_beam(BeamRow row, uint index) {
  BeamShape shape = beam_shape(row);
  shape.profile_power = drawn_profile(shape.profile_power);
  gobo_begin(index);
  return shape;
}

// Light over J0 that falls at a place in light space on a plane across it, 1/m^2, behind gobos and blades. rho, r_m: as
// of beam_illuminance().
vec3 light_at(BeamRow row, uint index, BeamShape shape, vec3 p, out vec2 rho, out float r_m) {
  float share = beam_illuminance(shape, p, rho, r_m);
  if (!(share > 0.0)) return vec3(0.0);
  if (kExtinction) share *= exp(-params.position.w * r_m);
  if (kBlades && (row.flags & FL_BEAM_BLADES) != 0u) share *= blades_at(index, rho, p.z);
  vec3 through = vec3(share);
  if (has_gobo(row)) through *= gobo_at(row.gobo, rho, p.z);
  return through;
}

// What the haze at a place t_m along the ray sends to the eye, over sigma_s and per metre of the ray, without the haze
// between it and the eye. ray: in light space.
vec3 scattered_at(BeamRow row, uint index, BeamShape shape, vec3 ray, float t_m) {
  vec2 rho;
  float r_m;
  vec3 light = light_at(row, index, shape, row.eye.xyz + ray * t_m, rho, r_m);
  if (!(max(light.r, max(light.g, light.b)) > 0.0)) return vec3(0.0);
  return row.j0.rgb * light * phase_function(dot(beam_direction(shape, rho), ray), params.anisotropy);
}

// The haze between a place and the eye.
float to_eye(float t_m) { return kExtinction ? exp(-params.position.w * t_m) : 1.0; }
