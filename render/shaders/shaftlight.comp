#version 460
// Adds the light of the sun behind panes of glass, in the air and on surfaces, and the panes themselves: by the tables
// of their groups (shaftlines.comp). A ray takes differences of sums along a line of the glass.
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/shared/shaft.h"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/albedo.glsl"
#include "render/shaders/lib/pane.glsl"
#include "render/shaders/lib/pane_groups.glsl"
#include "render/shaders/lib/shaft_solids.glsl"
#include "render/shaders/lib/shaft_view.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_SHAFT_ROWS) in;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
layout(constant_id = FL_SPEC_SHADOWS) const bool kShadows = false;
layout(constant_id = FL_SPEC_AIR) const bool kAir = true;
layout(constant_id = FL_SPEC_DETAIL) const bool kDetail = true;  // images as fine as pixels; else always whole ones
layout(set = 0, binding = FL_BINDING_HEADS, std430) readonly buffer HeadsBuffer { HeadRow heads[]; };
layout(set = 0, binding = FL_BINDING_PANE_GRIDS, std430) readonly buffer PaneGridsBuffer { uint grids[]; };
layout(set = 0, binding = FL_BINDING_PANE_FANS, std430) readonly buffer PaneFansBuffer { PaneFansRow fans[]; };
layout(set = 0, binding = FL_BINDING_PANE_LINES, std430) readonly buffer PaneLinesBuffer { vec2 sums[]; };
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

const float kPi = 3.141592653589793;
const float kLossMost = 16.0;       // of a ray; beyond it, no light is left
const float kStationsLeast = 3.0;   // a ray that goes by fewer of them takes samples of the glass
const float kSamples = 8.0;         // so many
const uint kWords = uint(FL_PANES_MAX) / 32u;

// The panes at a place of a group: rows of grids[] from x on, y of them.
uvec2 panes_at(PaneGroupRow row, vec2 at) {
  vec2 cell = clamp((at * 0.5 + 0.5) * vec2(row.grid_x, row.grid_y), vec2(0.0), vec2(row.grid_x - 1u, row.grid_y - 1u));
  uint word = grids[row.grid_first + uint(cell.y) * row.grid_x + uint(cell.x)];
  return uvec2(word >> FL_PANE_GRID_COUNT_BITS, word & ((1u << FL_PANE_GRID_COUNT_BITS) - 1u));
}
bool is_on(vec2 at) { return abs(at.x) <= 1.0 && abs(at.y) <= 1.0; }

// The glass at a place of a group, over a parallelogram with the sides right and down. sky: what is seen against the
// sky, cd/m^2; else the light that goes through, lx.
vec3 glass_at(PaneGroupRow row, vec2 at, vec2 right, vec2 down, bool sky) {
  vec3 sum = vec3(0.0);
  uvec2 list = panes_at(row, at);
  for (uint i = list.x; i < list.x + list.y; ++i) {
    GroupPaneRow pane = group_panes[grids[i]];
    vec2 uv = on_pane(pane, at);
    if (!is_on(uv)) continue;
    float texels = 0.0;
    if (kDetail) {
      vec2 x = texels_of(pane, right);
      vec2 y = texels_of(pane, down);
      texels = sqrt(abs(x.x * y.y - x.y * y.x));
    }
    sum += (sky ? pane.glass.rgb : pane.light.rgb) * pane_mean(pane_image(pane), uv, texels);
  }
  return sum;
}

