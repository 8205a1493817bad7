#version 460
// Blurred copies of a gobo (lib/gobo_blurs.glsl). A thread has one texel: four discs around it, of texels of a level of
// detail of the image.
#extension GL_GOOGLE_include_directive : require
#define FL_GOBO_TABLES_ACCESS readonly
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/profile_index.glsl"
#include "render/shaders/lib/gobo_tables.glsl"
#include "render/shaders/lib/gobo_queue.glsl"
#include "render/shaders/lib/gobo_blurs.glsl"

layout(local_size_x = FL_GROUP_GOBOS) in;
layout(set = 0, binding = FL_BINDING_GOBOS) uniform sampler2DArray gobo_images;
layout(set = 0, binding = FL_BINDING_GOBO_BLURS_OUT, rgba16f) uniform writeonly image2DArray blurs_out;

// Radii of the discs in texels of the image: 2^(i/3) times 4 on the first two levels, times 8 on the others, where it
// costs little: with 4 the error of the chords nearest to a lens is three times as large. The level of detail is a mean
// over squares, the edge of the disc a ramp a texel wide, and a look between the texels of the copy is a mean again.
// The variance of these three is taken off the disc's, which is a quarter of the radius squared.
void main() {
  uint image = gobo_jobs[2u * gobo_queue.capacity + uint(FL_GATES_MAX) + gl_WorkGroupID.z];
  uvec2 texel = gl_GlobalInvocationID.xy;
  uint level = min(texel.x / uint(FL_GOBO_BLUR_PX), 2u);
  while (level >= 2u && level + 1u < uint(FL_GOBO_BLUR_LEVELS) && texel.y >= blur_corner(level + 1u).y) ++level;
  float side = float(blur_side(level));
  vec2 at = vec2(texel - blur_corner(level)) + 0.5;
  if (any(greaterThan(at, vec2(side)))) return;
  bool fine = level >= 2u;
  float image_side = fine ? side : float(uint(FL_GOBO_BLUR_PX) >> level);
  float radius = fine ? 8.0 : 4.0;
  int reach = fine ? 16 : 8;
  float between = image_side / side;
  vec4 radii = radius * exp2(vec4(0.0, 1.0, 2.0, 3.0) / 3.0);
  radii = sqrt(radii * radii - 4.0 * (1.0 / 12.0 + 0.104 + between * between / 6.0));
  // One texel each: a filter would read four. An image with fewer texels than the copy is as even as these.
  int mip = int(log2(max(float(textureSize(gobo_images, 0).x) / image_side, 1.0)) + 0.5);
  int last = textureSize(gobo_images, mip).x - 1;
  float texels = float(last + 1) / image_side;
  vec2 middle = at * between;
  vec2 nearest = floor(middle) + 0.5;
  vec4 red = vec4(0.0);
  vec4 green = vec4(0.0);
  vec4 blue = vec4(0.0);
  vec4 all = vec4(0.0);
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      vec2 p = nearest + vec2(x, y);
      vec4 share = clamp(radii - distance(p, middle) + 0.5, 0.0, 1.0);
      if (share.w == 0.0) continue;
      ivec2 there = clamp(ivec2(floor(p * texels)), 0, last);
      vec3 through = texelFetch(gobo_images, ivec3(there, int(image - 1u)), mip).rgb;
      all += share;
      red += share * through.r;
      green += share * through.g;
      blue += share * through.b;
    }
  }
  GoboTableRow table = gobo_tables[image - 1u];
  int layer = int(table.blurs) - 1;
  imageStore(blurs_out, ivec3(texel, layer), red / all);
  if (table.planes == 1u) return;
  imageStore(blurs_out, ivec3(texel, layer + 1), green / all);
  imageStore(blurs_out, ivec3(texel, layer + 2), blue / all);
}
