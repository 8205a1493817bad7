#version 460
// From radiance to the screen: the mean of the pixels that one of the screen stands for, exposure, white balance, tone
// curve, dither.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/meter.glsl"
#include "render/shaders/shared/agx.h"
#include "render/shaders/shared/tone.h"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;
layout(set = 0, binding = FL_BINDING_SCREEN, rgba8) uniform writeonly image2D screen;
layout(constant_id = FL_SPEC_TONE) const uint kTone = FL_TONE_AGX;
layout(constant_id = FL_SPEC_WHITE) const bool kWhite = false;
layout(constant_id = FL_SPEC_METER) const bool kMeter = false;
// Rows of the matrix that balances white (render/display.h).
layout(push_constant) uniform Push {
  float red_red; float red_green; float red_blue;
  float green_red; float green_green; float green_blue;
  float blue_red; float blue_green; float blue_blue;
} push;
#ifdef FL_GLARE_TONE
layout(set = 0, binding = FL_BINDING_GLARE, rgba32f) uniform readonly image2D glare;

// The light of so many pixels as the camera's lens leaves it: what stays in place, and what is scattered, of the
// pyramid's first level.
vec3 with_glare(vec3 sum, float pixels, ivec2 pixel) {
  ivec2 own = ivec2(FL_GLARE_MARGIN, FL_GLARE_MARGIN + 1) + (pixel >> 1);
  ivec2 nearer = own + 2 * (pixel & 1) - 1;
  vec3 row = 0.75 * imageLoad(glare, own).rgb + 0.25 * imageLoad(glare, ivec2(nearer.x, own.y)).rgb;
  vec3 next = 0.75 * imageLoad(glare, ivec2(own.x, nearer.y)).rgb + 0.25 * imageLoad(glare, nearer).rgb;
  return imageLoad(glare, ivec2(0, 0)).r * sum + pixels * (0.75 * row + 0.25 * next);
}
#endif

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  int side = int(FL_NOT_IN_CODE(params.supersample));
  if (pixel.x * side >= int(params.width) || pixel.y * side >= int(params.height)) return;
  vec3 sum = vec3(0.0);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) sum += imageLoad(radiance, pixel * side + ivec2(x, y)).rgb;
  }
#ifdef FL_GLARE_TONE
  sum = with_glare(sum, float(side * side), pixel);
#endif
  float exposure = params.exposure;
  if (kMeter && meter.luminance > 0.0) exposure = 1.0 / meter.luminance;
  vec3 exposed = sum * (exposure / float(side * side));
  if (kWhite) {
    exposed = rgb_into_gamut(vec3(dot(exposed, vec3(push.red_red, push.red_green, push.red_blue)),
                                  dot(exposed, vec3(push.green_red, push.green_green, push.green_blue)),
                                  dot(exposed, vec3(push.blue_red, push.blue_green, push.blue_blue))));
  }
  vec3 shown = tone_shown(kTone, exposed);
  imageStore(screen, pixel, vec4(dithered(shown, uint(pixel.x), uint(pixel.y)), 1.0));
}
