#version 460
// From radiance to the screen: exposure, then AgX (Troy Sobotka; the constants and the 6th-order fit of its curve are the
// published ones of the minimal GLSL form by Benjamin Wrensch, 2023), with a little contrast and saturation for stage colour.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;
layout(set = 0, binding = FL_BINDING_SCREEN, rgba8) uniform writeonly image2D screen;

const float kMinEv = -12.47393;
const float kMaxEv = 4.026069;

vec3 agx_curve(vec3 x) {
  vec3 x2 = x * x;
  vec3 x4 = x2 * x2;
  return 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232;
}

vec3 agx(vec3 linear_color) {
  const mat3 inset = mat3(0.842479062253094, 0.0423282422610123, 0.0423756549057051,
                          0.0784335999999992, 0.878468636469772, 0.0784336,
                          0.0792237451477643, 0.0791661274605434, 0.879142973793104);
  const mat3 outset = mat3(1.19687900512017, -0.0528968517574562, -0.0529716355144438,
                           -0.0980208811401368, 1.15190312990417, -0.0980434501171241,
                           -0.0990297440797205, -0.0989611768448433, 1.15107367264116);
  vec3 v = max(inset * linear_color, vec3(1e-10));
  v = (clamp(log2(v), kMinEv, kMaxEv) - kMinEv) / (kMaxEv - kMinEv);
  v = agx_curve(v);
  // Look: more contrast and saturation than the base curve.
  float luma = dot(v, vec3(0.2126, 0.7152, 0.0722));
  v = pow(max(v, vec3(0.0)), vec3(1.25));
  luma = pow(max(luma, 0.0), 1.25);
  v = luma + 1.3 * (v - luma);
  return clamp(outset * v, 0.0, 1.0);  // display-encoded (gamma 2.2 ~ sRGB)
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(params.width) || pixel.y >= int(params.height)) return;
  vec3 color = imageLoad(radiance, pixel).rgb * params.exposure;
  imageStore(screen, pixel, vec4(agx(color), 1.0));
}
