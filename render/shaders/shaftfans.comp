#version 460
// The fans of lines of each group of panes (shaft.h), and whether its table of sums has to be made anew: not where the
// camera is at the same place, nor while it is out of sight. One thread a group.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/shared/shaft.h"
#include "render/shaders/lib/pane.glsl"
#include "render/shaders/lib/pane_groups.glsl"

layout(local_size_x = FL_GROUP_PANE_FANS) in;
layout(constant_id = FL_SPEC_DETAIL) const bool kDetail = true;  // images as fine as pixels; else always whole ones
layout(set = 0, binding = FL_BINDING_PANE_FANS, std430) buffer PaneFansBuffer { PaneFansRow fans[]; };

const float kPixelsALine = 0.7;  // lines are no closer
const float kLinesATexel = 2.0;  // nor are there more of them, at the far end of a fan

PaneFanRow fan_row(PaneGroupRow row, ShaftFan fan) {
  float stations = float(row.stations);
  PaneFanRow of;
  of.q_low = fan.q_low;
  of.q_step = 0.0;
  of.p_low = fan.p_low;
  of.p_step = (fan.p_high - fan.p_low) / (stations - 1.0);
  of.p_middle = 0.5 * (fan.p_low + fan.p_high);
  of.first = 0u;
  of.lines = 0u;
  of.pad = 0u;
  return of;
}

// Shares the lines of the group among the four fans by the texels that they cross at their far ends.
void share_lines(PaneGroupRow row, vec2 eye, out PaneFanRow rows[4]) {
  float needs[4];
  float all = 0.0;
  ShaftFan of[4];
  for (uint side = 0u; side < 4u; ++side) {
    of[side] = shaft_fan(side, eye);
    rows[side] = fan_row(row, of[side]);
    float range = max(of[side].q_high - of[side].q_low, 0.0);
    needs[side] = range > 0.0 ? range * of[side].p_high / (side >= 2u ? row.texel_u : row.texel_v) : 0.0;
    all += needs[side];
  }
  uint first = 0u;
  for (uint side = 0u; side < 4u; ++side) {
    if (!(needs[side] > 0.0) || row.lines == 0u) continue;
    float range = of[side].q_high - of[side].q_low;
    float lines = 2.0 + min(float(row.lines - 8u) * min(needs[side] / all, 1.0), kLinesATexel * needs[side]);
    if (kDetail) {
      // On the glass a ray is longer than in the air, by what the light is slanted.
      float slopes = range * (side >= 2u ? row.across.w / row.upward.w : row.upward.w / row.across.w);
      slopes *= length(row.along.xyz);
      lines = min(lines, 2.0 + slopes / (kPixelsALine * pixel_rad()));
    }
    rows[side].first = first;
    rows[side].lines = uint(lines);
    rows[side].q_step = range / float(rows[side].lines - 1u);
    first += rows[side].lines;
  }
}

void main() {
  uint group = gl_GlobalInvocationID.x;
  if (group >= uint(groups.length())) return;
  PaneGroupRow row = groups[group];
  PaneFansRow before = fans[group];
  PaneFansRow now;
  vec2 eye = group_of(row, params.position.xyz - row.center.xyz).xy;
  now.eye_u = eye.x;
  now.eye_v = eye.y;
  now.detail = kDetail ? floatBitsToUint(pixel_rad()) : 1u;
  vec2 size = vec2(params.width, params.height);
  vec3 sides[4];
  for (uint side = 0u; side < 4u; ++side) sides[side] = side_of(vec2(0.0), size, side);
  bool needed = row.along.w > 0.0 && row.is_even == 0u && group_meets(row, sides);
  if (!needed) now.detail = 0u;
  bool same = before.eye_u == eye.x && before.eye_v == eye.y && before.detail == now.detail;
  now.is_new = needed && !same ? 1u : 0u;
  share_lines(row, eye, now.fans);
  fans[group] = now;
}
