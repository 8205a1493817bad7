#version 460
// The table of haze that is not even: for rays from the camera through the nodes of a grid over the picture, how much
// more haze than even haze is on the ray up to each of FL_HAZE_SLICES distances (lib/haze.glsl). A thread a ray.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_HAZE
#define FL_HAZE_WRITE
#include "render/shaders/lib/frame.glsl"

layout(local_size_x = FL_GROUP_HAZE) in;

void main() {
  uint node = gl_GlobalInvocationID.x;
  if (node >= uint(FL_HAZE_X * FL_HAZE_Y)) return;
  uvec2 at = uvec2(node % uint(FL_HAZE_X), node / uint(FL_HAZE_X));
  vec2 picture = vec2(float(params.width), float(params.height));
  vec3 ray = ray_through(vec2(at) / vec2(FL_HAZE_X - 1, FL_HAZE_Y - 1) * picture);
  float ray_length = length(ray);
  ray /= ray_length;
  // Cubes down to 1.4 sides of a cell count in full, since the smallest ones decide the error (numerics.md).
  float across = 1.4 * max(length(params.right.xyz) / float(FL_HAZE_X - 1),
                           length(params.up.xyz) / float(FL_HAZE_Y - 1));
  float blur = across / ray_length;
  float sum = 0.0;
  float last_m = haze_distance(0.0);
  for (uint k = 0u; k < uint(FL_HAZE_SLICES); ++k) {
    float next_m = haze_distance(float(k + 1u) / float(FL_HAZE_SLICES));
    float middle_m = 0.5 * (last_m + next_m);
    float density = haze_density(haze_field, params.position.xyz + ray * middle_m, blur * middle_m);
    float next = sum + (density - 1.0) * (next_m - last_m);
    imageStore(haze_table, ivec3(at, k), vec4(sum, next, 0.0, 0.0));
    sum = next;
    last_m = next_m;
  }
}
