// Rivals that sample light along the rays of pixels: workgroups, tests of tiles and the walk over beams are those of
// the beam pass (render/shaders/lib/tile_walk.glsl), so that all methods compute the same beams. The shader defines
// air_light(): light over sigma_s between the eye and t_max_m. After rival_light.glsl.
#include "render/rivals/shaders/lib/beam_walk.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX / FL_ROWS) in;
layout(constant_id = FL_SPEC_NODES) const uint kNodes = 16;
layout(constant_id = FL_SPEC_WHOLE_RAY) const bool kWholeRay = false;
layout(set = 0, binding = FL_BINDING_BOUNDS, std430) readonly buffer BoundsBuffer { BoundsRow bounds; };
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

vec3 air_light(BeamRow row, uint index, BeamShape shape, vec3 ray, float t_max_m, uvec2 pixel);

// Where a march along a whole ray ends: at the surface, or where the ray leaves the box of all beams.
float whole_ray_m(vec3 d, float t_max_m) {
  vec3 inverse = 1.0 / mix(d, vec3(1e-12), lessThan(abs(d), vec3(1e-12)));
  vec3 out_m = max(bounds.low.xyz * inverse, bounds.high.xyz * inverse);
  return clamp(min(out_m.x, min(out_m.y, out_m.z)), 0.0, t_max_m);
}

void main() {
  vec3 d[FL_ROWS];
  float t_max_m[FL_ROWS];
  vec3 total[FL_ROWS];
  for (int i = 0; i < FL_ROWS; ++i) {
    ivec2 pixel = tile_pixel(i);
    d[i] = normalize(ray_through(vec2(pixel) + 0.5));
    t_max_m[i] = in_picture(pixel) ? imageLoad(radiance, pixel).a : 0.0;
    if (kWholeRay) t_max_m[i] = whole_ray_m(d[i], t_max_m[i]);
    total[i] = vec3(0.0);
  }
  for (uint word = 0u; word < walk_words();) {
    word = tile_walk(word);
    FL_WALK_BEGIN(number, index, walk_bits[walk_w])
      BeamRow row = beams[index];
      BeamShape shape = begin_beam(row, index);
      for (int i = 0; i < FL_ROWS; ++i) {
        total[i] += air_light(row, index, shape, to_light(row, d[i]), t_max_m[i], uvec2(tile_pixel(i)));
      }
    FL_WALK_END
  }
  for (int i = 0; i < FL_ROWS; ++i) {
    ivec2 pixel = tile_pixel(i);
    if (!in_picture(pixel)) continue;
    vec4 behind = imageLoad(radiance, pixel);
    imageStore(radiance, pixel, vec4(behind.rgb + params.forward.w * total[i], behind.a));
  }
}
