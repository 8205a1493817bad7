// The pixels of displays in a pixel of the picture. After surface.glsl and display_cells.glsl.
layout(constant_id = FL_SPEC_EXTINCTION) const bool kExtinction = false;
layout(constant_id = FL_SPEC_DETAIL) const bool kDetail = true;  // means over pixels of the picture

const float kPlane = 1e-5;       // of the distance: surfaces of one plane are off it by no more
const float kThinPx = 2.0;       // a display thinner than this is drawn by the share of pixels that it covers
const float kCaseM = 1e-3;       // half of what its case is behind it

float extinction() { return kExtinction ? params.position.w : 0.0; }

// The unit ray through a pixel's middle, and what it changes by a pixel to the right and down.
struct PixelRay {
  vec3 way;
  vec3 step_x;
  vec3 step_y;
};
PixelRay pixel_ray(ivec2 pixel) {
  vec3 through = ray_through(vec2(pixel) + 0.5);
  float size = length(through);
  vec3 way = through / size;
  vec3 step_x = params.right.xyz * (2.0 / float(params.width));
  vec3 step_y = params.up.xyz * (-2.0 / float(params.height));
  return PixelRay(way, (step_x - way * dot(way, step_x)) / size, (step_y - way * dot(way, step_y)) / size);
}

// What a pixel of the picture shows of a display: a rectangle of it, in pixels of the display.
struct ShownPart {
  bool is_shown;
  bool is_thin;  // the display is thinner than kThinPx there: `whole` is the pixel, also where the display is not
  float t_m;     // along the ray
  vec2 at;
  vec2 low;
  vec2 high;
  float whole;  // the light is the sum over the rectangle, over this
};

ShownPart shown_part(DisplayRow row, PixelRay ray) {
  ShownPart part = ShownPart(false, false, 0.0, vec2(0.0), vec2(0.0), vec2(0.0), 1.0);
  vec3 eye = in_display(row, params.position.xyz - row.center.xyz);
  vec3 way = in_display(row, ray.way);
  if (!(eye.z > 0.0 && way.z < -1e-6)) return part;
  part.t_m = eye.z / -way.z;
  vec2 size = vec2(row.columns, row.rows);
  vec2 scale = 0.5 * size / vec2(row.right.w, row.down.w);  // pixels a metre
  part.at = (eye.xy + way.xy * part.t_m) * scale + 0.5 * size;
  bool inside = all(greaterThanEqual(part.at, vec2(0.0))) && all(lessThan(part.at, size));
  part.is_shown = inside;
  if (!kDetail) return part;
  vec3 step_x = in_display(row, ray.step_x);
  vec3 step_y = in_display(row, ray.step_y);
  vec2 right = (step_x.xy - way.xy * (step_x.z / way.z)) * (part.t_m * scale);
  vec2 down = (step_y.xy - way.xy * (step_y.z / way.z)) * (part.t_m * scale);
  vec2 foot = max(abs(right) + abs(down), 1e-3);
  part.low = part.at - 0.5 * foot;
  part.high = part.at + 0.5 * foot;
  bool touches = all(lessThan(part.low, size)) && all(greaterThan(part.high, vec2(0.0)));
  vec2 thick = size / foot;
  part.is_thin = min(thick.x, thick.y) < kThinPx;
  part.is_shown = touches && (part.is_thin || inside);
  part.low = clamp(part.low, vec2(0.0), size);
  part.high = clamp(part.high, vec2(0.0), size);
  vec2 whole = part.is_thin ? foot : part.high - part.low;
  part.whole = max(whole.x * whole.y, 1e-12);
  return part;
}

// end_m: where the ray ends.
bool is_hidden(ShownPart part, float end_m) { return part.t_m > end_m * (1.0 + kPlane) + kCaseM; }

// cd/m^2, of a part that is shown.
vec3 light_of_part(DisplayRow row, ShownPart part) {
  vec3 light = row.light.rgb * exp(-extinction() * part.t_m);
  if (!kDetail) return light * read_pixel(row, min(uvec2(part.at), uvec2(row.columns, row.rows) - 1u));
  return light * covered(row, part.low, part.high) / part.whole;
}
