#version 460
// A few pixels of the finished picture once more, by the general path at high order: every live beam, whether a mask
// has it or not, 8 Gauss nodes, FL_SPEC_GOBO_TAPS samples of gobos, no tiles, no polynomials, no tables of gobos. What
// the pixel shows (the surface) and clouds of haze are as the picture has them. Of each of FL_RECHECK_X x FL_RECHECK_Y
// cells one pixel is drawn, bright ones more often: each thread of a group proposes one, and one of these is taken with
// a chance that grows with its brightness (resampled importance sampling: Talbot 2005). Its weight makes the mean of
// any function over the samples that over the picture.
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
#include "render/shaders/lib/surface_light.glsl"
#include "render/shaders/lib/air_light.glsl"
#include "render/shaders/lib/bounce.glsl"
#include "render/shaders/shared/sheen.h"
#include "render/shaders/lib/sheen.glsl"
#include "render/shaders/shared/probe.h"
#include "render/shaders/lib/probes.glsl"
layout(constant_id = FL_SPEC_PROBES) const bool kProbes = false;
#define FL_LENSES_ACCESS readonly
#include "render/shaders/lib/lens_row.glsl"

layout(local_size_x = FL_GROUP_RECHECK) in;
layout(push_constant) uniform Push { uint seed; uint first; } push;  // first: place in the order of cells
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;
layout(set = 0, binding = FL_BINDING_RECHECKED, std430) writeonly buffer RecheckedBuffer { RecheckRow rechecked[]; };

const uint kThreads = uint(FL_GROUP_RECHECK);
const uint kNodes = 8u;
// A proposed pixel counts as at least this share of the mean brightness of all, so that dark ones are drawn as well.
const float kFloor = 0.1;

shared float brightness[kThreads];
shared uvec2 proposed[kThreads];
shared uint taken;
shared float weight;
shared vec3 sum_lx[kThreads];
shared vec3 sum_reflected[kThreads];
shared vec3 sum_air[kThreads];
shared vec3 sum_lenses[kThreads];

// PCG (Jarzynski, Olano 2020, "Hash functions for GPU rendering").
uint hashed(uint x) {
  x = x * 747796405u + 2891336453u;
  x = ((x >> ((x >> 28) + 4u)) ^ x) * 277803737u;
  return (x >> 22) ^ x;
}
float uniform_of(uint x) { return float(x >> 8) * (1.0 / 16777216.0); }

// Light of a beam in the haze along a unit ray, over sigma_s.
vec3 light_in_air(BeamRow row, uint index, Medium medium, vec3 d, float t_max_m) {
  BeamShape beam = beam_shape(row);
  beam.profile_power = drawn_profile(beam.profile_power);
  bool gobo = has_gobo(row);
  vec3 eye = row.eye.xyz;
  vec3 ray = to_light(row, d);
  float gain = 1.0;
  if (thin_in_haze_applies(row)) {
    gain = thin_in_haze(beam, row, eye, ray, dot(d, params.forward.xyz), t_max_m, thin_is_plain(row, gobo));
  }
  return row.j0.rgb *
         (gain * air_light(beam, row, index, medium, eye, ray, t_max_m, gobo, AirKnobs(kNodes, kGoboTaps)));
}

// What the eye gets from a surface with this illuminance. reflected: of a surface with sheen, the light of beams,
// cd/m^2.
vec3 seen_of(Surface surface, Sheen sheen, vec3 offset_m, vec3 lx, vec3 reflected, Medium medium) {
  if (surface.kind == kNothing) return vec3(0.0);
  float form = work_light(surface.normal, offset_m);
  if (kBounce) lx += bounced_lx(surface, params.position.xyz + offset_m);
  vec3 albedo = albedo_of(surface);
  vec3 ambient = vec3(surface.kind == kBox ? params.ambient_lx : params.ambient_lx * form);
  float even = 1.0;
  if (kProbes && surface.sheen != 0u) {
    reflected += probes_mirrored(sheen, sheens[surface.sheen].metal, surface.normal, offset_m, even);
  }
  vec3 color = even * albedo / kPi * (lx + ambient + params.work_lx * form) + reflected;
  if (surface.kind == kBody && (surface.which & uint(FL_PART_LENS)) != 0u) {
    color += lens_radiance(surface.which >> 3, surface.t_m, normalize(offset_m), surface.normal);
  }
  return kExtinction ? color * exp(-medium.extinction_per_m * surface.t_m) : color;
}

// Whether the picture shows a mixture there (edges.comp), which the light at the pixel's centre is not.
layout(constant_id = FL_SPEC_EDGES) const bool kEdges = false;
layout(set = 0, binding = FL_BINDING_EDGE_MASKS, std430) readonly buffer EdgeMasksBuffer { uint edge_masks[]; };
bool has_edge(uvec2 pixel) {
  if (!kEdges) return false;
  uvec2 tile = pixel / uint(FL_TILE_PX);
  uvec2 at = pixel % uint(FL_TILE_PX);
  uint across = (params.width + uint(FL_TILE_PX) - 1u) / uint(FL_TILE_PX);
  uint word = edge_masks[(tile.y * across + tile.x) * uint(FL_EDGE_WORDS) + at.y];
  return (word >> at.x & 1u) != 0u;
}

