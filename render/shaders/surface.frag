#version 460
// Visibility buffer: the packed normal and the identity of what the pixel shows. Files wind their triangles as they
// like and poses mirror, so nothing is culled, and a normal that lies on the far side of its triangle is turned over.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/normal.glsl"
#if defined(FL_MIRROR) || defined(FL_TEXTURES) || defined(FL_SHEEN)
#include "render/shaders/lib/frame.glsl"
#endif
#ifdef FL_TEXTURES
#include "render/shaders/lib/texture.glsl"
layout(location = 3) in vec2 in_uv;
#endif
layout(location = 0) in vec3 in_normal;
layout(location = 1) flat in uint in_id;
layout(location = 2) in vec3 in_offset_m;
layout(location = 0) out uvec2 out_surface;

void main() {
#ifdef FL_TEXTURES
  vec2 uv_dx = dFdx(in_uv);
  vec2 uv_dy = dFdy(in_uv);
#endif
#ifdef FL_MIRROR
  // Of a mirrored camera: nothing below the mirror, nor its face.
  bool below = in_offset_m.z < params.mirror_m + 1e-3;
  if (params.mirror_m > 0.0 && below) discard;
#endif
  vec3 face = cross(dFdx(in_offset_m), dFdy(in_offset_m));
  if (dot(face, in_offset_m) > 0.0) face = -face;
  uint id = in_id;
#ifdef FL_SHEEN
  uint sheen = 0u;
#endif
#ifdef FL_TEXTURES
  if ((id & FL_OBJECT_TEXTURED) != 0u) {
#ifdef FL_SHEEN
    id = textured_identity(id & ~(FL_OBJECT | FL_OBJECT_TEXTURED), in_uv, uv_dx, uv_dy, gl_FragCoord.xy, sheen);
#else
    id = textured_identity(id & ~(FL_OBJECT | FL_OBJECT_TEXTURED), in_uv, uv_dx, uv_dy, gl_FragCoord.xy);
#endif
  }
#endif
  vec3 normal = dot(in_normal, face) < 0.0 ? -in_normal : in_normal;
#ifdef FL_SHEEN
#ifndef FL_TEXTURES
  if ((id & FL_BODY_SHEEN) != 0u) {
    sheen = id >> FL_BODY_SHEEN_SHIFT & uint(FL_SHEENS_MAX - 1);
    id &= ~(uint(FL_SHEENS_MAX - 1) << FL_BODY_SHEEN_SHIFT);
  }
#endif
  if ((id & FL_BODY_SHEEN) != 0u) {  // the same bit of an object
    out_surface = uvec2(pack_sheen_normal(normal, sheen), id);
    return;
  }
#endif
  out_surface = uvec2(pack_normal(normal), id);
}
