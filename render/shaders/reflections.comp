#version 460
// Adds what surfaces with sheen mirror, as reflection probes show it, to what the surface pass has left; less what
// their matt part, or a metal, shows of the same light as even light. A pass of its own: inside surfaces.comp it takes
// a CPU a minute to compile.
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
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/thin.glsl"
#include "render/shaders/lib/shadow.glsl"
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
#include "render/shaders/lib/surface_light.glsl"
#include "render/shaders/lib/bounce.glsl"
#include "render/shaders/shared/sheen.h"
#include "render/shaders/lib/sheen.glsl"
#include "render/shaders/shared/probe.h"
#include "render/shaders/lib/probes.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(params.width) || pixel.y >= int(params.height)) return;
  Surface surface = surface_at(pixel, normalize(ray_through(vec2(pixel) + 0.5)));
  if (surface.kind == kNothing || surface.sheen == 0u) return;
  vec3 offset_m = normalize(ray_through(vec2(pixel) + 0.5)) * surface.t_m;
  vec3 albedo = albedo_of(surface);
  Sheen sheen = surface_sheen(pixel, surface, albedo);
  float even;
  vec3 color = probes_mirrored(sheen, sheens[surface.sheen].metal, surface.normal, offset_m, even);
  float form = work_light(surface.normal, offset_m);
  vec3 lx = vec3(surface.kind == kBox ? params.ambient_lx : params.ambient_lx * form) + params.work_lx * form;
  if (kBounce) lx += bounced_lx(surface, params.position.xyz + offset_m);
  color -= (1.0 - even) * albedo / kPi * lx;
  if (kExtinction) color *= exp(-params.position.w * surface.t_m);
  vec4 own = imageLoad(radiance, pixel);
  imageStore(radiance, pixel, vec4(max(own.rgb + color, vec3(0.0)), own.a));
}
