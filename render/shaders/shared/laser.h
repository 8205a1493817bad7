// The light of a scanned laser, in closed form: docs/decisions/0130. C++ and GLSL; rules in sim/shared/real.h. After
// phase_function() of beam.h.
//
// A beam is a Gaussian across: variance sigma^2 + slope^2 r^2 at the distance r from where it leaves. A sheet is a beam
// that goes evenly through the directions first + tau second (not normalised), tau from 0 to reach. A pixel is a
// Gaussian as well: of the picture, with the variance kLaserPixel of the square of a pixel. So what a pixel sees of a
// beam is a Gaussian of the distance of its ray from the beam, and a sheet is a difference of two error functions.

FL_CONST float kLaserPixel = 0.36f;

struct LaserSheet {
  Vec3 first;
  Vec3 second;
  Real reach;   // tangent of the angle between its first and its last beam; 0: a single beam
  Real spread;  // reach over that angle
  Vec3 eye;     // the camera, from where the light leaves, m
  Vec3 cross_1;  // first x eye
  Vec3 cross_2;
  Real variance;  // m^2
  Real slope_square;
  Real jump;    // tau at which the ends jump
  Real end[4];  // sqrt(1 + tau^2) over the length of the beam: at 0, on both sides of the jump, at reach; 1/m
};

// A ray of depth 1 and how it changes from pixel to pixel.
struct LaserPixel {
  Vec3 ray;
  Vec3 step_x;
  Vec3 step_y;
};

// Integral of the normal distribution up to z. Abramowitz and Stegun 7.1.26: within 8e-8.
FL_FN Real normal_below(Real z) {
  Real x = min(abs(z), Real(6)) * Real(0.7071067811865476);
  Real t = Real(1) / (Real(1) + Real(0.3275911) * x);
  Real tail = Real(1.421413741) + t * (Real(-1.453152027) + t * Real(1.061405429));
  tail = t * (Real(0.254829592) + t * (Real(-0.284496736) + t * tail));
  tail = Real(0.5) * tail * exp(-x * x);
  return z < Real(0) ? tail : Real(1) - tail;
}
FL_FN Real normal_at(Real z) { return Real(0.3989422804014327) * exp(Real(-0.5) * min(z * z, Real(80))); }

// Mean of the normal density between two places.
FL_CONST float kNormalNear = 0.6f;  // places that are nearer to each other than this: by a series
FL_FN Real normal_share(Real from, Real to) {
  Real way = to - from;
  Real at = Real(0.5) * (from + to);
  if (abs(way) >= Real(kNormalNear)) {
    // In the lower tail, where the difference is exact.
    Real share = at > Real(0) ? normal_below(-from) - normal_below(-to) : normal_below(to) - normal_below(from);
    return max(share / way, Real(0));
  }
  Real square = min(at * at, Real(80));
  Real w = way * way;
  Real fourth = (square * square - Real(6) * square + Real(3)) * Real(0.0005208333333333333);
  return normal_at(at) * (Real(1) + w * ((square - Real(1)) * Real(0.041666666666666664) + w * fourth));
}

// The same, and where between them its middle is, 0 to 1.
FL_FN Real normal_mean(Real from, Real to, FL_OUT(Real) middle) {
  Real way = to - from;
  Real mean = normal_share(from, to);
  if (abs(way) < Real(kNormalNear)) {
    middle = clamp(Real(0.5) - Real(0.5) * (from + to) * way * Real(0.08333333333333333), Real(0), Real(1));
    return mean;
  }
  Real share = mean * way;
  // In a tail the middle is at the end that is nearer.
  Real z = abs(share) > Real(1e-5) ? (normal_at(from) - normal_at(to)) / share : (abs(from) < abs(to) ? from : to);
  middle = clamp((z - from) / way, Real(0), Real(1));
  return mean;
}

// Length of the beam at tau.
FL_FN Real laser_length(FL_IN(LaserSheet) sheet, Real tau) {
  bool after = tau > sheet.jump;
  Real from = after ? sheet.jump : Real(0);
  Real to = after ? sheet.reach : sheet.jump;
  Real share = to > from ? clamp((tau - from) / (to - from), Real(0), Real(1)) : Real(0);
  Real end = after ? mix(sheet.end[2], sheet.end[3], share) : mix(sheet.end[0], sheet.end[1], share);
  return sqrt(Real(1) + tau * tau) / max(end, Real(1e-9));
}

