#version 460
// Tables of whole chords: for each straight line through a gobo, the weights with which the smooth factor W at the four
// Gauss nodes gives the integral of W times pattern times profile (lib/gobo_chord.glsl). A thread has one line.
#extension GL_GOOGLE_include_directive : require
#define FL_GOBO_TABLES_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/lib/profile_index.glsl"
#include "render/shaders/lib/gobo_tables.glsl"
#include "render/shaders/lib/gobo_queue.glsl"
#include "render/shaders/lib/gobo_sample.glsl"

layout(local_size_x = FL_GROUP_GOBOS) in;
layout(set = 0, binding = FL_BINDING_GOBO_WHOLE_OUT, rgba16f) uniform writeonly image2DArray whole_out;

void main() {
  uint job = gobo_jobs[gl_WorkGroupID.z];
  uint image = job & 0xffffu;
  uint profile = job >> 16;
  GoboTableRow table = gobo_tables[image - 1u];
  uint i = gl_GlobalInvocationID.x;
  float angle = kPi * float(gl_WorkGroupID.y) / float(FL_GOBO_ANGLES);
  vec2 direction = vec2(cos(angle), sin(angle));
  float offset = gobo_offset(i, FL_GOBO_CHORDS);
  float half_chord = sqrt(max(1.0 - offset * offset, 1e-5));
  float power = profile_of_index(profile);
  uint n = max(uint(float(FL_GOBO_CHORD_SAMPLES) * half_chord), 4u);
  // Means of pattern times profile times y^j, y from -1 to 1 along the chord.
  vec3 m0 = vec3(0.0);
  vec3 m1 = vec3(0.0);
  vec3 m2 = vec3(0.0);
  vec3 m3 = vec3(0.0);
  for (uint k = 0u; k < n; ++k) {
    float y = (2.0 * float(k) + 1.0) / float(n) - 1.0;
    float s = y * half_chord;
    vec3 light = gobo_sample_at(table, image, direction, offset, s) * beam_profile(s * s + offset * offset, power);
    m0 += light;
    light *= y;
    m1 += light;
    light *= y;
    m2 += light;
    m3 += light * y;
  }
  // The weights that are exact for W of degree 3, with the nodes at -+outer and -+inner.
  const float outer = 0.8611363115940526;
  const float inner = 0.3399810435848563;
  const float apart = outer * outer - inner * inner;
  vec3 even_outer = (m2 - inner * inner * m0) / apart;
  vec3 even_inner = (outer * outer * m0 - m2) / apart;
  vec3 odd_outer = (m3 - inner * inner * m1) / (apart * outer);
  vec3 odd_inner = (outer * outer * m1 - m3) / (apart * inner);
  vec3 a = even_outer - odd_outer;
  vec3 b = even_inner - odd_inner;
  vec3 c = even_inner + odd_inner;
  vec3 d = even_outer + odd_outer;
  uint layer = table.whole[profile] - 1u;
  float scale = 0.5 / float(n);
  for (uint plane = 0u; plane < table.planes; ++plane) {
    imageStore(whole_out, ivec3(i, gl_WorkGroupID.y, layer + plane),
               scale * vec4(a[plane], b[plane], c[plane], d[plane]));
  }
}
