#version 460
// Displays: their pixels, and their light in the air and on surfaces where records have it (displaynodes.comp), added
// to the picture. Pixels without a record are left to displaypixels.comp. One workgroup a tile. Displays that are thin
// in the picture are drawn later, by strips.comp.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/albedo.glsl"
#define FL_CELLS_ACCESS readonly
#include "render/shaders/lib/display_cells.glsl"
#include "render/shaders/lib/display_pixels.glsl"
#define FL_DISPLAY_TILES_ACCESS
#define FL_DISPLAY_RECORDS_ACCESS readonly
#include "render/shaders/lib/display_records.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(constant_id = FL_SPEC_VIEW) const uint kView = FL_VIEW_PICTURE;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

const float kPi = 3.141592653589793;

const float kMostBend = 0.02;  // of light in the air between planes, as the second difference over the light

shared uint exact[FL_TILE_PX * FL_TILE_PX / 32];
shared uint solids[FL_TILE_PX * FL_TILE_PX / 32];
const uint kShownWords = 8u;
shared uint shown[kShownWords];  // bits of displays that may be in the tile; a rig has at most 256

// The record of a pixel at or below one of a supertile; FL_NONE: it has none.
uint record_below(uint record, uvec2 pixel) {
  if (!has_room(0u)) return FL_NONE;
  for (uint level = 0u; record != FL_NONE; ++level) {
    if (display_records[record].state == FL_DISPLAY_RECORD_GOOD) return record;
    if (level + 1u == uint(FL_DISPLAY_RECORD_LEVELS) || !has_room(level + 1u)) return FL_NONE;
    uvec2 half_of = pixel / (uint(FL_SUPERTILE_PX / 2) >> level) & 1u;
    record = display_records[record].children[2u * half_of.y + half_of.x];
  }
  return FL_NONE;
}

// Light in the air over sigma_s, and the red of that on the surface, lx; rest: green and blue.
vec4 read_light(uint record, vec2 px, out vec2 rest) {
  vec4 box = display_records[record].box;
  vec2 at = (2.0 * px - box.xy - box.zw) / (box.zw - box.xy);
  vec4 across = weights_at(at.x);
  vec4 down = weights_at(at.y);
  vec4 first = vec4(0.0);
  rest = vec2(0.0);
  for (uint y = 0u; y < 4u; ++y) {
    for (uint x = 0u; x < 4u; ++x) first += across[x] * down[y] * display_records[record].light[4u * y + x];
    for (uint x = 0u; x < 2u; ++x) {
      vec4 two = display_records[record].light[kNodes + 2u * y + x];
      rest += down[y] * (across[2u * x] * two.xy + across[2u * x + 1u] * two.zw);
    }
  }
  rest = max(rest, 0.0);
  return max(first, 0.0);
}

// Light in the air before what is no plane, by the three records of planes across the camera's axis. Returns whether
// they do.
bool read_rest(uint tile, uvec2 pixel, float depth_m, out vec3 air) {
  air = vec3(0.0);
  uint first = display_tiles[tile].rest_record;
  if (first == FL_NONE) return false;
  vec3 at[3];
  for (uint i = 0u; i < 3u; ++i) {
    uint record = record_below(first + i, pixel);
    if (record == FL_NONE) return false;
    vec2 unused;
    at[i] = read_light(record, vec2(pixel) + 0.5, unused).rgb;
  }
  vec3 bend = abs(at[0] - 2.0 * at[1] + at[2]);
  if (max(bend.r, max(bend.g, bend.b)) > kMostBend * max(at[1].r, max(at[1].g, at[1].b))) return false;
  float from_m = display_tiles[tile].rest_from_m;
  if (depth_m > display_tiles[tile].rest_to_m) return false;
  float s = 2.0 * (depth_m - from_m) / max(display_tiles[tile].rest_to_m - from_m, 1e-6);
  air = max(0.5 * (s - 1.0) * (s - 2.0) * at[0] + s * (2.0 - s) * at[1] + 0.5 * s * (s - 1.0) * at[2], 0.0);
  return true;
}

