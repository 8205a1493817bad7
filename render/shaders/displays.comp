#version 460
// Displays: their pixels, and their light in the air and on surfaces, added to the picture. One workgroup a tile. Those
// that are thin in the picture are drawn later, by strips.comp.
//
// Light in the air and on surfaces is smooth. Where a tile shows one plane, or nothing, it is computed at 4 x 4 pixels
// and interpolated by polynomials of degree 3; it is also computed at eight other pixels, and where one of these is off
// by more than kTileError, each pixel is computed.
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

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(constant_id = FL_SPEC_VIEW) const uint kView = FL_VIEW_PICTURE;
layout(constant_id = FL_SPEC_AIR) const bool kAir = true;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

const float kPi = 3.141592653589793;
const float kTileError = 1e-3;

// What one of the lanes of a place computes: every stride_of-th display from first on, and of each every parts-th place
// on the ray from number `part` on.
struct Lane {
  uint first;
  uint stride_of;
  uint part;
  uint parts;
};
const Lane kAlone = Lane(0u, 1u, 0u, 1u);

// Light of displays without their pixels: in the air over sigma_s, and on the surface, lx.
void light_at(ivec2 pixel, Lane lane, out vec3 air, out vec3 lx) {
  vec3 ray = normalize(ray_through(vec2(pixel) + 0.5));
  Surface surface = surface_at(pixel, ray);
#ifdef FL_USE_HAZE
  haze_begin(vec2(pixel) + 0.5);
#endif
  air = vec3(0.0);
  lx = vec3(0.0);
  for (uint i = lane.first; i < uint(displays.length()); i += lane.stride_of) {
    DisplayRow row = displays[i];
    vec3 mean = row.light.rgb * read_cell(row, row.levels - 1u, uvec2(0u)).mean;
    if (!(mean.r + mean.g + mean.b > 0.0)) continue;
    vec3 eye = in_display(row, params.position.xyz - row.center.xyz);
    vec3 way = in_display(row, ray);
    vec3 place = eye + way * surface.t_m;
    if (lane.part == 0u && surface.kind != kNothing && place.z > 0.0) {
      lx += row.light.rgb * light_of_cells(row, place, in_display(row, surface.normal), false, extinction());
    }
    if (kAir) air += row.light.rgb * air_of_display(row, eye, way, surface.t_m, extinction(), lane.part, lane.parts);
  }
}

// Weights of the values at 0, 5, 10 and 15.
vec4 weights_at(float x) {
  vec4 away = vec4(x) - vec4(0.0, 5.0, 10.0, 15.0);
  return vec4(away.y * away.z * away.w / -750.0, away.x * away.z * away.w / 250.0, away.x * away.y * away.w / -250.0,
              away.x * away.y * away.z / 750.0);
}
const uint kNodes = 16u;
const uint kChecks = 8u;
const uvec2 kCheckPx[8] = uvec2[8](uvec2(2, 7), uvec2(7, 2), uvec2(7, 12), uvec2(12, 7), uvec2(2, 2), uvec2(13, 13),
                                   uvec2(13, 2), uvec2(2, 13));
// Where a place of a tile is, in pixels: the nodes, then the checks.
uvec2 place_px(uint place) {
  return place < kNodes ? 5u * uvec2(place & 3u, place >> 2) : kCheckPx[(place - kNodes) & 7u];
}
// The places of a tile are shared out among its threads, kLanes to a place; their sums are added in their order.
const uint kPlaces = kNodes + kChecks;
const uint kLanes = uint(FL_TILE_PX * FL_TILE_PX) / kPlaces;
Lane lane_of(uint number) {
  uint parts = max(kLanes / uint(displays.length()), 1u);
  return Lane(number / parts, max(kLanes / parts, 1u), number % parts, parts);
}
shared vec3 lane_air[kPlaces * kLanes];
shared vec3 lane_lx[kPlaces * kLanes];
shared vec3 node_air[kNodes];
shared vec3 node_lx[kNodes];
shared vec4 plane;  // that the first pixel shows
shared uint kind;
shared uint uneven;

