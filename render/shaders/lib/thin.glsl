// Beams thinner than a pixel. A pixel is one ray, and rays pass between thin beams: a laser of 4 mm breaks into dots.
// Where a beam's radius is below FL_THIN_RADIUS_PX pixels it is drawn that wide, and as much weaker: the light of each
// of its cross sections stays the same. Wider beams are not touched. beam_thin() is that radius over the depth;
// 0: the beam is nowhere so thin, or the frame does not widen. After beam.h and tile_test.glsl.
//
// The wide cross section is (1 - rho^2)^3, whose mean square radius is compared with the beam's own. Sums of pixels
// across it are within 0.8 % of its light wherever it lies between them, sums over a spot on a surface within 1.4 %
// (tests/render/thin_test.cpp). Beams with gobos, blades, an iris, measured light or rectangles keep their own cross
// section. In the haze each side of a rectangle is widened by itself.

// Mean of rho^2 over the light of the profile m, and over that of (1 - rho^2)^3.
float mean_square_radius(float profile_power) {
  if (profile_power < 1.0) return profile_power / (1.0 + 2.0 * profile_power);
  return (profile_power + 1.0) / (2.0 * profile_power + 4.0);
}
const float kThinMeanSquare = 0.2;
const float kThinProfileM = 1.0 / 3.0;

// Spread up to which the flux factor is taken as pi m / (m + 1), times the slant of the mean radius. Up to there it is
// within 6e-4 of the integral, for every profile.
const float kThinNarrow = 0.3;

// Returns the factor of J0 that keeps the flux when the cross section becomes (1 - rho^2)^3.
float thin_gain(float profile_power, float spread) {
  float k2 = spread * spread;
  if (FL_NEED_WIDE && spread > kWideSpread) {
    return wide_flux_factor(spread, profile_power, 1.0) / wide_flux_factor(spread, kThinProfileM, 1.0);
  }
  if (spread > kThinNarrow) {
    return round_flux_factor(spread, profile_power, 1.0) / round_flux_factor(spread, kThinProfileM, 1.0);
  }
  float own = profile_power / (profile_power + 1.0) * pow(1.0 + k2 * mean_square_radius(profile_power), -1.5);
  return own / (0.25 * pow(1.0 + k2 * kThinMeanSquare, -1.5));
}

// Whether the cross section may be replaced.
bool thin_is_plain(BeamRow row, bool gobo) {
  return !gobo && (row.flags & FL_BEAM_BLADES) == 0u && row.j0.w == 0.0 && row.measured == 0u &&
         row.squeeze == 0.0;
}

// The radius that a thin beam gets, over its depth in the picture. Half the side of a square is less than its radius.
float thin_reach(BeamRow row) {
  return beam_thin(row) * (row.squeeze > 0.0 ? 1.4142135623730951 : 1.0);
}

// Widest beam that is widened in the haze: k = tan(5.7 degrees).
const float kThinInHazeSpread = 0.1;

// Whether a marked beam is widened in the haze. The widening of the whole beam follows from the place where a ray is
// nearest its axis. That holds for narrow beams that the eye stands outside of: a ray in a wide cone, or from inside
// the light, meets the beam at places of very different width, most of them wider than a pixel.
bool thin_in_haze_applies(BeamRow row) {
  float at_eye = row.x_axis.w + row.y_axis.w * row.eye.z;
  bool holds_eye = row.eye.z > 0.0 && dot(row.eye.xy, row.eye.xy) < at_eye * at_eye;
  return beam_thin(row) > 0.0 && row.y_axis.w <= kThinInHazeSpread && !holds_eye;
}

// Widens a rectangle: half its width and half its height become `wide` where they are less. Both are times sqrt(2), as
// `own` is, half its width. Its light space gets the new ratio of the sides, with the eye and the ray in it. Returns
// the factor of the beam's light.
float thin_rectangle(inout BeamShape beam, inout vec3 eye, inout vec3 d, float own, float wide) {
  float flat_by = sqrt(beam.squeeze);
  if (!(wide > own * min(flat_by, 1.0))) return 1.0;
  float width = max(own, wide);
  float gain = flat_by * width / max(own * flat_by, wide);  // the new ratio of the sides over the old
  beam.lens_radius_m += width - own;
  beam.squeeze /= gain * gain;
  eye.y *= gain;
  d.y *= gain;
  return gain;
}

