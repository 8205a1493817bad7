#version 460
// Light on solid things, and how far away they are (alpha of the radiance image, for the beams that follow): albedo /
// pi times the illuminance of every beam that reaches the pixel's surface, dimmed by the haze between it and the eye.
// Lenses shine by themselves.
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_MASKS
#define FL_MASKS_ACCESS readonly
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/lib/view.glsl"
#include "render/shaders/lib/gobo.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/lib/tile_test.glsl"
#include "render/shaders/lib/thin.glsl"

// Smallest box of the tile's surface points as ordered integers, camera-relative; then a sphere round it.
shared int bound_low[3];
shared int bound_high[3];

// Order-preserving integer of a float.
int ordered(float x) {
  int bits = floatBitsToInt(x);
  return bits ^ ((bits >> 31) & 0x7fffffff);
}
float from_ordered(int bits) { return intBitsToFloat(bits ^ ((bits >> 31) & 0x7fffffff)); }

void bound_begin() {
  uint lane = gl_LocalInvocationIndex;
  if (lane < 3u) {
    bound_low[lane] = 0x7fffffff;
    bound_high[lane] = int(0x80000000);
  }
  barrier();
}
// The box of one thread's points; low > high where it has none. All threads of the group call it together.
void bound_add(vec3 low_m, vec3 high_m) {
  low_m = subgroupMin(low_m);
  high_m = subgroupMax(high_m);
  if (!subgroupElect() || low_m.x > high_m.x) return;
  for (int i = 0; i < 3; ++i) {
    atomicMin(bound_low[i], ordered(low_m[i]));
    atomicMax(bound_high[i], ordered(high_m[i]));
  }
}

// Whether the cone reaches the sphere round the tile's points.
bool tile_touches(BeamRow row) {
  if (bound_low[0] > bound_high[0]) return false;  // nothing solid here
  vec3 low = vec3(from_ordered(bound_low[0]), from_ordered(bound_low[1]), from_ordered(bound_low[2]));
  vec3 high = vec3(from_ordered(bound_high[0]), from_ordered(bound_high[1]), from_ordered(bound_high[2]));
  vec3 p = row.eye.xyz + to_light(row, 0.5 * (low + high));
  // What float loses of a place grows with its distance from the lens and from the camera.
  float radius = 0.5001 * length(high - low) + 1e-4 + 1e-6 * (length(row.eye.xyz) + length(p));
  float spread = row.y_axis.w;
  float lens_radius_m = beam_bound(row, FL_THIN_ON_SURFACE).lens_radius_m;
  if (kRectangle && row.squeeze > 0.0) {
    float stretched = radius * max(1.0, inversesqrt(row.squeeze));
    return p.z > -radius && p.z < row.axis.w + radius &&
           length(p.xy) < lens_radius_m + spread * max(p.z, 0.0) + stretched + radius * spread;
  }
  return p.z > -radius && p.z < row.axis.w + radius &&
         length(p.xy) < lens_radius_m + spread * max(p.z, 0.0) + radius * sqrt(1.0 + spread * spread);
}
#include "render/shaders/lib/tile_walk.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX / FL_ROWS) in;
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;

layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform writeonly image2D radiance;

const float kPi = 3.141592653589793;
// Reflectance of painted housings. Chosen by eye.
const float kBodyAlbedo = 0.04;

// The lens of a head, cd/m^2: it lights the eye as all beams of the head do there, and a little of its light goes to
// all sides. The disc's projected area over the square of its distance is the solid angle that it has for the eye.
vec3 lens_radiance(uint index, float t_m, vec3 unit_ray, vec3 normal) {
  TypeRow type = types[heads[index].type];
  HeadState state = states[index];
  float facing = dot(normal, -unit_ray);
  if (!(facing > 0.0)) return vec3(0.0);
  float area_m2 = kPi * type.lens_radius_m * type.lens_radius_m;
  if (kRectangle && type.aspect > 0.0) area_m2 = 4.0 * type.lens_radius_m * type.lens_radius_m / type.aspect;
  vec3 eye_lx = vec3(0.0);
  uint beam_count = state.beam_first == kNoAddress ? 0u : max(state.beams, 1u);
  for (uint b = 0u; b < beam_count; ++b) {
    BeamRow row = beams[state.beam_first + b];
    if (!(dot(normal, row.axis.xyz) > 0.5)) continue;  // the side of the glass
    BeamShape beam = beam_shape(row);
    beam.profile_power = drawn_profile(beam.profile_power);
    beam.range_m = 1e30;  // a lens is seen from any distance
    vec2 rho;
    float r_m;
    float share = beam_illuminance(beam, row.eye.xyz, rho, r_m);
    if (!(share > 0.0)) continue;
    gobo_begin(row);
    if (kBlades && (row.flags & FL_BEAM_BLADES) != 0u) share *= blades_at(state.beam_first + b, rho, row.eye.z);
    vec3 through = vec3(share);
    if (has_gobo(row)) through *= gobo_on_surface(row.gobo, rho, row.eye.z);
    eye_lx += row.j0.rgb * through;
  }
  vec3 glow_lm = vec3(state.red, state.green, state.blue) * type.glow_lm;
  return eye_lx * (t_m * t_m / (area_m2 * facing)) + glow_lm / (kPi * area_m2);
}

