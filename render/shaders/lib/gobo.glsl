// Gobo images: layer i holds gobo i + 1; transmission over the square -1..1 of the gobo plane.
layout(constant_id = FL_SPEC_GOBO) const bool kGobo = false;
layout(constant_id = FL_SPEC_GOBO_TAPS) const uint kGoboTaps = 16;
layout(set = 0, binding = FL_BINDING_GOBOS) uniform sampler2DArray gobo_images;
float gobo_at(uint gobo, vec2 rho) {
  return textureLod(gobo_images, vec3(rho * 0.5 + 0.5, float(gobo) - 1.0), 0.0).x;
}
#define FL_GOBO
