#version 460
// One thread a row of what lasers draw: a lit part of a figure becomes a sheet of light on the stage, as far as the
// exposure sees the scanner on it, with the light that it gets and where it ends.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#define FL_USE_POSE
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#define FL_LASERS_ACCESS writeonly
#include "render/shaders/lib/laser_row.glsl"

layout(local_size_x = FL_GROUP_LASERS) in;
layout(constant_id = FL_SPEC_SHADOWS) const bool kShadows = false;
layout(constant_id = FL_SPEC_BODIES) const bool kBodies = false;
layout(set = 0, binding = FL_BINDING_LASER_STATES, std430) readonly buffer LaserStatesBuffer {
  LaserState laser_states[];
};
layout(set = 0, binding = FL_BINDING_LASER_SEGMENTS, std430) readonly buffer LaserSegmentsBuffer {
  LaserSegmentRow segments[];
};
#include "render/shaders/lib/laser_end.glsl"

// The head of a row: the last one whose first row is not behind it.
uint head_of(uint row) {
  uint low = 0u;
  uint high = params.head_count;
  while (high - low > 1u) {
    uint middle = (low + high) / 2u;
    if (heads[middle].laser_first <= row) low = middle;
    else high = middle;
  }
  return low;
}

// An exposure of less of a pass sees the scanner stand still: in float, its ends are not apart.
const float kStillPasses = 1e-5;

// The part of a segment that the exposure sees, as times; empty where it sees none. second: the part behind the one
// that it begins with, where an exposure of nearly a pass begins and ends in the same segment.
vec2 seen_part(vec2 times, float begun, float passes, bool second) {
  if (passes >= 0.999999) return second ? vec2(1.0, 0.0) : times;
  vec2 early = vec2(max(times.x, begun - 1.0), min(times.y, begun - 1.0 + passes));
  vec2 late = vec2(max(times.x, begun), min(times.y, begun + passes));
  bool has_early = early.y > early.x;
  if (second) return has_early ? late : vec2(1.0, 0.0);
  return has_early ? early : late;
}

// The segment of a frame that the scanner is in at a time; the last before it where that is dark.
uint segment_at(uint first, uint count, float time) {
  uint low = 0u;
  uint high = count;
  while (high - low > 1u) {
    uint middle = (low + high) / 2u;
    if (segments[first + middle].begin <= time) low = middle;
    else high = middle;
  }
  return low;
}

// Where the scanner looks for a place of the figure.
vec3 direction_of(vec2 place, LaserState state, uint laser, BeamPose pose) {
  vec2 half_rad = vec2(defaults[laser + kLaserHalfX], defaults[laser + kLaserHalfY]);
  vec2 at = place * vec2(state.size_x, state.size_y) * half_rad;
  float c = cos(state.angle);
  float s = sin(state.angle);
  at = vec2(c * at.x - s * at.y, s * at.x + c * at.y) + vec2(state.x, state.y) * half_rad;
  at = clamp(at, -half_rad, half_rad);
  return cos(at.y) * (cos(at.x) * pose.axis + sin(at.x) * pose.x_axis) - sin(at.y) * pose.y_axis;
}

// The pixels of a triangle from where the light leaves: low, high. margin: around it, in pixels.
vec4 picture_of(vec3 corners[3], float margin) {
  vec4 box = vec4(FL_FAR_M, FL_FAR_M, -FL_FAR_M, -FL_FAR_M);
  float near_m = params.right.w * 0.1;
  vec2 size = vec2(float(params.width), float(params.height));
  for (int i = 0; i < 3; ++i) {
    vec3 a = corners[i] - params.position.xyz;
    vec3 b = corners[(i + 1) % 3] - params.position.xyz;
    float a_m = dot(a, params.forward.xyz);
    float b_m = dot(b, params.forward.xyz);
    for (int end = 0; end < 2; ++end) {
      bool crosses = end == 1;
      if (crosses ? (a_m >= near_m) == (b_m >= near_m) : a_m < near_m) continue;
      vec3 p = crosses ? mix(a, b, (near_m - a_m) / (b_m - a_m)) : a;
      float depth_m = crosses ? near_m : a_m;
      vec2 at = vec2(dot(p, params.right.xyz) / dot(params.right.xyz, params.right.xyz),
                     dot(p, params.up.xyz) / dot(params.up.xyz, params.up.xyz)) / depth_m;
      vec2 px = clamp(0.5 * vec2(1.0 + at.x, 1.0 - at.y) * size, vec2(-1e6), vec2(1e6));
      box = vec4(min(box.xy, px), max(box.zw, px));
    }
  }
  return box.x > box.z ? box : vec4(box.xy - margin, box.zw + margin);
}

// Distance of the eye from the triangle, not more than it is.
float nearest_m(vec3 corners[3]) {
  vec3 p = params.position.xyz;
  vec3 ab = corners[1] - corners[0];
  vec3 ac = corners[2] - corners[0];
  vec3 ap = p - corners[0];
  vec3 normal = cross(ab, ac);
  float square = dot(normal, normal);
  if (square > 1e-12) {  // above the triangle its plane is nearest
    float u = dot(cross(ap, ac), normal) / square;
    float v = dot(cross(ab, ap), normal) / square;
    if (u >= 0.0 && v >= 0.0 && u + v <= 1.0) return abs(dot(ap, normal)) * inversesqrt(square);
  }
  float least = FL_FAR_M;
  for (int i = 0; i < 3; ++i) {
    vec3 a = corners[i];
    vec3 way = corners[(i + 1) % 3] - a;
    float share = clamp(dot(p - a, way) / max(dot(way, way), 1e-20), 0.0, 1.0);
    least = min(least, length(p - a - way * share));
  }
  return least;
}

