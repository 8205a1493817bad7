#version 460
// Tables of groups of panes: along the lines of fans (shaft.h), the sum of the light that the glass lets through and
// its first moment, from where the fan meets the glass to each station. A workgroup sums one line. Tables stay while
// the camera stays.
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
layout(set = 0, binding = FL_BINDING_PANE_FANS, std430) readonly buffer PaneFansBuffer { PaneFansRow fans[]; };
layout(set = 0, binding = FL_BINDING_PANE_LINES, std430) writeonly buffer PaneLinesBuffer { vec2 sums[]; };

const uint kThreads = uint(FL_GROUP_PANE_LINES);

// Of each station, sum and moment of each colour; then from the first one on.
shared vec2 station_sums[3 * FL_PANE_STATIONS_MAX];
shared vec2 scan[3 * FL_GROUP_PANE_LINES];
// Panes on the line, and between which p.
shared uint met[FL_PANES_MAX / 32];
shared vec2 parts[FL_PANES_MAX];

// Sum and moment of a pane's light from p to p, cell by cell between four texels: there both are polynomials of at most
// degree 3, which Simpson's rule sums exactly.
void add_pane(GroupPaneRow pane, uint side, vec2 eye, float q, PaneFanRow fan, float from_p, float to_p,
              inout vec3 sum, inout vec3 moment) {
  PaneImage image = pane_image(pane);
  uint level = 0u;
  if (kDetail) {
    vec2 across = texels_of(pane, side >= 2u ? vec2(fan.q_step, 0.0) : vec2(0.0, fan.q_step));
    float texels = max(abs(across.x), abs(across.y)) * 0.5 * (from_p + to_p);
    level = min(uint(log2(max(texels, 1.0))), image.levels - 1u);
  }
  PaneLevel glass = pane_level(image, level);
  vec2 from = pane_place(glass, clamp(on_pane(pane, shaft_fan_place(side, eye, q, from_p)), -1.0, 1.0));
  vec2 way = pane_place(glass, clamp(on_pane(pane, shaft_fan_place(side, eye, q, to_p)), -1.0, 1.0)) - from;
  ivec2 cell = ivec2(floor(from));
  ivec2 last = ivec2(floor(from + way));
  vec2 rest = vec2(abs(last - cell));  // sides that are left to cross
  if (image.levels == 1u) rest = vec2(0.0);
  ivec2 ahead = ivec2(greaterThan(way, vec2(0.0)));
  ivec2 go = 2 * ahead - 1;
  vec2 speed = 1.0 / mix(way, vec2(1.0), equal(last, cell));
  vec3 all = vec3(0.0);
  vec3 first = vec3(0.0);
  vec3 light;
  uint steps = uint(rest.x + rest.y);
  float y = 0.0;
  for (uint i = 0u; i <= steps; ++i) {
    vec2 next = (vec2(cell + ahead) - from) * speed;
    next = mix(next, vec2(2.0), lessThan(rest, vec2(0.5)));
    float end_y = clamp(min(next.x, next.y), y, 1.0);
    PaneCell corners = pane_cell(glass, cell);
    vec2 f = from - vec2(cell);
    float middle_y = 0.5 * (y + end_y);
    if (i == 0u) light = pane_value(corners, f);
    vec3 middle = 4.0 * pane_value(corners, f + way * middle_y);
    vec3 end = pane_value(corners, f + way * end_y);
    float share = end_y - y;
    all += share * (light + middle + end);
    first += share * (y * light + middle_y * middle + end_y * end);
    light = end;
    y = end_y;
    int crossed = next.x <= next.y ? 0 : 1;
    cell[crossed] += go[crossed];
    rest[crossed] -= 1.0;
  }
  float size_p = to_p - from_p;
  vec3 scale = pane.light.rgb * (size_p / 6.0);
  sum += scale * all;
  moment += scale * ((from_p - fan.p_middle) * all + size_p * first);
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
  if (fans[group].is_new == 0u) return;
  uint side = 0u;
  while (side < 4u && line - fans[group].fans[side].first >= fans[group].fans[side].lines) ++side;
  if (side == 4u) return;
  PaneGroupRow row = groups[group];
  PaneFanRow fan = fans[group].fans[side];
  vec2 eye = vec2(fans[group].eye_u, fans[group].eye_v);
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
