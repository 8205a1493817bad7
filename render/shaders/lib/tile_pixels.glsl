// The pixels of a workgroup of FL_PIXEL_THREADS threads with FL_FINE_PX x FL_FINE_PX of them. A thread has FL_ROWS, one
// below the other, so that a record is read once for all of them; neighbours in a subgroup are neighbours in the
// picture. After thread_number.glsl.
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform image2D radiance;
#ifndef FL_PIXEL_THREADS
#define FL_PIXEL_THREADS FL_GROUP_TILE
#endif
#define FL_ROWS (FL_FINE_PX * FL_FINE_PX / FL_PIXEL_THREADS)

// This thread's first pixel, from the group's corner; the others are below it.
uvec2 first_pixel() {
  uint number = thread_number();
  const uint kPart = uint(FL_PIXEL_THREADS / 4);  // threads of a quarter
  uint quarter = number / kPart;
  return uvec2((quarter & 1u) * 16u + (number & 15u), (quarter >> 1) * 16u + (number % kPart / 16u) * uint(FL_ROWS));
}
// Its middle, from the group's middle.
vec2 first_place() { return vec2(first_pixel()) + 0.5 - 0.5 * float(FL_FINE_PX); }

// Adds light over sigma_s to this thread's pixels.
void add_to_pixels(vec3 total[FL_ROWS]) {
  ivec2 first = ivec2(gl_WorkGroupID.xy * uint(FL_FINE_PX) + first_pixel());
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
    ivec2 pixel = first + ivec2(0, i);
    if (pixel.x >= int(params.width) || pixel.y >= int(params.height)) continue;
    vec4 behind = imageLoad(radiance, pixel);  // its distance stays for the beam pass
    imageStore(radiance, pixel, vec4(behind.rgb + light_scale() * total[i], behind.a));
  }
}

// 1 / depth of what this thread's pixel number i shows, 1/m.
float pixel_per_depth(int i) {
  uvec2 pixel = min(gl_WorkGroupID.xy * uint(FL_FINE_PX) + first_pixel() + uvec2(0, i),
                    uvec2(params.width, params.height) - 1u);
  return length(ray_through(vec2(pixel) + 0.5)) / imageLoad(radiance, ivec2(pixel)).a;
}
