#version 460
// A rival: shafts of sunlight by a march with equal steps through the box of each shaft, as it is usual for stained
// glass. It ends at what the pixel shows and at the first pane; each step looks at the image and at what hides the sun.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/shaft_pixel.glsl"

layout(constant_id = FL_SPEC_NODES) const uint kNodes = 30u;

// Where the ray meets the first of all panes.
float first_pane(View view, float end_m) {
  for (uint pane = 0u; pane < uint(panes.length()); ++pane) {
    PaneRow row = panes[pane];
    vec3 eye = glass_of(row, params.position.xyz - row.center.xyz);
    vec3 way = glass_of(row, view.ray);
    if (way.z == 0.0) continue;
    float t_m = -eye.z / way.z;
    vec2 at = eye.xy + way.xy * t_m;
    if (t_m > 0.0 && abs(at.x) <= 1.0 && abs(at.y) <= 1.0) end_m = min(end_m, t_m);
  }
  return end_m;
}

vec3 light_in_air(uint pane, PaneRow row, View view, vec3 eye, vec3 way, float end_m) {
  end_m = first_pane(view, end_m);
  // The box lies along the light. Its sides are those of the shaft, its ends are not.
  vec3 from = params.position.xyz - row.center.xyz;
  float low = dot(row.sun.xyz, from) + row.center.w;
  float high = low - 2.0 * row.center.w - params.up.w;
  float speed = dot(row.sun.xyz, view.ray) * end_m;
  float x0 = 0.0;
  float x1 = 1.0;
  vec3 last = eye + way * end_m;
  bool any_of = shaft_cut(eye.x, last.x, x0, x1) && shaft_cut(eye.y, last.y, x0, x1) &&
                shadow_cut(-low, -low - speed, x0, x1) && shadow_cut(high, high + speed, x0, x1);
  if (!any_of) return vec3(0.0);
  steps_taken += float(kNodes);
  vec3 sum = vec3(0.0);
  for (uint i = 0u; i < kNodes; ++i) {
    float t_m = mix(x0, x1, (float(i) + 0.5) / float(kNodes)) * end_m;
    vec3 at = eye + way * t_m;
    if (abs(at.x) > 1.0 || abs(at.y) > 1.0 || !(at.z > 0.0) || at.z > params.up.w) continue;
    if (kShadows && is_dark(pane, row, view.ray * t_m, at.z, 1.0, FL_NONE)) continue;
    float left = kExtinction ? exp(-params.position.w * (t_m + at.z)) : 1.0;
    sum += pane_at(pane_image(row), 0u, at.xy) * left;
  }
  float phase = phase_function(dot(row.sun.xyz, view.ray), params.anisotropy);
  return row.light.rgb * sum * ((x1 - x0) * end_m / float(kNodes) * phase);
}
