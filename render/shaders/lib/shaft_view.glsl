// A pixel's ray, and how it changes from pixel to pixel. After frame.glsl.
struct View {
  vec3 ray;     // unit
  vec3 step_x;  // of it, a pixel to the right
  vec3 step_y;
};

View view_of(uvec2 pixel) {
  vec3 through = ray_through(vec2(pixel) + 0.5);
  float size = length(through);
  View view;
  view.ray = through / size;
  view.step_x = params.right.xyz * (2.0 / float(params.width));
  view.step_y = params.up.xyz * (-2.0 / float(params.height));
  view.step_x = (view.step_x - view.ray * dot(view.ray, view.step_x)) / size;
  view.step_y = (view.step_y - view.ray * dot(view.ray, view.step_y)) / size;
  return view;
}
