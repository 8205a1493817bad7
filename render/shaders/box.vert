#version 460
// Stage boxes: one instance a box, 36 vertices, no vertex buffer.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/project.glsl"
layout(set = 0, binding = FL_BINDING_BOXES, std430) readonly buffer BoxesBuffer { BoxRow boxes[]; };
layout(location = 0) out vec3 out_normal;
layout(location = 1) flat out uint out_id;

void main() {
  // Face: axis and side; two triangles of a unit square, counter-clockwise from outside.
  const vec2 square[6] = vec2[6](vec2(0, 0), vec2(1, 0), vec2(1, 1), vec2(0, 0), vec2(1, 1), vec2(0, 1));
  int face = gl_VertexIndex / 6;
  int axis = face >> 1;
  bool high = (face & 1) == 1;
  vec2 uv = square[gl_VertexIndex % 6];
  if (!high) uv = uv.yx;
  vec3 corner = vec3(0.0);
  corner[axis] = high ? 1.0 : 0.0;
  corner[(axis + 1) % 3] = uv.x;
  corner[(axis + 2) % 3] = uv.y;
  out_normal = vec3(0.0);
  out_normal[axis] = high ? 1.0 : -1.0;
  BoxRow box = boxes[gl_InstanceIndex];
  gl_Position = project(mix(box.low.xyz, box.high.xyz, corner) - params.position.xyz);
  out_id = (uint(FL_SURFACE_BOX) << 30) | uint(gl_InstanceIndex);
}