// Light that a place of a beam sends along a ray, over sigma_s and its illuminance: phase function, extinction, haze.
#ifdef __cplusplus
#define FL_WITH_CLOUDS [[maybe_unused]]  // C++ has no clouds here
#else
#define FL_WITH_CLOUDS
#endif
FL_FN Real laser_scatter(Real cosine, Real t_m, Real r_m, FL_WITH_CLOUDS Real haze_m, Real anisotropy,
                         Real extinction_per_m, bool with_extinction) {
  Real value = phase_function(cosine, anisotropy);
  if (with_extinction) value *= exp(-extinction_per_m * (t_m + r_m));
#ifdef FL_HAZE_FIELD
  value *= haze_mean(max(t_m - haze_m, Real(0)), t_m + haze_m);
#endif
  return value;
}
#undef FL_WITH_CLOUDS

// A vector from the eye as x, y in pixels from the pixel's middle, times its depth; z: its depth.
FL_FN Vec3 laser_picture(FL_IN(LaserPixel) pixel, Vec3 v) {
  Vec3 forward = cross(pixel.step_x, pixel.step_y);
  Real depth = dot(v, forward) / dot(pixel.ray, forward);
  Vec3 aside = v - pixel.ray * depth;
  return Vec3(dot(aside, pixel.step_x) / dot(pixel.step_x, pixel.step_x),
              dot(aside, pixel.step_y) / dot(pixel.step_y, pixel.step_y), depth);
}

// The picture of a beam is a line that is even in w, one over the depth: `gone` + w `way`, in pixels from the pixel.
struct LaserLine {
  Vec2 gone;  // where the beam goes to, infinitely far away
  Vec2 way;
  Real depth_m;  // of where it leaves
  Real deeper;   // change of the depth along the beam
};
FL_FN LaserLine laser_line(FL_IN(LaserSheet) sheet, FL_IN(LaserPixel) pixel, Vec3 beam) {
  Vec3 from = laser_picture(pixel, sheet.eye * Real(-1));
  Vec3 along = laser_picture(pixel, beam);
  LaserLine line;
  line.depth_m = from.z;
  line.deeper = abs(along.z) > Real(1e-6) ? along.z : Real(1e-6);
  line.gone = Vec2(along.x / line.deeper, along.y / line.deeper);
  line.way = Vec2(from.x - line.gone.x * from.z, from.y - line.gone.y * from.z);
  return line;
}

FL_FN Real laser_arsinh(Real x) { return log(x + sqrt(x * x + Real(1))); }

FL_CONST uint kLaserPanels = uint(3);
FL_CONST uint kLaserNodes = uint(6);  // of each panel
FL_CONST float kLaserNearest = 0.001f;  // depth, m: light that is nearer to the eye is left out
// So many pixels around the place where a beam goes to, its depth changes with the pixels: it is summed along itself.
FL_CONST float kLaserGonePx = 100.0f;

// What a pixel sees of a sheet in the air.
struct LaserAir {
  Real light;    // over sigma_s and the flux; 1/(m sr)
  Real smooth_light;  // the same over scale and the mean of the normal density between the sheet's edges; not of
                      // beams that are seen nearly along themselves
  bool is_along;      // it is such a beam
  Real lit;           // the share of the light that is on the beam, in front of the eye and before t_max_m
  Real scale;    // one over the deviation of what the pixel sees, of places of dot(ray, sheet.cross_1 + tau cross_2)
  Real near_m;   // depths between which all but 1e-5 of the light is
  Real far_m;
};
FL_CONST float kLaserTail = 4.5f;  // deviations

