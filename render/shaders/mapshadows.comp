#version 460
// Draws the shadow map of a beam (lib/shadow_map.glsl), a workgroup a beam. Bodies that may hide its light are listed
// some hundred at a time; each thread keeps what its block of texels meets first. The smallest distance does not depend
// on their order.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/lib/tile_test.glsl"

layout(local_size_x = FL_GROUP_BEAM_MAPS) in;
layout(constant_id = FL_SPEC_MAP_PX) const uint kMapPx = 64u;
// Whether anything beside the stage boxes, which come first, hides light.
layout(constant_id = FL_SPEC_BODIES) const bool kBodies = false;
#include "render/shaders/lib/solid.glsl"
layout(set = 0, binding = FL_BINDING_SHADOW_LISTS, std430) writeonly buffer ShadowListsBuffer {
  ShadowListRow shadow_lists[];
};
layout(set = 0, binding = FL_BINDING_BEAM_MAPS, std430) buffer ShadowMapsBuffer { uint shadow_maps[]; };

const uint kThreads = uint(FL_GROUP_BEAM_MAPS);
#include "render/shaders/lib/shadow_map_words.glsl"
// Threads have blocks side by side, 16 x 16 of them at a time.
const uint kSide = 16u;
const uint kBlock = kMapPx < 4u * kSide ? kMapPx / kSide : 4u;  // texels a side
const uint kRegion = kSide * kBlock;
#define kTexel (2.0 / float(kMapPx))  // of rho
const float kNone = 65504.0;  // the largest half float

// A body in the beam: it is where |dual[i] . place + offset| <= 1 for all i, and its texels are within a rectangle.
struct MapSolid {
  vec4 dual[3];
  vec4 rect;  // of rho: least x, y, most x, y
  float slack_m;  // as OccluderRow
};
shared uint solid_ids[2u * kThreads];  // of bodies that may hide light of the beam
shared uint solid_count;
shared MapSolid solids[kThreads];
shared uint group_ids[kThreads];
shared uint group_count;
shared uint nearest_bits[FL_MAP_CELLS * FL_MAP_CELLS];  // of half floats, which are in the order of their bits
shared uint farthest_bits[FL_MAP_CELLS * FL_MAP_CELLS];

MapSolid map_solid(OccluderRow occluder, BeamRow row, BeamShape beam) {
  ShadowSolid solid = solid_of(occluder, row);
  MapSolid result;
  bool is_solid = true;
  [[unroll]] for (int i = 0; i < 3; ++i) {
    // A plate has no thickness: a tenth of a millimetre stands for it.
    vec3 n = cross(solid.half_edge[(i + 1) % 3], solid.half_edge[(i + 2) % 3]);
    float unit = inversesqrt(max(dot(n, n), 1e-30));
    if (dot(solid.half_edge[i], solid.half_edge[i]) < 1e-8) solid.half_edge[i] = 1e-4 * unit * n;
  }
  [[unroll]] for (int i = 0; i < 3; ++i) {
    vec3 n = cross(solid.half_edge[(i + 1) % 3], solid.half_edge[(i + 2) % 3]);
    float reach = dot(n, solid.half_edge[i]);
    is_solid = is_solid && abs(reach) > 1e-30;
    n /= abs(reach) > 1e-30 ? reach : 1e-30;
    result.dual[i] = vec4(n, -dot(n, solid.center));
  }
  result.slack_m = occluder.half_edge_1.w;
  vec2 low = vec2(1e30);
  vec2 high = vec2(-1e30);
  bool is_whole = false;
  [[unroll]] for (int corner = 0; corner < 8; ++corner) {
    vec3 p = solid.center + ((corner & 1) != 0 ? 1.0 : -1.0) * solid.half_edge[0] +
             ((corner & 2) != 0 ? 1.0 : -1.0) * solid.half_edge[1] +
             ((corner & 4) != 0 ? 1.0 : -1.0) * solid.half_edge[2];
    float w = beam.lens_radius_m + beam.spread * p.z;
    is_whole = is_whole || !(w > 0.5 * beam.lens_radius_m);
    vec2 rho = p.xy / max(w, 0.5 * beam.lens_radius_m);
    low = min(low, rho);
    high = max(high, rho);
  }
  result.rect = !is_solid ? vec4(3.0, 3.0, -3.0, -3.0) : is_whole ? vec4(-2.0, -2.0, 2.0, 2.0) : vec4(low, high);
  return result;
}

