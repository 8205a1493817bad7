#version 460
// The light of a card: falls off from its axis as a smoothstep of the angle at the fan's apex, and evenly to its end.
// Colour times alpha is added, and both have the fall-off, as in the method's blending (SrcAlpha, One).
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/rivals/shared/rival_io.h"

layout(location = 0) in vec3 from_camera_m;
layout(location = 1) in vec2 place;
layout(location = 2) in float attenuation;
layout(location = 3) flat in vec3 light;
layout(location = 0) out vec4 color;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;

void main() {
  if (length(from_camera_m) > imageLoad(radiance, ivec2(gl_FragCoord.xy)).a) discard;
  float shine = smoothstep(0.0, 0.5, clamp(1.0 - abs(atan(place.x, place.y)), 0.0, 1.0));
  color = vec4(light * (shine * shine * attenuation), 0.0);
}
