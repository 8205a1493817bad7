// An image, or that of a gate, as the tables of moments see it, and the straight line of a direction and an offset
// through it. After gobo_tables.glsl.
layout(set = 0, binding = FL_BINDING_GOBOS) uniform sampler2DArray gobo_images;
#include "render/shaders/lib/gate_image.glsl"
vec3 gobo_sample_at(GoboTableRow table, uint image, vec2 direction, float offset, float s) {
  vec2 p = 0.5 * (s * direction + offset * vec2(direction.y, -direction.x)) + 0.5;
  if (table.gate != 0u) return gate_image(table.gate - 1u, table.planes, p);
  return textureLod(gobo_images, vec3(p, float(image) - 1.0), 0.0).rgb;
}
// Of line i of `count`.
float gobo_offset(uint i, int count) { return 2.0 * float(i) / float(count - 1) - 1.0; }
const float kPi = 3.141592653589793;
