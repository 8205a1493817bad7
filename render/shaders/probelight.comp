#version 460
// What reflection probes see: a thread has a texel of level 0 of a probe. Its rays end at the first stage box or solid
// of scenery. They get what that reflects of each beam there, of the light that the bounce pass has found between its
// patches, and of even light; and on the way the light of beams in the haze. Not that of lenses, displays, lasers and
// panes: what surfaces with sheen show of lenses are highlights (surfaces.comp). The bits of a texel's number in
// reverse are its place in the order, so that a part of a map is spread over all directions.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/lib/gobo.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/shared/gobo_chord.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/thin.glsl"
#include "render/shaders/lib/shadow.glsl"
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
layout(constant_id = FL_SPEC_AIR) const bool kAir = true;
#include "render/shaders/lib/surface_light.glsl"
#include "render/shaders/lib/air_light.glsl"
#include "render/shaders/lib/bounce_rays.glsl"
#include "render/shaders/shared/probe.h"

layout(local_size_x = FL_GROUP_PROBES) in;
layout(push_constant) uniform Push { uint first; uint count; } push;  // places in the order
layout(set = 0, binding = FL_BINDING_BOUNCE_PATCHES, std430) readonly buffer PatchesBuffer {
  BouncePatchRow patches[];
};
layout(set = 0, binding = FL_BINDING_BOUNCE_LIGHT, std430) readonly buffer LightBuffer { vec4 bounce_light[]; };
layout(set = 0, binding = FL_BINDING_PROBES, std430) readonly buffer ProbesBuffer { ProbeRow probes[]; };
layout(set = 0, binding = FL_BINDING_PROBE_LIGHT, std430) buffer ProbeLightBuffer { vec4 probe_light[]; };

const AirKnobs kKnobs = AirKnobs(3u, 16u);
// Beams are drawn at least this wide over the distance of their lens: three quarters of a texel.
const float kWidest = 0.04;

// Rays a texel: spots of beams are smaller than patches, and may be smaller than a texel.
const uint kRays = 4u;
struct Seen {
  vec3 offset_m;  // of the place from the camera
  vec3 normal;
  vec3 albedo;  // 0: nothing that reflects
};

// Without the light of beams, cd/m^2: between the nearest four patches of the face; what is covered does not count.
vec3 even_light(uint first, uint counts, vec2 at, vec3 albedo, float form) {
  uvec2 count = uvec2(counts & 0xffffu, counts >> 16);
  vec2 cell = clamp(at * vec2(count) - 0.5, vec2(0.0), vec2(count) - 1.0);
  uvec2 low = min(uvec2(cell), count - 1u);
  vec2 share = cell - vec2(low);
  vec4 sum = vec4(0.0);
  for (uint i = 0u; i < 4u; ++i) {
    uvec2 side = uvec2(i & 1u, i >> 1);
    uvec2 own = min(low + side, count - 1u);
    vec2 weight = mix(1.0 - share, share, vec2(side));
    vec4 light = bounce_light[first + own.y * count.x + own.x];
    sum += weight.x * weight.y * light.w * vec4(light.rgb, 1.0);
  }
  return albedo / kPi * (sum.rgb / max(sum.w, 1e-6) + params.ambient_lx + params.work_lx * form);
}

// What a ray ends at, how far away, and its light without that of beams.
Seen look(vec3 from, vec3 way, out float t, out vec3 light) {
  uint face;
  uint solid = bounce_hit(from, way, 0.0, FL_FAR_M, false, t, face);
  Seen seen = Seen(vec3(0.0), vec3(0.0, 0.0, 1.0), vec3(0.0));
  light = vec3(0.0);
  uint first = solid != FL_NONE ? solids[solid].first[face] : FL_NONE;
  if (first == FL_NONE) return seen;
  uint axis = face >> 1;
  vec4 dual_u = solids[solid].dual[(axis + 1u) % 3u];
  vec4 dual_v = solids[solid].dual[(axis + 2u) % 3u];
  vec3 place = from + t * way;
  BouncePatchRow row = patches[first];
  seen = Seen(place - params.position.xyz, row.normal.xyz, vec3(row.red, row.green, row.blue));
  vec2 at = 0.5 + 0.5 * vec2(dot(dual_u.xyz, place) + dual_u.w, dot(dual_v.xyz, place) + dual_v.w);
  light = even_light(first, solids[solid].count[face], at, seen.albedo, work_light(seen.normal, way));
  return seen;
}

// Light of a beam in the haze along a ray from a place, that is `center` from the camera, over sigma_s.
vec3 light_in_air(BeamRow row, uint index, Medium medium, vec3 center, vec3 d, float t_max_m) {
  BeamShape beam = beam_shape(row);
  beam.profile_power = drawn_profile(beam.profile_power);
  vec3 eye = row.eye.xyz + to_light(row, center);
  beam.lens_radius_m = max(beam.lens_radius_m, kWidest * length(eye));
  return row.j0.rgb * air_light(beam, row, index, medium, eye, to_light(row, d), t_max_m, has_gobo(row), kKnobs);
}

void main() {
  uint order = gl_GlobalInvocationID.x;
  if (order >= push.count) return;
  uint texel = bitfieldReverse((push.first + order) % uint(FL_PROBE_TEXELS)) >> (32u - 2u * uint(FL_PROBE_SIDE_LOG2));
  uint side = 1u << uint(FL_PROBE_SIDE_LOG2);
  vec2 at = vec2(texel % side, texel / side) + 0.5;
  vec3 from = probes[gl_WorkGroupID.y].center.xyz;
  Medium medium = Medium(params.anisotropy, params.position.w);
  Seen seen[kRays];
  float left[kRays];  // what the haze leaves of the light, over the number of rays
  vec3 light = vec3(0.0);
  float far_m = 0.0;
  for (uint i = 0u; i < kRays; ++i) {
    vec2 aside = vec2(i & 1u, i >> 1) * 0.5 - 0.25;
    float t;
    vec3 even;
    seen[i] = look(from, normalize(probe_way((at + aside) / float(side))), t, even);
    left[i] = (kExtinction ? exp(-medium.extinction_per_m * t) : 1.0) / float(kRays);
    light += left[i] * even;
    far_m = max(far_m, t);
  }
  vec3 d = normalize(probe_way(at / float(side)));
  vec3 air = vec3(0.0);
  for (uint index = 0u; index < counts.live_count; ++index) {
    BeamRow row = beams[index];
    gobo_begin(index);
    if (kAir && params.forward.w > 0.0) {
      air += light_in_air(row, index, medium, from - params.position.xyz, d, far_m);
    }
    SurfaceBeam beam = surface_beam(row);
    beam.thin = false;
    for (uint i = 0u; i < kRays; ++i) {
      if (seen[i].albedo == vec3(0.0)) continue;
      Surface surface = Surface(kBox, 0u, seen[i].normal, 0.0, 0u);
      vec3 lx = light_on_surface(beam, row, index, medium, surface, seen[i].offset_m);
      light += left[i] / kPi * seen[i].albedo * lx;
    }
  }
  light += params.forward.w * air;
  uint first = uint(FL_PROBE_SHARES * FL_PROBE_SHARES) + gl_WorkGroupID.y * uint(FL_PROBE_ALL);
  probe_light[first + texel] = vec4(light, min(far_m, FL_FAR_M));
}
