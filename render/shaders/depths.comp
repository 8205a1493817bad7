#version 460
// What each tile of 16 x 16 pixels shows: the nearest and the farthest distance, and whether it is one plane. The beam
// passes take beams that end on one plane together for a whole tile.
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "render/shaders/lib/frame.glsl"
const bool kSolids = true;
#define FL_DEPTHS_ACCESS writeonly
#include "render/shaders/lib/tile_depth.glsl"

#define FL_ROWS 4
layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX / FL_ROWS) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;

shared float per_depth[FL_TILE_PX * FL_TILE_PX];  // 1 / depth of each pixel, 1/m
shared uint near_bits;                            // distances are positive: their bits are in order
shared uint far_bits;
shared uint off_plane;

void main() {
  uvec2 first = gl_WorkGroupID.xy * uint(FL_TILE_PX);
  uvec2 size = min(uvec2(params.width, params.height) - first, uvec2(FL_TILE_PX));
  if (gl_LocalInvocationIndex == 0u) {
    near_bits = floatBitsToUint(FL_FAR_M);
    far_bits = 0u;
    off_plane = 0u;
  }
  barrier();
  float near_m = FL_FAR_M;
  float far_m = 0.0;
  for (uint i = 0u; i < uint(FL_ROWS); ++i) {
    uvec2 at = gl_LocalInvocationID.xy + uvec2(0u, i * uint(FL_TILE_PX / FL_ROWS));
    float inverse = 0.0;
    if (at.x < size.x && at.y < size.y) {
      float t_m = min(imageLoad(radiance, ivec2(first + at)).a, FL_FAR_M);
      near_m = min(near_m, t_m);
      far_m = max(far_m, t_m);
      inverse = t_m < 0.5 * FL_FAR_M ? length(ray_through(vec2(first + at) + 0.5)) / t_m : 0.0;
    }
    per_depth[at.y * uint(FL_TILE_PX) + at.x] = inverse;
  }
  near_m = subgroupMin(near_m);
  far_m = subgroupMax(far_m);
  if (subgroupElect()) {
    atomicMin(near_bits, floatBitsToUint(near_m));
    atomicMax(far_bits, floatBitsToUint(far_m));
  }
  barrier();
  // The plane through three corners; all pixels are held against it.
  float corner = per_depth[0];
  float right = per_depth[size.x - 1u];
  float below = per_depth[(size.y - 1u) * uint(FL_TILE_PX)];
  vec2 slope = vec2(size.x > 1u ? (right - corner) / float(size.x - 1u) : 0.0,
                    size.y > 1u ? (below - corner) / float(size.y - 1u) : 0.0);
  for (uint i = 0u; i < uint(FL_ROWS); ++i) {
    uvec2 at = gl_LocalInvocationID.xy + uvec2(0u, i * uint(FL_TILE_PX / FL_ROWS));
    if (at.x >= size.x || at.y >= size.y) continue;
    float own = per_depth[at.y * uint(FL_TILE_PX) + at.x];
    float off = own - corner - dot(slope, vec2(at));
    if (!(abs(off) <= kPlaneSlack * own)) atomicOr(off_plane, 1u);
  }
  barrier();
  if (gl_LocalInvocationIndex == 0u) {
    float middle = corner + dot(slope, vec2(0.5 * float(FL_TILE_PX) - 0.5));
    tile_depths[gl_WorkGroupID.y * tiles_across() + gl_WorkGroupID.x] =
        TileDepthRow(uintBitsToFloat(near_bits), uintBitsToFloat(far_bits), 1u - off_plane, 0u,
                     vec4(middle, slope, 0.0));
  }
}
