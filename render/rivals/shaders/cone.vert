#version 460
// A rival: a cone mesh a beam, both sides of it, one instance a live beam. After the beams of VR Stage Lighting (MIT),
// whose formulas are restated here: see cone.frag.
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

layout(location = 0) out vec3 from_camera_m;
layout(location = 1) out vec3 normal;
layout(location = 2) out float along;  // 0 at the lens, 1 at the end
layout(location = 3) flat out vec3 light;
layout(location = 4) flat out float zoom;  // 0 to 1

void main() {
  BeamRow row = beams[gl_InstanceIndex];
  uint corner = uint(gl_VertexIndex) % 6u;
  uint side = uint(gl_VertexIndex) / 6u + (corner == 1u || corner == 2u || corner == 4u ? 1u : 0u);
  along = corner == 2u || corner == 4u || corner == 5u ? 1.0 : 0.0;
  float angle = 6.283185307179586 * float(side) / float(FL_CONE_SIDES);
  vec2 around = vec2(cos(angle), sin(angle));
  float z = along * row.axis.w;
  float w = row.x_axis.w + row.y_axis.w * z;
  from_camera_m = from_light(row, vec3(w * around, z) - row.eye.xyz);
  normal = from_light(row, vec3(around, -row.y_axis.w));
  light = mesh_light(row);
  // Its zoom goes from 1.75 to 19.8 degrees of half angle.
  zoom = clamp((degrees(atan(row.y_axis.w)) - 1.75) / 18.05, 0.0, 1.0);
  gl_Position = project(from_camera_m);
}
