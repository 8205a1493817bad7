#version 460
// Sums of a gobo along straight lines, from the edge of its square to each of FL_GOBO_NODES places: of the pattern, and
// of the pattern times the place (lib/gobo_chord.glsl). A thread has one line.
#extension GL_GOOGLE_include_directive : require
#define FL_GOBO_TABLES_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/profile_index.glsl"
#include "render/shaders/lib/gobo_tables.glsl"
#include "render/shaders/lib/gobo_queue.glsl"
#include "render/shaders/lib/gobo_sample.glsl"

layout(local_size_x = FL_GROUP_GOBOS) in;
layout(set = 0, binding = FL_BINDING_GOBO_LINES_OUT, rg16) uniform writeonly image2DArray lines_out;

void main() {
  uint image = gobo_jobs[gobo_queue.capacity + gl_WorkGroupID.z];
  uint i = gl_GlobalInvocationID.x;
  float angle = kPi * float(gl_WorkGroupID.y) / float(FL_GOBO_DIRECTIONS);
  vec2 direction = vec2(cos(angle), sin(angle));
  float offset = gobo_offset(i, FL_GOBO_LINES);
  GoboTableRow table = gobo_tables[image - 1u];
  const uint kBetween = uint(FL_GOBO_LINE_SAMPLES / (FL_GOBO_NODES - 1));
  const float kStep = 2.0 / float(FL_GOBO_LINE_SAMPLES);
  vec3 sum = vec3(0.0);
  vec3 first = vec3(0.0);
  for (uint node = 0u; node < uint(FL_GOBO_NODES); ++node) {
    for (uint plane = 0u; plane < table.planes; ++plane) {
      imageStore(lines_out, ivec3(i, gl_WorkGroupID.y * uint(FL_GOBO_NODES) + node, table.lines - 1u + plane),
                 vec4(0.5 * sum[plane], first[plane] + 0.5, 0.0, 0.0));
    }
    for (uint k = 0u; k < kBetween; ++k) {
      float s = (float(node * kBetween + k) + 0.5) * kStep - 1.0;
      vec3 light = gobo_sample_at(table, image, direction, offset, s) * kStep;
      sum += light;
      first += light * s;
    }
  }
}
