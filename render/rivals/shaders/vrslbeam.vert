#version 460
// VR Stage Lighting's beam as a style of pictures: a cone of walls for each live beam. The cone is that of the beam.
// What is the same all over a beam is computed here. vrslbeam.frag has the formulas.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/rivals/shared/rival_io.h"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/project.glsl"
#include "render/rivals/shaders/lib/beam_ends.glsl"
#include "render/rivals/shaders/lib/mesh_light.glsl"
#include "render/rivals/shaders/lib/cone_wall.glsl"
#include "render/rivals/shaders/lib/vrsl_zoom.glsl"

layout(location = 0) out vec3 from_camera_m;
layout(location = 1) out vec3 normal;
layout(location = 2) out vec2 on_wall;     // 0 at the lens, 1 at the end; around, in turns
layout(location = 3) flat out vec3 light;
layout(location = 4) flat out vec4 whole;  // zoom 0 to 1, blinding, stripes, their share
layout(location = 5) flat out vec2 own;    // the turn of its gobo, rad; where its noise is

// Of the brightness that haze has across the lens: chosen by eye, so that the demo is about as bright as with physical
// light. The formulas have no unit.
const float kShare = 1.0 / 24.0;

// Stripes of gobos 2 to 8, and how strong they are.
const vec2 kStripes[7] = vec2[7](vec2(9, 0.441), vec2(16, 0.217), vec2(5, 0.55), vec2(6, 0.395), vec2(22, 0.215),
                                 vec2(5, 0.27), vec2(9, 0.5));

// How much more a beam shines into an eye near its axis, and in the middle of the picture.
float blinding(BeamRow row, vec3 lens_m) {
  float beside_m = length(row.eye.xy);
  float near = clamp(0.6 / max(0.25 * beside_m * beside_m, 1e-6), 1.0, 20.0);
  vec4 at = project(lens_m);
  float middle = at.w > 0.0 ? clamp(0.5 - 0.5 * length(at.xy / at.w), 0.0, 1.0) : 0.0;
  float strong = mix(mix(1.0, near, 0.15), 2.2 * near, middle);
  return mix(1.0, strong, 0.1);
}

void main() {
  BeamRow row = beams[gl_InstanceIndex];
  ConeWall wall = cone_wall(row);
  from_camera_m = wall.from_camera_m;
  normal = wall.normal;
  on_wall = wall.on_wall;
  light = kShare * mesh_light(row);
  vec2 stripes = row.gobo == 0u ? vec2(0.0) : kStripes[(row.gobo - 1u) % 7u];
  whole = vec4(vrsl_zoom(row), blinding(row, -from_light(row, row.eye.xyz)), stripes);
  own = vec2(atan(row.gobo_sin, row.gobo_cos), 17.0 * float(row.head));
  gl_Position = project(from_camera_m);
}
