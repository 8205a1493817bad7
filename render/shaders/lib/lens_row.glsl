// The splats of small lenses. After frame.glsl.
layout(set = 0, binding = FL_BINDING_LENSES, std430) FL_LENSES_ACCESS buffer LensesBuffer {
  LensesHead lenses_head;
  LensRow lenses[];
};

// A disc with a soft edge, a pixel wide: 1 inside of the ellipse, 0 outside. away: from its middle, in pixels.
float lens_weight(LensRow row, vec2 away) {
  float square = row.shape.x * away.x * away.x + 2.0 * row.shape.y * away.x * away.y + row.shape.z * away.y * away.y;
  return clamp(0.5 + row.color.w * (1.0 - sqrt(max(square, 0.0))), 0.0, 1.0);
}
// What it adds to a pixel. shown_m: distance along the ray of what the pixel shows.
vec3 lens_splat(LensRow row, vec2 center, float shown_m) {
  return shown_m < row.place.z ? vec3(0.0) : row.color.rgb * lens_weight(row, center - row.place.xy);
}
