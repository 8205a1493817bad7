#version 460
// Displays: their pixels, and their light in the air and on surfaces, added to the picture. One workgroup a tile.
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
#include "render/shaders/lib/display_light.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
layout(constant_id = FL_SPEC_VIEW) const uint kView = FL_VIEW_PICTURE;
layout(constant_id = FL_SPEC_AIR) const bool kAir = true;
layout(constant_id = FL_SPEC_DETAIL) const bool kDetail = true;  // means over pixels of the picture
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

const float kPi = 3.141592653589793;
const float kTileError = 1e-3;
const float kPlane = 1e-5;       // of the distance: surfaces of one plane are off it by no more
const uint kCellsMost = 32u;     // that a pixel of the picture averages
const float kThinPx = 2.0;       // a display thinner than this is drawn by the share of pixels that it covers
const float kCaseM = 1e-3;       // half of what its case is behind it

vec3 in_display(DisplayRow row, vec3 v) {
  return vec3(dot(row.right.xyz, v), dot(row.down.xyz, v), dot(row.front.xyz, v));
}
float extinction() { return kExtinction ? params.position.w : 0.0; }

// Light of displays without their pixels: in the air over sigma_s, and on the surface, lx.
void light_at(ivec2 pixel, out vec3 air, out vec3 lx) {
  vec3 ray = normalize(ray_through(vec2(pixel) + 0.5));
  Surface surface = surface_at(pixel, ray);
#ifdef FL_USE_HAZE
  haze_begin(vec2(pixel) + 0.5);
#endif
  air = vec3(0.0);
  lx = vec3(0.0);
  for (uint i = 0u; i < uint(displays.length()); ++i) {
    DisplayRow row = displays[i];
    vec3 mean = row.light.rgb * read_cell(row, row.levels - 1u, uvec2(0u)).mean;
    if (!(mean.r + mean.g + mean.b > 0.0)) continue;
    vec3 eye = in_display(row, params.position.xyz - row.center.xyz);
    vec3 way = in_display(row, ray);
    vec3 place = eye + way * surface.t_m;
    if (surface.kind != kNothing && place.z > 0.0) {
      lx += row.light.rgb * light_of_cells(row, place, in_display(row, surface.normal), false, extinction());
    }
    if (kAir) air += row.light.rgb * air_of_display(row, eye, way, surface.t_m, extinction());
  }
}

// The mean of the cells that a rectangle covers, in pixels of the display, times the area that it covers.
vec3 covered(DisplayRow row, vec2 low, vec2 high) {
  uint level = 0u;
  vec2 cell = vec2(1.0);
  for (; level + 1u < row.levels; ++level) {
    uvec2 shift = halvings(row, uint(FL_DISPLAY_PARTS) + level) - halvings(row, FL_DISPLAY_PARTS);
    cell = vec2(uvec2(1u) << shift);
    vec2 count = (high - low) / cell + 1.0;
    if (count.x * count.y <= float(kCellsMost)) break;
  }
  uvec2 shift = halvings(row, uint(FL_DISPLAY_PARTS) + level) - halvings(row, FL_DISPLAY_PARTS);
  cell = vec2(uvec2(1u) << shift);
  vec2 size = vec2(row.columns, row.rows);
  uvec2 first = uvec2(low / cell);
  uvec2 last = uvec2(min(high, size - 0.001) / cell);
  vec3 sum = vec3(0.0);
  for (uint y = first.y; y <= last.y; ++y) {
    for (uint x = first.x; x <= last.x; ++x) {
      vec2 begin = max(vec2(x, y) * cell, low);
      vec2 end = min(min(vec2(x + 1u, y + 1u) * cell, size), high);
      vec2 area = max(end - begin, 0.0);
      sum += read_cell(row, level, uvec2(x, y)).mean * (area.x * area.y);
    }
  }
  return sum;
}

// The pixels of a display, cd/m^2.
vec3 shown_of(DisplayRow row, vec3 eye, vec3 way, vec3 step_x, vec3 step_y, float end_m) {
  if (!(eye.z > 0.0 && way.z < -1e-6)) return vec3(0.0);
  float t_m = eye.z / -way.z;
  if (t_m > end_m * (1.0 + kPlane) + kCaseM) return vec3(0.0);
  vec2 size = vec2(row.columns, row.rows);
  vec2 scale = 0.5 * size / vec2(row.right.w, row.down.w);  // pixels a metre
  vec2 at = (eye.xy + way.xy * t_m) * scale + 0.5 * size;
  bool inside = all(greaterThanEqual(at, vec2(0.0))) && all(lessThan(at, size));
  vec3 light = row.light.rgb * exp(-extinction() * t_m);
  if (!kDetail) return inside ? light * read_pixel(row, min(uvec2(at), uvec2(row.columns, row.rows) - 1u)) : vec3(0.0);
  vec2 right = (step_x.xy - way.xy * (step_x.z / way.z)) * (t_m * scale);
  vec2 down = (step_y.xy - way.xy * (step_y.z / way.z)) * (t_m * scale);
  vec2 foot = max(abs(right) + abs(down), 1e-3);
  vec2 low = at - 0.5 * foot;
  vec2 high = at + 0.5 * foot;
  if (any(greaterThanEqual(low, size)) || any(lessThanEqual(high, vec2(0.0)))) return vec3(0.0);
  low = clamp(low, vec2(0.0), size);
  high = clamp(high, vec2(0.0), size);
  vec2 thick = size / foot;
  bool is_thin = min(thick.x, thick.y) < kThinPx;
  if (!is_thin && !inside) return vec3(0.0);
  vec2 whole = is_thin ? foot : high - low;
  return light * covered(row, low, high) / max(whole.x * whole.y, 1e-12);
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
  vec3 through = ray_through(vec2(pixel) + 0.5);
  float size = length(through);
  vec3 ray = through / size;
  Surface surface = Surface(kNothing, 0u, vec3(0.0, 0.0, 1.0), kNothingM);
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
  for (uint stage = 0u; stage < 2u; ++stage) {
    bool each = uneven != 0u;
    uvec2 node = thread < kNodes ? 5u * uvec2(thread & 3u, thread >> 2) : kCheckPx[(thread - kNodes) & 7u];
    bool works = stage == 0u ? !each && thread < kNodes + kChecks : each && is_drawn;
    if (works) light_at(stage == 0u ? low + ivec2(node) : pixel, air, lx);
    if (stage == 0u) {
      if (works && thread < kNodes) {
        node_air[thread] = air;
        node_lx[thread] = lx;
      }
      barrier();
      bool checks = works && thread >= kNodes;
      if (checks && (is_off(node_mean(node, true), air) || is_off(node_mean(node, false), lx))) atomicOr(uneven, 2u);
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
    vec3 step_x = params.right.xyz * (2.0 / float(params.width));
    vec3 step_y = params.up.xyz * (-2.0 / float(params.height));
    step_x = (step_x - ray * dot(ray, step_x)) / size;
    step_y = (step_y - ray * dot(ray, step_y)) / size;
    sum = params.forward.w * air;
    if (surface.kind != kNothing) sum += albedo_of(surface) / kPi * lx * exp(-extinction() * surface.t_m);
    for (uint i = 0u; i < uint(displays.length()); ++i) {
      DisplayRow row = displays[i];
      sum += shown_of(row, in_display(row, params.position.xyz - row.center.xyz), in_display(row, ray),
                      in_display(row, step_x), in_display(row, step_y), surface.t_m);
    }
  }
  vec4 behind = imageLoad(radiance, pixel);
  imageStore(radiance, pixel, vec4(behind.rgb + sum, behind.a));
}
