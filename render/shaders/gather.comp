#version 460
// Compacts the lit heads into beam rows, in patch order: each group finds its place from the counts of those before it.
// A prism makes several beams of one. Each head's state gets the place of its first beam, for its lens. The last group
// writes the totals and the indirect arguments of the passes that follow.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS writeonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS
#define FL_USE_HEADS
#define FL_STATES_ACCESS
#define FL_USE_POSE
#include "render/shaders/lib/frame.glsl"

layout(local_size_x = FL_GROUP_HEADS) in;
layout(constant_id = FL_SPEC_OPTICS) const bool kOptics = false;
layout(constant_id = FL_SPEC_STACKED) const bool kStacked = false;
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
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/view_beams.glsl"
#include "render/shaders/lib/beam_counts.glsl"
#include "render/shaders/shared/optics.h"

// tan(x) for 0 <= x < pi/2 to 3e-7 of itself. GPUs may have it to 5e-7 of 1 alone, much of the spread of a pencil
// beam. Lambert's continued fraction, cut after x^2/9: off by 2e-8 at pi/4, beyond which it is turned round.
float tangent(float x) {
  bool steep = x > 0.78539816;
  float y = steep ? (1.57079637 - x) - 4.37113883e-8 : x;
  float z = y * y;
  float numerator = y * (945.0 - 105.0 * z + z * z);
  float denominator = 945.0 - 420.0 * z + 15.0 * z * z;
  return steep ? denominator / max(numerator, 1e-9) : numerator / denominator;
}

const float kSquareRadius = 1.4142135623730951;  // of the circle round a square, over half its side

// What prisms make of a beam: a copy whose image is turned over, turned, scaled and moved.
struct Copy {
  vec2 at;    // of its middle, in beam radii
  vec2 turn;  // cos, sin, from x to y
  float mirror;
  float scale;
  vec3 light;  // share of the beam's
};
vec2 turned(vec2 turn, vec2 v) { return vec2(turn.x * v.x - turn.y * v.y, turn.y * v.x + turn.x * v.y); }

// Of one facet of a prism that is turned about its middle; an image that it mirrors turns twice as far.
Copy copy_of(FacetRow facet, float angle) {
  Copy copy;
  vec2 turn = vec2(cos(angle), sin(angle));
  copy.at = turned(turn, vec2(facet.x, facet.y));
  copy.turn = vec2(facet.turn_cos, facet.turn_sin);
  if (facet.mirror < 0.0) copy.turn = turned(turn, turned(turn, copy.turn));
  copy.mirror = facet.mirror;
  copy.scale = facet.scale;
  copy.light = vec3(facet.red, facet.green, facet.blue) * facet.share;
  return copy;
}
// A copy of a copy.
Copy copied(Copy first, Copy then) {
  Copy both;
  both.at = then.at + then.scale * turned(then.turn, vec2(first.at.x, then.mirror * first.at.y));
  both.turn = turned(then.turn, vec2(first.turn.x, then.mirror * first.turn.y));
  both.mirror = then.mirror * first.mirror;
  both.scale = then.scale * first.scale;
  both.light = then.light * first.light;
  return both;
}

// The beam without frost, focus and iris.
BeamShape open_shape(BeamRow beam, float profile_power, float spread) {
  BeamShape shape;
  shape.lens_radius_m = 0.0;
  shape.spread = beam.squeeze > 0.0 ? spread * kSquareRadius : spread;
  shape.range_m = 0.0;
  shape.profile_power = profile_power;
  shape.squeeze = beam.squeeze;
  shape.measured = 0u;
  shape.hidden = 0.0;
  return shape;
}
// Flux over J0 of a beam as it is drawn.
float flux_factor(BeamShape beam, float iris) {
  if (beam.measured != 0u) return measured_flux_factor(beam.measured, beam.spread / iris) / (iris * iris);
  return beam_flux_factor(beam);
}

#include "render/shaders/lib/beam_flags.glsl"

shared uint beams_before;
shared uint lit_before;
shared uint beams_of[FL_GROUP_HEADS];
shared uint lit_here;

