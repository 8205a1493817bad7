#version 460
// Compacts the lit heads into beam rows, in patch order: each group finds its place from the counts of those before it.
// A prism makes several beams of one. The last group writes the totals and the indirect arguments of the passes that
// follow.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS writeonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#define FL_USE_POSE
#include "render/shaders/lib/frame.glsl"

layout(local_size_x = FL_GROUP_HEADS) in;
layout(constant_id = FL_SPEC_OPTICS) const bool kOptics = false;
layout(constant_id = FL_SPEC_BLADES) const bool kBlades = false;

layout(set = 0, binding = FL_BINDING_WHEEL_SLOTS, std430) readonly buffer SlotsBuffer { WheelSlotRow wheel_slots[]; };
layout(set = 0, binding = FL_BINDING_FACETS, std430) readonly buffer FacetsBuffer { FacetRow facets[]; };
layout(set = 0, binding = FL_BINDING_OPTICS_STATES, std430) readonly buffer OpticsStatesBuffer {
  OpticsState optics_states[];
};
layout(set = 0, binding = FL_BINDING_BLADES, std430) writeonly buffer BladesBuffer { BladesRow blades[]; };

#include "render/shaders/lib/lit.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/optics.h"

const float kSquareRadius = 1.4142135623730951;  // of the circle round a square, over half its side

shared uint beams_before;
shared uint lit_before;
shared uint beams_of[FL_GROUP_HEADS];
shared uint lit_here;

void write_beams(uint index, uint first) {
  HeadRow row = heads[index];
  TypeRow type = types[row.type];
  HeadState state = states[index];
  BeamPose pose = beam_pose(row, type, state);
  float spread = tan(state.zoom);
  float profile_m = type.profile_m;
  bool shaped = kOptics && row.optics != kNoAddress;

  BeamRow beam;
  beam.gobo = 0u;
  beam.gobo_cos = 1.0;
  beam.gobo_sin = 0.0;
  beam.gobo_2 = 0u;
  beam.gobo_2_cos = 1.0;
  beam.gobo_2_sin = 0.0;
  beam.gobo_scale = 1.0;
  beam.gobo_blur = 0.0;
  beam.blades = 0u;
  beam.next_1 = 0u;
  beam.next_2 = 0u;
  beam.offset_1 = 0.0;
  beam.offset_2 = 0.0;
  beam.focus = -1.0;
  beam.animation = 0u;
  beam.animation_cos = 1.0;
  beam.animation_sin = 0.0;
  beam.measured = kMeasured ? type.measured : 0u;
  beam.squeeze = kRectangle && type.aspect > 0.0 ? 1.0 / (type.aspect * type.aspect) : 0.0;
  beam.head = index;
  float lens_radius_m = type.lens_radius_m;
  OpticsState optics;
  uint facet_count = 0u;
  uint facet_first = 0u;
  if (shaped) {
    optics = optics_states[row.optics];
    beam.focus = optics.focus;
    profile_m = softened_profile(profile_m, max(optics.frost, focus_rim(lens_radius_m, spread, optics.focus)));
    if (optics.frost > 0.0) {
      spread = spread * (1.0 + kFrostWidens * optics.frost) + kFrostAdds * optics.frost;
      beam.gobo_blur = kFrostBlur * optics.frost;
    }
  }
  if (beam.squeeze > 0.0) {  // the round beam through the corners of the square
    lens_radius_m *= kSquareRadius;
    spread *= kSquareRadius;
  }
  float flux_factor;
  if (beam.measured != 0u) {
    flux_factor = measured_flux_factor(beam.measured, spread);
  } else if (beam.squeeze > 0.0) {
    flux_factor = rectangle_flux_factor(spread, profile_m, beam.squeeze);
  } else {
    flux_factor = beam_flux_factor(spread, profile_m);
  }
  float j0 = type.flux_lm / flux_factor;
  if (shaped) {
    beam.gobo = optics.image_1;
    beam.gobo_cos = cos(optics.angle_1);
    beam.gobo_sin = sin(optics.angle_1);
    beam.gobo_2 = optics.image_2;
    beam.gobo_2_cos = cos(optics.angle_2);
    beam.gobo_2_sin = sin(optics.angle_2);
    beam.next_1 = optics.next_1;
    beam.next_2 = optics.next_2;
    beam.offset_1 = optics.offset_1;
    beam.offset_2 = optics.offset_2;
    beam.animation = optics.animation;
    beam.animation_cos = cos(optics.animation_angle);
    beam.animation_sin = sin(optics.animation_angle);
    // The iris leaves the middle of the beam as it is, but for the rim, which falls off as that of the whole beam.
    beam.gobo_scale = optics.iris;
    spread *= optics.iris;
    lens_radius_m *= optics.iris;
    j0 *= optics.iris * optics.iris;
    if (optics.prism > 0u) {
      facet_first = wheel_slots[optics.prism - 1u].facet_first;
      facet_count = state.beams;
    }
    if (kBlades) {
      for (uint i = 0u; i < 4u; ++i) beam.blades |= optics.blade_a[i] + optics.blade_b[i] > 0.0 ? 1u : 0u;
    }
  }

  for (uint b = 0u; b < max(state.beams, 1u); ++b) {
    vec3 axis = pose.axis;
    vec3 x_axis = pose.x_axis;
    vec3 y_axis = pose.y_axis;
    float facet_spread = spread;
    float share = 1.0;
    if (facet_count > 0u) {
      FacetRow facet = facets[facet_first + b];
      float c = cos(optics.prism_angle);
      float s = sin(optics.prism_angle);
      vec2 at = vec2(c * facet.x - s * facet.y, s * facet.x + c * facet.y);
      float step = beam.squeeze > 0.0 ? spread / kSquareRadius : spread;
      axis = normalize(pose.axis + step * (at.x * pose.x_axis + at.y * pose.y_axis));
      x_axis = normalize(pose.x_axis - axis * dot(axis, pose.x_axis));
      y_axis = cross(axis, x_axis);
      if (dot(y_axis, pose.y_axis) < 0.0) y_axis = -y_axis;
      facet_spread = spread * facet.scale;
      share = facet.share;
    }
    vec3 eye = params.position.xyz - pose.lens_m;
    beam.x_axis = vec4(x_axis, lens_radius_m);
    if (beam.squeeze > 0.0) y_axis *= type.aspect;
    beam.y_axis = vec4(y_axis, facet_spread);
    beam.axis = vec4(axis, params.up.w);
    beam.eye = vec4(dot(x_axis, eye), dot(y_axis, eye), dot(axis, eye), profile_m);
    beam.j0 = vec4(vec3(state.red, state.green, state.blue) * (j0 * share), 0.0);
    beams[first + b] = beam;
    if (kBlades && beam.blades != 0u) {
      for (uint i = 0u; i < 4u; ++i) {
        vec3 edge = blade_edge(i, optics.blade_a[i], optics.blade_b[i], optics.blade_angle[i]);
        blades[first + b].edge[i] = vec4(edge.xy, edge.z / optics.iris, 0.0);
      }
    }
  }
}

