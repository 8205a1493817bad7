// Light of displays along a ray and where it ends, without their pixels. After display_light.glsl and surface.glsl.
layout(constant_id = FL_SPEC_AIR) const bool kAir = true;

// What one of several threads computes: every stride_of-th display from first on, and of each every parts-th place
// on the ray from number `part` on.
struct Lane {
  uint first;
  uint stride_of;
  uint part;
  uint parts;
};
Lane lane_of(uint number, uint lanes) {
  uint parts = max(lanes / uint(displays.length()), 1u);
  return Lane(number / parts, max(lanes / parts, 1u), number % parts, parts);
}

struct RayLight {
  vec3 air;    // over sigma_s
  vec3 lx;     // on the surface
  float face;  // cd/m^2, the mean of the display that the ray ends at
};
const float kFaceM = 0.05;  // a display is no farther than this before what stands for it

// px: in the picture; ray: unit; normal: of the surface at t_m, 0: light on it is not wanted.
RayLight light_along(vec2 px, vec3 ray, float t_m, vec3 normal, bool in_air, Lane lane) {
#ifdef FL_USE_HAZE
  haze_begin(px);
#endif
  RayLight sum = RayLight(vec3(0.0), vec3(0.0), 0.0);
  for (uint i = lane.first; i < uint(displays.length()); i += lane.stride_of) {
    DisplayRow row = displays[i];
    vec3 mean = row.light.rgb * read_cell(row, row.levels - 1u, uvec2(0u)).mean;
    if (!(mean.r + mean.g + mean.b > 0.0)) continue;
    vec3 eye = in_display(row, params.position.xyz - row.center.xyz);
    vec3 way = in_display(row, ray);
    if (lane.part == 0u && normal != vec3(0.0)) {
      vec3 place = eye + way * t_m;
      if (place.z > 0.0) {
        sum.lx += row.light.rgb * light_of_cells(row, place, in_display(row, normal), false, extinction());
      }
      bool on_face = abs(place.z) < kFaceM && all(lessThan(abs(place.xy), vec2(row.right.w, row.down.w)));
      if (on_face && way.z < 0.0) sum.face += max(mean.r, max(mean.g, mean.b));
    }
    if (in_air) sum.air += row.light.rgb * air_of_display(row, eye, way, t_m, extinction(), lane.part, lane.parts);
  }
  return sum;
}
