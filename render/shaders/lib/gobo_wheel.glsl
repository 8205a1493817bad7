// Images of gobo wheels and of animation wheels at a place of the gate. lod: level of detail.
#include "render/shaders/shared/optics.h"
layout(set = 0, binding = FL_BINDING_GOBOS) uniform sampler2DArray gobo_images;

vec3 gobo_image(uint image, vec2 p, float lod) {
  return textureLod(gobo_images, vec3(0.5 * p + 0.5, float(image) - 1.0), lod).rgb;
}

vec3 gobo_wheel(uint image, uint next, float offset, vec2 turn, vec2 p, float lod) {
  float open = 1.0;
  if (offset != 0.0) {
    vec2 at;
    image = wheel_slot_at(p, offset, at) ? next : image;
    p = at;
    // The rim of the opening, a texel and a half wide.
    open = clamp((1.0 - length(p)) / 0.006 + 0.5, 0.0, 1.0);
  }
  if (image == 0u) return vec3(open);
  return open * gobo_image(image, vec2(turn.x * p.x + turn.y * p.y, turn.x * p.y - turn.y * p.x), lod);
}

vec3 gobo_animation(uint image, vec2 turn, vec2 p, float lod) {
  vec2 at = (p - vec2(kAnimationAwayX, 0.0)) / kAnimationRadius;
  return gobo_image(image, vec2(turn.x * at.x + turn.y * at.y, turn.x * at.y - turn.y * at.x), lod);
}