void write_beams(uint index, uint first) {
  HeadRow row = heads[index];
  TypeRow type = types[row.type];
  HeadState state = states[index];
  BeamPose pose = beam_pose(row, type, state);
  bool is_measured = kMeasured && type.measured != 0u;
  float zoom_spread = tangent(drawn_half_angle(state.zoom, kRectangle ? type.aspect : 0.0, is_measured));
  float spread = zoom_spread;
  float profile_power = drawn_profile(type.profile_power);
  bool shaped = kOptics && row.optics != kNoAddress;

  BeamRow beam;
  open_beam(beam);
  beam.measured = is_measured ? type.measured : 0u;
  beam.squeeze = kRectangle && type.aspect > 0.0 ? 1.0 / (type.aspect * type.aspect) : 0.0;
  beam.head = index;
  float lens_radius_m = type.lens_radius_m;
  OpticsState optics;
  bool copies = false;
  float iris = 1.0;
  float hidden = 0.0;
  float flux_lm = type.flux_lm;  // in the beam
  if (shaped) {
    optics = optics_states[row.optics];
    beam.focus = optics.focus;
    float soft = max(optics.frost, focus_rim(lens_radius_m, spread, optics.focus));
    if (kIris && optics.iris < 1.0) {
      iris = optics.iris;
      hidden = beam.measured != 0u ? 1.0 - iris : iris_hidden(iris, soft);
      if (beam.measured == 0u) flux_lm *= iris_flux_share(open_shape(beam, profile_power, zoom_spread), iris);
    }
    profile_power = drawn_profile(softened_profile(profile_power, soft));
    if (optics.frost > 0.0) {
      spread = spread * (1.0 + kFrostWidens * optics.frost) + kFrostAdds * optics.frost;
      beam.gobo_blur = kFrostBlur * optics.frost;
    }
  }
  if (beam.squeeze > 0.0) {  // the round beam through the corners of the square
    lens_radius_m *= kSquareRadius;
    spread *= kSquareRadius;
  }
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
    beam.gobo_scale = iris;
    spread *= iris;
    lens_radius_m *= iris;
    copies = optics.prism > 0u || (kStacked && optics.prism_2 > 0u);
    if (kBlades) {
      for (uint i = 0u; i < 4u; ++i) beam.flags |= optics.blade_a[i] + optics.blade_b[i] > 0.0 ? FL_BEAM_BLADES : 0u;
    }
  }

  float j0 = 0.0;
  float j0_spread = -1.0;  // of the beam that it was computed for
  for (uint b = 0u; b < max(state.beams, 1u); ++b) {
    vec3 axis = pose.axis;
    vec3 x_axis = pose.x_axis;
    vec3 y_axis = pose.y_axis;
    float copy_spread = spread;
    vec3 light = vec3(1.0);
    if (copies) {
      Copy copy = Copy(vec2(0.0), vec2(1.0, 0.0), 1.0, 1.0, vec3(1.0));
      uint rest = b;
      if (optics.prism > 0u) {
        WheelSlotRow slot = wheel_slots[optics.prism - 1u];
        copy = copy_of(facets[slot.facet_first + rest % slot.facet_count], optics.prism_angle);
        rest /= slot.facet_count;
      }
      if (kStacked && optics.prism_2 > 0u) {
        uint facet_first = wheel_slots[optics.prism_2 - 1u].facet_first;
        copy = copied(copy, copy_of(facets[facet_first + rest], optics.prism_2_angle));
      }
      // In radii of the beam as the zoom has it: iris and frost change the copies, and not where they are.
      axis = normalize(pose.axis + zoom_spread * (copy.at.x * pose.x_axis + copy.at.y * pose.y_axis));
      vec3 right = copy.turn.x * pose.x_axis + copy.turn.y * pose.y_axis;
      vec3 down = copy.mirror * (copy.turn.x * pose.y_axis - copy.turn.y * pose.x_axis);
      x_axis = normalize(right - axis * dot(axis, right));
      y_axis = cross(axis, x_axis);
      if (dot(y_axis, down) < 0.0) y_axis = -y_axis;
      copy_spread = spread * copy.scale;
      light = copy.light;
    }
    vec3 eye = params.position.xyz - pose.lens_m;
    beam.x_axis = vec4(x_axis, lens_radius_m);
    if (beam.squeeze > 0.0) y_axis *= type.aspect;
    beam.y_axis = vec4(y_axis, copy_spread);
    beam.axis = vec4(axis, params.up.w);
    beam.eye = vec4(dot(x_axis, eye), dot(y_axis, eye), dot(axis, eye), profile_power);
    beam.j0.w = hidden;
    if (copy_spread != j0_spread) {
      j0 = flux_lm / flux_factor(beam_shape(beam), iris);
      j0_spread = copy_spread;
    }
    beam.j0.rgb = vec3(state.red, state.green, state.blue) * (j0 * light);
    beam.flags &= ~FL_BEAM_PLAIN;
    if (is_plain(beam)) beam.flags |= FL_BEAM_PLAIN;
    beam.flags = view_flags(beam);
    beams[first + b] = beam;
    if (kBlades && (beam.flags & FL_BEAM_BLADES) != 0u) {
      for (uint i = 0u; i < 4u; ++i) {
        bool round = beam.squeeze == 0.0;
        vec3 edge = blade_edge(i, optics.blade_a[i], optics.blade_b[i], round ? optics.blade_angle[i] : 0.0);
        if (!round) {
          // An edge of the square, in half sides, to the rectangle, where it turns, in half widths; and back.
          edge = vec3(edge.x, type.aspect * edge.y, edge.z) / length(vec2(edge.x, type.aspect * edge.y));
          edge.xy = turned(vec2(cos(optics.blade_angle[i]), sin(optics.blade_angle[i])), edge.xy);
          edge.xy *= kSquareRadius * vec2(1.0, 1.0 / type.aspect);
        }
        blades[first + b].edge[i] = vec4(edge.xy, edge.z / iris, 0.0);
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
  if (index < params.head_count) states[index].beam_first = lit ? beams_before + rank : kNoAddress;

  if (lane == uint(FL_GROUP_HEADS) - 1u && group == gl_NumWorkGroups.x - 1u) {
    uint live = beams_before + rank + beams_of[lane];
    counts.dark_count = params.head_count - lit_before - lit_here;
    write_beam_counts(live);
  }
}
