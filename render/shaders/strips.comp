#version 460
// Displays that are thin in the picture: adds their pixels by the share of each pixel of the picture that they cover.
// After the edges, which would weight the light of displays with a case by their share once more.
#extension GL_GOOGLE_include_directive : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/surface.glsl"
#define FL_CELLS_ACCESS readonly
#include "render/shaders/lib/display_cells.glsl"
#include "render/shaders/lib/display_pixels.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= int(params.width) || pixel.y >= int(params.height)) return;
  PixelRay ray = pixel_ray(pixel);
  vec3 sum = vec3(0.0);
  float end_m = 0.0;  // of the ray, once it is needed
  for (uint i = 0u; i < uint(displays.length()); ++i) {
    ShownPart part = shown_part(displays[i], ray);
    if (!part.is_shown || !part.is_thin) continue;
    if (end_m == 0.0) end_m = surface_at(pixel, ray.way).t_m;
    if (!is_hidden(part, end_m)) sum += light_of_part(displays[i], part);
  }
  if (sum == vec3(0.0)) return;
  vec4 behind = imageLoad(radiance, pixel);
  imageStore(radiance, pixel, vec4(behind.rgb + sum, behind.a));
}
