#version 460
// Tables of groups of panes: along lines through the point of the glass that the camera's picture is (shaft.h), the sum
// of the light that the glass lets through and its first moment, from where the fan of lines meets the glass to each
// station. A workgroup sums one line.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/shared/shaft.h"
#include "render/shaders/lib/pane.glsl"
#include "render/shaders/lib/pane_groups.glsl"

layout(local_size_x = FL_GROUP_PANE_LINES) in;
layout(constant_id = FL_SPEC_DETAIL) const bool kDetail = true;  // images as fine as pixels; else always whole ones
layout(set = 0, binding = FL_BINDING_PANE_FANS, std430) writeonly buffer PaneFansBuffer { PaneFanRow fans[]; };
layout(set = 0, binding = FL_BINDING_PANE_LINES, std430) writeonly buffer PaneLinesBuffer { vec2 sums[]; };

const uint kThreads = uint(FL_GROUP_PANE_LINES);
const float kTexelsAStep = 0.75;  // of the sums
const float kStepsMax = 64.0;     // from a station to the next
const float kPixelsALine = 0.7;   // lines are no closer

// Of each station, sum and moment of each colour; then from the first one on.
shared vec2 station_sums[3 * FL_PANE_STATIONS_MAX];
shared vec2 scan[3 * FL_GROUP_PANE_LINES];
// Panes on the line, and between which p.
shared uint met[FL_PANES_MAX / 32];
shared vec2 parts[FL_PANES_MAX];

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
    if (!(needs[side] > 0.0)) continue;
    float range = of[side].q_high - of[side].q_low;
    float lines = 2.0 + float(row.lines - 8u) * min(needs[side] / all, 1.0);
    if (kDetail) {
      float slopes = range * (side >= 2u ? row.across.w / row.upward.w : row.upward.w / row.across.w);
      lines = min(lines, 2.0 + slopes / (kPixelsALine * pixel_rad()));
    }
    rows[side].first = first;
    rows[side].lines = uint(lines);
    rows[side].q_step = range / float(rows[side].lines - 1u);
    first += rows[side].lines;
  }
}

// Sum and moment of a pane's light from p to p.
void add_pane(GroupPaneRow pane, uint side, vec2 eye, float q, PaneFanRow fan, float from, float to, inout vec3 sum,
              inout vec3 moment) {
  PaneImage image = pane_image(pane);
  vec2 across = texels_of(pane, side >= 2u ? vec2(fan.q_step, 0.0) : vec2(0.0, fan.q_step)) * (0.5 * (from + to));
  uint level = 0u;
  if (kDetail) level = min(uint(log2(max(max(abs(across.x), abs(across.y)), 1.0))), image.levels - 1u);
  vec2 along = abs(texels_of(pane, side >= 2u ? vec2(q, 1.0) : vec2(1.0, q))) * (to - from);
  float steps = clamp(ceil(max(along.x, along.y) / (kTexelsAStep * float(1u << level))), 1.0, kStepsMax);
  if (image.levels == 1u) steps = 1.0;
  PaneLevel glass = pane_level(image, level);
  float step_p = (to - from) / steps;
  vec3 all = vec3(0.0);
  vec3 first = vec3(0.0);
  for (float i = 0.5; i < steps; i += 1.0) {
    float p = from + i * step_p;
    vec2 place = pane_place(glass, clamp(on_pane(pane, shaft_fan_place(side, eye, q, p)), -1.0, 1.0));
    vec2 low = floor(place);
    vec3 light = pane_value(pane_cell(glass, ivec2(low)), place - low);
    all += light;
    first += light * (p - fan.p_middle);
  }
  sum += all * pane.light.rgb * step_p;
  moment += first * pane.light.rgb * step_p;
}

// What a line meets of each pane.
void meet_panes(PaneGroupRow row, uint side, vec2 eye, float q, PaneFanRow fan) {
  for (uint i = gl_LocalInvocationIndex; i < uint(FL_PANES_MAX) / 32u; i += kThreads) met[i] = 0u;
  barrier();
  float p_high = fan.p_low + fan.p_step * float(row.stations - 1u);
  vec2 begin = shaft_fan_place(side, eye, q, fan.p_low);
  vec2 end = shaft_fan_place(side, eye, q, p_high);
  for (uint i = gl_LocalInvocationIndex; i < row.pane_count; i += kThreads) {
    GroupPaneRow pane = group_panes[row.pane_first + i];
    vec2 from = on_pane(pane, begin);
    vec2 to = on_pane(pane, end);
    float x0 = 0.0;
    float x1 = 1.0;
    if (shaft_cut(from.x, to.x, x0, x1) && shaft_cut(from.y, to.y, x0, x1)) {
      parts[i] = mix(vec2(fan.p_low), vec2(p_high), vec2(x0, x1));
      atomicOr(met[i / 32u], 1u << (i & 31u));
    }
  }
  barrier();
}

