#version 460
// Adds the beams that the mirrors of mirror balls send, behind those of the lamps: a workgroup a ball and lamp. The
// first dispatch lists the mirrors that each lamp lights; the second makes their rows, in the order of pairs, beams of
// the lamp and mirrors, and writes the totals again. They are made of the lamp's rows of the same frame, so they follow
// its colour, dimmer, movement and what stands in its gate (docs/decisions/0148).
#extension GL_GOOGLE_include_directive : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#define FL_USE_POSE
#include "render/shaders/lib/frame.glsl"

layout(local_size_x = FL_GROUP_MIRRORS) in;
layout(constant_id = FL_SPEC_WRITE) const bool kWrite = false;

#include "render/shaders/lib/forms.glsl"
#include "render/shaders/lib/gobo.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/mirror.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/view_beams.glsl"
#include "render/shaders/lib/beam_counts.glsl"
#include "render/shaders/lib/beam_flags.glsl"

layout(set = 0, binding = FL_BINDING_MIRROR_BALLS, std430) readonly buffer BallsBuffer { MirrorBallRow balls[]; };
layout(set = 0, binding = FL_BINDING_MIRROR_PAIRS, std430) readonly buffer PairsBuffer { MirrorPairRow pairs[]; };
layout(set = 0, binding = FL_BINDING_MIRROR_NORMALS, std430) readonly buffer NormalsBuffer { vec4 normals[]; };
layout(set = 0, binding = FL_BINDING_MIRROR_PICKS, std430) buffer PicksBuffer { uint picks[]; };

shared uint lit_bits[FL_GROUP_MIRRORS / 32];
shared uint rows_before;

// The light of a lamp's beam at a mirror.
struct Arrival {
  vec3 way;          // of the light, unit, stage space
  vec2 rho;          // in the lamp's beam
  float z_m;         // along its axis
  float share;       // illuminance across the light, over J0
  float distance_m;  // along the light
  float apex_per_m;  // 1 / distance of the apex
  float cosine;      // to the mirror's normal; below kMirrorGrazing: it is not lit
};
// offset_m: of the mirror's middle from the camera.
Arrival arrive(BeamRow row, BeamShape shape, vec3 offset_m, vec3 normal) {
  Arrival at;
  vec3 p = row.eye.xyz + to_light(row, offset_m);
  at.z_m = p.z;
  at.share = beam_illuminance(shape, p, at.rho, at.distance_m);
  float stretch = kRectangle && row.squeeze > 0.0 ? row.squeeze : 1.0;
  vec3 way = row.axis.xyz + shape.spread * (at.rho.x * row.x_axis.xyz + stretch * at.rho.y * row.y_axis.xyz);
  float slant = length(way);
  at.way = way / slant;
  at.apex_per_m = shape.spread / max((shape.lens_radius_m + shape.spread * p.z) * slant, 1e-9);
  at.cosine = at.share > 0.0 ? -dot(at.way, normal) : 0.0;
  return at;
}

// Radius of a disc with the area of the lens.
float source_radius(BeamRow row) {
  return row.x_axis.w * (row.squeeze > 0.0 ? sqrt(0.6366197723675814 * sqrt(row.squeeze)) : 1.0);
}

// A ball as it hangs, from the camera.
struct Placed {
  vec3 center_m;
  mat3 turn;
};
Placed place(MirrorBallRow ball) {
  HeadRow head = heads[ball.head];
  BeamPose pose = beam_pose(head, types[head.type], states[ball.head]);
  return Placed(pose.lens_m - params.position.xyz, mat3(pose.x_axis, -pose.y_axis, -pose.axis));
}

// Lists the mirrors that the lamp lights, in order: 2 (beam x mirrors + mirror), plus 1 for the opposite one.
void find(MirrorPairRow pair, uint pair_index) {
  MirrorBallRow ball = balls[pair.ball];
  uint beam_first = states[pair.head].beam_first;
  uint all = beam_first == kNoAddress ? 0u : states[pair.head].beams * ball.normal_count;
  all = min(all, pair.pick_count);
  uint lane = gl_LocalInvocationIndex;
  uint lit_before = 0u;
  Placed placed = place(ball);
  for (uint from = 0u; from < all; from += uint(FL_GROUP_MIRRORS)) {
    if (lane < uint(FL_GROUP_MIRRORS / 32)) lit_bits[lane] = 0u;
    barrier();
    uint number = from + lane;
    bool lit = false;
    bool opposite = false;
    if (number < all) {
      BeamRow row = beams[beam_first + number / ball.normal_count];
      BeamShape shape = beam_shape(row);
      shape.profile_power = drawn_profile(shape.profile_power);
      vec3 normal = placed.turn * normals[ball.normal_first + number % ball.normal_count].xyz;
      lit = arrive(row, shape, placed.center_m + ball.radius_m * normal, normal).cosine > kMirrorGrazing;
      opposite = !lit;
      lit = lit || arrive(row, shape, placed.center_m - ball.radius_m * normal, -normal).cosine > kMirrorGrazing;
    }
    if (lit) atomicOr(lit_bits[lane / 32u], 1u << (lane % 32u));
    barrier();
    uint rank = 0u;
    uint together = 0u;
    for (uint word = 0u; word < uint(FL_GROUP_MIRRORS / 32); ++word) {
      uint below = word < lane / 32u ? 0xffffffffu : word > lane / 32u ? 0u : (1u << (lane % 32u)) - 1u;
      rank += uint(bitCount(lit_bits[word] & below));
      together += uint(bitCount(lit_bits[word]));
    }
    if (lit) picks[1u + gl_NumWorkGroups.x + pair.pick_first + lit_before + rank] = 2u * number + (opposite ? 1u : 0u);
    lit_before += together;
    barrier();
  }
  if (lane == 0u) picks[1u + pair_index] = lit_before;
  if (lane == 0u && pair_index == 0u) picks[0] = counts.live_count;
}