// Sums along a line of a fan.
struct Line {
  uint entry;  // of its first station
  float to_next;  // share of the next line
  PaneFanRow fan;
  uint stations;
};
struct Sums {
  vec3 sum;
  vec3 moment;
};
Line line_of(PaneGroupRow row, PaneFanRow fan, float q) {
  float at = clamp((q - fan.q_low) / fan.q_step, 0.0, float(fan.lines - 1u));
  uint line = min(uint(at), fan.lines - 2u);
  return Line(row.line_first + (fan.first + line) * row.stations, at - float(line), fan, row.stations);
}
// Between two stations the light is taken as linear, by its sum and its moment there.
Sums sums_at(Line line, float p) {
  float at = clamp((p - line.fan.p_low) / line.fan.p_step, 0.0, float(line.stations - 1u));
  uint station = min(uint(at), line.stations - 2u);
  float f = at - float(station);
  uint entry = 3u * (line.entry + station);
  uint next = entry + 3u * line.stations;
  vec2 low[3];
  vec2 high[3];
  for (uint color = 0u; color < 3u; ++color) {
    low[color] = mix(sums[entry + color], sums[next + color], line.to_next);
    high[color] = mix(sums[entry + 3u + color], sums[next + 3u + color], line.to_next);
  }
  vec3 sum = vec3(low[0].x, low[1].x, low[2].x);
  vec3 moment = vec3(low[0].y, low[1].y, low[2].y);
  vec3 whole = vec3(high[0].x, high[1].x, high[2].x) - sum;
  float from = line.fan.p_low + float(station) * line.fan.p_step - line.fan.p_middle;
  vec3 slope = (vec3(high[0].y, high[1].y, high[2].y) - moment - (from + 0.5 * line.fan.p_step) * whole) *
               (12.0 / line.fan.p_step);
  slope = clamp(slope, -2.0 * whole, 2.0 * whole);  // light is nowhere below 0
  vec3 part = f * (whole + (0.5 * f - 0.5) * slope);
  vec3 part_moment = f * f * (0.5 * whole + (f * (1.0 / 3.0) - 0.25) * slope);
  return Sums(sum + part, moment + from * part + line.fan.p_step * part_moment);
}

// How much of the light is lost at t_m of the ray.
float gone_at(vec3 eye, vec3 way, float t_m) {
  return kExtinction ? params.position.w * (t_m + max(eye.z + way.z * t_m, 0.0)) : 0.0;
}

// Light of a part of a ray by the table, over sigma_s and the phase function. speed: of p, 1/m.
vec3 light_by_table(Line line, vec3 eye, vec3 way, float speed, float from_m, float to_m) {
  float gone = gone_at(eye, way, from_m);
  float loses = gone_at(eye, way, to_m) - gone;
  float pieces = max(ceil(abs(loses) * (1.0 / FL_SHAFT_PIECE_LOSS)), 1.0);
  float loss = loses / pieces;
  float step_p = (to_m - from_m) * speed / pieces;
  vec2 left = shaft_line(loss);
  vec3 light = vec3(0.0);
  Sums begin = sums_at(line, from_m * speed);
  for (float i = 0.0; i < pieces; i += 1.0) {
    Sums end = sums_at(line, from_m * speed + (i + 1.0) * step_p);
    vec3 sum = max(end.sum - begin.sum, 0.0);
    float middle = from_m * speed + (i + 0.5) * step_p - line.fan.p_middle;
    vec3 moment = (end.moment - begin.moment - middle * sum) / step_p;
    moment = clamp(moment, -0.5 * sum, 0.5 * sum);
    light += exp(-gone - (i + 0.5) * loss) * (left.x * sum + left.y * moment);
    begin = end;
  }
  return light / speed;
}

// The same from samples of the glass.
vec3 light_by_samples(PaneGroupRow row, vec3 eye, vec3 way, float from_m, float to_m) {
  float gone = gone_at(eye, way, from_m);
  float loses = gone_at(eye, way, to_m) - gone;
  float pieces = max(ceil(abs(loses) * (1.0 / FL_SHAFT_PIECE_LOSS)), kSamples);
  vec3 light = vec3(0.0);
  for (float i = 0.5; i < pieces; i += 1.0) {
    float t_m = mix(from_m, to_m, i / pieces);
    float size = t_m * pixel_rad();
    vec3 glass = glass_at(row, clamp(eye.xy + way.xy * t_m, -1.0, 1.0), vec2(size / row.across.w, 0.0),
                          vec2(0.0, size / row.upward.w), false);
    light += glass * exp(-gone - i * loses / pieces);
  }
  return light * ((to_m - from_m) / pieces);
}