void main() {
  uint lane = gl_LocalInvocationIndex;
  uint group = gl_WorkGroupID.x;
  uint index = gl_GlobalInvocationID.x;
  if (lane == 0u) {
    beams_before = 0u;
    lit_before = 0u;
    lit_here = 0u;
  }
  barrier();
  uint beam_sum = 0u;
  uint lit_sum = 0u;
  for (uint g = lane; g < group; g += uint(FL_GROUP_HEADS)) {
    beam_sum += group_live[2u * g];
    lit_sum += group_live[2u * g + 1u];
  }
  if (beam_sum > 0u) atomicAdd(beams_before, beam_sum);
  if (lit_sum > 0u) atomicAdd(lit_before, lit_sum);

  bool lit = false;
  if (index < params.head_count) lit = is_lit(states[index], types[heads[index].type]);
  beams_of[lane] = lit ? states[index].beams : 0u;
  if (lit) atomicAdd(lit_here, 1u);
  barrier();

  uint rank = 0u;
  for (uint l = 0u; l < lane; ++l) rank += beams_of[l];
  if (lit) write_beams(index, beams_before + rank);

  if (lane == uint(FL_GROUP_HEADS) - 1u && group == gl_NumWorkGroups.x - 1u) {
    uint live = beams_before + rank + beams_of[lane];
    uint supertiles_y = (params.height + uint(FL_SUPERTILE_PX) - 1u) / uint(FL_SUPERTILE_PX);
    counts.live_count = live;
    counts.dark_count = params.head_count - lit_before - lit_here;
    counts.tiles_groups[0] = (live + uint(FL_GROUP_MASK) - 1u) / uint(FL_GROUP_MASK);
    counts.tiles_groups[1] = params.supertiles_x * supertiles_y;
    counts.tiles_groups[2] = 1u;
    bool any = live > 0u;
    counts.beams_groups[0] = any ? (params.width + uint(FL_TILE_PX) - 1u) / uint(FL_TILE_PX) : 0u;
    counts.beams_groups[1] = any ? (params.height + uint(FL_TILE_PX) - 1u) / uint(FL_TILE_PX) : 0u;
    counts.beams_groups[2] = 1u;
  }
}
