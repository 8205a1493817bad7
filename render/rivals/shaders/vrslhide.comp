#version 460
// Takes the light of a disco ball's beams, which the style of VR Stage Lighting does not have.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/rivals/shared/rival_io.h"
#include "render/rivals/shaders/lib/disco_ball.glsl"

layout(local_size_x = 64) in;

void main() {
  for (uint i = gl_LocalInvocationID.x; i < counts.live_count; i += 64u) {
    if (beams[i].head - ball.head_first < ball.head_count) beams[i].j0.rgb = vec3(0.0);
  }
}