// The same of panes without images, in closed form.
vec3 light_of_even(PaneGroupRow row, vec3 eye, vec3 way, float from_m, float to_m) {
  vec3 light = vec3(0.0);
  for (uint i = row.pane_first; i < row.pane_first + row.pane_count; ++i) {
    GroupPaneRow pane = group_panes[i];
    vec2 from = on_pane(pane, eye.xy + way.xy * from_m);
    vec2 to = on_pane(pane, eye.xy + way.xy * to_m);
    float x0 = 0.0;
    float x1 = 1.0;
    if (!(shaft_cut(from.x, to.x, x0, x1) && shaft_cut(from.y, to.y, x0, x1))) continue;
    float gone_0 = gone_at(eye, way, mix(from_m, to_m, x0));
    float gone_1 = gone_at(eye, way, mix(from_m, to_m, x1));
    vec3 clear = pane.light.rgb * pane_texel(pane_level(pane_image(pane), 0u), ivec2(0));
    light += clear * (exp(-min(gone_0, gone_1)) * shaft_moments(abs(gone_1 - gone_0)).x * (x1 - x0));
  }
  return light * (to_m - from_m);
}

// Cuts out what solids hide of a ray between two distances.
ShaftDark dark_of(uint group, vec3 sun, View view, vec3 eye, vec3 way, float from_m, float to_m) {
  ShaftDark dark;
  dark.count = 0u;
  vec3 from = view.ray * from_m;
  vec3 to = view.ray * to_m;
  float from_c = max(eye.z + way.z * from_m, 0.0);
  float to_c = max(eye.z + way.z * to_m, 0.0);
  if (tile_solid_count <= kSolidsMax) {
    for (uint i = 0u; i < tile_solid_count; ++i) {
      if (!reaches_into(group, tile_solids[i])) continue;
      float x0 = 0.0;
      float x1 = 1.0;
      if (shaft_shadow(tile_slabs[i], from, to, from_c, to_c, 0.0, x0, x1)) shaft_add_dark(dark, x0, x1);
    }
    return dark;
  }
  for (uint i = 0u; i < uint(occluders.length()); ++i) {
    if (!reaches_into(group, i)) continue;
    float x0 = 0.0;
    float x1 = 1.0;
    ShaftSlabs slabs = shaft_slabs(solid_of(occluders[i]), sun);
    if (shaft_shadow(slabs, from, to, from_c, to_c, 0.0, x0, x1)) shaft_add_dark(dark, x0, x1);
  }
  return dark;
}

vec3 light_in_air(uint group, PaneGroupRow row, View view, vec3 eye, vec3 way, float end_m) {
  vec3 last = eye + way * end_m;
  float x0 = 0.0;
  float x1 = 1.0;
  if (!(shaft_cut(eye.x, last.x, x0, x1) && shaft_cut(eye.y, last.y, x0, x1) && shadow_cut(-eye.z, -last.z, x0, x1) &&
        shadow_cut(eye.z - params.up.w, last.z - params.up.w, x0, x1))) {
    return vec3(0.0);
  }
  float from_m = x0 * end_m;
  float to_m = x1 * end_m;
  ShaftDark dark;
  dark.count = 0u;
  if (kShadows && tile_solid_count > 0u) dark = dark_of(group, row.sun.xyz, view, eye, way, from_m, to_m);
  uint side = shaft_fan_side(way.xy);
  PaneFanRow fan = fans[group].fans[side];
  float speed = max(abs(way.x), abs(way.y));
  bool even = row.is_even != 0u;
  bool is_short = !((to_m - from_m) * speed > kStationsLeast * fan.p_step) || fan.lines < 2u;
  Line line;
  if (!even && !is_short) line = line_of(row, fan, (side >= 2u ? way.x : way.y) / speed);
  vec3 sum = vec3(0.0);
  float begin = 0.0;
  for (uint i = 0u; i <= dark.count; ++i) {
    float end = i < dark.count ? dark.from[min(i, uint(FL_SHAFT_PARTS - 1))] : 1.0;
    if (end > begin) {
      float a_m = mix(from_m, to_m, begin);
      float b_m = mix(from_m, to_m, end);
      float loses = gone_at(eye, way, b_m) - gone_at(eye, way, a_m);
      float most = kLossMost / max(abs(loses), kLossMost);
      if (loses > 0.0) b_m = mix(a_m, b_m, most);
      else a_m = mix(b_m, a_m, most);
      if (!(b_m > a_m)) {
        // Two dark parts that differ by rounding.
      } else if (even) sum += light_of_even(row, eye, way, a_m, b_m);
      else if (is_short) sum += light_by_samples(row, eye, way, a_m, b_m);
      else sum += light_by_table(line, eye, way, speed, a_m, b_m);
    }
    begin = dark.to[min(i, uint(FL_SHAFT_PARTS - 1))];
  }
  return sum * phase_function(dot(row.sun.xyz, view.ray), params.anisotropy);
}

