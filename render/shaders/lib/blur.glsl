// Depth of field: what a point at a distance becomes before a sensor of 24 mm height (shared by blurtiles.comp and
// blur.comp).
layout(push_constant) uniform Push {
  float f_stop;
  float focus_m;
} push;

// The radius in pixels, below 0 for what is nearer than the focus. t_m: along the ray through the middle of a pixel.
float blur_px(uvec2 pixel, float t_m) {
  vec3 ray = ray_through(vec2(pixel) + 0.5);  // 1 deep
  float depth_m = max(t_m * inversesqrt(dot(ray, ray)), 0.01);
  float half_height = length(params.up.xyz);
  float aperture_m = 0.5 * 0.012 / (half_height * push.f_stop);
  float px = aperture_m * (1.0 / push.focus_m - 1.0 / depth_m) * 0.5 * float(params.height) / half_height;
  return clamp(px, -float(FL_BLUR_PX_MAX), float(FL_BLUR_PX_MAX));
}
