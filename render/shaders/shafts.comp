#version 460
// Adds the light of the sun behind panes of glass, in the air and on surfaces, and the panes themselves. A thread a
// pixel. With FL_USE_HAZE: haze that is not even.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/shared/shaft.h"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/pane.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
layout(constant_id = FL_SPEC_SHADOWS) const bool kShadows = false;
layout(constant_id = FL_SPEC_VIEW) const uint kView = FL_VIEW_PICTURE;
layout(constant_id = FL_SPEC_AIR) const bool kAir = true;
layout(constant_id = FL_SPEC_DETAIL) const bool kDetail = true;  // images as fine as pixels; else always whole ones
layout(set = 0, binding = FL_BINDING_HEADS, std430) readonly buffer HeadsBuffer { HeadRow heads[]; };
layout(set = 0, binding = FL_BINDING_OCCLUDERS, std430) readonly buffer OccludersBuffer { OccluderRow occluders[]; };
layout(set = 0, binding = FL_BINDING_PANE_MASKS, std430) readonly buffer PaneMasksBuffer { uint pane_masks[]; };
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

const float kPi = 3.141592653589793;
const float kBodyAlbedo = 0.04;  // as in surface_light.glsl
const float kSlackM = 1e-4;      // of a body that light has passed, which does not hide it on a surface
const float kLeastFacing = 0.02;

struct View {
  vec3 ray;     // unit
  vec3 step_x;  // of it, a pixel to the right
  vec3 step_y;
};

// u, v and c (PaneRow) of a vector.
vec3 glass_of(PaneRow row, vec3 v) {
  return vec3(dot(row.across.xyz, v), dot(row.upward.xyz, v), dot(row.along.xyz, v));
}

ShaftSolid solid_of(OccluderRow row) {
  // From the camera.
  return ShaftSolid(vec3(row.center_x, row.center_y, row.center_z) - params.position.xyz, row.half_edge_0.xyz,
                    row.half_edge_1.xyz, row.half_edge_2.xyz);
}

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
  return any_of;
}

ShaftDark dark_of(uint pane, PaneRow row, vec3 ray, Part part) {
  ShaftDark dark;
  dark.count = 0u;
  uint words = (uint(occluders.length()) + 31u) / 32u;
  for (uint word = 0u; word < words; ++word) {
    for (uint bits = pane_masks[pane * words + word]; bits != 0u; bits &= bits - 1u) {
      ShaftSolid solid = solid_of(occluders[32u * word + uint(findLSB(bits))]);
      float x0 = 0.0;
      float x1 = 1.0;
      if (shaft_shadow(solid, row.sun.xyz, ray * part.from_m, ray * part.to_m, part.from.z, part.to.z, 0.0, x0, x1)) {
        shaft_add_dark(dark, x0, x1);
      }
    }
  }
  return dark;
}