// Whether something hides the sun at a place on a surface; place: from the camera, c_m behind the panes.
bool hides(OccluderRow occluder, ShaftSlabs slabs, vec3 place, float c_m, float facing, uint fixture) {
  if (occluder.fixture == fixture && fixture != FL_NONE) return false;
  float rounding_m = 1e-6 * length(place) + 1e-7 * length(params.position.xyz);
  float slack_m = (max(occluder.half_edge_1.w, kSlackM) + rounding_m) / max(facing, kLeastFacing);
  float x0 = 0.0;
  float x1 = 1.0;
  return shaft_shadow(slabs, place, place, c_m, c_m, slack_m, x0, x1);
}
bool is_dark(uint group, vec3 sun, vec3 place, float c_m, float facing, uint fixture) {
  bool dark = false;
  if (tile_solid_count <= kSolidsMax) {
    for (uint i = 0u; i < tile_solid_count && !dark; ++i) {
      uint solid = tile_solids[i];
      dark = reaches_into(group, solid) && hides(occluders[solid], tile_slabs[i], place, c_m, facing, fixture);
    }
    return dark;
  }
  for (uint i = 0u; i < uint(occluders.length()) && !dark; ++i) {
    if (!reaches_into(group, i)) continue;
    OccluderRow occluder = occluders[i];
    dark = hides(occluder, shaft_slabs(solid_of(occluder), sun), place, c_m, facing, fixture);
  }
  return dark;
}

// Illuminance of a surface, lx.
vec3 light_on(uint group, PaneGroupRow row, View view, vec3 at, Surface surface) {
  float facing = -dot(surface.normal, row.sun.xyz);
  if (!(facing > 0.0 && is_on(at.xy) && at.z > 0.0 && at.z <= params.up.w)) return vec3(0.0);
  // A pixel has a parallelogram on the surface.
  float towards = dot(surface.normal, view.ray);
  towards = abs(towards) > 1e-3 ? towards : -1e-3;
  vec3 right = (view.step_x - view.ray * (dot(surface.normal, view.step_x) / towards)) * surface.t_m;
  vec3 down = (view.step_y - view.ray * (dot(surface.normal, view.step_y) / towards)) * surface.t_m;
  vec3 light = glass_at(row, at.xy, group_of(row, right).xy, group_of(row, down).xy, false);
  if (!(light.r + light.g + light.b > 0.0)) return vec3(0.0);
  uint fixture = surface.kind == kBody ? heads[surface.which >> 3].fixture : FL_NONE;
  if (kShadows && is_dark(group, row.sun.xyz, view.ray * surface.t_m, at.z, facing, fixture)) return vec3(0.0);
  float lost = kExtinction ? exp(-params.position.w * at.z) : 1.0;
  return light * (facing * lost);
}

