#version 460
// Adds the light of lasers in the air that laserstrips.comp has taken together, in the order of the rows. One workgroup
// a tile.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#define FL_LASERS_ACCESS readonly
#include "render/shaders/lib/laser_row.glsl"
#include "render/shaders/lib/laser_strip.glsl"
#define FL_STRIPS_ACCESS readonly
#define FL_LISTS_ACCESS readonly
#include "render/shaders/lib/laser_lists.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

const uint kThreads = uint(FL_TILE_PX * FL_TILE_PX);
const uint kNotes = kThreads / 32u;
shared uint here[kNotes];  // of so many strips: those that may reach into the tile, a bit each

// Whether a strip may reach into the tile. middle: of the tile, from that of the supertile.
bool reaches(uint strip, vec2 middle) {
  vec4 frame = laser_strips[strip].frame;
  vec4 size = laser_strips[strip].size;
  float tile = 0.5 * float(FL_TILE_PX) * (abs(frame.z) + abs(frame.w));
  vec2 away = middle - frame.xy;
  return abs(dot(away, frame.zw)) < size.x + tile &&
         abs(dot(away, strip_across(frame.zw))) < size.y + laser_strips[strip].edge_1.w + tile;
}

void main() {
  const uint side = uint(FL_SUPERTILE_PX / FL_TILE_PX);
  uvec2 cell = gl_WorkGroupID.xy / side;
  LaserListRow list = laser_lists[cell.y * params.supertiles_x + cell.x];
  if (list.strips == 0u) return;
  vec2 middle = (vec2(gl_WorkGroupID.xy % side) + 0.5) * float(FL_TILE_PX) - 0.5 * float(FL_SUPERTILE_PX);
  vec2 px = middle + vec2(gl_LocalInvocationID.xy) + 0.5 - 0.5 * float(FL_TILE_PX);
  vec3 air = vec3(0.0);
  uint thread = gl_LocalInvocationIndex;
  for (uint base = 0u; base < list.strips; base += kThreads) {
    barrier();
    if (thread < kNotes) here[thread] = 0u;
    barrier();
    if (base + thread < list.strips && reaches(list.first + base + thread, middle)) {
      atomicOr(here[thread / 32u], 1u << (thread % 32u));
    }
    barrier();
    for (uint word = 0u; word < kNotes; ++word) {
      for (uint bits = here[word]; bits != 0u; bits &= bits - 1u) {
        uint strip = list.first + base + 32u * word + uint(findLSB(bits));
        air += laser_strips[strip].light.rgb * light_of_strip(laser_strips[strip], px);
      }
    }
  }
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(params.width) || pixel.y >= int(params.height)) return;
  vec4 behind = imageLoad(radiance, pixel);
  imageStore(radiance, pixel, vec4(behind.rgb + params.forward.w * air, behind.a));
}
