#version 460
// What reflection probes see: a thread has a texel of level 0 of a probe. Its rays end at the first stage box or solid
// of scenery. They get what that reflects of each beam there, of the light that the bounce pass has found between its
// patches, and of even light; and on the way the light of beams in the haze. A ray that meets a lit display before that
// ends there. Not in the map are lenses, lasers, panes, and light of displays in the air and on surfaces: what
// surfaces with sheen show of lenses are highlights (surfaces.comp). The bits of a texel's number in reverse are its
// place in the order, so that a part of a map is spread over all directions.
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
#define FL_CELLS_ACCESS readonly
#include "render/shaders/lib/display_cells.glsl"

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
  if (solid == FL_NONE) return seen;
  uint first = solids[solid].first[face];
  uint axis = face >> 1;
  if (first == FL_NONE) {  // people, tubes of trusses: without light from other surfaces
    vec3 normal = normalize(solids[solid].dual[axis].xyz) * ((face & 1u) != 0u ? 1.0 : -1.0);
    vec3 albedo = vec3((uvec3(solids[solid].count[face]) >> uvec3(20, 10, 0)) & 1023u) / 1023.0;
    light = albedo / kPi * (params.ambient_lx + params.work_lx) * work_light(normal, way);
    return Seen(from + t * way - params.position.xyz, normal, albedo);
  }
  vec4 dual_u = solids[solid].dual[(axis + 1u) % 3u];
  vec4 dual_v = solids[solid].dual[(axis + 2u) % 3u];
  vec3 place = from + t * way;
  BouncePatchRow row = patches[first];
  seen = Seen(place - params.position.xyz, row.normal.xyz, vec3(row.red, row.green, row.blue));
  vec2 at = 0.5 + 0.5 * vec2(dot(dual_u.xyz, place) + dual_u.w, dot(dual_v.xyz, place) + dual_v.w);
  light = even_light(first, solids[solid].count[face], at, seen.albedo, work_light(seen.normal, way));
  return seen;
}

// The mean of the pixels of the nearest display that a ray meets from its front before t, which becomes its distance;
// below 0: it meets none. The ray stands for kFoot around it.
const float kFoot = 0.028;   // of the distance: half of a texel
const float kCaseM = 1e-3;   // what stands for a display is so little before it at most
vec3 display_seen(vec3 from, vec3 way, inout float t) {
  vec3 light = vec3(-1.0);
  for (uint i = 0u; i < uint(displays.length()); ++i) {
    DisplayRow row = displays[i];
    vec3 eye = in_display(row, from - row.center.xyz);
    vec3 toward = in_display(row, way);
    vec2 half_m = vec2(row.right.w, row.down.w);
    if (!(eye.z > 0.0 && toward.z < -1e-6 && min(half_m.x, half_m.y) > 0.0)) continue;
    float at_m = eye.z / -toward.z;
    vec2 at = eye.xy + toward.xy * at_m;
    if (at_m > t + kCaseM || any(greaterThanEqual(abs(at), half_m))) continue;
    vec2 size = vec2(row.columns, row.rows);
    vec2 scale = 0.5 * size / half_m;  // pixels a metre
    vec2 foot = kFoot * at_m * inversesqrt(-toward.z) * scale;
    vec2 low = clamp(at * scale + 0.5 * size - 0.5 * foot, vec2(0.0), size);
    vec2 high = clamp(at * scale + 0.5 * size + 0.5 * foot, vec2(0.0), size);
    light = row.light.rgb * covered(row, low, high) / max((high.x - low.x) * (high.y - low.y), 1e-12);
    t = at_m;
  }
  return light;
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
    vec3 way = normalize(probe_way((at + aside) / float(side)));
    seen[i] = look(from, way, t, even);
    vec3 shown = display_seen(from, way, t);
    if (shown.r >= 0.0) {
      seen[i].albedo = vec3(0.0);
      even = shown;
    }
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