// The panes themselves against the sky, where nothing stands before them.
vec3 light_of_glass(PaneGroupRow row, View view, vec3 eye, vec3 way, float end_m) {
  if (way.z == 0.0) return vec3(0.0);
  float t_m = -eye.z / way.z;
  vec2 at = eye.xy + way.xy * t_m;
  if (!(t_m > 0.0 && t_m < end_m && is_on(at))) return vec3(0.0);
  vec2 right = (group_of(row, view.step_x).xy - way.xy * (dot(row.along.xyz, view.step_x) / way.z)) * t_m;
  vec2 down = (group_of(row, view.step_y).xy - way.xy * (dot(row.along.xyz, view.step_y) / way.z)) * t_m;
  float lost = kExtinction ? exp(-params.position.w * t_m) : 1.0;
  return glass_at(row, at, right, down, true) * lost;
}

// Sets tile_sides.
void find_sides() {
  uint side = gl_LocalInvocationIndex;
  if (side >= 4u) return;
  const uvec2 size = uvec2(FL_TILE_PX, FL_SHAFT_ROWS);
  vec2 low = vec2(gl_WorkGroupID.xy * size);
  tile_sides[side] = side_of(low, low + vec2(size), side);
}
// Sets tile_groups.
void find_groups() {
  if (gl_LocalInvocationIndex < kWords) tile_groups[gl_LocalInvocationIndex] = 0u;
  barrier();
  for (uint group = gl_LocalInvocationIndex; group < uint(groups.length()); group += uint(FL_TILE_PX * FL_SHAFT_ROWS)) {
    if (group_meets(groups[group], tile_sides)) atomicOr(tile_groups[group / 32u], 1u << (group % 32u));
  }
  barrier();
}

// Nothing of a group's light is farther from the camera, m.
float reach_of(PaneGroupRow row) {
  return length(params.position.xyz - row.center.xyz) + row.center.w + params.up.w;
}
// Of all that the tile may show.
float tile_reach() {
  float most = 0.0;
  for (uint word = 0u; word < kWords; ++word) {
    for (uint bits = tile_groups[word]; bits != 0u; bits &= bits - 1u) {
      most = max(most, reach_of(groups[32u * word + uint(findLSB(bits))]));
    }
  }
  return most;
}

void main() {
  find_sides();
  find_groups();
  uint any_group = 0u;
  for (uint word = 0u; word < kWords; ++word) any_group |= tile_groups[word];
  if (any_group == 0u) return;
  uvec2 pixel = gl_GlobalInvocationID.xy;
  bool inside = pixel.x < params.width && pixel.y < params.height;
  View view = view_of(pixel);
  Surface surface = Surface(kNothing, 0u, vec3(0.0, 0.0, 1.0), 0.0, 0u);
  if (inside) surface = surface_at(ivec2(pixel), view.ray);
  if (kShadows) find_solids(groups[0].sun.xyz, view.ray * min(surface.t_m, tile_reach()));
  if (!inside) return;
  vec3 air = vec3(0.0);
  vec3 lx = vec3(0.0);
  vec3 glass = vec3(0.0);
  for (uint word = 0u; word < kWords; ++word) {
    for (uint bits = tile_groups[word]; bits != 0u; bits &= bits - 1u) {
      uint group = 32u * word + uint(findLSB(bits));
      PaneGroupRow row = groups[group];
      vec3 eye = group_of(row, params.position.xyz - row.center.xyz);
      vec3 way = group_of(row, view.ray);
      bool shines = row.along.w > 0.0;
      if (kAir && shines) air += light_in_air(group, row, view, eye, way, min(surface.t_m, reach_of(row)));
      if (shines && surface.kind != kNothing) lx += light_on(group, row, view, eye + way * surface.t_m, surface);
      glass += light_of_glass(row, view, eye, way, surface.t_m);
    }
  }
  vec3 sum = params.forward.w * air + glass;
  if (surface.kind != kNothing) {
    float lost = kExtinction ? exp(-params.position.w * surface.t_m) : 1.0;
    sum += albedo_of(surface) / kPi * lx * lost;
  }
  if (sum.r + sum.g + sum.b == 0.0) return;
  vec4 behind = imageLoad(radiance, ivec2(pixel));
  imageStore(radiance, ivec2(pixel), vec4(behind.rgb + sum, behind.a));
}
