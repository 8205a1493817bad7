#version 460
// Planes of tiles that are one plane of their supertile become its records, and other things of it have three, of light
// in the air before planes across the camera's axis. One workgroup a supertile, a thread a plane of a tile.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#define FL_DISPLAY_TILES_ACCESS
#define FL_DISPLAY_RECORDS_ACCESS
#include "render/shaders/lib/display_records.glsl"

layout(constant_id = FL_SPEC_AIR) const bool kAir = true;
const uint kSide = uint(FL_SUPERTILE_PX / FL_TILE_PX);
layout(local_size_x = FL_DISPLAY_RECORD_PLANES * (FL_SUPERTILE_PX / FL_TILE_PX) * (FL_SUPERTILE_PX / FL_TILE_PX)) in;

const float kPlane = 2e-5;  // of the distance
const uint kLists = uint(FL_DISPLAY_RECORD_LISTS);
const uint kLeast = uint(FL_DISPLAY_RECORD_LEAST);
const uint kRestLeast = 3u * kLeast;
const float kDeepest = FL_DISPLAY_REST;

shared uint leader;
shared vec4 planes[FL_DISPLAY_RECORD_LISTS];
shared uint albedos[FL_DISPLAY_RECORD_LISTS];  // bits
shared uint counts[FL_DISPLAY_RECORD_LISTS];
shared uint low_x[FL_DISPLAY_RECORD_LISTS];
shared uint low_y[FL_DISPLAY_RECORD_LISTS];
shared uint high_x[FL_DISPLAY_RECORD_LISTS];
shared uint high_y[FL_DISPLAY_RECORD_LISTS];
shared uint records[FL_DISPLAY_RECORD_LISTS];
shared uint rest_count;
shared uint rest_near;  // bits of depths
shared uint rest_far;
shared uvec4 rest_box;
shared uint rest_record;

void main() {
  uint thread = gl_LocalInvocationIndex;
  uint slot = thread % uint(FL_DISPLAY_RECORD_PLANES);
  uint number = thread / uint(FL_DISPLAY_RECORD_PLANES);
  uvec2 first = gl_WorkGroupID.xy * kSide;
  uvec2 at = first + uvec2(number % kSide, number / kSide);
  uvec2 size = tiles_of_picture();
  bool left = at.x < size.x && at.y < size.y;
  uint tile = left ? at.y * size.x + at.x : 0u;
  uint box = left ? display_tiles[tile].boxes[slot] : ~0u;
  left = left && box != ~0u;
  vec4 own = left ? display_tiles[tile].planes[slot] : vec4(0.0);
  uvec4 ends = unpacked_box(box) + uvec4(at, at) * uint(FL_TILE_PX);
  bool solid = own.xyz != vec3(0.0);
  float t_m = 0.0;
  if (solid) {
    vec3 ray = normalize(ray_through(0.5 * vec2(ends.xy + ends.zw + 1u)));
    t_m = own.w / min(dot(own.xyz, ray), -1e-4);
  }
  if (thread < kLists) {
    counts[thread] = albedos[thread] = 0u;
    low_x[thread] = low_y[thread] = ~0u;
    high_x[thread] = high_y[thread] = 0u;
    records[thread] = FL_NONE;
  }
  if (thread == 0u) {
    rest_count = rest_far = 0u;
    rest_near = ~0u;
    rest_box = uvec4(~0u, ~0u, 0u, 0u);
    rest_record = FL_NONE;
  }
  barrier();
  bool has_rest = at.x < size.x && at.y < size.y && slot == 0u && display_tiles[tile].rest_count > 0u;
  if (has_rest) atomicMin(rest_near, floatBitsToUint(display_tiles[tile].rest_near_m));
  barrier();
  bool near_rest = has_rest && display_tiles[tile].rest_far_m <= uintBitsToFloat(rest_near) * kDeepest;
  if (near_rest) {
    uvec4 rest = unpacked_box(display_tiles[tile].rest_box) + uvec4(at, at) * uint(FL_TILE_PX);
    atomicAdd(rest_count, display_tiles[tile].rest_count);
    atomicMax(rest_far, floatBitsToUint(display_tiles[tile].rest_far_m));
    atomicMin(rest_box.x, rest.x);
    atomicMin(rest_box.y, rest.y);
    atomicMax(rest_box.z, rest.z);
    atomicMax(rest_box.w, rest.w);
  }
  uint mine = FL_NONE;
  for (uint list = 0u; list < kLists; ++list) {
    if (thread == 0u) leader = ~0u;
    barrier();
    if (left) atomicMin(leader, thread);
    barrier();
    if (leader == ~0u) break;
    if (thread == leader) planes[list] = own;
    barrier();
    vec4 plane = planes[list];
    bool same = left && solid == (plane.xyz != vec3(0.0));
    if (same && solid) same = dot(own.xyz, plane.xyz) > 0.99999 && abs(own.w - plane.w) <= kPlane * t_m;
    if (same) {
      left = false;
      mine = list;
      atomicAdd(counts[list], display_tiles[tile].counts[slot]);
      atomicMax(albedos[list], floatBitsToUint(display_tiles[tile].albedos[slot]));
      atomicMin(low_x[list], ends.x);
      atomicMin(low_y[list], ends.y);
      atomicMax(high_x[list], ends.z);
      atomicMax(high_y[list], ends.w);
    }
    barrier();
  }
  if (thread == 0u) {
    uint wanted = 0u;
    for (uint i = 0u; i < kLists; ++i) wanted += counts[i] >= kLeast ? 1u : 0u;
    bool rests = kAir && rest_count >= kRestLeast;
    if (rests) wanted += 3u;
    uint next = wanted == 0u ? 0u : atomicAdd(display_lists.counts[0], wanted);
    if (wanted > 0u && next + wanted <= uint(display_records.length())) {
      atomicMax(display_lists.groups[0], next + wanted);
      for (uint i = 0u; i < kLists; ++i) {
        if (counts[i] >= kLeast) records[i] = next++;
      }
      if (rests) rest_record = next;
    }
  }
  barrier();
  if (thread < kLists && records[thread] != FL_NONE) {
    uint record = records[thread];
    display_records[record].plane = planes[thread];
    display_records[record].box = vec4(low_x[thread], low_y[thread], high_x[thread] + 1u, high_y[thread] + 1u);
    display_records[record].root = record;
    display_records[record].albedo = uintBitsToFloat(albedos[thread]);
    display_records[record].square = first.y << 16 | first.x;
  }
  if (thread < 3u && rest_record != FL_NONE) {
    uint record = rest_record + thread;
    float depth_m = mix(uintBitsToFloat(rest_near), uintBitsToFloat(rest_far), 0.5 * float(thread));
    display_records[record].plane = vec4(-params.forward.xyz, -depth_m);
    display_records[record].box = vec4(rest_box.xy, rest_box.zw + 1u);
    display_records[record].root = rest_record;
    display_records[record].albedo = -1.0;
    display_records[record].square = first.y << 16 | first.x;
  }
  if (has_rest) {
    display_tiles[tile].rest_record = near_rest ? rest_record : FL_NONE;
    display_tiles[tile].rest_from_m = uintBitsToFloat(rest_near);
    display_tiles[tile].rest_to_m = uintBitsToFloat(rest_far);
  }
  if (box != ~0u) display_tiles[tile].records[slot] = mine == FL_NONE ? FL_NONE : records[mine];
}
