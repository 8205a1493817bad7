#version 460
// Light of displays at the pixels that displays.comp has left: in the air and on surfaces, added to the picture. One
// workgroup a tile. Where these pixels are few, several threads share each of them.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/display.h"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/albedo.glsl"
#define FL_CELLS_ACCESS readonly
#include "render/shaders/lib/display_cells.glsl"
#include "render/shaders/lib/display_pixels.glsl"
#include "render/shaders/lib/display_light.glsl"
#define FL_RAYS (FL_TILE_PX * FL_TILE_PX)
#define FL_TOGETHER 6
#include "render/shaders/lib/display_rays.glsl"
#define FL_DISPLAY_TILES_ACCESS readonly
#define FL_DISPLAY_RECORDS_ACCESS readonly
#include "render/shaders/lib/display_records.glsl"

layout(local_size_x = FL_TILE_PX * FL_TILE_PX) in;
layout(constant_id = FL_SPEC_VIEW) const uint kView = FL_VIEW_PICTURE;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

const float kPi = 3.141592653589793;
const uint kThreads = uint(FL_TILE_PX * FL_TILE_PX);
const uint kLanesMost = 16u;

shared uint listed[kThreads];
shared vec3 lane_air[kThreads];
shared vec3 lane_lx[kThreads];

void main() {
  uint thread = gl_LocalInvocationIndex;
  uint tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  uint count = 0u;
  uint before = 0u;
  bool listens = false;
  for (uint word = 0u; word < kThreads / 32u; ++word) {
    uint bits = display_tiles[tile].exact[word];
    count += uint(bitCount(bits));
    if (word < thread / 32u) before += uint(bitCount(bits));
    if (word == thread / 32u) {
      before += uint(bitCount(bits & ((1u << (thread & 31u)) - 1u)));
      listens = (bits >> (thread & 31u) & 1u) != 0u;
    }
  }
  if (count == 0u) return;
  if (listens) listed[before] = thread;
  barrier();
  uint lanes = min(kThreads / count, kLanesMost);
  uint number = thread % count;
  RayPart part;
  part.lane = thread / count;
  part.lanes = lanes;
  part.works = part.lane < lanes;
  uint at = listed[number];
  ivec2 pixel = ivec2(gl_WorkGroupID.xy) * FL_TILE_PX + ivec2(at % uint(FL_TILE_PX), at / uint(FL_TILE_PX));
  part.px = vec2(pixel) + 0.5;
  part.ray = normalize(ray_through(part.px));
  part.number = number;
  Surface surface = surface_at(pixel, part.ray);
  part.t_m = surface.t_m;
  part.normal = surface.kind == kNothing ? vec3(0.0) : surface.normal;
  part.in_air = kAir && (display_tiles[tile].solids[at / 32u] >> (at & 31u) & 1u) == 0u;
  RayLight light = light_along(part);
  lane_air[thread] = light.air;
  lane_lx[thread] = light.lx;
  barrier();
  if (thread >= count) return;
  vec3 air = vec3(0.0);
  vec3 lx = vec3(0.0);
  for (uint i = 0u; i < lanes; ++i) {
    air += lane_air[count * i + thread];
    lx += lane_lx[count * i + thread];
  }
  vec3 sum = lx;
  if (kView == uint(FL_VIEW_PICTURE)) {
    sum = params.forward.w * air;
    if (surface.kind != kNothing) sum += albedo_of(surface) / kPi * lx * exp(-extinction() * surface.t_m);
  }
  vec4 behind = imageLoad(radiance, pixel);
  imageStore(radiance, pixel, vec4(behind.rgb + sum, behind.a));
}
