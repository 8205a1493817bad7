#version 460
// VR Stage Lighting's projected spot as a style of pictures, added to what surfaces have: colour and gobo of a beam
// times the surface's own colour, whatever way it faces, darker with the third power of the distance. On the axis, 6 m
// from the lens, it is as bright as the beam's illuminance.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS readonly
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_USE_MASKS
#define FL_MASKS_ACCESS readonly
#include "render/rivals/shaders/lib/rival_light.glsl"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/albedo.glsl"
#include "render/rivals/shaders/lib/vrsl_zoom.glsl"
#include "render/rivals/shaders/lib/beam_walk.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX / FL_ROWS) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

const float kEqualM = 6.0;

// Its brightness at a distance from the lens; width: of its cone, 0 to 4.
float spot_law(float distance_m, float width) {
  float slower_m = mix(0.6 * distance_m + 0.65, distance_m, clamp(width, 0.0, 1.0));
  return 3.0 / (distance_m * 0.006 * slower_m * slower_m);
}

// lx. place_m: from the camera.
vec3 spot(BeamRow row, uint index, BeamShape shape, vec3 place_m) {
  vec3 p = row.eye.xyz + to_light(row, place_m);
  float distance_m = length(p);
  if (!(p.z > 0.0) || distance_m < 0.165) return vec3(0.0);
  vec2 rho = p.xy / (row.x_axis.w + row.y_axis.w * p.z);
  float r = length(rho);
  if (r >= 1.0) return vec3(0.0);
  vec2 ignored;
  float ignored_m;
  float equal = beam_illuminance(shape, vec3(0.0, 0.0, kEqualM), ignored, ignored_m);
  float width = 4.0 * vrsl_zoom(row);
  vec3 light = row.j0.rgb * (equal * spot_law(distance_m, width) / spot_law(kEqualM, width) * (1.0 - pow(r, 1.99)));
  if (kBlades && (row.flags & FL_BEAM_BLADES) != 0u) light *= blades_at(index, rho, p.z);
  if (has_gobo(row)) light *= gobo_on_surface(row.gobo, rho, p.z);
  return light;
}

void main() {
  Surface hit[FL_ROWS];
  vec3 place_m[FL_ROWS];
  vec3 total[FL_ROWS];
  for (int i = 0; i < FL_ROWS; ++i) {
    ivec2 pixel = tile_pixel(i);
    vec3 ray = normalize(ray_through(vec2(pixel) + 0.5));
    hit[i] = Surface(kNothing, 0u, vec3(0.0, 0.0, 1.0), kNothingM, 0u);
    if (in_picture(pixel)) hit[i] = surface_at(pixel, ray);
    place_m[i] = ray * hit[i].t_m;
    total[i] = vec3(0.0);
  }
  for (uint word = 0u; word < walk_words();) {
    word = tile_walk(word);
    FL_WALK_BEGIN(number, index, walk_bits[walk_w])
      BeamRow row = beams[index];
      BeamShape shape = begin_beam(row, index);
      for (int i = 0; i < FL_ROWS; ++i) {
        if (hit[i].kind != kNothing) total[i] += spot(row, index, shape, place_m[i]);
      }
    FL_WALK_END
  }
  for (int i = 0; i < FL_ROWS; ++i) {
    ivec2 pixel = tile_pixel(i);
    if (!in_picture(pixel) || hit[i].kind == kNothing) continue;
    vec4 behind = imageLoad(radiance, pixel);
    vec3 color = behind.rgb + albedo_of(hit[i]) / 3.141592653589793 * total[i];
    imageStore(radiance, pixel, vec4(color, behind.a));
  }
}