// Light in the air of the beams of a sheet that are seen nearly along themselves. from_m, to_m: as LaserAir.
FL_FN Real laser_air_along(FL_IN(LaserSheet) sheet, FL_IN(LaserPixel) pixel, LaserLine line, Vec3 beam, Vec3 side,
                           Real angle, Real length_m, Real t_max_m, Real anisotropy, Real extinction_per_m,
                           bool with_extinction, FL_OUT(Real) from_m, FL_OUT(Real) to_m) {
  Real ray_length = length(pixel.ray);
  Real px_1 = length(pixel.step_x);  // of a pixel at a depth of 1 m
  Real px_2 = length(pixel.step_y);
  // The depths of its ends, of what the pixel shows, and of the eye.
  Real end_m = line.depth_m + line.deeper * length_m;
  Real near_m = max(min(line.depth_m, end_m), Real(kLaserNearest));
  Real far_m = min(max(line.depth_m, end_m), t_max_m / ray_length);
  from_m = near_m;
  to_m = far_m;
  if (!(far_m > near_m)) return Real(0);
  Real w_from = Real(1) / far_m;
  Real w_to = Real(1) / near_m;
  Vec3 sideways = laser_picture(pixel, side);
  // What of it the pixel sees: where its picture, and where that of the sheet, is within 4.5 deviations. That of
  // a pixel and the width of the beam, which grows with w, are added.
  Real square = line.way.x * line.way.x + line.way.y * line.way.y;
  Real w_at = w_from;
  if (square > Real(0)) w_at = clamp(-(line.gone.x * line.way.x + line.gone.y * line.way.y) / square, w_from, w_to);
  Real at_m = clamp((Real(1) / w_at - line.depth_m) / line.deeper, Real(0), length_m);
  Real wide_1 = sqrt((sheet.variance + sheet.slope_square * at_m * at_m) / (px_1 * px_2));
  Vec2 at_px = Vec2(line.gone.x + line.way.x * w_at, line.gone.y + line.way.y * w_at);
  Vec2 sweep = Vec2((sideways.x - at_px.x * sideways.z) * at_m * angle,
                    (sideways.y - at_px.y * sideways.z) * at_m * angle);
  Real sweep_1 = sqrt(sweep.x * sweep.x + sweep.y * sweep.y);
  for (uint which = uint(0); which < uint(2); ++which) {
    // Along its own picture; then across the way that it sweeps.
    Vec2 way = line.way;
    Real spare = Real(0.5) * sweep_1;
    if (which == uint(1)) {
      way = sweep_1 > Real(0) ? Vec2(-sweep.y / sweep_1, sweep.x / sweep_1) : Vec2(0, 0);
      spare = Real(0);
    }
    Real speed = line.way.x * way.x + line.way.y * way.y;
    Real size = sqrt(way.x * way.x + way.y * way.y);
    if (!(abs(speed) > Real(1e-9) * size) || !(size > Real(0))) continue;
    Real middle = -(line.gone.x * way.x + line.gone.y * way.y) / speed;
    Real pixels = Real(4.5 * 0.6) * size / abs(speed);
    Real growth = (Real(4.5) * wide_1 + spare) * size / abs(speed);
    w_from = max(w_from, (middle - pixels) / (Real(1) + growth));
    if (growth < Real(0.99)) w_to = min(w_to, (middle + pixels) / (Real(1) - growth));
  }
  if (!(w_to > w_from)) return Real(0);
  // Where the beam, or what it sweeps, becomes wider than a pixel, its light falls as 1 / w or faster: from there on
  // nodes are even in the logarithm.
  Real turn_w = Real(0.6) / max(wide_1 + sweep_1, Real(1e-9));
  Real from = laser_arsinh(w_from / turn_w);
  Real way_x = laser_arsinh(w_to / turn_w) - from;
  Real cosine = dot(pixel.ray, beam) / ray_length;
  Real sum = Real(0);
  for (uint i = uint(0); i < kLaserPanels * kLaserNodes; ++i) {
    uint panel = i / kLaserNodes;
    uint node = kLaserNodes * (kLaserNodes - uint(1)) / uint(2) + i % kLaserNodes;
    Real x = (Real(panel) + Real(kGaussNode[node])) / Real(kLaserPanels);
    Real e = exp(from + way_x * x);
    Real w = clamp(Real(0.5) * turn_w * (e - Real(1) / e), w_from, w_to);
    Real r_m = clamp((Real(1) / w - line.depth_m) / line.deeper, Real(0), length_m);
    Real wide = (sheet.variance + sheet.slope_square * r_m * r_m) * w * w;
    Real sigma = sqrt(Real(kLaserPixel) + wide / (px_1 * px_2));
    Vec2 at = Vec2(line.gone.x + line.way.x * w, line.gone.y + line.way.y * w);
    // The sheet sweeps over the pixel as far as this.
    Real turn = r_m * w * angle;
    Vec2 swept = Vec2((sideways.x - at.x * sideways.z) * turn, (sideways.y - at.y * sideways.z) * turn);
    Real far_px = sqrt(swept.x * swept.x + swept.y * swept.y);
    Vec2 to = far_px > Real(1e-9) ? Vec2(swept.x / far_px, swept.y / far_px) : Vec2(1, 0);
    Real along_px = at.x * to.x + at.y * to.y;
    Real beside_px = at.y * to.x - at.x * to.y;
    Real unused;
    Real seen = normal_mean((along_px - Real(0.5) * far_px) / sigma, (along_px + Real(0.5) * far_px) / sigma, unused) *
                normal_at(beside_px / sigma) / (sigma * sigma);
    Real t_m = ray_length / w;
    Real haze_m = Real(0.25) * (w_to - w_from) / (w * w);
    sum += Real(kGaussWeight[node]) * seen * Real(0.5) * turn_w * (e + Real(1) / e) *
           laser_scatter(cosine, t_m, r_m, haze_m, anisotropy, extinction_per_m, with_extinction);
  }
  return sum * way_x * ray_length / (Real(kLaserPanels) * px_1 * px_2 * abs(line.deeper));
}