// What a pixel has of records.
struct PixelLight {
  vec3 air;
  vec3 lx;
  bool has_air;
  bool has_lx;
};
PixelLight light_of_pixel(uint tile, uint thread, uvec2 pixel, Surface surface, vec3 ray) {
  PixelLight light = PixelLight(vec3(0.0), vec3(0.0), false, false);
  uint plane = display_tiles[tile].pixels[thread / 8u] >> (4u * (thread % 8u)) & 15u;
  if (plane == FL_DISPLAY_RECORD_NONE) {
    if (surface.kind != kNothing) {
      light.has_air = read_rest(tile, pixel, surface.t_m * dot(ray, params.forward.xyz), light.air);
    }
    return light;
  }
  uint record = record_below(display_tiles[tile].records[plane], pixel);
  if (record == FL_NONE) return light;
  vec2 rest;
  vec4 first = read_light(record, vec2(pixel) + 0.5, rest);
  return PixelLight(first.rgb, vec3(first.a, rest), true, true);
}

// Whether the front of a display may be in a tile of the picture.
bool may_show(DisplayRow row, vec2 low, vec2 high) {
  vec3 to = row.center.xyz - params.position.xyz;
  if (!(dot(row.front.xyz, to) < 0.0)) return false;
  vec3 right = row.right.xyz * row.right.w;
  vec3 down = row.down.xyz * row.down.w;
  vec3 corners[4] = vec3[4](ray_through(low), ray_through(vec2(high.x, low.y)), ray_through(high),
                            ray_through(vec2(low.x, high.y)));
  for (uint i = 0u; i < 4u; ++i) {
    vec3 outwards = cross(corners[i], corners[(i + 1u) & 3u]);
    if (dot(outwards, corners[(i + 2u) & 3u]) > 0.0) outwards = -outwards;
    if (dot(outwards, to) - abs(dot(outwards, right)) - abs(dot(outwards, down)) > 0.0) return false;
  }
  return true;
}

vec3 pixels_of(DisplayRow row, PixelRay ray, float begin_m, float end_m) {
  ShownPart part = shown_part(row, ray);
  if (!part.is_shown || part.is_thin || part.t_m < begin_m || is_hidden(part, end_m)) return vec3(0.0);
  return light_of_part(row, part);
}

void main() {
  uint thread = gl_LocalInvocationIndex;
  uint tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  bool is_drawn = pixel.x < int(params.width) && pixel.y < int(params.height);
  if (thread < uint(exact.length())) exact[thread] = solids[thread] = 0u;
  if (thread < kShownWords) shown[thread] = 0u;
  barrier();
  const bool picture = kView == uint(FL_VIEW_PICTURE);
  if (picture && thread < uint(displays.length())) {
    vec2 low = vec2(gl_WorkGroupID.xy * uint(FL_TILE_PX));
    if (may_show(displays[thread], low, low + float(FL_TILE_PX))) atomicOr(shown[thread / 32u], 1u << (thread & 31u));
  }
  vec3 ray = normalize(ray_through(vec2(pixel) + 0.5));
  Surface surface = Surface(kNothing, 0u, vec3(0.0), kNothingM, 0u);
  PixelLight light = PixelLight(vec3(0.0), vec3(0.0), true, true);
  if (is_drawn) {
    surface = surface_at(pixel, ray);
    if (kTiles) {
      light = light_of_pixel(tile, thread, uvec2(pixel), surface, ray);
    } else {
      light.has_air = light.has_lx = false;
    }
  }
  if (!light.has_lx) atomicOr(exact[thread / 32u], 1u << (thread & 31u));
  if (!light.has_lx && light.has_air) atomicOr(solids[thread / 32u], 1u << (thread & 31u));
  barrier();
  if (thread < uint(exact.length())) {
    display_tiles[tile].exact[thread] = exact[thread];
    display_tiles[tile].solids[thread] = solids[thread];
  }
  if (!is_drawn) return;
  vec3 sum = light.lx;
  if (picture) {
    sum = params.forward.w * light.air;
    if (surface.kind != kNothing) sum += albedo_of(surface) / kPi * light.lx * exp(-extinction() * surface.t_m);
    PixelRay of_pixel = pixel_ray(pixel);
    float begin_m = kGloss ? ray_begin(ray) : 0.0;
    for (uint word = 0u; 32u * word < uint(displays.length()); ++word) {
      for (uint bits = shown[word]; bits != 0u; bits &= bits - 1u) {
        sum += pixels_of(displays[32u * word + uint(findLSB(bits))], of_pixel, begin_m, surface.t_m);
      }
    }
  }
  vec4 behind = imageLoad(radiance, pixel);
  imageStore(radiance, pixel, vec4(behind.rgb + sum, behind.a));
}