// Where light at rho is in a body: x to y along the axis; y below x: nowhere. lean_m: how much deeper the face that it
// enters is a texel further, at most some 83 degrees.
vec2 inside_m(MapSolid solid, BeamShape beam, vec2 rho, out float lean_m) {
  vec2 part = vec2(0.0, beam.range_m);
  lean_m = 0.0;
  [[unroll]] for (int i = 0; i < 3; ++i) {
    float at = dot(solid.dual[i].xy, rho) * beam.lens_radius_m + solid.dual[i].w;
    float slope = dot(solid.dual[i].xy, rho) * beam.spread + solid.dual[i].z;
    float inverse = 1.0 / (abs(slope) > 1e-12 ? slope : 1e-12);
    vec2 ends = (vec2(-1.0, 1.0) - at) * inverse;
    float near = min(ends.x, ends.y);
    if (near > part.x) {
      part.x = near;
      lean_m = min(length(solid.dual[i].xy) * abs(inverse), 8.0) * (beam.lens_radius_m + beam.spread * near) * kTexel;
    }
    part.y = min(part.y, max(ends.x, ends.y));
  }
  return part;
}

// False only where nothing of a group of bodies has a shadow in the beam.
bool group_may_hide(uint group, uint groups, BeamRow row, BeamShape beam) {
  uint place = uint(shadow_maps.length()) - 4u * (groups - group);
  vec4 sphere = vec4(uintBitsToFloat(shadow_maps[place]), uintBitsToFloat(shadow_maps[place + 1u]),
                     uintBitsToFloat(shadow_maps[place + 2u]), uintBitsToFloat(shadow_maps[place + 3u]));
  if (sphere.w < 0.0) return false;
  vec3 center = row.eye.xyz + to_light(row, sphere.xyz - params.position.xyz);
  float radius_m = sphere.w * beam_stretch(row.squeeze) + 1e-6 * length(center);
  float reach_m = radius_m * sqrt(1.0 + beam.spread * beam.spread);
  return center.z + radius_m > 0.0 && center.z - radius_m < beam.range_m &&
         length(center.xy) <= beam.lens_radius_m + beam.spread * center.z + reach_m;
}

// Lists the groups from `first` on, one a thread. All threads call it together.
void list_groups(uint first, uint groups, BeamRow row, BeamShape beam) {
  uint lane = gl_LocalInvocationIndex;
  barrier();  // the list before this one has been read
  if (lane == 0u) group_count = 0u;
  barrier();
  if (first + lane < groups && group_may_hide(first + lane, groups, row, beam)) {
    group_ids[atomicAdd(group_count, 1u)] = first + lane;
  }
  barrier();
}

// Where the search for bodies is: groups from `first` on are listed, and rows of these from the one numbered `base` on
// are next; found: so many bodies are on the list.
struct Search {
  uint first;
  uint base;
  uint found;
};
// Adds what may hide light among the next rows to the list, a row a thread. All threads call it together.
void find_solids(inout Search search, uint groups, uint all, BeamRow row, BeamShape beam, uint fixture) {
  if (search.base == 0u) list_groups(search.first, groups, row, beam);
  uint own = search.base + gl_LocalInvocationIndex;
  if (own < group_count * uint(FL_OCCLUDER_GROUP)) {
    uint at = group_ids[own / uint(FL_OCCLUDER_GROUP)] * uint(FL_OCCLUDER_GROUP) + own % uint(FL_OCCLUDER_GROUP);
    if (at < all && may_hide(occluders[at], row, beam, fixture)) solid_ids[atomicAdd(solid_count, 1u)] = at;
  }
  search.base += kThreads;
  if (search.base >= group_count * uint(FL_OCCLUDER_GROUP)) search = Search(search.first + kThreads, 0u, 0u);
  barrier();
  search.found = solid_count;
  barrier();  // all threads go on with the same number
}

