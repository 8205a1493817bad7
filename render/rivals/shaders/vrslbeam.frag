#version 460
// The light of a cone's wall, added to what is there, after VR Stage Lighting's standard mover (MIT; restated). It is
// no integral along the ray: a wall shines by the angle at which it is seen and by its place along the beam.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/rivals/shared/rival_io.h"

layout(location = 0) in vec3 from_camera_m;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 on_wall;
layout(location = 3) flat in vec3 light;
layout(location = 4) flat in vec4 whole;
layout(location = 5) flat in vec2 own;
layout(location = 0) out vec4 color;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;

float unit(float x) { return clamp(x, 0.0, 1.0); }

// Value noise, 0 to 1: random at the corners of unit cubes, smooth between them.
float corner(ivec3 at) {
  uint x = uint(at.x) * 0x9e3779b9u ^ uint(at.y) * 0x85ebca6bu ^ uint(at.z) * 0xc2b2ae35u;
  x = (x ^ x >> 16) * 0x21f0aaadu;
  x = (x ^ x >> 15) * 0x735a2d97u;
  return float((x ^ x >> 15) >> 8) / 16777215.0;
}
float value_noise(vec3 p) {
  ivec3 cell = ivec3(floor(p));
  vec3 f = p - vec3(cell);
  f = f * f * (3.0 - 2.0 * f);
  vec4 low = vec4(corner(cell), corner(cell + ivec3(1, 0, 0)), corner(cell + ivec3(0, 1, 0)),
                  corner(cell + ivec3(1, 1, 0)));
  vec4 high = vec4(corner(cell + ivec3(0, 0, 1)), corner(cell + ivec3(1, 0, 1)), corner(cell + ivec3(0, 1, 1)),
                   corner(cell + ivec3(1, 1, 1)));
  vec4 between = mix(low, high, f.z);
  return mix(mix(between.x, between.y, f.x), mix(between.z, between.w, f.x), f.y);
}

void main() {
  float along = unit(on_wall.x);  // at the edge of a triangle it may be a rounding below 0, whose powers are NaN
  float zoom = whole.x;
  float distance_m = length(from_camera_m);
  float surface_m = imageLoad(radiance, ivec2(gl_FragCoord.xy)).a;
  if (distance_m > surface_m) discard;
  bool has_gobo = whole.z > 0.0;
  float slope = pow(unit(0.95 - along), has_gobo ? 0.6 * 2.25 : 0.8 * 2.248);
  float before_surface = mix(1.0, unit(surface_m - distance_m), unit(35.0 * along));
  float from_eye = mix(1.0, unit(distance_m - 0.5), pow(along, 0.1));
  float stretched = unit(1.5 * along);
  float facing = -dot(normalize(normal), from_camera_m) / distance_m;
  float sharpness = facing > 0.0 ? 7.0 : mix(1.0, 5.0 + mix(5.0, 1.0, zoom), unit(pow(stretched, 0.1) + 0.05));
  float edge = pow(max(abs(facing), 1e-6), sharpness) * (facing > 0.0 ? 1.0 : 3.0);
  float value = slope * before_surface * from_eye * (1.0 - sqrt(stretched)) * mix(1.0, 0.5, stretched);
  // Noise on the wall, and in the room, as strong as its default.
  vec3 place_m = params.position.xyz + from_camera_m;
  vec2 around = vec2(cos(6.283185 * on_wall.y), sin(6.283185 * on_wall.y));
  value *= 0.5 + value_noise(vec3(6.0 * along, 2.0 * around + own.y));
  value *= mix(1.0, value_noise(place_m / 1.25), 0.85);
  value *= mix(1.0, 25.0, unit(pow(slope, 12.0)));
  if (has_gobo) value *= mix(1.0, 1.0 + sin(6.283185307179586 * whole.z * on_wall.y + 5.0 * own.x), whole.w);
  float blinded = mix(value, 10.0 * value * whole.y * whole.y, slope);
  float wide = unit(1.0 - mix(0.15, 0.95, pow((1.5 + 4.0 * zoom) / 5.5, 0.4)));
  color = vec4(light * (blinded * wide * edge), 0.0);
}
