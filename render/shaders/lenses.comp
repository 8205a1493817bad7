#version 460
// Where the images of small lenses are, and how much light each of their pixels gets: all that the lens sends to the
// eye, over the sum of the weights of its pixels. So a splat has the light of its lens wherever it falls on the pixels.
// One thread a head.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#define FL_USE_POSE
#define FL_LENSES_ACCESS
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/lib/gobo.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/lens.glsl"
#include "render/shaders/lib/lens_row.glsl"
#include "render/shaders/lib/mirror.glsl"

layout(local_size_x = FL_GROUP_HEADS) in;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;

// A splat is blurred by this deviation, in pixels. An ellipse then covers several pixels however small its lens is.
const float kBlurPx = 0.75;
// An ellipse with the area of a square has 2 / sqrt(pi) times half its side as radius.
const float kSquareToDisc = 1.1283791670955126;

// How the image of a place at `at` (picture coordinates -1 to 1) and depth_m moves with the place, in pixels.
vec2 moved_px(vec3 way, vec2 at, float depth_m) {
  float forward = dot(way, params.forward.xyz);
  float x = dot(way, params.right.xyz) / dot(params.right.xyz, params.right.xyz) - at.x * forward;
  float y = dot(way, params.up.xyz) / dot(params.up.xyz, params.up.xyz) - at.y * forward;
  return vec2(x, -y) * 0.5 * vec2(float(params.width), float(params.height)) / depth_m;
}

void main() {
  uint head = gl_GlobalInvocationID.x;
  if (head >= params.head_count) return;
  TypeRow type = types[heads[head].type];
  HeadState state = states[head];
  BeamPose pose = beam_pose(heads[head], type, state);
  vec3 place = pose.lens_m - params.position.xyz;
  float depth_m = dot(place, params.forward.xyz);
  float t_m = length(place);
  float facing = -dot(pose.axis, place) / t_m;
  float share = splat_share(type, depth_m);
  LensRow row = LensRow(vec4(0.0, 0.0, 0.0, -1.0), vec4(0.0), vec4(0.0));

  bool above = !kGloss || params.mirror_m == 0.0 || place.z > params.mirror_m;
  if (depth_m > params.right.w && facing > 0.0 && share > 0.0 && above) {
    vec2 at = vec2(dot(place, params.right.xyz) / dot(params.right.xyz, params.right.xyz),
                   dot(place, params.up.xyz) / dot(params.up.xyz, params.up.xyz)) / depth_m;
    vec2 size = vec2(float(params.width), float(params.height));
    row.place.xy = 0.5 * vec2(1.0 + at.x, 1.0 - at.y) * size;
    vec2 extent = lens_half(type) * (kRectangle && type.aspect > 0.0 ? kSquareToDisc : 1.0);
    vec2 a = moved_px(pose.x_axis * extent.x, at, depth_m);
    vec2 b = moved_px(pose.y_axis * extent.y, at, depth_m);
    float xx = a.x * a.x + b.x * b.x + kBlurPx * kBlurPx;
    float xy = a.x * a.y + b.x * b.y;
    float yy = a.y * a.y + b.y * b.y + kBlurPx * kBlurPx;
    float det = xx * yy - xy * xy;
    row.shape = vec4(yy, -xy, xx, 0.0) / det;
    float most = 0.5 * (xx + yy) + sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
    row.color.w = sqrt(det / most);  // the smaller half axis, in pixels
    float reach = sqrt(max(xx, yy)) * (1.0 + 0.5 / row.color.w);
    // Far outside of the picture the ellipse, which is linear in its place, means nothing.
    bool near = all(lessThan(abs(at), vec2(4.0)));
    bool seen = near && all(greaterThan(row.place.xy + reach, vec2(0.0))) && all(lessThan(row.place.xy - reach, size));

    vec3 eye_lx = vec3(0.0);
    float sum = 0.0;
    if (seen) {
      eye_lx = lens_beams_lx(state, pose.axis) + lens_glow_lm(state, type) * (facing / (kPi * t_m * t_m));
      ivec2 from = ivec2(ceil(row.place.xy - reach - 0.5));
      ivec2 to = ivec2(floor(row.place.xy + reach - 0.5));
      for (int y = from.y; y <= to.y; ++y) {
        for (int x = from.x; x <= to.x; ++x) sum += lens_weight(row, vec2(x, y) + 0.5 - row.place.xy);
      }
    }
    if (any(greaterThan(eye_lx, vec3(0.0)))) {
      if (kExtinction) eye_lx *= exp(-params.position.w * t_m);
      float turn = depth_m / t_m;
      float solid_angle = pixel_at_1m() * pixel_at_1m() * turn * turn * turn;
      row.color.rgb = eye_lx * (share / (solid_angle * sum));
      // Housings stand out around lenses, and are drawn with fewer triangles far away.
      row.place.z = t_m - max(extent.x, extent.y) - 2.0 * pixel_at_1m() * depth_m;
      row.place.w = reach;
      atomicMax(lenses_head.groups[0], (params.width + uint(FL_SPLAT_PX) - 1u) / uint(FL_SPLAT_PX));
    }
  }
  lenses[head] = row;
}