// Turns the sums between stations into those from the first station on. Each thread has neighbouring stations.
void add_up(uint stations) {
  uint thread = gl_LocalInvocationIndex;
  uint each = (stations + kThreads - 1u) / kThreads;
  uint begin = min(thread * each, stations);
  uint end = min(begin + each, stations);
  for (uint color = 0u; color < 3u; ++color) {
    vec2 sum = vec2(0.0);
    for (uint i = begin; i < end; ++i) sum += station_sums[3u * i + color];
    scan[3u * thread + color] = sum;
  }
  barrier();
  for (uint step_threads = 1u; step_threads < kThreads; step_threads *= 2u) {
    vec2 before[3] = vec2[3](vec2(0.0), vec2(0.0), vec2(0.0));
    if (thread >= step_threads) {
      for (uint color = 0u; color < 3u; ++color) before[color] = scan[3u * (thread - step_threads) + color];
    }
    barrier();
    for (uint color = 0u; color < 3u; ++color) scan[3u * thread + color] += before[color];
    barrier();
  }
  for (uint color = 0u; color < 3u; ++color) {
    vec2 sum = thread > 0u ? scan[3u * (thread - 1u) + color] : vec2(0.0);
    for (uint i = begin; i < end; ++i) {
      vec2 own = station_sums[3u * i + color];
      station_sums[3u * i + color] = sum;
      sum += own;
    }
  }
  barrier();
}

void main() {
  uint group = gl_WorkGroupID.y;
  uint line = gl_WorkGroupID.x;
  PaneGroupRow row = groups[group];
  vec2 eye = group_of(row, params.position.xyz - row.center.xyz).xy;
  PaneFanRow rows[4];
  if (row.along.w > 0.0) {
    share_lines(row, eye, rows);
  } else {  // dark
    for (uint side = 0u; side < 4u; ++side) rows[side] = PaneFanRow(0.0, 0.0, 0.0, 0.0, 0u, 0u, 0.0, 0u);
  }
  if (line == 0u && gl_LocalInvocationIndex < 4u) fans[4u * group + gl_LocalInvocationIndex] = rows[gl_LocalInvocationIndex];
  uint side = 4u;
  PaneFanRow fan;
  for (uint i = 0u; i < 4u; ++i) {
    if (line - rows[i].first < rows[i].lines) {
      side = i;
      fan = rows[i];
    }
  }
  if (side == 4u) return;
  float q = fan.q_low + fan.q_step * float(line - fan.first);
  meet_panes(row, side, eye, q, fan);
  for (uint station = gl_LocalInvocationIndex; station < row.stations; station += kThreads) {
    float from = fan.p_low + fan.p_step * float(station);
    float to = from + fan.p_step;
    vec3 sum = vec3(0.0);
    vec3 moment = vec3(0.0);
    for (uint word = 0u; word < uint(FL_PANES_MAX) / 32u; ++word) {
      for (uint bits = met[word]; bits != 0u; bits &= bits - 1u) {
        uint i = 32u * word + uint(findLSB(bits));
        vec2 part = vec2(max(parts[i].x, from), min(parts[i].y, to));
        if (part.y > part.x) {
          add_pane(group_panes[row.pane_first + i], side, eye, q, fan, part.x, part.y, sum, moment);
        }
      }
    }
    station_sums[3u * station] = vec2(sum.r, moment.r);
    station_sums[3u * station + 1u] = vec2(sum.g, moment.g);
    station_sums[3u * station + 2u] = vec2(sum.b, moment.b);
  }
  barrier();
  add_up(row.stations);
  uint entry = 3u * (row.line_first + line * row.stations);
  for (uint i = gl_LocalInvocationIndex; i < 3u * row.stations; i += kThreads) sums[entry + i] = station_sums[i];
}
