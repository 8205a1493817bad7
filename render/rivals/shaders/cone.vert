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
#include "render/rivals/shaders/lib/cone_wall.glsl"
#include "render/rivals/shaders/lib/vrsl_zoom.glsl"

layout(location = 0) out vec3 from_camera_m;
layout(location = 1) out vec3 normal;
layout(location = 2) out float along;  // 0 at the lens, 1 at the end
layout(location = 3) flat out vec3 light;
layout(location = 4) flat out float zoom;  // 0 to 1

void main() {
  BeamRow row = beams[gl_InstanceIndex];
  ConeWall wall = cone_wall(row);
  from_camera_m = wall.from_camera_m;
  normal = wall.normal;
  along = wall.on_wall.x;
  light = mesh_light(row);
  zoom = vrsl_zoom(row);
  gl_Position = project(from_camera_m);
}
