#version 460
// Beam rows for a camera that stands elsewhere: all that of a row follows from the camera. One thread a beam.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/view_beams.glsl"

layout(local_size_x = FL_GROUP_HEADS) in;
layout(push_constant) uniform Push { float x_m; float y_m; float z_m; } push;  // from the camera before to this one

void main() {
  uint index = gl_GlobalInvocationID.x;
  if (index == 0u) set_view_groups(counts.live_count);
  if (index >= counts.live_count) return;
  BeamRow row = beams[index];
  row.eye.xyz += to_light(row, vec3(push.x_m, push.y_m, push.z_m));
  beams[index].eye = row.eye;
  beams[index].flags = view_flags(row);
}