void main() {
  uint lane = gl_LocalInvocationIndex;
  uint beam_index = gl_WorkGroupID.y * uint(FL_SHADOWS_X) + gl_WorkGroupID.x;
  if (beam_index >= counts.live_count) return;
  BeamRow row = beams[beam_index];
  BeamShape beam = beam_shape(row);
  uint fixture = heads[row.head].fixture;
  uint all = uint(occluders.length());
  if (!kBodies) all = min(all, params.box_count);
  uint groups = occluder_groups(uint(occluders.length()));
  if (lane < kMapCells * kMapCells) {
    nearest_bits[lane] = packHalf2x16(vec2(kNone, 0.0));
    farthest_bits[lane] = 0u;
  }
  uvec2 thread_at = uvec2(lane % kSide, lane / kSide);
  uint found_all = 0u;
  for (uint region = 0u; region < (kMapPx / kRegion) * (kMapPx / kRegion); ++region) {
    uvec2 block = kRegion * uvec2(region % (kMapPx / kRegion), region / (kMapPx / kRegion)) + kBlock * thread_at;
    vec2 block_rho = (vec2(block) + 0.5) * kTexel - 1.0;  // of its first texel
    vec2 block_end = block_rho + float(kBlock - 1u) * kTexel;
    float met[16];
    float passed[16];
    [[unroll]] for (int t = 0; t < 16; ++t) {
      met[t] = kNone;
      passed[t] = kNone;
    }
    found_all = 0u;
    Search search = Search(0u, 0u, 0u);
    while (search.first < groups) {
      barrier();  // the list before this one has been read
      if (lane == 0u) solid_count = 0u;
      search.found = 0u;
      barrier();
      while (search.first < groups && search.found < kThreads) find_solids(search, groups, all, row, beam, fixture);
      found_all += search.found;
      for (uint base = 0u; base < search.found; base += kThreads) {
        uint count = min(search.found - base, kThreads);
        barrier();  // the solids before these have been read
        if (lane < count) solids[lane] = map_solid(occluders[solid_ids[base + lane]], row, beam);
        barrier();
        // Each thread goes on to the next body of its own block: most are in few blocks.
        for (uint word = 0u; word < count; word += 32u) {
          uint bits = 0u;
          for (uint s = word; s < min(word + 32u, count); ++s) {
            vec4 rect = solids[s].rect;
            bool reaches = !any(greaterThan(rect.xy, block_end)) && !any(lessThan(rect.zw, block_rho));
            bits |= reaches ? 1u << (s - word) : 0u;
          }
          while (bits != 0u) {
            MapSolid solid = solids[word + uint(findLSB(bits))];
            bits &= bits - 1u;
            [[unroll]] for (int t = 0; t < 16; ++t) {
              vec2 rho = block_rho + kTexel * vec2(float(t & 3), float(t >> 2));
              float lean_m;
              vec2 part = inside_m(solid, beam, rho, lean_m);
              bool hits = part.y > max(part.x, 1e-4) && part.x < part.y;
              met[t] = hits ? min(met[t], part.x) : met[t];
              // A plate must not hide light from its own face, nor from what is as far behind it as it may be smaller.
              float behind_m = max(part.y, part.x + 1.5 * lean_m + 2.0 * solid.slack_m);
              passed[t] = hits ? min(passed[t], behind_m) : passed[t];
            }
          }
        }
      }
    }
    [[unroll]] for (int t = 0; t < 16; ++t) {
      uvec2 at = uvec2(uint(t) & 3u, uint(t) >> 2);
      if (at.x >= kBlock || at.y >= kBlock) continue;
      uvec2 texel = block + at;
      // What is nearer than half floats tell apart counts as at the lens.
      uint word = packHalf2x16(min(vec2(met[t], passed[t]), kNone)) & 0x7fff7fffu;
      shadow_maps[beam_index * kMapWords + kMapCells * kMapCells + texel.y * kMapPx + texel.x] = word;
      vec2 rho = block_rho + kTexel * vec2(at);
      if (length(rho) > 1.0 + 0.75 * kTexel) continue;  // no light of the beam is there
      uvec2 cell = texel / max(kMapPx / kMapCells, 1u);
      atomicMin(nearest_bits[cell.y * kMapCells + cell.x], word & 0xffffu);
      atomicMax(farthest_bits[cell.y * kMapCells + cell.x], word & 0xffffu);
    }
  }
  barrier();
  if (lane < kMapCells * kMapCells) {
    // Cells without light: neither lit nor dark.
    shadow_maps[beam_index * kMapWords + lane] = nearest_bits[lane] | farthest_bits[lane] << 16;
  }
  if (lane == 0u) shadow_lists[beam_index] = ShadowListRow(0u, found_all);
}
