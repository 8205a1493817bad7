#version 460
// Visibility buffer: the packed normal and the identity of what the pixel shows.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/normal.glsl"
layout(location = 0) in vec3 in_normal;
layout(location = 1) flat in uint in_id;
layout(location = 0) out uvec2 out_surface;

void main() { out_surface = uvec2(pack_normal(in_normal), in_id); }
