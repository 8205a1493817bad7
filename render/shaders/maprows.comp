#version 460
// Writes the rows of a beam's shadow map (lib/shadow_row_line.glsl) from its texels, a workgroup a beam.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/lib/tile_test.glsl"
layout(local_size_x = FL_GROUP_BEAM_MAPS) in;
layout(constant_id = FL_SPEC_MAP_PX) const uint kMapPx = 64u;
#include "render/shaders/lib/shadow_map_words.glsl"
#include "render/shaders/lib/shadow_row_line.glsl"
layout(set = 0, binding = FL_BINDING_SHADOW_LISTS, std430) readonly buffer ShadowListsBuffer {
  ShadowListRow shadow_lists[];
};
layout(set = 0, binding = FL_BINDING_BEAM_MAPS, std430) buffer ShadowMapsBuffer { uint shadow_maps[]; };

const uint kNone = 0x7c00u;

// The lines of a row through the eye's place, in homogeneous places of the gobo plane: offset is that of all points
// rho with rho = s along + offset (along.y, -along.x), and `along` is the way of a camera ray.
struct MapRow {
  float offset;
  vec2 along;
  float half_length;  // of the line within the disc
  vec2 slope;         // w and z of the eye over its distance along the line, against the way
};
MapRow map_row(vec3 eye, float w, uint number) {
  MapRow row;
  row.offset = (2.0 * float(number) + 1.0) / float(FL_MAP_ROWS) - 1.0;
  row.half_length = sqrt(1.0 - row.offset * row.offset);
  float square = dot(eye.xy, eye.xy);
  float away = sqrt(max(square - row.offset * row.offset * w * w, 1e-20));
  row.along = (-away * eye.xy + row.offset * w * vec2(-eye.y, eye.x)) / square;
  row.slope = vec2(w, eye.z) / away;
  return row;
}

// The key of a place: of the ray of the row that meets the first body there. At the eye z over w is slope.y over
// slope.x, where s is -1 over slope.x.
uint place_key(uint beam_index, BeamShape beam, MapRow row, uint place) {
  float s = row.half_length * ((2.0 * float(place) + 1.0) / float(FL_MAP_ROWS) - 1.0);
  vec2 rho = s * row.along + row.offset * vec2(row.along.y, -row.along.x);
  ivec2 at = clamp(ivec2(floor((0.5 * rho + 0.5) * float(kMapPx))), 0, int(kMapPx) - 1);
  uint word = shadow_maps[beam_index * kMapWords + kMapCells * kMapCells + uint(at.y) * kMapPx + uint(at.x)];
  float met_m = unpackHalf2x16(word).x;
  if (met_m >= 65504.0) return kNone;
  if (!(met_m > 0.0)) return 0u;
  // z over w is linear along each ray.
  float met = met_m / (beam.lens_radius_m + beam.spread * met_m);
  float middle = (met + s * row.slope.y) / (1.0 + s * row.slope.x);
  float enters = middle * (1.0 - row.half_length * row.slope.x) + row.half_length * row.slope.y;
  float below = 1.0 - beam.spread * enters;
  return row_key(below > 1e-6 ? enters * beam.lens_radius_m / below : kRowFar);
}

void main() {
  uint beam_index = gl_WorkGroupID.y * uint(FL_SHADOWS_X) + gl_WorkGroupID.x;
  if (beam_index >= counts.live_count || shadow_lists[beam_index].count == 0u) return;
  BeamRow row = beams[beam_index];
  if (!has_rows(row, kRowsFrom)) return;
  BeamShape beam = beam_shape(row);
  float w = beam.lens_radius_m + beam.spread * row.eye.z;
  // A thread writes two groups, whose least and largest keys share words.
  const uint kPairs = uint(FL_MAP_ROW_GROUPS / 2);
  for (uint pair = gl_LocalInvocationIndex; pair < uint(FL_MAP_ROWS) * kPairs; pair += uint(FL_GROUP_BEAM_MAPS)) {
    uint own = pair % kPairs;
    MapRow of = map_row(row.eye.xyz, w, pair / kPairs);
    uint at = beam_index * kMapWords + kMapRowsAt + pair / kPairs * uint(FL_MAP_ROW_WORDS);
    uvec2 least = uvec2(kNone);
    uvec2 most = uvec2(0u);
    [[unroll]] for (uint half_of = 0u; half_of < 2u; ++half_of) {
      uint group = own + half_of * kPairs;
      [[unroll]] for (uint k = 0u; k < uint(FL_MAP_GROUP_WORDS); ++k) {
        uvec2 keys = uvec2(place_key(beam_index, beam, of, 8u * group + k),
                           place_key(beam_index, beam, of, 8u * group + k + 4u));
        least[half_of] = min(least[half_of], min(keys.x, keys.y));
        most[half_of] = max(most[half_of], max(keys.x, keys.y));
        shadow_maps[at + 2u * kPairs + uint(FL_MAP_GROUP_WORDS) * group + k] = keys.x | keys.y << 16;
      }
    }
    shadow_maps[at + own] = least.x | least.y << 16;
    shadow_maps[at + kPairs + own] = most.x | most.y << 16;
  }
}