// Where a ray and a beam of a sheet are nearest to each other.
struct LaserMeeting {
  Vec3 beam;
  Real root;      // 1 / sqrt(1 + tau^2)
  Real length_m;  // of the beam
  Real along;     // dot(ray, beam)
  Real square;    // of the ray across the beam
  Real ray_at;    // the place, in lengths of the ray
  Real beam_at;   // m
  Real beam_square;  // variance of the light across the beam there, m^2
  Real tx, ty;       // how T, their distance times the root of `square`, changes with the pixel
  Real whole;        // variance of T in what the pixel sees
  Real scale;        // LaserAir
};
FL_FN LaserMeeting laser_meeting(FL_IN(LaserSheet) sheet, FL_IN(LaserPixel) pixel, Real tau) {
  LaserMeeting at;
  at.root = Real(1) / sqrt(Real(1) + tau * tau);
  at.length_m = laser_length(sheet, tau);
  at.beam = (sheet.first + sheet.second * tau) * at.root;
  at.along = dot(pixel.ray, at.beam);
  Vec3 away = pixel.ray - at.beam * at.along;
  at.square = max(dot(away, away), Real(1e-12) * dot(pixel.ray, pixel.ray));
  Real eye_along = dot(sheet.eye, at.beam);
  at.ray_at = -dot(sheet.eye - at.beam * eye_along, away) / at.square;
  at.beam_at = eye_along + at.ray_at * at.along;
  Vec3 normal = (sheet.cross_1 + sheet.cross_2 * tau) * at.root;
  at.tx = dot(pixel.step_x, normal);
  at.ty = dot(pixel.step_y, normal);
  Real at_m = clamp(at.beam_at, Real(0), at.length_m);
  at.beam_square = sheet.variance + sheet.slope_square * at_m * at_m;
  at.whole = max(at.square * at.beam_square + Real(kLaserPixel) * (at.tx * at.tx + at.ty * at.ty), Real(1e-30));
  at.scale = at.root / sqrt(at.whole);
  return at;
}