// Whether something hides the sun at a place on a surface; place: from the camera, c_m behind the pane.
bool is_dark(uint pane, PaneRow row, vec3 place, float c_m, float facing, uint fixture) {
  uint words = (uint(occluders.length()) + 31u) / 32u;
  float rounding_m = 1e-6 * length(place) + 1e-7 * length(params.position.xyz);
  bool dark = false;
  for (uint word = 0u; word < words && !dark; ++word) {
    for (uint bits = pane_masks[pane * words + word]; bits != 0u && !dark; bits &= bits - 1u) {
      OccluderRow occluder = occluders[32u * word + uint(findLSB(bits))];
      if (occluder.fixture == fixture && fixture != FL_NONE) continue;
      float slack_m = (max(occluder.half_edge_1.w, kSlackM) + rounding_m) / max(facing, kLeastFacing);
      float x0 = 0.0;
      float x1 = 1.0;
      dark = shaft_shadow(solid_of(occluder), row.sun.xyz, place, place, c_m, c_m, slack_m, x0, x1);
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
  if (!kDetail) return walk(pane_level(row, 0u), part);
  float fine = log2(max(texels_per_m * part.from_m, 1.0));
  uint level = min(uint(fine), row.levels - 1u);
  vec3 sum = vec3(0.0);
  float length_m = part.to_m - part.from_m;
  Part piece = part;
  // A level is used up to the distance at which a pixel covers two of its texels.
  for (bool more = true; more; ++level) {
    float end_m = level + 1u < row.levels ? exp2(float(level + 1u)) / max(texels_per_m, 1e-20) : FL_FAR_M;
    more = end_m < part.to_m;
    piece.to_m = more ? max(end_m, piece.from_m) : part.to_m;
    piece.to = mix(part.from, part.to, (piece.to_m - part.from_m) / length_m);
    sum += walk(pane_level(row, level), piece);
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

// Illuminance of a surface, lx.
vec3 light_on(uint pane, PaneRow row, View view, vec3 at, Surface surface) {
  float facing = -dot(surface.normal, row.sun.xyz);
  bool reaches = facing > 0.0 && abs(at.x) <= 1.0 && abs(at.y) <= 1.0 && at.z > 0.0 && at.z <= params.up.w;
  if (!reaches) return vec3(0.0);
  uint fixture = surface.kind == kBody ? heads[surface.which >> 3].fixture : FL_NONE;
  if (kShadows && is_dark(pane, row, view.ray * surface.t_m, at.z, facing, fixture)) return vec3(0.0);
  float texels = 0.0;
  if (kDetail) {
    // Of the parallelogram that a pixel has on the surface, the root of its area on the glass.
    float towards = dot(surface.normal, view.ray);
    towards = abs(towards) > 1e-3 ? towards : -1e-3;
    vec2 scale = vec2(row.width, row.height) * (0.5 * surface.t_m);
    vec2 right = glass_of(row, view.step_x - view.ray * (dot(surface.normal, view.step_x) / towards)).xy * scale;
    vec2 down = glass_of(row, view.step_y - view.ray * (dot(surface.normal, view.step_y) / towards)).xy * scale;
    texels = sqrt(abs(right.x * down.y - right.y * down.x));
  }
  float lost = kExtinction ? exp(-params.position.w * at.z) : 1.0;
  return row.light.rgb * pane_mean(row, at.xy, texels) * (facing * lost);
}

// The pane itself against the sky, where nothing stands before it.
vec3 light_of_glass(PaneRow row, View view, vec3 eye, vec3 way, float end_m) {
  if (way.z == 0.0) return vec3(0.0);
  float t_m = -eye.z / way.z;
  vec2 at = eye.xy + way.xy * t_m;
  if (!(t_m > 0.0 && t_m < end_m && abs(at.x) <= 1.0 && abs(at.y) <= 1.0)) return vec3(0.0);
  vec2 scale = vec2(row.width, row.height) * (0.5 * t_m);
  vec2 right = (glass_of(row, view.step_x).xy - way.xy * (dot(row.along.xyz, view.step_x) / way.z)) * scale;
  vec2 down = (glass_of(row, view.step_y).xy - way.xy * (dot(row.along.xyz, view.step_y) / way.z)) * scale;
  float texels = kDetail ? sqrt(abs(right.x * down.y - right.y * down.x)) : 0.0;
  float lost = kExtinction ? exp(-params.position.w * t_m) : 1.0;
  return row.glass.rgb * pane_mean(row, at, texels) * lost;
}

vec3 albedo_of(Surface surface) {
  if (surface.kind == kBox) return boxes[surface.which].albedo.rgb;
  if (surface.kind == kBody) return vec3(kBodyAlbedo);
  return vec3((uvec3(surface.which) >> uvec3(20, 10, 0)) & 1023u) / 1023.0;
}

void main() {
  uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= params.width || pixel.y >= params.height) return;
  vec3 through = ray_through(vec2(pixel) + 0.5);
  float size = length(through);
  View view;
  view.ray = through / size;
  view.step_x = params.right.xyz * (2.0 / float(params.width));
  view.step_y = params.up.xyz * (-2.0 / float(params.height));
  view.step_x = (view.step_x - view.ray * dot(view.ray, view.step_x)) / size;
  view.step_y = (view.step_y - view.ray * dot(view.ray, view.step_y)) / size;
  Surface surface = surface_at(ivec2(pixel), view.ray);
#ifdef FL_USE_HAZE
  haze_begin(vec2(pixel) + 0.5);
#endif
  vec3 air = vec3(0.0);
  vec3 lx = vec3(0.0);
  vec3 glass = vec3(0.0);
  for (uint pane = 0u; pane < uint(panes.length()); ++pane) {
    PaneRow row = panes[pane];
    vec3 from = params.position.xyz - row.center.xyz;
    vec3 eye = glass_of(row, from);
    vec3 way = glass_of(row, view.ray);
    // Nothing of the shaft is farther away.
    float end_m = min(surface.t_m, length(from) + row.center.w + params.up.w);
    bool shines = row.light.r + row.light.g + row.light.b > 0.0;
    if (kAir && shines) air += light_in_air(pane, row, view, eye, way, end_m);
    if (shines && surface.kind != kNothing) lx += light_on(pane, row, view, eye + way * surface.t_m, surface);
    if (kView == uint(FL_VIEW_PICTURE)) glass += light_of_glass(row, view, eye, way, surface.t_m);
  }
  vec3 sum = lx;
  if (kView == uint(FL_VIEW_PICTURE)) {
    sum = params.forward.w * air + glass;
    if (surface.kind != kNothing) {
      float lost = kExtinction ? exp(-params.position.w * surface.t_m) : 1.0;
      sum += albedo_of(surface) / kPi * lx * lost;
    }
  }
  vec4 behind = imageLoad(radiance, ivec2(pixel));
  imageStore(radiance, ivec2(pixel), vec4(behind.rgb + sum, behind.a));
}
