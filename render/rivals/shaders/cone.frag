#version 460
// The light of a cone's wall, added to what is there. Constants and exponents of VR Stage Lighting's standard mover
// without noise, gobo split, whitening and glare, which are looks and not light. It is no integral along the ray: a
// wall shines by the angle at which it is seen and by its distance from the lens.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/rivals/shared/rival_io.h"

layout(location = 0) in vec3 from_camera_m;
layout(location = 1) in vec3 normal;
layout(location = 2) in float along_wall;
layout(location = 3) flat in vec3 light;
layout(location = 4) flat in float zoom;
layout(location = 0) out vec4 color;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;

float unit(float x) { return clamp(x, 0.0, 1.0); }

void main() {
  float along = unit(along_wall);  // at the edge of a triangle it may be a rounding below 0, whose powers are NaN
  float distance_m = length(from_camera_m);
  float surface_m = imageLoad(radiance, ivec2(gl_FragCoord.xy)).a;
  if (distance_m > surface_m) discard;
  float slope = pow(unit(0.95 - along), 1.75 * 2.248);
  float before_surface = mix(1.0, unit(surface_m - distance_m), unit(35.0 * along));
  float from_eye = mix(1.0, unit(distance_m - 0.5), pow(along, 0.1));
  float stretched = unit(1.5 * along);
  float facing = -dot(normalize(normal), from_camera_m) / distance_m;
  float sharpness = facing > 0.0 ? 7.0 : mix(1.0, 5.0 + mix(5.0, 1.0, zoom), unit(pow(stretched, 0.1) + 0.05));
  float edge = pow(max(abs(facing), 1e-6), sharpness);
  float value = slope * before_surface * from_eye * (1.0 - sqrt(stretched)) * mix(1.0, 25.0, unit(pow(slope, 12.0)));
  color = vec4(light * (value * edge), 0.0);
}
