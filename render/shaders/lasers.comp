#version 460
// Adds the light of those rows of lasers that laserstrips.comp left: on surfaces, and in the air. A workgroup has a
// tile of 16 x 16 pixels and goes through the rows that may touch it, in their order, 16 at a time. With FL_USE_HAZE:
// haze that is not even, where each pixel is computed.
//
// Of each row the light in the air is computed at 16 places of its strip of the tile: 12 give polynomials, which make
// the light of the tile's pixels, and four check them. Where these are off, and where something solid stands among the
// light, each pixel is computed. A row whose light is in front of all that the tile shows lights none of it.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/albedo.glsl"
#define FL_LASERS_ACCESS readonly
#include "render/shaders/lib/laser_row.glsl"
#include "render/shaders/lib/laser_strip.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
layout(constant_id = FL_SPEC_VIEW) const uint kView = FL_VIEW_PICTURE;
layout(constant_id = FL_SPEC_LASER) const bool kAir = true;  // light in the air is drawn
#define FL_LASER_MASKS_ACCESS readonly
#include "render/shaders/lib/laser_masks.glsl"
layout(set = 0, binding = FL_BINDING_HEADS, std430) readonly buffer HeadsBuffer { HeadRow heads[]; };
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

const float kPi = 3.141592653589793;

#define FL_LASER_PIXELS
#include "render/shaders/lib/laser_batch.glsl"

// Whether light gets as far as a surface. A body lies within what hides light for it.
bool gets_there(LaserRow row, LaserSheet sheet, LaserSpot spot, Surface surface) {
  float length_m = laser_length(sheet, spot.tau);
  if (spot.r_m <= length_m * 1.0005 + 1e-3 + row.slack_m) return true;
  uint fixture = spot.tau > sheet.jump ? row.end_fixture_2 : row.end_fixture_1;
  return surface.kind == kBody && fixture != FL_NONE && heads[surface.which >> 3].fixture == fixture &&
         spot.r_m < length_m + 1.0;
}

// Adds some of the rows that touch the tile.
void add_batch(uint begin, uint count, vec2 middle, vec2 from_middle, Surface surface, float ray_length,
               inout vec3 air, inout vec3 lx) {
  find_strips(begin, count, middle, 0.5 * float(FL_TILE_PX), from_middle, surface.t_m, air);
  for (uint bits = by_strip; bits != 0u; bits &= bits - 1u) {
    uint of = uint(findLSB(bits));
    air += strips[of].light.rgb * light_of_strip(strips[of], from_middle);
  }
  LaserPixel view = LaserPixel(ray_through(middle + from_middle), laser_step_x(), laser_step_y());
  for (uint bits = surface.kind == kNothing ? 0u : on_surfaces; bits != 0u; bits &= bits - 1u) {
    LaserRow row = lasers[listed[begin + uint(findLSB(bits))]];
    LaserSheet sheet = laser_sheet(row);
    float depth = surface.t_m / ray_length;
    LaserSpot spot = laser_on_surface(sheet, view, sheet.eye + view.ray * depth, depth, surface.normal);
    if (spot.illuminance > 0.0 && gets_there(row, sheet, spot, surface)) {
      float lost = kExtinction ? exp(-params.position.w * spot.r_m) : 1.0;
      lx += row.light.rgb * (spot.illuminance * lost);
    }
  }
  barrier();
}

void main() {
  uvec2 pixel = gl_GlobalInvocationID.xy;
  vec2 low = vec2(gl_WorkGroupID.xy * uint(FL_TILE_PX));
  vec2 high = low + float(FL_TILE_PX);
  vec2 middle = 0.5 * (low + high);
  vec2 from_middle = vec2(pixel) + 0.5 - middle;
  uvec2 size = uvec2(params.width, params.height);
  bool is_drawn = all(lessThan(pixel, size));
  uvec2 cell = gl_WorkGroupID.xy / uint(FL_SUPERTILE_PX / FL_TILE_PX);
  uint words = laser_words();
  uint mask = (cell.y * params.supertiles_x + cell.x) * words;
  if (gl_LocalInvocationIndex == 0u) {
    nearest_bits = floatBitsToUint(kNothingM);
    farthest_bits = 0u;
  }

  Surface surface;
  float ray_length = 1.0;
  vec3 air = vec3(0.0);
  vec3 lx = vec3(0.0);
  bool ready = false;
  for (uint base = 0u; base < words; base += kThreads) {
    uint count = list_words(mask, base, words);
    for (uint from = 0u; from < count; from += kNotes) {
      uint total = list_rows(mask, from, count, low, high);
      if (total > 0u && !ready) {
        vec3 ray = ray_through(vec2(pixel) + 0.5);
        ray_length = length(ray);
        surface = surface_at(ivec2(min(pixel, size - 1u)), ray / ray_length);
        ready = true;
        if (is_drawn) {
          atomicMin(nearest_bits, floatBitsToUint(surface.t_m / ray_length));
          atomicMax(farthest_bits, floatBitsToUint(surface.t_m / ray_length));
        }
      }
      barrier();
      for (uint begin = 0u; begin < total; begin += kBatch) {
        add_batch(begin, min(total - begin, kBatch), middle, from_middle, surface, ray_length, air, lx);
      }
    }
  }
  if (!ready || !is_drawn) return;
  vec3 sum = lx;
  if (kView == uint(FL_VIEW_PICTURE)) {
    sum = params.forward.w * air;
    if (surface.kind != kNothing) {
      float lost = kExtinction ? exp(-params.position.w * surface.t_m) : 1.0;
      sum += albedo_of(surface) / kPi * lx * lost;
    }
  }
  vec4 behind = imageLoad(radiance, ivec2(pixel));
  imageStore(radiance, ivec2(pixel), vec4(behind.rgb + sum, behind.a));
}
