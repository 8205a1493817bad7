#version 460
// Takes the light in the air of lasers together for supertiles, one workgroup a supertile: rows whose light in front of
// everything solid is near polynomials become strips, which laserair.comp draws; rows without light there are dropped;
// the bits of the others stay for lasers.comp. Haze is even.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#define FL_LASERS_ACCESS readonly
#include "render/shaders/lib/laser_row.glsl"
#define FL_LASER_MASKS_ACCESS
#include "render/shaders/lib/laser_masks.glsl"
#include "render/shaders/lib/laser_strip.glsl"
#define FL_STRIPS_ACCESS writeonly
#define FL_LISTS_ACCESS
#include "render/shaders/lib/laser_lists.glsl"

layout(local_size_x = 256) in;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
layout(constant_id = FL_SPEC_BOXES) const bool kBoxes = true;
layout(constant_id = FL_SPEC_BODIES) const bool kBodies = true;
const bool kSolids = kBoxes || kBodies;
const bool kAir = true;
#define FL_DEPTHS_ACCESS readonly
#define FL_DEPTHS_READ
#include "render/shaders/lib/tile_depth.glsl"
#include "render/shaders/lib/laser_batch.glsl"

shared uint first_strip;

// Takes together rows of the list; returns how many are strips, of which `found` are before.
uint take_batch(uint begin, uint count, vec2 middle, uint mask, uint found) {
  vec3 unused = vec3(0.0);
  find_strips(begin, count, middle, 0.5 * float(FL_SUPERTILE_PX), vec2(0.0), 0.0, unused);
  uint slot = gl_LocalInvocationIndex / kPlaces;
  if (gl_LocalInvocationIndex % kPlaces == 0u && slot < count) {
    if ((by_strip >> slot & 1u) != 0u) {
      laser_strips[first_strip + found + uint(bitCount(by_strip & ((1u << slot) - 1u)))] = strips[slot];
    }
    uint row = listed[begin + slot];
    if (((by_pixel | on_surfaces) >> slot & 1u) == 0u) atomicAnd(laser_masks[mask + row / 32u], ~(1u << (row % 32u)));
  }
  uint strips_here = uint(bitCount(by_strip));
  barrier();
  return strips_here;
}

void main() {
  uint thread = gl_LocalInvocationIndex;
  uint supertile = gl_WorkGroupID.y * params.supertiles_x + gl_WorkGroupID.x;
  vec2 low = vec2(gl_WorkGroupID.xy * uint(FL_SUPERTILE_PX));
  vec2 high = low + float(FL_SUPERTILE_PX);
  vec2 middle = 0.5 * (low + high);
  uint words = laser_words();
  uint mask = supertile * words;
  uint rows = laser_lists[supertile].rows;
  if (rows == 0u) return;
  if (thread == 0u) {
    first_strip = 0u;
    const uint side = uint(FL_SUPERTILE_PX / FL_TILE_PX);
    RectDepth depth = rect_depth(gl_WorkGroupID.xy * side, side);
    // In lengths of rays, which differ by less than this in a supertile.
    float ray_length = length(ray_through(middle));
    float apart = length(ray_through(low) - ray_through(high)) / ray_length;
    nearest_bits = floatBitsToUint(depth.near_m / (ray_length * (1.0 + apart)));
    farthest_bits = floatBitsToUint(depth.far_m / ray_length * (1.0 + apart));
  }
  barrier();
  uint before = 0u;
  for (uint other = thread; other < supertile; other += kThreads) before += laser_lists[other].rows;
  if (before > 0u) atomicAdd(first_strip, before);
  barrier();
  if (first_strip + rows > uint(laser_strips.length())) return;  // lasers.comp draws them
  uint found = 0u;
  for (uint base = 0u; base < words; base += kThreads) {
    uint count = list_words(mask, base, words);
    for (uint from = 0u; from < count; from += kNotes) {
      uint total = list_rows(mask, from, count, low, high);
      barrier();
      for (uint begin = 0u; begin < total; begin += kBatch) {
        found += take_batch(begin, min(total - begin, kBatch), middle, mask, found);
      }
    }
  }
  if (thread == 0u) {
    laser_lists[supertile].first = first_strip;
    laser_lists[supertile].strips = found;
  }
}
