// Gobo images and blades: what stands in a beam. Layer i holds image i + 1; transmission over the square -1..1 of the
// gobo plane. Two wheels and an animation wheel lie behind each other, and an iris shows the middle of them. After
// forms.glsl, with FL_USE_BEAMS.
#include "render/shaders/lib/has_gobo.glsl"
#include "render/shaders/lib/blades.glsl"
layout(constant_id = FL_SPEC_GOBO_TAPS) const uint kGoboTaps = 16;
layout(constant_id = FL_SPEC_FOCUS) const bool kFocus = false;
layout(constant_id = FL_SPEC_ANIMATION) const bool kAnimation = false;
#include "render/shaders/lib/gobo_wheel.glsl"

// Of the beam that is being drawn. Its row is read where it is used: a global copy would be stored for each beam.
uint gobo_beam;
#define gobo_row beams[gobo_beam]
uint gobo_sample;  // how many looks at its images there were
void gobo_begin(uint beam) {
  gobo_beam = beam;
  gobo_sample = 0u;
}

// A blur is spread over the looks along a ray: each is moved within the disc of the blur, by a sequence that fills it
// evenly (M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018), and sees what is around it
// through a quarter of the disc, by levels of detail. A square of that many texels has the variance of the disc.
float texels_of_blur() { return 0.25 * 0.8660254 * float(textureSize(gobo_images, 0).x); }
vec2 gobo_spread(uint look) {
  vec2 u = fract(vec2(0.5) + float(look) * vec2(0.7548776662466927, 0.5698402909980532));
  float angle = 6.283185307179586 * u.y;
  return sqrt(u.x) * vec2(cos(angle), sin(angle));
}

// Where a place in the beam lies in its gate.
vec2 gobo_place(vec2 rho) {
  vec2 p = rho * gobo_row.gobo_scale;
  // The image is as it is, and its disc goes through the corners of a rectangle.
  if (kRectangle && gobo_row.squeeze > 0.0) {
    p *= sqrt(2.0 / (1.0 + gobo_row.squeeze)) * vec2(1.0, sqrt(gobo_row.squeeze));
  }
  return p;
}

// rho in the beam, z_m from its lens.
vec3 gobo_at(uint gobo, vec2 rho, float z_m) {
  vec2 p = gobo_place(rho);
  float blur = gobo_row.gobo_blur;
  if (kFocus) blur = max(blur, focus_blur(gobo_row.x_axis.w, gobo_row.y_axis.w, z_m, gobo_row.focus));
  float lod = 0.0;
  if (blur > 1e-4) {
    p += blur * gobo_spread(gobo_sample++);
    lod = log2(max(texels_of_blur() * blur, 1.0));
  }
  vec3 through = gobo_wheel(gobo, gobo_row.next_1, gobo_row.offset_1, vec2(gobo_row.gobo_cos, gobo_row.gobo_sin), p,
                            lod);
  if (gobo_row.gobo_2 != 0u || gobo_row.offset_2 != 0.0) {
    through *= gobo_wheel(gobo_row.gobo_2, gobo_row.next_2, gobo_row.offset_2,
                          vec2(gobo_row.gobo_2_cos, gobo_row.gobo_2_sin), p, lod);
  }
  if (kAnimation && gobo_row.animation != 0u) {
    through *= gobo_animation(gobo_row.animation, vec2(gobo_row.animation_cos, gobo_row.animation_sin), p, lod);
  }
  return through;
}
// On a surface: as many looks as a blur needs.
const uint kSurfaceLooks = 24u;
vec3 gobo_on_surface(uint gobo, vec2 rho, float z_m) {
  float blur = gobo_row.gobo_blur;
  if (kFocus) blur = max(blur, focus_blur(gobo_row.x_axis.w, gobo_row.y_axis.w, z_m, gobo_row.focus));
  uint looks = blur > 1e-4 ? kSurfaceLooks : 1u;
  vec3 sum = vec3(0.0);
  gobo_sample = 0u;  // the same looks for every pixel, or neighbours would differ by a grain
  for (uint i = 0u; i < looks; ++i) sum += gobo_at(gobo, rho, z_m);
  return sum / float(looks);
}
#define FL_GOBO

float blades_at(uint index, vec2 rho, float z_m) {
  float soft = kBladeSoft;
  if (kFocus) soft += 2.0 * focus_blur(gobo_row.x_axis.w, gobo_row.y_axis.w, z_m, gobo_row.focus);
  float through = 1.0;
  for (int i = 0; i < 4; ++i) {
    vec4 edge = blades[index].edge[i];
    through *= clamp((edge.z - dot(edge.xy, rho)) / soft + 0.5, 0.0, 1.0);
  }
  return through;
}
