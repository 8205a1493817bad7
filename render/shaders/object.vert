#version 460
// Objects of the scene: one mesh in stage space; `part` carries their albedo. FL_TEXTURES: some have textures.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/project.glsl"

layout(location = 0) in vec3 position_m;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint part;  // FL_OBJECT
layout(location = 0) out vec3 out_normal;
layout(location = 1) flat out uint out_id;
layout(location = 2) out vec3 out_offset_m;  // from the camera
#ifdef FL_TEXTURES
layout(location = 3) out vec2 out_uv;
layout(set = 0, binding = FL_BINDING_BODY_LEVELS, std430) readonly buffer LevelsBuffer { BodyLevelRow levels[]; };
layout(set = 0, binding = FL_BINDING_OBJECT_UVS, std430) readonly buffer UvsBuffer { vec2 object_uvs[]; };
#endif

void main() {
  out_normal = normal;
  out_offset_m = position_m - params.position.xyz;
  gl_Position = project(out_offset_m);
  out_id = part;
#ifdef FL_TEXTURES
  out_uv = object_uvs[uint(gl_VertexIndex) - levels[params.object_level].vertex_first];
#endif
}
