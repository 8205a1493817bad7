#version 460
// Adds the light of lasers in the air and on surfaces. A workgroup has a tile of 16 x 16 pixels and goes through the
// rows that may touch it, in their order. With FL_USE_HAZE: haze that is not even.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/lib/surface.glsl"
#define FL_LASERS_ACCESS readonly
#include "render/shaders/lib/laser_row.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
layout(constant_id = FL_SPEC_VIEW) const uint kView = FL_VIEW_PICTURE;
layout(constant_id = FL_SPEC_LASER) const bool kAir = true;  // light in the air is drawn
layout(set = 0, binding = FL_BINDING_LASER_MASKS, std430) readonly buffer LaserMasksBuffer { uint laser_masks[]; };
layout(set = 0, binding = FL_BINDING_HEADS, std430) readonly buffer HeadsBuffer { HeadRow heads[]; };
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

const uint kThreads = uint(FL_TILE_PX * FL_TILE_PX);
const uint kNotes = kThreads / 32u;
const float kPi = 3.141592653589793;
const float kBodyAlbedo = 0.04;  // as in surface_light.glsl
shared uint word_bits[kNotes];   // of so many words: those that have a row
shared uint row_words[kThreads]; // their numbers, in order
shared uint row_bits[kNotes];    // of so many rows: those that touch the tile

// Whether light gets as far as a surface. A body lies within what hides light for it.
bool gets_there(LaserRow row, LaserSheet sheet, LaserSpot spot, Surface surface) {
  float length_m = laser_length(sheet, spot.tau);
  if (spot.r_m <= length_m * 1.0005 + 1e-3 + row.slack_m) return true;
  uint fixture = spot.tau > sheet.jump ? row.end_fixture_2 : row.end_fixture_1;
  return surface.kind == kBody && fixture != FL_NONE && heads[surface.which >> 3].fixture == fixture &&
         spot.r_m < length_m + 1.0;
}

vec3 albedo_of(Surface surface) {
  if (surface.kind == kBox) return boxes[surface.which].albedo.rgb;
  if (surface.kind == kBody) return vec3(kBodyAlbedo);
  return vec3((uvec3(surface.which) >> uvec3(20, 10, 0)) & 1023u) / 1023.0;
}

void main() {
  uint thread = gl_LocalInvocationIndex;
  uvec2 pixel = gl_GlobalInvocationID.xy;
  vec2 low = vec2(gl_WorkGroupID.xy * uint(FL_TILE_PX));
  vec2 high = low + float(FL_TILE_PX);
  uvec2 size = uvec2(params.width, params.height);
  uvec2 cell = gl_WorkGroupID.xy / uint(FL_SUPERTILE_PX / FL_TILE_PX);
  uint rows = uint(lasers.length());
  uint words = (rows + 31u) / 32u;
  uint mask = (cell.y * params.supertiles_x + cell.x) * words;

  LaserPixel view;
  view.ray = ray_through(vec2(pixel) + 0.5);
  view.step_x = laser_step_x();
  view.step_y = laser_step_y();
  float ray_length = length(view.ray);
  Surface surface;
  vec3 air = vec3(0.0);
  vec3 lx = vec3(0.0);
  bool ready = false;
#ifdef FL_USE_HAZE
  haze_begin(vec2(pixel) + 0.5);
#endif
  for (uint base = 0u; base < words; base += kThreads) {
    barrier();
    if (thread < kNotes) word_bits[thread] = 0u;
    barrier();
    uint word = base + thread < words ? laser_masks[mask + base + thread] : 0u;
    if (word != 0u) atomicOr(word_bits[thread / 32u], 1u << (thread % 32u));
    barrier();
    uint before = 0u;
    uint count = 0u;
    for (uint w = 0u; w < kNotes; ++w) {
      uint here = uint(bitCount(word_bits[w]));
      if (w < thread / 32u) before += here;
      count += here;
    }
    before += uint(bitCount(word_bits[thread / 32u] & ((1u << (thread % 32u)) - 1u)));
    if (word != 0u) row_words[before] = base + thread;
    for (uint from = 0u; from < count; from += kNotes) {
      barrier();
      if (thread < kNotes) row_bits[thread] = 0u;
      barrier();
      uint which = from + thread / 32u;
      if (which < count) {
        uint index = 32u * row_words[which] + thread % 32u;
        bool touches = (laser_masks[mask + row_words[which]] >> (thread % 32u) & 1u) != 0u;
        if (touches && laser_touches(lasers[index], low, high)) {
          atomicOr(row_bits[thread / 32u], 1u << (thread % 32u));
        }
      }
      barrier();
      for (uint w = 0u; w < kNotes; ++w) {
        for (uint bits = row_bits[w]; bits != 0u; bits &= bits - 1u) {
          LaserRow row = lasers[32u * row_words[from + w] + uint(findLSB(bits))];
          for (; !ready; ready = true) {  // a loop, since lavapipe runs both sides of a branch
            surface = surface_at(ivec2(min(pixel, size - 1u)), view.ray / ray_length);
          }
          LaserSheet sheet = laser_sheet(row);
          if (kAir) {
            air += row.light.rgb * laser_in_air(sheet, view, surface.t_m, params.anisotropy, params.position.w,
                                                kExtinction);
          }
          if (surface.kind != kNothing) {
            float depth = surface.t_m / ray_length;
            LaserSpot spot = laser_on_surface(sheet, view, sheet.eye + view.ray * depth, depth, surface.normal);
            if (spot.illuminance > 0.0 && gets_there(row, sheet, spot, surface)) {
              float lost = kExtinction ? exp(-params.position.w * spot.r_m) : 1.0;
              lx += row.light.rgb * (spot.illuminance * lost);
            }
          }
        }
      }
    }
  }
  if (!ready || any(greaterThanEqual(pixel, size))) return;
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