void main() {
  uint index = gl_GlobalInvocationID.x;
  if (index >= uint(lasers.length())) return;
  LaserRow row;
  row.box = vec4(1.0, 1.0, 0.0, 0.0);
  lasers[index].box = row.box;
  uint head = head_of(index);
  if (heads[head].laser == kNoAddress) return;
  HeadState state = states[head];
  TypeRow type = types[heads[head].type];
  vec3 head_lm = vec3(state.red, state.green, state.blue) * defaults[type.laser + kLaserFluxLm];
  LaserState laser = laser_states[heads[head].laser];
  if (!(max(head_lm.r, max(head_lm.g, head_lm.b)) > params.dark_lm)) return;
  uint most = uint(defaults[type.laser + kLaserSegments]);
  uint first = uint(defaults[laser.frame + kFrameSegment]);
  uint count = uint(defaults[laser.frame + kFrameSegments]);
  float begun = min(turns_real(laser.begun), 0.9999999);
  uint number = index - heads[head].laser_first;
  bool second = number == most;
  if (count == 0u || (!second && number >= count)) return;
  LaserSegmentRow segment = segments[first + (second ? segment_at(first, count, begun) : number)];
  vec2 times = vec2(segment.begin, segment.end);
  float passes = laser.passes < 0.0 ? 1.0 : laser.passes;
  bool still = passes < kStillPasses;
  if (still && (second || begun < times.x || begun >= times.y)) return;
  vec2 seen = still ? vec2(begun) : seen_part(times, begun, passes, second);
  if (!still && !(seen.y > seen.x)) return;
  float share = still ? 1.0 : (seen.y - seen.x) / (passes >= 0.999999 ? 1.0 : passes);
  vec2 part = (seen - times.x) / (times.y - times.x);
  vec2 from = vec2(segment.from_x, segment.from_y);
  vec2 way = vec2(segment.to_x, segment.to_y) - from;

  BeamPose pose = beam_pose(heads[head], type, state);
  vec3 a = direction_of(from + way * part.x, laser, type.laser, pose);
  vec3 b = direction_of(from + way * part.y, laser, type.laser, pose);
  vec3 beside = b - a - a * dot(a, b - a);
  float sine = length(beside);
  bool is_sheet = sine > 2e-6;
  if (!is_sheet) beside = abs(a.z) < 0.7 ? cross(a, vec3(0.0, 0.0, 1.0)) : cross(a, vec3(1.0, 0.0, 0.0));
  float cosine = dot(a, b);
  if (cosine < 0.5) return;  // parts are far narrower; a wide one has no tangent
  float reach = is_sheet ? sine / cosine : 0.0;
  row.first = vec4(a, reach);
  row.second = vec4(normalize(beside), is_sheet ? reach / atan(sine, cosine) : 1.0);
  vec3 eye = params.position.xyz - pose.lens_m;
  float sigma_m = laser.thickness_m > 0.0 ? 0.25 * laser.thickness_m : defaults[type.laser + kLaserSigma];
  float slope = defaults[type.laser + kLaserSlope];
  row.eye = vec4(eye, sigma_m * sigma_m);
  row.cross_1 = vec4(cross(row.first.xyz, eye), slope * slope);
  row.cross_2 = vec4(cross(row.second.xyz, eye), 0.0);

  float range_m = params.up.w;
  if (laser.length_m > 0.0) range_m = min(range_m, laser.length_m);
  SheetEnd end = sheet_end(row, pose.lens_m, heads[head].fixture, range_m);
  row.ends = end.ends;
  row.light = vec4(head_lm * vec3(segment.red, segment.green, segment.blue) * share, end.jump);
  row.end_fixture_1 = end.fixture_1;
  row.end_fixture_2 = end.fixture_2;
  row.slack_m = end.slack_m;

  float longest_m = sqrt(1.0 + reach * reach) / min(min(row.ends.x, row.ends.y), min(row.ends.z, row.ends.w));
  if (longest_m < 2.0 * kInside) return;  // something stands around the place where the light leaves
  float shown_m = longest_m * 1.0005 + 1e-3 + row.slack_m;  // as gets_there() of lasers.comp
  if (row.end_fixture_1 != FL_NONE || row.end_fixture_2 != FL_NONE) shown_m += 1.0;
  float sides = sqrt(1.0 + reach * reach);
  vec3 corners[3] = vec3[3](pose.lens_m, pose.lens_m + a * shown_m * sides,
                            pose.lens_m + (a + row.second.xyz * reach) * shown_m);
  float widest_m = sqrt(sigma_m * sigma_m + slope * slope * shown_m * shown_m);
  float pixel = 2.0 * length(params.up.xyz) / float(params.height);
  float width_px = widest_m / (max(nearest_m(corners) - kLaserReach * widest_m, 1e-4) * pixel);
  float corner = sqrt(1.0 + dot(params.right.xyz, params.right.xyz) + dot(params.up.xyz, params.up.xyz));
  float margin_px = kLaserReach * sqrt(kLaserPixel + width_px * width_px) * corner;
  row.cross_2.w = margin_px;
  row.box = picture_of(corners, margin_px);
  lasers[index] = row;
}
