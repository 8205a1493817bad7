// The solids that may hide the sun from something that a tile of the picture shows, found by its threads together.
// After shaft.h.
#include "render/shaders/lib/shaft_occluders.glsl"

const uint kSolidsMax = 64u;  // of a tile; with more, all that reach into a group's light are tried
shared uint tile_groups[FL_PANES_MAX / 32];  // of panes, whose light the tile may show: a bit each
// The planes at the sides of the tile's pyramid, through the camera and turned inwards; unit.
shared vec3 tile_sides[4];
shared uint tile_solid_count;
shared uint tile_solids_found[kSolidsMax];
shared uint tile_solids[kSolidsMax];  // ascending
shared ShaftSlabs tile_slabs[kSolidsMax];
// Of all that the tile shows and the camera, from the camera, m; bits that grow with the value.
shared uint tile_low[3];
shared uint tile_high[3];

uint ordered(float v) {
  uint bits = floatBitsToUint(v);
  return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}
float from_ordered(uint v) { return uintBitsToFloat((v & 0x80000000u) != 0u ? v & 0x7fffffffu : ~v); }

bool reaches_into(uint group, uint solid) {
  return (pane_masks[group * mask_words() + solid / 32u] >> (solid & 31u) & 1u) != 0u;
}

// False only where nothing of the tile is in the shadow: all of it is beyond one of the solid's faces towards the sun,
// or all of the shadow is beyond one side of the tile's pyramid.
bool shadow_meets_tile(ShaftSolid solid, ShaftSlabs slabs, vec3 sun, vec3 low, vec3 high) {
  float size = length(low) + length(high);
  vec3 normals[3] = vec3[3](slabs.normal_0, slabs.normal_1, slabs.normal_2);
  for (int i = 0; i < 3; ++i) {
    // The light goes along the normal, so the shadow is at the face against it and behind.
    float nearest = slabs.middle[i] - slabs.reach;
    float farthest = dot(max(normals[i], 0.0), high) + dot(min(normals[i], 0.0), low);
    float slack = 1e-5 * length(normals[i]) * (size + length(solid.center));
    if (farthest <= nearest + slack) return false;
    // Along the face the shadow ends.
    float lowest = dot(max(normals[i], 0.0), low) + dot(min(normals[i], 0.0), high);
    if (lowest >= slabs.middle[i] + slabs.reach + slabs.speed[i] * params.up.w + slack) return false;
  }
  for (int i = 0; i < 4; ++i) {
    vec3 inwards = tile_sides[i];
    float most = dot(inwards, solid.center) + abs(dot(inwards, solid.half_0)) + abs(dot(inwards, solid.half_1)) +
                 abs(dot(inwards, solid.half_2)) + max(dot(inwards, sun), 0.0) * params.up.w;
    if (most < -1e-5 * (length(solid.center) + params.up.w)) return false;
  }
  return true;
}

// Finds them; all threads of the tile call it, with tile_sides and tile_groups set. end: what the pixel shows, or how
// far light may be seen, from the camera. There are tile_solid_count, and lists only if these are kSolidsMax or less.
void find_solids(vec3 sun, vec3 end) {
  const uint kThreads = uint(FL_TILE_PX * FL_SHAFT_ROWS);
  uint thread = gl_LocalInvocationIndex;
  if (thread < 3u) {
    tile_low[thread] = ordered(0.0);
    tile_high[thread] = ordered(0.0);
  }
  if (thread == 3u) tile_solid_count = 0u;
  barrier();
  vec3 low = subgroupMin(end);
  vec3 high = subgroupMax(end);
  if (subgroupElect()) {
    for (int i = 0; i < 3; ++i) {
      atomicMin(tile_low[i], ordered(low[i]));
      atomicMax(tile_high[i], ordered(high[i]));
    }
  }
  barrier();
  low = vec3(from_ordered(tile_low[0]), from_ordered(tile_low[1]), from_ordered(tile_low[2]));
  high = vec3(from_ordered(tile_high[0]), from_ordered(tile_high[1]), from_ordered(tile_high[2]));
  uint words = mask_words();
  for (uint i = thread; i < uint(occluders.length()); i += kThreads) {
    uint reaches = 0u;
    for (uint word = 0u; word < uint(FL_PANES_MAX) / 32u; ++word) {
      for (uint bits = tile_groups[word]; bits != 0u; bits &= bits - 1u) {
        reaches |= pane_masks[(32u * word + uint(findLSB(bits))) * words + i / 32u];
      }
    }
    if ((reaches >> (i & 31u) & 1u) == 0u) continue;
    ShaftSolid solid = solid_of(occluders[i]);
    if (!shadow_meets_tile(solid, shaft_slabs(solid, sun), sun, low, high)) continue;
    uint place = atomicAdd(tile_solid_count, 1u);
    if (place < kSolidsMax) tile_solids_found[place] = i;
  }
  barrier();
  uint count = tile_solid_count;
  if (count > kSolidsMax) return;
  if (thread < count) {
    uint own = tile_solids_found[thread];
    uint place = 0u;
    for (uint i = 0u; i < count; ++i) place += tile_solids_found[i] < own ? 1u : 0u;
    tile_solids[place] = own;
    tile_slabs[place] = shaft_slabs(solid_of(occluders[own]), sun);
  }
  barrier();
}