// How a place on a surface moves in light space for a step by FrameParams::thin along `way`, a unit vector of the
// picture's plane. A face that is nearly edge on counts as one at kEdgeOn: FL_THIN_ON_SURFACE is sqrt(2) (1 + 1 /
// kEdgeOn).
const float kEdgeOn = 0.2;
vec3 step_on_surface(BeamRow row, Surface surface, vec3 ray, float depth_m, vec3 way) {
  float facing = min(dot(surface.normal, ray), -kEdgeOn * length(ray));
  return to_light(row, (way - ray * (dot(surface.normal, way) / facing)) * (beam_thin(row) * depth_m));
}
// ray: one of depth 1.
float thin_illuminance(BeamShape beam, BeamRow row, vec3 p, Surface surface, vec3 offset_m, bool plain, out vec2 rho,
                       out float r_m) {
  float depth_m = dot(offset_m, params.forward.xyz);
  vec3 ray = offset_m / depth_m;
  return thin_on_surface(beam, p, step_on_surface(row, surface, ray, depth_m, normalize(params.right.xyz)),
                         step_on_surface(row, surface, ray, depth_m, normalize(params.up.xyz)), plain, rho, r_m);
}

// Its share that reaches a face. The work light falls on everything from above and from the eye, so that its form
// shows, and comes back from the floor, so that thin undersides are no black lines. So does a rig's own ambient light
// on what has triangles; on boxes that is the same everywhere.
float work_light(vec3 normal, vec3 offset_m) {
  return 0.3 + 0.3 * (0.5 + 0.5 * normal.z) + 0.4 * max(-dot(normal, normalize(offset_m)), 0.0);
}

void main() {
  Medium medium = Medium(params.anisotropy, params.position.w);
  Surface surface[FL_ROWS];
  vec3 offset_m[FL_ROWS];  // of the surface point from the camera
  vec3 illuminance_lx[FL_ROWS];
  // A sphere round all surface points of the tile: most beams that cross the tile in the air light none of them.
  bound_begin();
  vec3 low_m = vec3(kNothingM * 2.0);
  vec3 high_m = vec3(-kNothingM * 2.0);
  for (int i = 0; i < FL_ROWS; ++i) {
    ivec2 pixel = tile_pixel(i);
    vec3 d = normalize(ray_through(vec2(pixel) + 0.5));
    // Threads past the edge of the picture look at its last pixel; what they find is not used.
    surface[i] = surface_at(min(pixel, ivec2(int(params.width), int(params.height)) - 1), d);
    offset_m[i] = d * surface[i].t_m;
    illuminance_lx[i] = vec3(params.ambient_lx);
    if (surface[i].kind != kNothing && in_picture(pixel)) {
      low_m = min(low_m, offset_m[i]);
      high_m = max(high_m, offset_m[i]);
    }
  }
  bound_add(low_m, high_m);
  barrier();

  for (uint base = 0u; base < counts.live_count; base += FL_WALK_BEAMS) {
    if (!tile_walk(base)) continue;
    FL_WALK_BEGIN(base, index)
      BeamRow row = beams[index];
      BeamShape beam = beam_shape(row);
      beam.profile_power = drawn_profile(beam.profile_power);
      gobo_begin(row);
      bool gobo = has_gobo(row);
      bool plain = thin_is_plain(row, gobo);
      bool thin = beam_thin(row) > 0.0;
      for (int i = 0; i < FL_ROWS; ++i) {
        vec3 p = row.eye.xyz + to_light(row, offset_m[i]);
        vec2 rho;
        float r_m;
        float share = 0.0;
        if (thin && surface[i].kind != kNothing) {
          share = thin_illuminance(beam, row, p, surface[i], offset_m[i], plain, rho, r_m);
        } else {
          share = beam_illuminance(beam, p, rho, r_m);
        }
        if (surface[i].kind != kNothing && share > 0.0) {
          share *= max(-dot(to_light(row, surface[i].normal), beam_direction(beam, rho)), 0.0);
          if (kExtinction) share *= exp(-medium.extinction_per_m * r_m);
          if (kBlades && (row.flags & FL_BEAM_BLADES) != 0u) share *= blades_at(index, rho, p.z);
          vec3 through = vec3(share);
          if (gobo) through *= gobo_on_surface(row.gobo, rho, p.z);
          illuminance_lx[i] += row.j0.rgb * through;
        }
      }
    FL_WALK_END
  }

  for (int i = 0; i < FL_ROWS; ++i) {
    ivec2 pixel = tile_pixel(i);
    if (!in_picture(pixel)) continue;
    vec3 color = vec3(0.0);
    uint which = surface[i].which;
    if (surface[i].kind == kBox) {
      float form = work_light(surface[i].normal, offset_m[i]);
      color = boxes[which].albedo.rgb / kPi * (illuminance_lx[i] + params.work_lx * form);
    } else if (surface[i].kind == kObject) {
      vec3 albedo = vec3((uvec3(which) >> uvec3(20, 10, 0)) & 1023u) / 1023.0;
      float form = work_light(surface[i].normal, offset_m[i]);
      color = albedo / kPi * (illuminance_lx[i] + params.ambient_lx * (form - 1.0) + params.work_lx * form);
    } else if (surface[i].kind == kBody) {
      vec3 ray = normalize(offset_m[i]);
      float form = work_light(surface[i].normal, offset_m[i]);
      color = vec3(kBodyAlbedo / kPi) *
              (illuminance_lx[i] + params.ambient_lx * (form - 1.0) + params.work_lx * form);
      if ((which & uint(FL_PART_LENS)) != 0u) {
        color += lens_radiance(which >> 3, surface[i].t_m, ray, surface[i].normal);
      }
    }
    if (kExtinction) color *= exp(-medium.extinction_per_m * surface[i].t_m);
    if (kView == uint(FL_VIEW_LUX)) color = surface[i].kind != kNothing ? illuminance_lx[i] : vec3(0.0);
    if (kShowsClasses) color = vec3(0.0);
    imageStore(radiance, pixel, vec4(color, surface[i].t_m));
  }
}
