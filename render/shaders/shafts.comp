#version 460
// Adds the light of the sun behind panes of glass, in the air and on surfaces, and the panes themselves. With
// FL_USE_HAZE: haze that is not even.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/shaft_pixel.glsl"

// The part of a ray in a shaft.
struct Part {
  float from_m;
  float to_m;
  vec3 from;  // u, v, c
  vec3 to;
};

bool part_of(PaneRow row, vec3 eye, vec3 way, float end_m, out Part part) {
  vec3 last = eye + way * end_m;
  float x0 = 0.0;
  float x1 = 1.0;
  bool any_of = shaft_cut(eye.x, last.x, x0, x1) && shaft_cut(eye.y, last.y, x0, x1) &&
                shadow_cut(-eye.z, -last.z, x0, x1) && shadow_cut(eye.z - params.up.w, last.z - params.up.w, x0, x1);
  part.from_m = x0 * end_m;
  part.to_m = x1 * end_m;
  part.from = eye + way * part.from_m;
  part.to = eye + way * part.to_m;
  // Of an eye far away, rounding takes the ends out of the pane.
  part.from = vec3(clamp(part.from.xy, -1.0, 1.0), max(part.from.z, 0.0));
  part.to = vec3(clamp(part.to.xy, -1.0, 1.0), max(part.to.z, 0.0));
  return any_of;
}

ShaftDark dark_of(uint pane, PaneRow row, vec3 ray, Part part) {
  ShaftDark dark;
  dark.count = 0u;
  uint words = mask_words();
  for (uint word = 0u; word < words; ++word) {
    for (uint bits = pane_masks[pane * words + word]; bits != 0u; bits &= bits - 1u) {
      ShaftSlabs slabs = shaft_slabs(solid_of(occluders[32u * word + uint(findLSB(bits))]), row.sun.xyz);
      float x0 = 0.0;
      float x1 = 1.0;
      if (shaft_shadow(slabs, ray * part.from_m, ray * part.to_m, part.from.z, part.to.z, 0.0, x0, x1)) {
        shaft_add_dark(dark, x0, x1);
      }
    }
  }
  return dark;
}

// Texels of the whole image that a pixel covers across the line that the ray draws on the glass, a metre of distance.
float texels_across(PaneRow row, View view, vec3 way) {
  vec2 scale = vec2(row.width, row.height) * 0.5;
  vec2 along = way.xy * scale;
  float size = length(along);
  vec2 unit = size > 1e-6 * length(scale) ? along / size : vec2(0.0);
  vec2 right = glass_of(row, view.step_x).xy * scale;
  vec2 down = glass_of(row, view.step_y).xy * scale;
  right -= unit * dot(right, unit);
  down -= unit * dot(down, unit);
  return sqrt(dot(right, right) + dot(down, down));
}

// The integral of the glass and what is left of the light over a piece of the ray, on one level of detail, m.
vec3 walk(PaneLevel level, Part piece) {
  vec2 from = pane_place(level, piece.from.xy);
  vec2 way = pane_place(level, piece.to.xy) - from;
  ivec2 cell = ivec2(floor(from));
  ivec2 last = ivec2(floor(from + way));
  uint steps = uint(abs(last.x - cell.x) + abs(last.y - cell.y));
  ivec2 ahead = ivec2(greaterThan(way, vec2(0.0)));
  ivec2 go = 2 * ahead - 1;
  vec2 speed = 1.0 / mix(way, vec2(1.0), equal(last, cell));
  float gone = kExtinction ? params.position.w * (piece.from_m + piece.from.z) : 0.0;
  float loses = kExtinction ? params.position.w * (piece.to_m + piece.to.z) - gone : 0.0;
  vec3 sum = vec3(0.0);
  float y = 0.0;
  vec2 rest = vec2(abs(last - cell));  // sides that are left to cross
  if (kView == uint(FL_VIEW_STEPS)) steps_taken += float(steps + 1u);
  for (uint i = 0u; i <= steps; ++i) {
    vec2 next = (vec2(cell + ahead) - from) * speed;
    next = mix(next, vec2(2.0), lessThan(rest, vec2(0.5)));
    float end = clamp(min(next.x, next.y), y, 1.0);
    PaneCell glass = pane_cell(level, cell);
    vec2 f = from - vec2(cell);
    vec3 light = shaft_cell(pane_value(glass, f + way * y), pane_value(glass, f + way * (0.5 * (y + end))),
                            pane_value(glass, f + way * end), gone + loses * y, gone + loses * end);
#ifdef FL_USE_HAZE
    light *= haze_mean(mix(piece.from_m, piece.to_m, y), mix(piece.from_m, piece.to_m, end));
#endif
    sum += (end - y) * light;
    y = end;
    int side = next.x <= next.y ? 0 : 1;
    cell[side] += go[side];
    rest[side] -= 1.0;
  }
  return sum * (piece.to_m - piece.from_m);
}

// The same over a lit part, with levels of detail as fine as pixels.
vec3 walk_levels(PaneRow row, Part part, float texels_per_m) {
  float length_m = part.to_m - part.from_m;
  if (!(length_m > 0.0)) return vec3(0.0);  // two dark intervals that differ by rounding
  if (!kDetail) return walk(pane_level(pane_image(row), 0u), part);
  float fine = log2(max(texels_per_m * part.from_m, 1.0));
  uint level = min(uint(fine), row.levels - 1u);
  vec3 sum = vec3(0.0);
  Part piece = part;
  // A level is used up to the distance at which a pixel covers two of its texels.
  for (bool more = true; more; ++level) {
    float end_m = level + 1u < row.levels ? exp2(float(level + 1u)) / max(texels_per_m, 1e-20) : FL_FAR_M;
    more = end_m < part.to_m;
    piece.to_m = more ? max(end_m, piece.from_m) : part.to_m;
    piece.to = mix(part.from, part.to, (piece.to_m - part.from_m) / length_m);
    sum += walk(pane_level(pane_image(row), level), piece);
    piece.from_m = piece.to_m;
    piece.from = piece.to;
  }
  return sum;
}

vec3 light_in_air(uint pane, PaneRow row, View view, vec3 eye, vec3 way, float end_m) {
  Part part;
  if (!part_of(row, eye, way, end_m, part)) return vec3(0.0);
  ShaftDark dark;
  dark.count = 0u;
  if (kShadows) dark = dark_of(pane, row, view.ray, part);
  float texels_per_m = kDetail ? texels_across(row, view, way) : 0.0;
  vec3 sum = vec3(0.0);
  float x0 = 0.0;
  for (uint i = 0u; i <= dark.count; ++i) {
    float x1 = i < dark.count ? dark.from[min(i, uint(FL_SHAFT_PARTS - 1))] : 1.0;
    if (x1 > x0) {
      Part lit;
      lit.from_m = mix(part.from_m, part.to_m, x0);
      lit.to_m = mix(part.from_m, part.to_m, x1);
      lit.from = mix(part.from, part.to, x0);
      lit.to = mix(part.from, part.to, x1);
      sum += walk_levels(row, lit, texels_per_m);
    }
    x0 = dark.to[min(i, uint(FL_SHAFT_PARTS - 1))];
  }
  return row.light.rgb * sum * phase_function(dot(row.sun.xyz, view.ray), params.anisotropy);
}
