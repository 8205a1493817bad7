// A pixel of the pass of shafts; a method defines light_in_air(). One thread a pixel.
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/shared/shadow.h"
#include "render/shaders/shared/shaft.h"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/albedo.glsl"
#include "render/shaders/lib/pane.glsl"
#include "render/shaders/lib/shaft_occluders.glsl"
#include "render/shaders/lib/shaft_view.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
layout(constant_id = FL_SPEC_SHADOWS) const bool kShadows = false;
layout(constant_id = FL_SPEC_VIEW) const uint kView = FL_VIEW_PICTURE;
layout(constant_id = FL_SPEC_AIR) const bool kAir = true;
layout(constant_id = FL_SPEC_DETAIL) const bool kDetail = true;  // images as fine as pixels; else always whole ones
layout(set = 0, binding = FL_BINDING_HEADS, std430) readonly buffer HeadsBuffer { HeadRow heads[]; };
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

const float kPi = 3.141592653589793;

// u, v and c (PaneRow) of a vector.
vec3 glass_of(PaneRow row, vec3 v) {
  return vec3(dot(row.across.xyz, v), dot(row.upward.xyz, v), dot(row.along.xyz, v));
}

// Whether something hides the sun at a place on a surface; place: from the camera, c_m behind the pane.
bool is_dark(uint pane, PaneRow row, vec3 place, float c_m, float facing, uint fixture) {
  uint words = mask_words();
  float rounding_m = 1e-6 * length(place) + 1e-7 * length(params.position.xyz);
  bool dark = false;
  for (uint word = 0u; word < words && !dark; ++word) {
    for (uint bits = pane_masks[pane * words + word]; bits != 0u && !dark; bits &= bits - 1u) {
      OccluderRow occluder = occluders[32u * word + uint(findLSB(bits))];
      if (occluder.fixture == fixture && fixture != FL_NONE) continue;
      float slack_m = (max(occluder.half_edge_1.w, kSlackM) + rounding_m) / max(facing, kLeastFacing);
      float x0 = 0.0;
      float x1 = 1.0;
      ShaftSlabs slabs = shaft_slabs(solid_of(occluder), row.sun.xyz);
      dark = shaft_shadow(slabs, place, place, c_m, c_m, slack_m, x0, x1);
    }
  }
  return dark;
}

float steps_taken = 0.0;  // of all panes

// Light in the air of a pane up to end_m, over sigma_s. eye, way: u, v and c of the camera and of the ray.
vec3 light_in_air(uint pane, PaneRow row, View view, vec3 eye, vec3 way, float end_m);

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
  return row.light.rgb * pane_mean(pane_image(row), at.xy, texels) * (facing * lost);
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
  return row.glass.rgb * pane_mean(pane_image(row), at, texels) * lost;
}

// The panes whose shafts the rays of the tile's pixels may meet, a bit each.
const uint kPaneWords = uint(FL_PANES_MAX) / 32u;
shared uint tile_panes[kPaneWords];

// False only where no ray of the tile meets the pane or what lies behind it: all of its corners are beyond one side of
// the tile's pyramid.
bool pane_meets_tile(PaneRow row) {
  vec2 low = vec2(gl_WorkGroupID.xy * uint(FL_TILE_PX));
  vec2 high = low + float(FL_TILE_PX);
  vec3 corner[4] = vec3[4](ray_through(low), ray_through(vec2(high.x, low.y)), ray_through(high),
                           ray_through(vec2(low.x, high.y)));
  vec3 middle = ray_through(0.5 * (low + high));
  mat3 axes = inverse(transpose(mat3(row.across.xyz, row.upward.xyz, row.along.xyz)));  // of u, v and c, m
  vec3 center = row.center.xyz - params.position.xyz;
  bool meets = true;
  for (int side = 0; side < 4; ++side) {
    vec3 normal = normalize(cross(corner[side], corner[(side + 1) & 3]));
    if (dot(normal, middle) < 0.0) normal = -normal;
    vec3 reach = vec3(dot(normal, axes[0]), dot(normal, axes[1]), dot(normal, axes[2]) * params.up.w);
    float most = dot(normal, center) + abs(reach.x) + abs(reach.y) + max(reach.z, 0.0);
    float slack = 1e-5 * (length(center) + length(axes[0]) + length(axes[1]) + params.up.w * length(axes[2]));
    meets = meets && !(most < -slack);  // where the sun is in the plane of the pane, nothing is a number
  }
  return meets;
}

void main() {
  if (gl_LocalInvocationIndex < kPaneWords) tile_panes[gl_LocalInvocationIndex] = 0u;
  barrier();
  for (uint pane = gl_LocalInvocationIndex; pane < uint(panes.length()); pane += uint(FL_TILE_PX * FL_TILE_PX)) {
    if (pane_meets_tile(panes[pane])) atomicOr(tile_panes[pane / 32u], 1u << (pane % 32u));
  }
  barrier();
  uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= params.width || pixel.y >= params.height) return;
  View view = view_of(pixel);
  Surface surface = surface_at(ivec2(pixel), view.ray);
#ifdef FL_USE_HAZE
  haze_begin(vec2(pixel) + 0.5);
#endif
  vec3 air = vec3(0.0);
  vec3 lx = vec3(0.0);
  vec3 glass = vec3(0.0);
  for (uint word = 0u; word < kPaneWords; ++word) {
    for (uint bits = tile_panes[word]; bits != 0u; bits &= bits - 1u) {
      uint pane = 32u * word + uint(findLSB(bits));
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
  }
  vec3 sum = lx;
  if (kView == uint(FL_VIEW_PICTURE)) {
    sum = params.forward.w * air + glass;
    if (surface.kind != kNothing) {
      float lost = kExtinction ? exp(-params.position.w * surface.t_m) : 1.0;
      sum += albedo_of(surface) / kPi * lx * lost;
    }
  }
  if (kView == uint(FL_VIEW_STEPS)) {
    imageStore(radiance, ivec2(pixel), vec4(vec3(steps_taken), 1.0));
    return;
  }
  vec4 behind = imageLoad(radiance, ivec2(pixel));
  imageStore(radiance, ivec2(pixel), vec4(behind.rgb + sum, behind.a));
}
