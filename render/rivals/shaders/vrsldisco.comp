#version 460
// VR Stage Lighting's disco ball as a style of pictures: its cube map, which turns with the ball, on all surfaces
// around it, whatever way they face. Its law is (4 I map / d)^2; 6 m away a spot of the map is as bright as one of the
// ball's beams. The map is our own: rows of round spots of several sizes and colours.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#define FL_USE_POSE
#include "render/shaders/lib/frame.glsl"
#include "render/rivals/shared/rival_io.h"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/albedo.glsl"
#include "render/rivals/shaders/lib/disco_ball.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

const float kSpots = 10.0;  // a side of each face of the cube

// 0 to 1, by a cell of a face.
float random(uvec3 at, uint of) {
  uint x = at.x * 0x9e3779b9u ^ at.y * 0x85ebca6bu ^ at.z * 0xc2b2ae35u ^ of * 0x27d4eb2fu;
  x = (x ^ x >> 16) * 0x21f0aaadu;
  x = (x ^ x >> 15) * 0x735a2d97u;
  return float((x ^ x >> 15) >> 8) / 16777215.0;
}

// The map in a direction of the ball's space.
vec3 disco_map(vec3 direction) {
  vec3 size = abs(direction);
  uint axis = size.x >= size.y && size.x >= size.z ? 0u : size.y >= size.z ? 1u : 2u;
  vec2 at = axis == 0u ? direction.yz : axis == 1u ? direction.zx : direction.xy;
  float along = axis == 0u ? direction.x : axis == 1u ? direction.y : direction.z;
  vec2 place = (0.5 + 0.5 * at / abs(along)) * kSpots;
  vec2 cell = clamp(floor(place), 0.0, kSpots - 1.0);
  uvec3 which = uvec3(cell, axis * 2u + (along < 0.0 ? 1u : 0u));
  float radius = mix(0.14, 0.3, random(which, 0u));
  vec2 middle = vec2(radius) + (1.0 - 2.0 * radius) * vec2(random(which, 1u), random(which, 2u));
  float share = 1.0 - smoothstep(0.7 * radius, radius, length(place - cell - middle));
  float hue = random(which, 3u);
  vec3 tint = hue < 0.7 ? vec3(1.0) : hue < 0.8 ? vec3(1.0, 0.75, 0.5) : hue < 0.9 ? vec3(0.6, 0.8, 1.0)
                                                                               : vec3(1.0, 0.6, 0.8);
  return share * mix(0.6, 1.0, random(which, 4u)) * tint;
}

vec3 to_stage(vec3 v, float is_point) {
  HeadRow row = heads[ball.head_first];
  vec3 in_fixture = chain_to_fixture(types[row.type], states[ball.head_first], 1u, v, is_point);
  return is_point > 0.0 ? fixture_to_stage_point(row, in_fixture) : fixture_to_stage_direction(row, in_fixture);
}

void main() {
  HeadState state = states[ball.head_first];
  vec3 level = vec3(state.red, state.green, state.blue);
  if (!(max(level.r, max(level.g, level.b)) > 0.0)) return;
  vec3 x = to_stage(vec3(1.0, 0.0, 0.0), 0.0), y = to_stage(vec3(0.0, 1.0, 0.0), 0.0);
  vec3 z = to_stage(vec3(0.0, 0.0, 1.0), 0.0), middle = to_stage(vec3(0.0), 1.0) - params.position.xyz;
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(params.width) || pixel.y >= int(params.height)) return;
  vec3 ray = normalize(ray_through(vec2(pixel) + 0.5));
  Surface hit = surface_at(pixel, ray);
  if (hit.kind == kNothing) return;
  vec3 away = ray * hit.t_m - middle;
  float distance_m = length(away);
  if (distance_m < 0.3) return;  // the ball itself
  vec3 light = level * disco_map(vec3(dot(away, x), dot(away, y), dot(away, z)) / distance_m) / distance_m;
  vec4 behind = imageLoad(radiance, pixel);
  vec3 color = behind.rgb + albedo_of(hit) / 3.141592653589793 * (ball.spot_cd * light * light);
  imageStore(radiance, pixel, vec4(color, behind.a));
}