// Light in the air of a sheet in a pixel up to t_max_m.
FL_FN LaserAir laser_in_air(FL_IN(LaserSheet) sheet, FL_IN(LaserPixel) pixel, Real t_max_m, Real anisotropy,
                            Real extinction_per_m, bool with_extinction) {
  LaserAir air;
  Real c1 = dot(pixel.ray, sheet.cross_1);
  Real c2 = dot(pixel.ray, sheet.cross_2);
  Real ray_square = dot(pixel.ray, pixel.ray);
  Real ray_length = sqrt(ray_square);
  // The beam of the sheet that the ray meets, then the middle of those that the pixel sees.
  Real tau = abs(c2) * sheet.reach > Real(0) ? clamp(-c1 / c2, Real(0), sheet.reach) : Real(0);
  Real share = Real(0);
  LaserMeeting meeting;
  for (uint turn = uint(0); turn < uint(2); ++turn) {
    meeting = laser_meeting(sheet, pixel, tau);
    Real middle;
    share = normal_mean(c1 * meeting.scale, (c1 + c2 * sheet.reach) * meeting.scale, middle);
    if (turn == uint(0)) tau = middle * sheet.reach;
  }
  Vec3 beam = meeting.beam;
  Real root = meeting.root, scale = meeting.scale, length_m = meeting.length_m, along = meeting.along;
  Real square = meeting.square, ray_at = meeting.ray_at, beam_at = meeting.beam_at, whole = meeting.whole;
  Real beam_square = meeting.beam_square, tx = meeting.tx, ty = meeting.ty;
  air.scale = scale;
  LaserLine line = laser_line(sheet, pixel, beam);
  Vec2 gone = line.gone;
  air.is_along = gone.x * gone.x + gone.y * gone.y < Real(kLaserGonePx) * Real(kLaserGonePx);
  if (air.is_along) {
    // Its middle: of a narrow part any beam does.
    Real half_tau = Real(0.5) * sheet.reach;
    Real half_root = Real(1) / sqrt(Real(1) + half_tau * half_tau);
    Vec3 middle = (sheet.first + sheet.second * half_tau) * half_root;
    Vec3 side = (sheet.second - sheet.first * half_tau) * half_root;
    Real angle = sheet.reach / max(sheet.spread, Real(1e-6));
    air.light = laser_air_along(sheet, pixel, laser_line(sheet, pixel, middle), middle, side, angle,
                                laser_length(sheet, half_tau), t_max_m, anisotropy, extinction_per_m, with_extinction,
                                air.near_m, air.far_m);
    air.smooth_light = Real(0);
    air.lit = Real(1);
    return air;
  }
  // How these places move with the pixel; and how far they are spread by the pixel along the picture of the beam, by
  // what is left of it across, and by the width of the beam.
  Real reach = ray_at / square;
  Real bx = reach * (dot(pixel.step_x, beam) * ray_square - dot(pixel.step_x, pixel.ray) * along);
  Real by = reach * (dot(pixel.step_y, beam) * ray_square - dot(pixel.step_y, pixel.ray) * along);
  Real sx = -reach * (dot(pixel.step_x, pixel.ray) - dot(pixel.step_x, beam) * along);
  Real sy = -reach * (dot(pixel.step_y, pixel.ray) - dot(pixel.step_y, beam) * along);
  Real t_square = max(tx * tx + ty * ty, Real(1e-30));
  Real left = Real(kLaserPixel) * square * beam_square / whole;
  Real b_across = bx * tx + by * ty;
  Real s_across = sx * tx + sy * ty;
  Real b_along = bx * ty - by * tx;
  Real s_along = sx * ty - sy * tx;
  Real thick = beam_square / square;
  Real beam_sigma = sqrt(max((Real(kLaserPixel) * b_along * b_along + left * b_across * b_across) / t_square +
                             along * along * thick, Real(1e-20)));
  Real ray_sigma = sqrt(max((Real(kLaserPixel) * s_along * s_along + left * s_across * s_across) / t_square + thick,
                            Real(1e-20)));
  // The light comes from the side of the pixel on which the beam is.
  Real miss = (c1 + c2 * tau) * root * Real(kLaserPixel) / whole;
  beam_at -= miss * b_across;
  ray_at -= miss * s_across;
  air.near_m = ray_at - Real(kLaserTail) * ray_sigma;
  air.far_m = ray_at + Real(kLaserTail) * ray_sigma;
  // Which part of it is on the beam, in front of the eye and before what the pixel shows.
  Real ray_low = normal_below(-ray_at / ray_sigma);
  Real ray_high = normal_below((t_max_m / ray_length - ray_at) / ray_sigma);
  Real beam_low = normal_below(-beam_at / beam_sigma);
  Real beam_high = normal_below((length_m - beam_at) / beam_sigma);
  Real lit = max(min(ray_high, beam_high) - max(ray_low, beam_low), Real(0));
  // At an end of the beam the light comes from the side of the pixel that still has it.
  Real low_z = -beam_at / beam_sigma;
  Real high_z = (length_m - beam_at) / beam_sigma;
  Real of_beam = max(beam_high - beam_low, Real(1e-3));
  Real shift_m = beam_sigma * clamp((normal_at(low_z) - normal_at(high_z)) / of_beam, Real(-3), Real(3));
  Real t_size = sqrt(t_square);
  Real aside_px = Real(kLaserPixel) * b_along / (t_size * beam_sigma * beam_sigma) * shift_m;
  Vec3 ray = pixel.ray + (pixel.step_x * ty - pixel.step_y * tx) * (aside_px / t_size);
  Real aside_length = length(ray);
  Real t_m = clamp((ray_at + s_along / t_size * aside_px) * aside_length, Real(0), min(t_max_m, Real(1e7)));
  Real r_m = clamp(beam_at + shift_m, Real(0), length_m);
  Real haze_m = Real(2) * ray_sigma * ray_length;
  air.lit = lit;
  air.smooth_light = sheet.spread * aside_length * lit * root *
                     laser_scatter(dot(ray, beam) / aside_length, t_m, r_m, haze_m, anisotropy, extinction_per_m,
                                   with_extinction);
  air.light = air.smooth_light * share * scale;
  return air;
}