BeamRow mirrored(MirrorBallRow ball, Placed placed, uint lamp_beam, vec3 normal) {
  BeamRow row = beams[lamp_beam];
  BeamShape shape = beam_shape(row);
  shape.profile_power = drawn_profile(shape.profile_power);
  vec3 offset_m = placed.center_m + ball.radius_m * normal;
  Arrival at = arrive(row, shape, offset_m, normal);

  // The same blur for all mirrors, so that none changes it as the ball turns.
  vec3 center = row.eye.xyz + to_light(row, placed.center_m);
  if (row.squeeze > 0.0) center.y *= sqrt(row.squeeze);
  float lens_m = source_radius(row);
  vec3 from_apex = shape.spread * center + vec3(0.0, 0.0, shape.lens_radius_m);
  float scale;
  BeamRow beam;
  open_beam(beam);
  beam.head = ball.head;
  beam.measured = 0u;
  beam.squeeze = 0.0;
  float disc_m = mirror_radius(ball.mirror_m, 1.0, 1.0);
  float power = mirror_profile(disc_m, lens_m, length(center), shape.spread / max(length(from_apex), 1e-9), scale);
  float radius_m = max(mirror_radius(ball.mirror_m, at.cosine, scale), 1e-6);
  vec3 axis = normalize(mirror_reflect(at.way, normal));
  vec3 x_axis = normalize(cross(axis, abs(axis.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0)));
  vec3 y_axis = cross(axis, x_axis);
  beam.x_axis = vec4(x_axis, radius_m);
  beam.y_axis = vec4(y_axis, mirror_spread(radius_m, lens_m, at.distance_m, at.apex_per_m, scale));
  beam.axis = vec4(axis, params.up.w);
  beam.eye = vec4(-dot(x_axis, offset_m), -dot(y_axis, offset_m), -dot(axis, offset_m), power);

  vec3 lux = row.j0.rgb * (at.share * max(at.cosine, 0.0) * exp(-params.position.w * at.distance_m));
  if (kBlades && (row.flags & FL_BEAM_BLADES) != 0u) lux *= blades_at(lamp_beam, at.rho, at.z_m);
  if (has_gobo(row)) {
    gobo_begin(lamp_beam);
    lux *= gobo_on_surface(row.gobo, at.rho, at.z_m);
  }
  beam.j0 = vec4(0.0);
  float factor = beam_flux_factor(beam_shape(beam));
  beam.j0.rgb = lux * (ball.reflectance * ball.mirror_m * ball.mirror_m / factor);
  if (is_plain(beam)) beam.flags |= FL_BEAM_PLAIN;
  beam.flags = view_flags(beam);
  return beam;
}

void write(MirrorPairRow pair, uint pair_index) {
  uint lane = gl_LocalInvocationIndex;
  if (lane == 0u) rows_before = picks[0];
  barrier();
  uint sum = 0u;
  for (uint other = lane; other < pair_index; other += uint(FL_GROUP_MIRRORS)) sum += picks[1u + other];
  if (sum > 0u) atomicAdd(rows_before, sum);
  barrier();
  uint count = picks[1u + pair_index];
  MirrorBallRow ball = balls[pair.ball];
  Placed placed = place(ball);
  for (uint i = lane; i < count; i += uint(FL_GROUP_MIRRORS)) {
    uint pick = picks[1u + gl_NumWorkGroups.x + pair.pick_first + i];
    uint number = pick / 2u;
    vec3 normal = placed.turn * normals[ball.normal_first + number % ball.normal_count].xyz;
    if ((pick & 1u) != 0u) normal = -normal;
    uint lamp_beam = states[pair.head].beam_first + number / ball.normal_count;
    beams[rows_before + i] = mirrored(ball, placed, lamp_beam, normal);
  }
  if (lane == 0u && pair_index + 1u == gl_NumWorkGroups.x) write_beam_counts(rows_before + count);
}

void main() {
  uint pair_index = gl_WorkGroupID.x;
  MirrorPairRow pair = pairs[pair_index];
  if (kWrite) write(pair, pair_index);
  else find(pair, pair_index);
}
