#version 460
// Light in the haze of the beams that are smooth over a supertile but for their rim, or for what cuts them (RimRow and
// CutRow, of the coarse pass), each in patch order. A workgroup has 32 x 32 pixels of it; each of its subgroups leaves
// out what does not reach its pixels.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/lib/view.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/tile_node.h"
#include "render/shaders/lib/thread_number.glsl"
#define FL_PIXEL_THREADS FL_GROUP_RECORDS
#include "render/shaders/lib/tile_pixels.glsl"
#include "render/shaders/lib/tile_record.glsl"

layout(local_size_x = FL_GROUP_RECORDS) in;
layout(set = 0, binding = FL_BINDING_COARSE, std430) readonly buffer CoarseBuffer { CoarseRow coarse[]; };
layout(set = 0, binding = FL_BINDING_RIMS, std430) readonly buffer RimsBuffer { RimRow rims[]; };
layout(set = 0, binding = FL_BINDING_CUTS, std430) readonly buffer CutsBuffer { CutRow cuts[]; };

// The pixels of this thread and of its subgroup, from the supertile's middle, in halves of the hull.
vec2 first;
vec2 at;
vec2 reach;
vec3 y[FL_ROWS];
vec3 total[FL_ROWS];
bool any_reaches = false;  // some record reaches the subgroup's pixels

void add_rims(uint table, uint count) {
  float x2 = 2.0 * first.x * first.x - 1.0;
  for (uint base = 0u; base < count; base += gl_SubgroupSize) {
    uint own = table + base + gl_SubgroupInvocationID;
    bool reaches =
        own < table + count && record_reaches(rims[own].fits[0], rims[own].fits[1].xy, at, reach);
    uvec4 ballot = subgroupBallot(reaches);
    any_reaches = any_reaches || (ballot.x | ballot.y | ballot.z | ballot.w) != 0u;
    for (uint w = 0u; w < (gl_SubgroupSize + 31u) / 32u; ++w) {
      uint bits = ballot[w];
      while (bits != 0u) {
        RimRow row = rims[table + base + 32u * w + uint(findLSB(bits))];
        bits &= bits - 1u;
        vec3 rho = record_column(row.fits[0], row.fits[1].xy, first.x, x2);
        vec3 h = record_column(vec4(row.fits[1].zw, row.fits[2].xy), row.fits[2].zw, first.x, x2);
        [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
          float light = record_rim(rho, h, y[i], row.color.w);
          total[i] += kShowsClasses ? (light > 0.0 ? kClassRecord : vec3(0.0)) : light * row.color.rgb;
        }
      }
    }
  }
}

void add_cuts(uint table, uint count) {
  float x2 = 2.0 * first.x * first.x - 1.0;
  for (uint base = 0u; base < count; base += gl_SubgroupSize) {
    uint own = table + base + gl_SubgroupInvocationID;
    bool reaches =
        own < table + count && record_reaches(cuts[own].fits[0], cuts[own].fits[1].xy, at, reach);
    uvec4 ballot = subgroupBallot(reaches);
    any_reaches = any_reaches || (ballot.x | ballot.y | ballot.z | ballot.w) != 0u;
    for (uint w = 0u; w < (gl_SubgroupSize + 31u) / 32u; ++w) {
      uint bits = ballot[w];
      while (bits != 0u) {
        CutRow row = cuts[table + base + 32u * w + uint(findLSB(bits))];
        bits &= bits - 1u;
        CutColumns columns;
        [[unroll]] for (uint i = 0u; i < 3u; ++i) {
          columns.of[2u * i] = record_column(row.fits[3u * i], row.fits[3u * i + 1u].xy, first.x, x2);
          columns.of[2u * i + 1u] = record_column(vec4(row.fits[3u * i + 1u].zw, row.fits[3u * i + 2u].xy),
                                                  row.fits[3u * i + 2u].zw, first.x, x2);
        }
        [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
          float light = record_cut(columns, y[i]);
          total[i] += kShowsClasses ? (light > 0.0 ? kClassRecord : vec3(0.0)) : light * row.color.rgb;
        }
      }
    }
  }
}

void main() {
  uvec2 cell = gl_WorkGroupID.xy / uint(FL_SUPERTILE_PX / FL_FINE_PX);
  uint supertile = cell.y * params.supertiles_x + cell.x;
  uint rim_count = coarse[supertile].rims;
  uint cut_count = coarse[supertile].cuts;
  if (rim_count + cut_count == 0u) return;
  const float kHalf = FL_HULL * 0.5 * float(FL_SUPERTILE_PX);
  vec2 middle = (vec2(gl_WorkGroupID.xy) + 0.5) * float(FL_FINE_PX) - (vec2(cell) + 0.5) * float(FL_SUPERTILE_PX);
  first = (middle + first_place()) / kHalf;
  vec2 low = subgroupMin(first);
  vec2 high = subgroupMax(first) + vec2(0.0, float(FL_ROWS - 1) / kHalf);
  at = 0.5 * (low + high);
  reach = 0.5 * (high - low);
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
    total[i] = vec3(0.0);
    float place = first.y + float(i) / kHalf;
    y[i] = vec3(1.0, place, 2.0 * place * place - 1.0);
  }
  add_rims(supertile * params.rims_max, rim_count);
  add_cuts(supertile * params.cuts_max, cut_count);
  if (any_reaches) add_to_pixels(total);
}