// The beam's radius where a ray is nearest its axis, and the radius that a thin beam gets there. eye, d: the ray in
// light space. depth: depth per metre along the ray.
void thin_meets(BeamShape beam, BeamRow row, vec3 eye, vec3 d, float depth, float t_max_m, out float own,
                out float wide) {
  float across = dot(d.xy, d.xy);
  float t_m = -dot(eye.xy, d.xy) / max(across, 1e-12);
  float z = clamp(eye.z + t_m * d.z, 0.0, beam.range_m);
  t_m = clamp(((z - eye.z) * d.z - dot(eye.xy, d.xy)) / dot(d, d), 0.0, t_max_m);
  own = beam.lens_radius_m + beam.spread * z;
  wide = thin_reach(row) * t_m * depth;
}

// How many times its own radius a beam must become before it is widened.
float thin_scale(BeamShape beam, bool plain) {
  return plain ? sqrt(mean_square_radius(beam.profile_power) / kThinMeanSquare) : 1.0;
}

// Widens the beam as the pixel's ray meets it in the haze. eye, d: the ray in light space. d is a metre long, but not
// in the stretched light space of a rectangle. depth: depth per metre along the ray. Returns the factor of the beam's
// light.
float thin_in_haze(inout BeamShape beam, BeamRow row, inout vec3 eye, inout vec3 d, float depth, float t_max_m,
                   bool plain) {
  float own;
  float wide;
  thin_meets(beam, row, eye, d, depth, t_max_m, own, wide);
  if (FL_NEED_RECTANGLE && row.squeeze > 0.0) return thin_rectangle(beam, eye, d, own, wide);
  if (!(wide > own * thin_scale(beam, plain))) return 1.0;
  // With scale < 1 the sum may be negative where the beam is much wider than its lens.
  beam.lens_radius_m = max(beam.lens_radius_m + wide - own, 1e-4);
  if (!plain) return 1.0;
  float gain = thin_gain(beam.profile_power, beam.spread);
  beam.profile_power = kThinProfileM;
  return gain;
}

// The same on a surface, where the footprint of a pixel is an ellipse. p: the place in light space; step_x, step_y: how
// it moves for FL_THIN_RADIUS_PX pixels across the picture and up. Returns the illuminance as beam_illuminance() does.
float thin_on_surface(BeamShape beam, vec3 p, vec3 step_x, vec3 step_y, bool plain, out vec2 rho, out float r_m) {
  float w = max(beam.lens_radius_m + beam.spread * p.z, 1e-9);
  rho = p.xy / w;
  float scale = thin_scale(beam, plain);
  // Outside the cone the footprint is that of the nearest place on its edge: rho has no bound there.
  vec2 at = rho / max(length(rho), 1.0);
  vec2 a = (step_x.xy - at * beam.spread * step_x.z) / w;
  vec2 b = (step_y.xy - at * beam.spread * step_y.z) / w;
  if (FL_NEED_RECTANGLE && beam.squeeze > 0.0) {  // half the side of a square is less than its radius
    a *= 1.4142135623730951;
    b *= 1.4142135623730951;
  }
  // The ellipse that the footprint's unit circle becomes in the gobo plane: its axes, squared.
  float xx = a.x * a.x + b.x * b.x;
  float xy = a.x * a.y + b.x * b.y;
  float yy = a.y * a.y + b.y * b.y;
  float mean = 0.5 * (xx + yy);
  float root = sqrt(max(mean * mean - (xx * yy - xy * xy), 0.0));
  float longest = mean + root;
  if (!(longest > scale * scale)) return beam_illuminance(beam, p, rho, r_m);
  float gain = 1.0;
  if (plain) {
    gain = thin_gain(beam.profile_power, beam.spread);
    beam.profile_power = kThinProfileM;
  }
  vec2 radius = sqrt(max(vec2(longest, max(mean - root, 0.0)), vec2(scale * scale)));
  float angle = 0.5 * atan(2.0 * xy, xx - yy + 1e-30);
  vec2 axis = vec2(cos(angle), sin(angle));
  vec2 side = vec2(-axis.y, axis.x);
  rho = axis * (dot(axis, rho) / radius.x) + side * (dot(side, rho) / radius.y);
  float q = dot(rho, rho);
  float u = beam_slant_square(beam, rho, q);
  r_m = p.z * sqrt(u);
  if (!(p.z > 0.0) || p.z > beam.range_m || !(q < 1.0)) return 0.0;
  return gain * beam_value(beam, rho, q) / (w * w * u * radius.x * radius.y);
}
