// Gobo images and blades: what stands in a beam. Layer i holds image i + 1; transmission over the square -1..1 of the
// gobo plane. Two wheels lie behind each other, and an iris shows the middle of them.
layout(constant_id = FL_SPEC_GOBO) const bool kGobo = false;
layout(constant_id = FL_SPEC_GOBO_TAPS) const uint kGoboTaps = 16;
layout(constant_id = FL_SPEC_BLADES) const bool kBlades = false;
layout(set = 0, binding = FL_BINDING_GOBOS) uniform sampler2DArray gobo_images;
layout(set = 0, binding = FL_BINDING_BLADES, std430) readonly buffer BladesBuffer { BladesRow blades[]; };

// Of the beam that is being drawn, set by its row.
uint gobo_second;
vec2 gobo_second_turn;
float gobo_scale;
float gobo_blur;
void gobo_begin(BeamRow row) {
  gobo_second = row.gobo_2;
  gobo_second_turn = vec2(row.gobo_2_cos, row.gobo_2_sin);
  gobo_scale = row.gobo_scale;
  gobo_blur = row.gobo_blur;
}
bool has_gobo(BeamRow row) { return kGobo && (row.gobo | row.gobo_2) != 0u; }

// rho: turned with the first wheel.
float gobo_at(uint gobo, vec2 rho) {
  vec2 p = rho * (0.5 * gobo_scale);
  float through = gobo > 0u ? textureLod(gobo_images, vec3(p + 0.5, float(gobo) - 1.0), gobo_blur).x : 1.0;
  if (gobo_second > 0u) {
    vec2 turned = vec2(gobo_second_turn.x * p.x + gobo_second_turn.y * p.y,
                       gobo_second_turn.x * p.y - gobo_second_turn.y * p.x);
    through *= textureLod(gobo_images, vec3(turned + 0.5, float(gobo_second) - 1.0), gobo_blur).x;
  }
  return through;
}
#define FL_GOBO

// On a surface the edge of a blade is as soft as this, in beam radii. Chosen by eye.
const float kBladeSoft = 0.02;
float blades_at(uint index, vec2 rho) {
  float through = 1.0;
  for (int i = 0; i < 4; ++i) {
    vec4 edge = blades[index].edge[i];
    through *= clamp((edge.z - dot(edge.xy, rho)) / kBladeSoft + 0.5, 0.0, 1.0);
  }
  return through;
}