// Where a beam meets a surface.
struct LaserSpot {
  Real illuminance;  // over the flux, 1/m^2, without extinction
  Real tau;          // of the beam
  Real r_m;          // from where it leaves
};

// Mean of the illuminance over a pixel that shows a place on a plane. place_m: from where the light leaves; depth_m: of
// it from the eye, in lengths of the ray.
FL_FN LaserSpot laser_on_surface(FL_IN(LaserSheet) sheet, FL_IN(LaserPixel) pixel, Vec3 place_m, Real depth_m,
                                 Vec3 normal) {
  LaserSpot spot;
  spot.illuminance = Real(0);
  spot.tau = Real(0);
  spot.r_m = Real(0);
  Real x = dot(place_m, sheet.first);
  Real y = dot(place_m, sheet.second);
  Vec3 aside = cross(sheet.first, sheet.second);
  Real h = dot(place_m, aside);
  if (!(x > Real(0))) return spot;
  Real tau = clamp(y / x, Real(0), sheet.reach);
  Real root = Real(1) / sqrt(Real(1) + tau * tau);
  Vec3 beam = (sheet.first + sheet.second * tau) * root;
  Vec3 side = (sheet.second - sheet.first * tau) * root;
  Real facing = -dot(normal, beam);
  if (!(facing > Real(0))) return spot;
  // Where the beam meets the plane of the place.
  Real r_m = max(-dot(place_m, normal), Real(0)) / max(facing, Real(1e-4));
  spot.tau = tau;
  spot.r_m = r_m;
  // How the place moves with the pixel, out of the sheet and across the beam in it.
  Real against = dot(normal, pixel.ray);
  against = min(against, Real(-0.01) * length(pixel.ray));
  Vec3 move_x = (pixel.step_x - pixel.ray * (dot(normal, pixel.step_x) / against)) * depth_m;
  Vec3 move_y = (pixel.step_y - pixel.ray * (dot(normal, pixel.step_y) / against)) * depth_m;
  Real hx = dot(move_x, aside);
  Real hy = dot(move_y, aside);
  Real vx = dot(move_x, side);
  Real vy = dot(move_y, side);
  Real beam_square = sheet.variance + sheet.slope_square * r_m * r_m;
  Real hh = beam_square + Real(kLaserPixel) * (hx * hx + hy * hy);
  Real hv = Real(kLaserPixel) * (hx * vx + hy * vy);
  Real vv = beam_square + Real(kLaserPixel) * (vx * vx + vy * vy);
  Real h_sigma = sqrt(hh);
  Real v_sigma = sqrt(max(vv - hv * hv / hh, Real(1e-3) * beam_square));
  // Offsets across the first and the last beam, less what h says of them.
  Real shift = hv / hh * h;
  Real from = root * y - shift;
  Real to = root * (y - x * sheet.reach) - shift;
  Real unused;
  Real share = normal_mean(from / v_sigma, to / v_sigma, unused) / v_sigma;
  spot.illuminance = facing * sheet.spread * root * root * share * normal_at(h / h_sigma) / h_sigma;
  return spot;
}
