#version 460
// What each tile shows, for the light of displays: up to FL_DISPLAY_RECORD_PLANES planes, one of which may be nothing,
// which of its pixels show which, and how far away other things are. One workgroup a tile.
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/albedo.glsl"
#define FL_DISPLAY_TILES_ACCESS writeonly
#define FL_DISPLAY_RECORDS_ACCESS readonly
#include "render/shaders/lib/display_records.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;

const float kPlane = 1e-5;  // of the distance: surfaces of one plane are off it by no more
const uint kTries = 12u;
const float kDeepest = FL_DISPLAY_REST;
const uint kFew = 8u;  // pixels do not make a plane

shared uint leader;
shared vec4 plane;
shared uint albedo;  // bits of the brightest channel of all pixels of the plane
shared uint count;
shared uint low_x;
shared uint low_y;
shared uint high_x;
shared uint high_y;
shared uint near_bits;
shared uint far_bits;
shared uint words[FL_TILE_PX * FL_TILE_PX / 8];

// Counts the pixels that belong to something, and the box around them. By all threads; one adds for its subgroup.
void take(bool belongs) {
  uvec2 at = gl_LocalInvocationID.xy;
  uint number = subgroupAdd(belongs ? 1u : 0u);
  uvec2 low = subgroupMin(belongs ? at : uvec2(~0u));
  uvec2 high = subgroupMax(belongs ? at : uvec2(0u));
  if (number == 0u || !subgroupElect()) return;
  atomicAdd(count, number);
  atomicMin(low_x, low.x);
  atomicMin(low_y, low.y);
  atomicMax(high_x, high.x);
  atomicMax(high_y, high.y);
}

void main() {
  uint thread = gl_LocalInvocationIndex;
  uint tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  bool is_drawn = pixel.x < int(params.width) && pixel.y < int(params.height);
  vec3 ray = normalize(ray_through(vec2(pixel) + 0.5));
  Surface surface = Surface(kNothing, 0u, vec3(0.0), kNothingM, 0u);
  if (is_drawn) surface = surface_at(pixel, ray);
  bool solid = surface.kind != kNothing;
  vec4 own = solid ? vec4(surface.normal, dot(surface.normal, ray) * surface.t_m) : vec4(0.0);
  uint brightest = 0u;
  if (solid) {
    vec3 color = albedo_of(surface);
    brightest = floatBitsToUint(max(max(color.r, max(color.g, color.b)), 0.0));
  }
  uint mine = FL_DISPLAY_RECORD_NONE;
  uint planes = 0u;
  if (thread < uint(words.length())) words[thread] = 0u;
  bool left = is_drawn;
  for (uint try = 0u; try < kTries && planes < uint(FL_DISPLAY_RECORD_PLANES); ++try) {
    if (thread == 0u) {
      leader = ~0u;
      count = 0u;
      low_x = low_y = ~0u;
      high_x = high_y = 0u;
    }
    barrier();
    uint turn = (97u * thread + 61u * try) & uint(FL_TILE_PX * FL_TILE_PX - 1);
    uint first = subgroupMin(left ? turn : ~0u);
    if (first != ~0u && subgroupElect()) atomicMin(leader, first);
    barrier();
    if (leader == ~0u) break;
    if (left && turn == leader) {
      plane = own;
      albedo = 0u;
    }
    barrier();
    bool same = left && solid == (plane.xyz != vec3(0.0));
    if (same && solid) same = dot(own.xyz, plane.xyz) > 0.99999 && abs(own.w - plane.w) <= kPlane * surface.t_m;
    if (same) left = false;
    take(same);
    uint bright = subgroupMax(same ? brightest : 0u);
    if (bright > 0u && subgroupElect()) atomicMax(albedo, bright);
    barrier();
    if (count >= kFew) {
      if (same) mine = planes;
      if (thread == 0u) {
        display_tiles[tile].planes[planes] = plane;
        display_tiles[tile].boxes[planes] = packed_box(uvec2(low_x, low_y), uvec2(high_x, high_y));
        display_tiles[tile].counts[planes] = count;
        display_tiles[tile].albedos[planes] = uintBitsToFloat(albedo);
      }
      ++planes;
    }
    barrier();
  }
  bool rest = is_drawn && solid && mine == FL_DISPLAY_RECORD_NONE;
  if (thread == 0u) {
    count = 0u;
    low_x = low_y = near_bits = ~0u;
    high_x = high_y = far_bits = 0u;
  }
  barrier();
  uint depth = floatBitsToUint(surface.t_m * dot(ray, params.forward.xyz));
  uint nearest = subgroupMin(rest ? depth : ~0u);
  if (nearest != ~0u && subgroupElect()) atomicMin(near_bits, nearest);
  barrier();
  bool near_rest = rest && uintBitsToFloat(depth) <= uintBitsToFloat(near_bits) * kDeepest;
  take(near_rest);
  uint farthest = subgroupMax(near_rest ? depth : 0u);
  if (farthest > 0u && subgroupElect()) atomicMax(far_bits, farthest);
  atomicOr(words[thread / 8u], mine << (4u * (thread % 8u)));
  barrier();
  if (thread < uint(words.length())) display_tiles[tile].pixels[thread] = words[thread];
  if (thread >= planes && thread < uint(FL_DISPLAY_RECORD_PLANES)) display_tiles[tile].boxes[thread] = ~0u;
  if (thread == 0u) {
    display_tiles[tile].rest_box = packed_box(uvec2(low_x, low_y), uvec2(high_x, high_y));
    display_tiles[tile].rest_count = count;
    display_tiles[tile].rest_near_m = uintBitsToFloat(near_bits);
    display_tiles[tile].rest_far_m = uintBitsToFloat(far_bits);
  }
}
