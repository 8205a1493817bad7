// What a surface does with light: lenses that shine, the work light, the light of a beam, and how a thin one is widened
// there. After surface.glsl, gobo.glsl, beam.h, tile_test.glsl, thin.glsl, shadow.glsl and kExtinction.
#include "render/shaders/lib/lens.glsl"
#include "render/shaders/lib/albedo.glsl"

// The lens of a head, cd/m^2, as far as it is no splat: it lights the eye as all beams of the head do there, and a
// little of its light goes to all sides. The disc's projected area over the square of its distance is the solid angle
// that it has for the eye.
vec3 lens_radiance(uint index, float t_m, vec3 unit_ray, vec3 normal) {
  TypeRow type = types[heads[index].type];
  HeadState state = states[index];
  float facing = dot(normal, -unit_ray);
  if (!(facing > 0.0)) return vec3(0.0);
  float drawn = 1.0 - splat_share(type, t_m * dot(unit_ray, params.forward.xyz));
  if (!(drawn > 0.0)) return vec3(0.0);
  float area_m2 = lens_area(type);
  vec3 radiance = lens_beams_lx(state, normal) * (t_m * t_m / (area_m2 * facing)) +
                  lens_glow_lm(state, type) / (kPi * area_m2);
  return drawn * radiance;
}

// How a place on a surface moves in light space for a step by FrameParams::thin along `way`, a unit vector of the
// picture's plane. A face that is nearly edge on counts as one at kEdgeOn: FL_THIN_ON_SURFACE is sqrt(2) (1 + 1 /
// kEdgeOn).
const float kEdgeOn = 0.2;
vec3 step_on_surface(BeamRow row, Surface surface, vec3 ray, float depth_m, vec3 way) {
  float facing = min(dot(surface.normal, ray), -kEdgeOn * length(ray));
  return to_light(row, (way - ray * (dot(surface.normal, way) / facing)) * (beam_thin(row) * depth_m));
}
// ray: one of depth 1.
float thin_illuminance(BeamShape beam, BeamRow row, vec3 p, Surface surface, vec3 offset_m, bool plain, out vec2 rho,
                       out float r_m) {
  float depth_m = dot(offset_m, params.forward.xyz);
  vec3 ray = offset_m / depth_m;
  return thin_on_surface(beam, p, step_on_surface(row, surface, ray, depth_m, normalize(params.right.xyz)),
                         step_on_surface(row, surface, ray, depth_m, normalize(params.up.xyz)), plain, rho, r_m);
}

// Its share that reaches a face. The work light falls on everything from above and from the eye, so that its form
// shows, and comes back from the floor, so that thin undersides are no black lines. So does a rig's own ambient light
// on what has triangles; on boxes that is the same everywhere.
float work_light(vec3 normal, vec3 offset_m) {
  return 0.3 + 0.3 * (0.5 + 0.5 * normal.z) + 0.4 * max(-dot(normal, normalize(offset_m)), 0.0);
}

// What is the same for all places that a beam lights.
struct SurfaceBeam {
  BeamShape shape;
  bool gobo;
  bool plain;  // thin.glsl
  bool thin;
  uint number;  // for FL_LIT_SHARE
  float lit;    // share of the lens that lights the place, where it is known; else below 0
};
// lit_share_of() a place: an including pass may know which shadows reach what it shows.
#ifndef FL_LIT_SHARE
#define FL_LIT_SHARE(beam, index, p, aside, fixture, lens_m) lit_share_of(index, p, aside, fixture, lens_m)
#define FL_MAP_LIT(beam, index, row, p) map_lit(index, row, p)
#endif
SurfaceBeam surface_beam(BeamRow row) {
  SurfaceBeam beam;
  beam.shape = beam_shape(row);
  beam.shape.profile_power = drawn_profile(beam.shape.profile_power);
  beam.gobo = has_gobo(row);
  beam.plain = thin_is_plain(row, beam.gobo);
  beam.thin = beam_thin(row) > 0.0;
  beam.number = 0u;
  beam.lit = -1.0;
  return beam;
}
// What stands for the body of this fixture does not hide it.
uint fixture_of(Surface surface) {
  return surface.kind == kBody ? heads[surface.which >> 3].fixture : kNoFixture;
}
// Illuminance of a surface by the beam that gobo_begin() was called with. offset_m: of the place from the camera. rho:
// where the place is in the beam; r_m: how far from the lens.
vec3 light_and_place(SurfaceBeam beam, BeamRow row, uint index, Medium medium, Surface surface, vec3 offset_m,
                     out vec2 rho, out float r_m) {
  vec3 p = row.eye.xyz + to_light(row, offset_m);
  float share = beam.thin ? thin_illuminance(beam.shape, row, p, surface, offset_m, beam.plain, rho, r_m)
                          : beam_illuminance(beam.shape, p, rho, r_m);
  if (!(share > 0.0)) return vec3(0.0);
  if (kShadows) {
    uint fixture = fixture_of(surface);
    vec3 aside = beam.thin ? vec3(rho * (beam.shape.lens_radius_m + beam.shape.spread * p.z), p.z) : p;
    if (kMaps) {
      share *= FL_MAP_LIT(beam, index, row, aside);
    } else {
      float lens_m = kLensPoints > 1u ? shadow_lens_m(row) : 0.0;
      float lit = FL_LIT_SHARE(beam, index, p, aside, fixture, lens_m);
      if (!(lit > 0.0)) return vec3(0.0);
      if (kLensPoints > 1u) share *= lit;
    }
  }
  share *= max(-dot(to_light(row, surface.normal), beam_direction(beam.shape, rho)), 0.0);
  if (kExtinction) share *= exp(-medium.extinction_per_m * r_m);
  if (kBlades && (row.flags & FL_BEAM_BLADES) != 0u) share *= blades_at(index, rho, p.z);
  vec3 through = vec3(share);
  if (beam.gobo) through *= gobo_on_surface(row.gobo, rho, p.z);
  return row.j0.rgb * through;
}

vec3 light_on_surface(SurfaceBeam beam, BeamRow row, uint index, Medium medium, Surface surface, vec3 offset_m) {
  vec2 rho;
  float r_m;
  return light_and_place(beam, row, index, medium, surface, offset_m, rho, r_m);
}