void main() {
  uint lane = gl_LocalInvocationIndex;
  // A step that no cell count of a power of two divides: cells of one picture lie apart.
  uint cell = (push.first + gl_WorkGroupID.x) * 37u % uint(FL_RECHECK_X * FL_RECHECK_Y);
  uvec2 size = uvec2(params.width, params.height);
  uvec2 place = uvec2(cell % uint(FL_RECHECK_X), cell / uint(FL_RECHECK_X));
  uvec2 cells = uvec2(FL_RECHECK_X, FL_RECHECK_Y);
  uvec2 low = place * size / cells;
  uvec2 extent = (place + 1u) * size / cells - low;
  bool empty = extent.x == 0u || extent.y == 0u;

  uint random = hashed(push.seed ^ hashed(cell * kThreads + lane));
  uvec2 pixel = min(low + uvec2(vec2(uniform_of(random), uniform_of(hashed(random))) * vec2(extent)), size - 1u);
  vec3 bright = imageLoad(radiance, ivec2(pixel)).rgb;
  float b = max(bright.r, max(bright.g, bright.b));
  proposed[lane] = pixel;
  brightness[lane] = b > 0.0 && b < 1e30 ? b : 0.0;
  barrier();
  if (lane == 0u) {
    float all = 0.0;
    for (uint i = 0u; i < kThreads; ++i) all += brightness[i];
    float floor_of = all > 0.0 ? kFloor * all / float(kThreads) : 1.0;
    all += floor_of * float(kThreads);
    float left = uniform_of(hashed(hashed(push.seed + cell) + 1u)) * all;
    taken = 0u;
    for (uint i = 0u; i < kThreads; ++i) {
      taken = i;
      left -= brightness[i] + floor_of;
      if (left < 0.0) break;
    }
    weight = all / (float(kThreads) * (brightness[taken] + floor_of)) * float(extent.x * extent.y);
  }
  barrier();
  pixel = proposed[taken];

  Medium medium = Medium(params.anisotropy, params.position.w);
#ifdef FL_HAZE_FIELD
  haze_begin(vec2(pixel) + 0.5);
#endif
  vec3 d = normalize(ray_through(vec2(pixel) + 0.5));
  Surface surface = surface_at(ivec2(pixel), d);
  vec3 offset_m = d * surface.t_m;
  vec3 lx = vec3(0.0);
  vec3 reflected = vec3(0.0);
  bool shows_sheen = kSheen && surface.sheen != 0u;
  Sheen sheen;
  if (shows_sheen) sheen = surface_sheen(ivec2(pixel), surface, albedo_of(surface));
  vec3 air = vec3(0.0);
  bool scatters = FL_NOT_IN_CODE(uint(params.forward.w > 0.0)) != 0u;
  for (uint index = empty ? counts.live_count : lane; index < counts.live_count; index += kThreads) {
    BeamRow row = beams[index];
    gobo_begin(index);
    if (surface.kind != kNothing) {
      SurfaceBeam beam = surface_beam(row);
      vec2 rho;
      float r_m;
      vec3 light = light_and_place(beam, row, index, medium, surface, offset_m, rho, r_m);
      if (shows_sheen && light != vec3(0.0)) {
        reflected += light * sheen_share(sheen, surface, offset_m,
                                         way_on_stage(row, beam_direction(beam.shape, rho)), lens_angle(row, r_m));
      } else {
        lx += light;
      }
    }
    if (scatters) air += light_in_air(row, index, medium, d, surface.t_m);
  }
  vec3 small = vec3(0.0);
  uint heads_end = FL_NOT_IN_CODE(params.head_count);
  for (uint head = empty || !kSmallLenses ? params.head_count : lane; head < heads_end; head += kThreads) {
    if (lenses[head].place.w > 0.0) small += lens_splat(lenses[head], vec2(pixel) + 0.5, surface.t_m);
  }
  sum_lenses[lane] = small;
  sum_lx[lane] = lx;
  sum_reflected[lane] = reflected;
  sum_air[lane] = air;
  barrier();
  if (lane != 0u) return;
  for (uint i = 1u; i < kThreads; ++i) {
    lx += sum_lx[i];
    reflected += sum_reflected[i];
    air += sum_air[i];
    small += sum_lenses[i];
  }
  vec3 general = seen_of(surface, sheen, offset_m, lx, reflected, medium) + params.forward.w * air + small;
  vec4 shown = imageLoad(radiance, ivec2(pixel));
  empty = empty || has_edge(pixel);
  rechecked[gl_WorkGroupID.x] =
      RecheckRow(pixel.x, pixel.y, empty ? 0.0 : weight, 0u, shown, vec4(general, 1.0));
}
