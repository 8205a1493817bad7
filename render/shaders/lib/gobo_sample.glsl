// An image as the tables of moments see it, and the straight line of a direction and an offset through it.
layout(set = 0, binding = FL_BINDING_GOBOS) uniform sampler2DArray gobo_images;
vec3 gobo_sample_at(uint image, vec2 direction, float offset, float s) {
  vec2 p = s * direction + offset * vec2(direction.y, -direction.x);
  return textureLod(gobo_images, vec3(0.5 * p + 0.5, float(image) - 1.0), 0.0).rgb;
}
// Of line i of `count`.
float gobo_offset(uint i, int count) { return 2.0 * float(i) / float(count - 1) - 1.0; }
const float kPi = 3.141592653589793;
