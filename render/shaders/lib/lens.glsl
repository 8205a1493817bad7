// Lenses: their light towards the eye, and which share of it is added as a splat because their image is small. After
// gobo.glsl, beam.h and tile_test.glsl, with FL_USE_HEADS and FL_USE_BEAMS.
layout(constant_id = FL_SPEC_LENSES) const bool kSmallLenses = false;
const float kPi = 3.141592653589793;

// Radius of the image, in pixels: up to the first a lens is a splat alone, from the second on it is drawn alone.
const float kSplatPx = 3.0;
const float kDrawnPx = 4.0;

// Halves of the lens along the axes of its beam, m.
vec2 lens_half(TypeRow type) {
  bool plate = kRectangle && type.aspect > 0.0;
  return vec2(type.lens_radius_m, plate ? type.lens_radius_m / type.aspect : type.lens_radius_m);
}
float lens_area(TypeRow type) {
  vec2 size = lens_half(type);
  return (kRectangle && type.aspect > 0.0 ? 4.0 : kPi) * size.x * size.y;
}
float pixel_at_1m() { return 2.0 * length(params.up.xyz) / float(params.height); }
float splat_share(TypeRow type, float depth_m) {
  // What only glows shines to all sides and has any form, and a measured lamp's face may be far longer than its lens of
  // equal area is wide: their bodies show them.
  if (!kSmallLenses || !(type.flux_lm > 0.0) || type.measured != 0u) return 0.0;
  vec2 size = lens_half(type);
  return 1.0 - smoothstep(kSplatPx, kDrawnPx, max(size.x, size.y) / (pixel_at_1m() * max(depth_m, 1e-6)));
}

// Illuminance of the eye by all beams of a head. normal: of the lens there.
vec3 lens_beams_lx(HeadState state, vec3 normal) {
  vec3 eye_lx = vec3(0.0);
  uint beam_count = state.beam_first == kNoAddress ? 0u : max(state.beams, 1u);
  for (uint b = 0u; b < beam_count; ++b) {
    BeamRow row = beams[state.beam_first + b];
    if (!(dot(normal, row.axis.xyz) > 0.5)) continue;  // the side of the glass
    BeamShape beam = beam_shape(row);
    beam.profile_power = drawn_profile(beam.profile_power);
    beam.range_m = 1e30;  // a lens is seen from any distance
    vec2 rho;
    float r_m;
    float share = beam_illuminance(beam, row.eye.xyz, rho, r_m);
    if (!(share > 0.0)) continue;
    gobo_begin(state.beam_first + b);
    if (kBlades && (row.flags & FL_BEAM_BLADES) != 0u) share *= blades_at(state.beam_first + b, rho, row.eye.z);
    vec3 through = vec3(share);
    if (has_gobo(row)) through *= gobo_on_surface(row.gobo, rho, row.eye.z);
    eye_lx += row.j0.rgb * through;
  }
  return eye_lx;
}
// A little of the light goes to all sides, lm.
vec3 lens_glow_lm(HeadState state, TypeRow type) { return vec3(state.red, state.green, state.blue) * type.glow_lm; }
