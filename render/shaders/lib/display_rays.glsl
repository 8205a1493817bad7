// Light of displays along the rays of a workgroup and where they end, without their pixels. After display_light.glsl
// and surface.glsl. Several threads, the lanes of a ray, share it: each takes every so many-th node of all displays.
// FL_RAYS: how many rays a workgroup has at most; FL_TOGETHER: of so many displays their shapes are kept at a time.
layout(constant_id = FL_SPEC_AIR) const bool kAir = true;

// One thread's share of a ray.
struct RayPart {
  bool works;
  vec2 px;      // in the picture
  vec3 ray;     // unit
  uint number;  // of the ray
  float t_m;
  vec3 normal;  // of the surface at t_m, 0: light on it is not wanted
  bool in_air;
  uint lane;
  uint lanes;
};

struct RayLight {
  vec3 air;    // over sigma_s
  vec3 lx;     // on the surface
  float face;  // cd/m^2, the mean of the display that the ray ends at
};
const float kFaceM = 0.05;  // a display is no farther than this before what stands for it

const uint kTogether = uint(FL_TOGETHER);
shared float nearest_m[FL_RAYS * FL_TOGETHER];  // AirShape, of each ray
shared float nearest_d[FL_RAYS * FL_TOGETHER];
shared uint pieces[FL_RAYS * FL_TOGETHER];  // 0: no light

vec3 mean_of(DisplayRow row) { return row.light.rgb * read_cell(row, row.levels - 1u, uvec2(0u)).mean; }
vec3 eye_of(DisplayRow row) { return in_display(row, params.position.xyz - row.center.xyz); }

void add_surface(RayPart part, inout RayLight sum) {
  for (uint i = part.lane; i < uint(displays.length()); i += part.lanes) {
    DisplayRow row = displays[i];
    vec3 mean = mean_of(row);
    if (!(mean.r + mean.g + mean.b > 0.0)) continue;
    vec3 eye = eye_of(row);
    vec3 way = in_display(row, part.ray);
    vec3 place = eye + way * part.t_m;
    if (place.z > 0.0) {
      sum.lx += row.light.rgb * light_of_cells(row, place, in_display(row, part.normal), false, extinction());
    }
    bool on_face = abs(place.z) < kFaceM && all(lessThan(abs(place.xy), vec2(row.right.w, row.down.w)));
    if (on_face && way.z < 0.0) sum.face += max(mean.r, max(mean.g, mean.b));
  }
}

// Shapes of all rays before the displays from `first` on, kTogether at most. By all threads of a workgroup.
void shape_air(RayPart part, uint first, uint together) {
  barrier();  // those of the displays before have been read
  if (part.works && part.in_air) {
    for (uint i = part.lane; i < together; i += part.lanes) {
      uint at = kTogether * part.number + i;
      pieces[at] = 0u;
      DisplayRow row = displays[first + i];
      vec3 mean = mean_of(row);
      if (!(mean.r + mean.g + mean.b > 0.0)) continue;
      vec3 eye = eye_of(row);
      vec3 way = in_display(row, part.ray);
      AirShape shape = air_range(row, eye, way, part.t_m);
      if (!is_lit(shape)) continue;
      find_nearest(row, eye, way, extinction(), shape);
      nearest_m[at] = shape.nearest_m;
      nearest_d[at] = shape.d;
      pieces[at] = shape.pieces;
    }
  }
  barrier();
}

void add_air(RayPart part, uint first, uint together, inout RayLight sum) {
#ifdef FL_USE_HAZE
  haze_begin(part.px);
#endif
  uint number = part.lane;
  for (uint i = 0u; i < together; ++i) {
    uint at = kTogether * part.number + i;
    if (pieces[at] == 0u) continue;
    uint nodes = 4u * pieces[at] + 1u;
    if (number < nodes) {
      DisplayRow row = displays[first + i];
      vec3 eye = eye_of(row);
      vec3 way = in_display(row, part.ray);
      AirShape shape = air_range(row, eye, way, part.t_m);
      shape.nearest_m = nearest_m[at];
      shape.d = nearest_d[at];
      shape.pieces = pieces[at];
      float begin = w_at(shape, shape.begin_m);
      float whole = w_at(shape, air_end(shape)) - begin;
      vec3 light = vec3(0.0);
      for (; number < nodes; number += part.lanes) {
        light += light_of_node(row, shape, eye, way, begin, whole, part.ray.z, number, extinction());
      }
      sum.air += row.light.rgb * light;
    }
    number -= nodes;
  }
}

// By all threads of a workgroup, of which some may have no ray.
RayLight light_along(RayPart part) {
  RayLight sum = RayLight(vec3(0.0), vec3(0.0), 0.0);
  if (part.works && part.normal != vec3(0.0)) add_surface(part, sum);
  for (uint first = 0u; kAir && first < uint(displays.length()); first += kTogether) {
    uint together = min(uint(displays.length()) - first, kTogether);
    shape_air(part, first, together);
    if (part.works && part.in_air) add_air(part, first, together, sum);
  }
  return sum;
}
