#version 460
// Light of patches and probes. FL_BOUNCE_DIRECT: what beams bring to each patch becomes light that it emits.
// FL_BOUNCE_TO_PATCHES: once more reflected. FL_BOUNCE_TO_PROBES: the illuminance of the six faces of each probe.
// FL_BOUNCE_PARTS threads share the sums of four receivers, each with sources of its own; sums have a fixed order.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"

layout(local_size_x = FL_GROUP_BOUNCE, local_size_y = FL_BOUNCE_PARTS) in;
layout(push_constant) uniform Push {
  uint patches;
  uint probes;
  uint patch_row;  // numbers of a source: to patches, and to the faces of probes; multiples of 4
  uint probe_row;
  uint step;
  uint from;
} push;
layout(set = 0, binding = FL_BINDING_BOUNCE_PATCHES, std430) readonly buffer PatchesBuffer {
  BouncePatchRow patches[];
};
layout(set = 0, binding = FL_BINDING_BOUNCE_FORMS, std430) readonly buffer FormsBuffer { vec4 forms[]; };
layout(set = 0, binding = FL_BINDING_BOUNCE_FLUX, std430) readonly buffer FluxBuffer { uint flux[]; };
// Lists of patches: illuminance by reflected light, w: 1 where there is something of the patch; light that it emits of
// what beams bring; and two of all that it emits, which take turns; lm/m^2. Then the faces of probes, lx.
layout(set = 0, binding = FL_BINDING_BOUNCE_LIGHT, std430) buffer LightBuffer { vec4 light[]; };

shared vec4 parts[FL_BOUNCE_PARTS][FL_GROUP_BOUNCE][3];

float lm_of(uint at) { return (float(flux[at]) + 4294967296.0 * float(flux[at + 1u])) / FL_BOUNCE_FLUX; }

void emit_direct(uint receiver) {
  BouncePatchRow row = patches[receiver];
  vec3 lm = vec3(lm_of(6u * receiver), lm_of(6u * receiver + 2u), lm_of(6u * receiver + 4u));
  vec3 direct = row.center.w > 0.0 ? vec3(row.red, row.green, row.blue) * lm / row.center.w : vec3(0.0);
  light[push.patches + receiver] = vec4(direct, 0.0);
  light[2u * push.patches + receiver] = vec4(direct, 0.0);
}

void receive(uint receiver, vec3 lx) {
  if (push.step == FL_BOUNCE_TO_PROBES) {
    light[uint(FL_BOUNCE_LISTS) * push.patches + receiver] = vec4(lx, 0.0);
    return;
  }
  BouncePatchRow row = patches[receiver];
  light[receiver] = vec4(lx, row.center.w > 0.0 ? 1.0 : 0.0);
  vec3 emitted = light[push.patches + receiver].rgb + vec3(row.red, row.green, row.blue) * lx;
  light[(3u - push.from) * push.patches + receiver] = vec4(emitted, 0.0);
}

void main() {
  bool to_probes = push.step == FL_BOUNCE_TO_PROBES;
  uint receivers = to_probes ? 6u * push.probes : push.patches;
  uint receiver = 4u * gl_GlobalInvocationID.x;  // and the three after it
  uint part = gl_LocalInvocationID.y;
  uint own = gl_LocalInvocationID.x;
  uint end = min(receiver + 4u, receivers);
  if (push.step == FL_BOUNCE_DIRECT) {
    for (uint r = receiver + part; r < end; r += uint(FL_BOUNCE_PARTS)) emit_direct(r);
    return;
  }
  uint row = (to_probes ? push.probe_row : push.patch_row) / 4u;
  uint first = (to_probes ? push.patches * push.patch_row / 4u : 0u) + gl_GlobalInvocationID.x;
  uint emitted = (2u + push.from) * push.patches;
  uint low = push.patches * part / uint(FL_BOUNCE_PARTS);
  uint high = receiver < receivers ? push.patches * (part + 1u) / uint(FL_BOUNCE_PARTS) : low;
  vec4 red = vec4(0.0);
  vec4 green = vec4(0.0);
  vec4 blue = vec4(0.0);
  for (uint s = low; s < high; ++s) {
    vec4 form = forms[first + s * row];
    vec3 lm = light[emitted + s].rgb;
    red += form * lm.r;
    green += form * lm.g;
    blue += form * lm.b;
  }
  parts[part][own][0] = red;
  parts[part][own][1] = green;
  parts[part][own][2] = blue;
  barrier();
  for (uint r = receiver + part; r < end; r += uint(FL_BOUNCE_PARTS)) {
    uint k = r - receiver;
    vec3 sum = vec3(0.0);
    for (uint p = 0u; p < uint(FL_BOUNCE_PARTS); ++p) {
      sum += vec3(parts[p][own][0][k], parts[p][own][1][k], parts[p][own][2][k]);
    }
    receive(r, sum);
  }
}