vec3 node_mean(uvec2 px, bool in_air) {
  vec4 across = weights_at(float(px.x));
  vec4 down = weights_at(float(px.y));
  vec3 sum = vec3(0.0);
  for (uint i = 0u; i < kNodes; ++i) sum += across[i & 3u] * down[i >> 2] * (in_air ? node_air[i] : node_lx[i]);
  return max(sum, 0.0);
}
bool is_off(vec3 mean, vec3 value) {
  vec3 off = abs(mean - value);
  return max(off.x, max(off.y, off.z)) > kTileError * max(value.x, max(value.y, value.z));
}

void main() {
  uint thread = gl_LocalInvocationIndex;
  ivec2 low = ivec2(gl_WorkGroupID.xy) * FL_TILE_PX;
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  bool is_drawn = pixel.x < int(params.width) && pixel.y < int(params.height);
  vec3 ray = normalize(ray_through(vec2(pixel) + 0.5));
  Surface surface = Surface(kNothing, 0u, vec3(0.0, 0.0, 1.0), kNothingM, 0u);
  if (is_drawn) surface = surface_at(pixel, ray);
  float plane_m = surface.kind == kNothing ? 0.0 : dot(surface.normal, ray) * surface.t_m;
  if (thread == 0u) {
    plane = vec4(surface.normal, plane_m);
    kind = surface.kind;
    uneven = 0u;
  }
  barrier();
  bool same = is_drawn && surface.kind == kind;
  if (same && kind != kNothing) {
    same = dot(surface.normal, plane.xyz) > 0.99999 && abs(plane_m - plane.w) <= kPlane * surface.t_m;
  }
  if (!same) atomicOr(uneven, 1u);
  barrier();
  vec3 air = vec3(0.0);
  vec3 lx = vec3(0.0);
  // First the places, then, where these do not do, each pixel. One call in a loop, since it is long code.
  for (uint stage = 0u; stage < 2u; ++stage) {
    bool each = uneven != 0u;
    uint place = thread / kLanes;
    Lane lane = stage == 0u ? lane_of(thread % kLanes) : kAlone;
    bool works = stage == 0u ? !each && place < kPlaces : each && is_drawn;
    if (works) light_at(stage == 0u ? low + ivec2(place_px(place)) : pixel, lane, air, lx);
    if (stage == 0u) {
      if (works) {
        lane_air[thread] = air;
        lane_lx[thread] = lx;
      }
      barrier();
      bool sums = !each && thread < kPlaces;
      if (sums) {
        air = vec3(0.0);
        lx = vec3(0.0);
        for (uint i = 0u; i < kLanes; ++i) {
          air += lane_air[thread * kLanes + i];
          lx += lane_lx[thread * kLanes + i];
        }
      }
      if (sums && thread < kNodes) {
        node_air[thread] = air;
        node_lx[thread] = lx;
      }
      barrier();
      bool checks = sums && thread >= kNodes;
      uvec2 px = place_px(thread);
      if (checks && (is_off(node_mean(px, true), air) || is_off(node_mean(px, false), lx))) atomicOr(uneven, 2u);
      barrier();
    }
  }
  if (!is_drawn) return;
  if (uneven == 0u) {
    air = node_mean(gl_LocalInvocationID.xy, true);
    lx = node_mean(gl_LocalInvocationID.xy, false);
  }
  vec3 sum = lx;
  if (kView == uint(FL_VIEW_PICTURE)) {
    sum = params.forward.w * air;
    if (surface.kind != kNothing) sum += albedo_of(surface) / kPi * lx * exp(-extinction() * surface.t_m);
    PixelRay of_pixel = pixel_ray(pixel);
    for (uint i = 0u; i < uint(displays.length()); ++i) {
      ShownPart part = shown_part(displays[i], of_pixel);
      if (kGloss && part.t_m < ray_begin(ray)) continue;
      if (part.is_shown && !part.is_thin && !is_hidden(part, surface.t_m)) sum += light_of_part(displays[i], part);
    }
  }
  vec4 behind = imageLoad(radiance, pixel);
  imageStore(radiance, pixel, vec4(behind.rgb + sum, behind.a));
}
