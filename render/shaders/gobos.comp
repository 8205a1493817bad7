#version 460
// Queues the tables of moments that the lit beams read and that are not built yet.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_GOBO_TABLES_ACCESS
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/profile_index.glsl"
#include "render/shaders/lib/gobo_tables.glsl"
#include "render/shaders/lib/gobo_queue.glsl"

layout(local_size_x = FL_GROUP_GOBOS) in;
layout(constant_id = FL_SPEC_FOCUS) const bool kFocus = false;

void main() {
  uint index = gl_GlobalInvocationID.x;
  if (index >= counts.live_count) return;
  BeamRow row = beams[index];
  if (has_several_images(row)) return;  // gates.comp has queued those of gates
  GoboImage only = gobo_only_image(row);
  if (gobo_lines_layer(only) != 0u) {
    if ((atomicOr(gobo_tables[only.image - 1u].built, FL_GOBO_LINES_BUILT) & FL_GOBO_LINES_BUILT) == 0u) {
      gobo_jobs[gobo_queue.capacity + atomicAdd(gobo_queue.lines_groups[2], 1u)] = only.image;
    }
  }
  if (kFocus && !gobo_is_sharp(row) && gobo_blurs_layer(only) != 0u) {
    if ((atomicOr(gobo_tables[only.image - 1u].built, FL_GOBO_BLURS_BUILT) & FL_GOBO_BLURS_BUILT) == 0u) {
      uint first = 2u * gobo_queue.capacity + uint(FL_GATES_MAX);
      gobo_jobs[first + atomicAdd(gobo_queue.blur_groups[2], 1u)] = only.image;
    }
  }
  if (gobo_whole_layer(row, only) != 0u) {
    uint profile = profile_index(row.eye.w);
    if ((atomicOr(gobo_tables[only.image - 1u].built, 1u << profile) & (1u << profile)) == 0u) {
      gobo_jobs[atomicAdd(gobo_queue.whole_groups[2], 1u)] = only.image | profile << 16;
    }
  }
}
