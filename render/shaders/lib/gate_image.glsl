// The images of gates (render/shaders/gateimages.comp). at: 0 to 1.
layout(set = 0, binding = FL_BINDING_GATE_IMAGES) uniform sampler2DArray gate_images;
vec3 gate_image(uint layer, uint planes, vec2 at) {
  vec3 through = vec3(textureLod(gate_images, vec3(at, float(layer)), 0.0).r);
  if (planes > 1u) {
    through.g = textureLod(gate_images, vec3(at, float(layer + 1u)), 0.0).r;
    through.b = textureLod(gate_images, vec3(at, float(layer + 2u)), 0.0).r;
  }
  return through;
}
