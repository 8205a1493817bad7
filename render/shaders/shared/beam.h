// Light in one beam: the shape of a stage beam, what it puts on a surface and what haze in it sends to the eye.
//
// Light space of a beam: the lens centre at 0, the axis along +z, metres. The beam's radius is w(z) = R0 + k z, with R0
// the lens radius and k the tangent of the half angle; rho = (x, y) / w in the unit disc is the gobo plane. Illuminance
// across the light is E(p) = J0 f(rho) / (w^2 (1 + k^2 rho^2)), with the profile f = 1 - |rho|^(2m), or (1 -
// |rho|^2)^(1/m) for the soft ones, m < 1. J0 is in candela-like units (lm): the flux is J0 times the integral of f (1
// + k^2 rho^2)^(-3/2) over the unit disc.
//
// A camera ray o + t d maps to a straight line in the gobo plane, and dt / w^2 = ds / |V| with constant V, so the
// integral along the ray becomes one over s of a smooth function, which a few Gauss nodes give (the projective beam
// integral). The form (tb - ta) / (wa wb) x mean over s has no singularity: not at the lens, not along the axis, not
// for a cylinder.
//
// A rectangular beam is a square in a light space whose y is stretched by width over height, inscribed in the round
// beam of R0 and k: |x|, |y| <= sqrt(1/2) of rho. Straight lines stay straight, so all of this holds for it; only
// lengths and angles need what `squeeze` says. Its profile is the product of two, f(2 x^2) f(2 y^2).
//
// A measured beam has f from a table (fixtures/shared/measured.h), by the tangent of the angle: I = J0 / k^2 f.
//
// An iris keeps the middle of the beam: R0 and k shrink to its share of the radius, and f is read at (1 - hidden) rho.
//
// Where haze is not even (haze_field.h) the including file provides Real haze_until(Real t_m), the integral of its
// density minus 1 up to a distance along the camera ray, and defines FL_HAZE_FIELD.
//
// Error and cost of each method: docs/numerics.md, printed by `footlight report`. Half angles go up to 87.5 degrees.
// What a picture does not need the including file leaves out: FL_NEED_RECTANGLE, FL_NEED_IRIS, FL_NEED_WIDE, constants,
// true where they are not defined; FL_MEASURED where measured.h is there, with FL_NEED_MEASURED.
// Where gobos are used the including file provides Vec3 gobo_at(uint gobo, Vec2 rho, Real z_m), what they let through
// of red, green and blue at a place in the gate, z_m from the lens, and defines FL_GOBO.

#ifndef FL_NEED_RECTANGLE
#define FL_NEED_RECTANGLE true
#endif
#ifndef FL_NEED_IRIS
#define FL_NEED_IRIS true
#endif
#ifndef FL_NEED_WIDE
#define FL_NEED_WIDE true
#endif

struct BeamShape {
  Real lens_radius_m;  // R0 > 0
  Real spread;         // k = tan(half angle) >= 0
  Real range_m;        // the light ends at this z
  Real profile_power;  // m: 1/4, 1/3, 1/2, 1, 2, 3 or 4
  Real squeeze;        // 0: round; of a rectangle: height over width, squared
  uint measured;       // 0: it has a profile; else its table
  Real hidden;         // share of the profile's radius that an iris cuts off; 0: it is open
};

struct Medium {
  Real anisotropy;        // g of Henyey-Greenstein
  Real extinction_per_m;  // sigma_t
};

// f(rho) from q = |rho|^2; 0 outside the beam.
FL_FN Real beam_profile(Real q, Real profile_power) {
  Real q2 = q * q;
  Real power = q;
  if (profile_power > Real(1.5)) power = q2;
  if (profile_power > Real(2.5)) power = q2 * q;
  if (profile_power > Real(3.5)) power = q2 * q2;
  Real once = max(Real(1) - power, Real(0));
  Real soft = once;
  if (profile_power < Real(0.75)) soft *= once;
  if (profile_power < Real(0.42)) soft *= once;
  if (profile_power < Real(0.29)) soft *= once;
  return soft;
}

// Round beams with a larger k have quadratures of their own. Below it those in rho^2 and s are closer.
FL_CONST float kWideSpread = 1.0f;

// Integral of f (1 + k^2 rho^2)^(-3/2) over the unit disc, by 8 Gauss nodes in q = rho^2. f is read at sqrt(shown) rho.
FL_FN Real round_flux_factor(Real spread, Real profile_power, Real shown) {
  Real total = Real(0);
  for (uint i = uint(0); i < uint(8); ++i) {
    Real q = kGaussNode[uint(28) + i];
    Real u = Real(1) + spread * spread * q;
    total += kGaussWeight[uint(28) + i] * beam_profile(q * shown, profile_power) / (u * sqrt(u));
  }
  return total * Real(3.141592653589793);
}

// The same for wide beams, where (1 + k^2 q)^(-3/2) is a peak. The nodes lie in y with 1 + k^2 q = (1 + k^2)^y, that is
// in the logarithm of the cosine of the angle from the axis.
FL_FN Real wide_flux_factor(Real spread, Real profile_power, Real shown) {
  Real square = spread * spread;
  Real whole = log(Real(1) + square);
  Real total = Real(0);
  for (uint i = uint(0); i < uint(8); ++i) {
    Real u = exp(whole * kGaussNode[uint(28) + i]);
    Real q = min((u - Real(1)) / square, Real(1));
    total += kGaussWeight[uint(28) + i] * beam_profile(q * shown, profile_power) / sqrt(u);
  }
  return total * whole / square * Real(3.141592653589793);
}

// The same of a rectangle, 8 x 8 nodes over a quarter of it.
FL_FN Real rectangle_flux_factor(Real spread, Real profile_power, Real squeeze, Real shown) {
  Real total = Real(0);
  for (uint i = uint(0); i < uint(8); ++i) {
    Real x = kGaussNode[uint(28) + i] * kGaussNode[uint(28) + i];
    for (uint j = uint(0); j < uint(8); ++j) {
      Real y = kGaussNode[uint(28) + j] * kGaussNode[uint(28) + j];
      Real u = Real(1) + spread * spread * Real(0.5) * (x + squeeze * y);
      total += kGaussWeight[uint(28) + i] * kGaussWeight[uint(28) + j] * beam_profile(x * shown, profile_power) *
               beam_profile(y * shown, profile_power) / (u * sqrt(u));
    }
  }
  // Four quarters of the square, each of a half by a half of rho squared; y is stretched by 1 / sqrt(squeeze).
  return Real(2) * total * sqrt(squeeze);
}

// Flux in lumens over J0 of a beam with a profile, as it is drawn. Measured beams: measured_flux_factor().
FL_FN Real beam_flux_factor(BeamShape beam) {
  Real shown = Real(1);
  if (FL_NEED_IRIS) shown = (Real(1) - beam.hidden) * (Real(1) - beam.hidden);
  if (FL_NEED_RECTANGLE && beam.squeeze > Real(0)) {
    return rectangle_flux_factor(beam.spread, beam.profile_power, beam.squeeze, shown);
  }
  if (FL_NEED_WIDE && beam.spread > Real(kWideSpread)) return wide_flux_factor(beam.spread, beam.profile_power, shown);
  return round_flux_factor(beam.spread, beam.profile_power, shown);
}

// Share of a beam's flux that passes an iris, open to `iris` of its radius. The intensity within stays.
FL_FN Real iris_flux_share(BeamShape open, Real iris) {
  BeamShape within = open;
  within.spread = open.spread * iris;
  within.hidden = Real(1) - iris;
  return iris * iris * beam_flux_factor(within) / beam_flux_factor(open);
}

// f at a place in the beam; q = |rho|^2.
FL_FN Real beam_value(BeamShape beam, Vec2 rho, Real q) {
  if (FL_NEED_IRIS) {
    // The profile does not end at the iris.
    bool in_square = max(abs(rho.x), abs(rho.y)) < Real(0.7071067811865476);
    bool inside = FL_NEED_RECTANGLE && beam.squeeze > Real(0) ? in_square : q < Real(1);
    if (!inside) return Real(0);
    Real shown = Real(1) - beam.hidden;
    rho = rho * shown;
    q = q * shown * shown;
  }
#ifdef FL_MEASURED
  if (FL_NEED_MEASURED && beam.measured != uint(0)) return q < Real(1) ? measured_value(beam.measured, rho) : Real(0);
#endif
  if (FL_NEED_RECTANGLE && beam.squeeze > Real(0)) {
    return beam_profile(Real(2) * rho.x * rho.x, beam.profile_power) *
           beam_profile(Real(2) * rho.y * rho.y, beam.profile_power);
  }
  return beam_profile(q, beam.profile_power);
}

// 1 + k^2 |rho|^2, with true lengths: the square of the slant distance over z.
FL_FN Real beam_slant_square(BeamShape beam, Vec2 rho, Real q) {
  if (FL_NEED_RECTANGLE && beam.squeeze > Real(0)) {
    return Real(1) + beam.spread * beam.spread * (rho.x * rho.x + beam.squeeze * rho.y * rho.y);
  }
  return Real(1) + beam.spread * beam.spread * q;
}

// Henyey-Greenstein for light that travels along a unit direction with cosine mu to the camera ray, 1/sr. The eye sees
// the scattering angle from the other side: cos(gamma) = -mu.
FL_FN Real phase_function(Real mu, Real g) {
  Real square = max(Real(1) + g * g + Real(2) * g * mu, Real(1e-6));
  Real root = inversesqrt(square);
  return (Real(1) - g * g) * Real(0.07957747154594767) * root * root * root;
}

// Illuminance over J0 at light-space point p on a plane across the light, 1/m^2; 0 outside. r_m: distance from the lens
// along the light.
FL_FN Real beam_illuminance(BeamShape beam, Vec3 p, FL_OUT(Vec2) rho, FL_OUT(Real) r_m) {
  Real w = beam.lens_radius_m + beam.spread * p.z;
  rho = Vec2(p.x, p.y) / max(w, Real(1e-9));
  Real q = rho.x * rho.x + rho.y * rho.y;
  Real u = beam_slant_square(beam, rho, q);
  r_m = p.z * sqrt(u);
  if (!(p.z > Real(0)) || p.z > beam.range_m || !(q < Real(1))) return Real(0);
  return beam_value(beam, rho, q) / (w * w * u);
}

// Unit direction in which the light travels at gobo-plane position rho. Of a rectangle: what gives the cosine to a
// direction of its stretched light space as their dot product.
FL_FN Vec3 beam_direction(BeamShape beam, Vec2 rho) {
  if (FL_NEED_RECTANGLE && beam.squeeze > Real(0)) {
    Real root = inversesqrt(beam_slant_square(beam, rho, Real(0)));
    return Vec3(rho.x * beam.spread * root, beam.squeeze * rho.y * beam.spread * root, root);
  }
  Real s = inversesqrt(Real(1) + beam.spread * beam.spread * (rho.x * rho.x + rho.y * rho.y));
  return Vec3(rho.x * beam.spread * s, rho.y * beam.spread * s, s);
}

// The part of a ray inside the beam, and the straight line that it draws in the gobo plane.
struct Chord {
  Vec3 base;      // the ray's point nearest the lens within the clip: all t below are relative to it, so nothing large
                  // is subtracted from anything large
  Real t_base_m;  // of that point along the ray
  Real w_base;    // beam radius there
  Real w_slope;   // k d_z
  Real v_length;  // |V|
  Vec2 along;     // V / |V|
  Real offset;    // of the line from the centre of the disc, signed: rho = s along + offset (along.y, -along.x)
  Real s_base;    // s at the base
  Real s_from;    // the lit part of the line
  Real s_to;
  Real t_from_m;  // the lit part of the ray, relative to the base
  Real t_to_m;
  Real w_from;  // beam radius at its ends
  Real w_to;
};

// t relative to the base, for a position s on the line.
FL_FN Real chord_t(Chord chord, Real s) {
  Real ds = s - chord.s_base;
  Real denominator = chord.v_length - ds * chord.w_base * chord.w_slope;
  return ds * chord.w_base * chord.w_base / denominator;
}

// The line of a ray before the disc's rim cuts it: s at the ends of its part in the slab 0 <= z <= range.
struct ChordLine {
  Real t_from_m;  // that part, along the ray
  Real t_to_m;
  Real s_a;  // s there
  Real s_b;
};

// o, d: camera and unit ray direction in light space; t_min_m..t_max_m: the visible part of the ray. Fills the line and
// its base. False: no part of the ray is in the slab. Comparisons stand so that NaN is dark.
FL_FN bool beam_line(BeamShape beam, Vec3 o, Vec3 d, Real t_min_m, Real t_max_m, FL_INOUT(Chord) chord,
                     FL_OUT(ChordLine) line) {
  Real inverse = Real(1) / (abs(d.z) > Real(1e-12) ? d.z : Real(1e-12));
  Real t_lens = -o.z * inverse;
  Real t_end = (beam.range_m - o.z) * inverse;
  line.t_from_m = max(t_min_m, min(t_lens, t_end));
  line.t_to_m = min(t_max_m, max(t_lens, t_end));

  Real to_lens = -dot(o, d);
  if (FL_NEED_RECTANGLE && beam.squeeze > Real(0)) to_lens = -(o.x * d.x + beam.squeeze * o.y * d.y + o.z * d.z);
  chord.t_base_m = min(max(to_lens, line.t_from_m), line.t_to_m);
  chord.base = o + d * chord.t_base_m;
  chord.w_base = max(beam.lens_radius_m + beam.spread * chord.base.z, Real(1e-9));
  chord.w_slope = beam.spread * d.z;
  Vec2 v = Vec2(d.x * chord.w_base - chord.base.x * chord.w_slope, d.y * chord.w_base - chord.base.y * chord.w_slope);
  Real v_square = v.x * v.x + v.y * v.y;
  Real v_inverse = inversesqrt(max(v_square, Real(1e-30)));
  Real w_inverse = Real(1) / chord.w_base;
  chord.v_length = v_square * v_inverse;
  chord.along = v_square > Real(1e-30) ? v * v_inverse : Vec2(1, 0);
  Vec2 rho = Vec2(chord.base.x, chord.base.y) * w_inverse;
  chord.offset = rho.x * chord.along.y - rho.y * chord.along.x;
  chord.s_base = rho.x * chord.along.x + rho.y * chord.along.y;
  Real a = line.t_from_m - chord.t_base_m;
  Real b = line.t_to_m - chord.t_base_m;
  Real rate = chord.v_length * w_inverse;
  line.s_a = chord.s_base + rate * a / max(chord.w_base + a * chord.w_slope, Real(1e-9));
  line.s_b = chord.s_base + rate * b / max(chord.w_base + b * chord.w_slope, Real(1e-9));
  return line.t_to_m > line.t_from_m;
}

// The part of the line in the disc. False: dark.
FL_FN bool beam_chord(BeamShape beam, Vec3 o, Vec3 d, Real t_min_m, Real t_max_m, FL_OUT(Chord) chord) {
  ChordLine line;
  bool hit = beam_line(beam, o, d, t_min_m, t_max_m, chord, line);
  Real half_square = Real(1) - chord.offset * chord.offset;
  hit = hit && half_square > Real(0);
  Real half_chord = sqrt(max(half_square, Real(0)));
  Real a = line.t_from_m - chord.t_base_m;
  Real b = line.t_to_m - chord.t_base_m;
  chord.s_from = max(line.s_a, -half_chord);
  chord.s_to = min(line.s_b, half_chord);
  hit = hit && chord.s_to >= chord.s_from;
  chord.t_from_m = chord.s_from > line.s_a ? min(max(chord_t(chord, chord.s_from), a), b) : a;
  chord.t_to_m = chord.s_to < line.s_b ? min(max(chord_t(chord, chord.s_to), a), b) : b;
  chord.w_from = max(chord.w_base + chord.t_from_m * chord.w_slope, Real(1e-9));
  chord.w_to = max(chord.w_base + chord.t_to_m * chord.w_slope, Real(1e-9));
  return hit && chord.t_to_m > chord.t_from_m;
}

// Cuts the chord by an edge in the gobo plane: what has n . rho <= d stays. False: nothing stays. chord_close() after
// the last edge.
FL_FN bool chord_cut(FL_INOUT(Chord) chord, Vec2 n, Real d) {
  Real slope = n.x * chord.along.x + n.y * chord.along.y;
  Real aside = chord.offset * (n.x * chord.along.y - n.y * chord.along.x);
  if (abs(slope) < Real(1e-6)) {
    return aside + slope * Real(0.5) * (chord.s_from + chord.s_to) <= d;
  }
  Real s_edge = (d - aside) / slope;
  if (slope > Real(0)) {
    chord.s_to = min(chord.s_to, s_edge);
  } else {
    chord.s_from = max(chord.s_from, s_edge);
  }
  return chord.s_to >= chord.s_from;
}

// The ray's part for a chord whose ends were cut.
FL_FN void chord_close(FL_INOUT(Chord) chord) {
  Real a = chord.t_from_m;
  Real b = chord.t_to_m;
  chord.t_from_m = min(max(chord_t(chord, chord.s_from), a), b);
  chord.t_to_m = min(max(chord_t(chord, chord.s_to), a), b);
  chord.w_from = max(chord.w_base + chord.t_from_m * chord.w_slope, Real(1e-9));
  chord.w_to = max(chord.w_base + chord.t_to_m * chord.w_slope, Real(1e-9));
}

// The part of the chord in a rectangle. False: nothing.
FL_FN bool chord_in_rectangle(FL_INOUT(Chord) chord) {
  Real half_side = Real(0.7071067811865476);
  bool seen = chord_cut(chord, Vec2(1, 0), half_side);
  seen = chord_cut(chord, Vec2(-1, 0), half_side) && seen;
  seen = chord_cut(chord, Vec2(0, 1), half_side) && seen;
  seen = chord_cut(chord, Vec2(0, -1), half_side) && seen;
  chord_close(chord);
  return seen;
}

// The smooth part of the integrand at (s, t): profile (where it is asked for) over (1 + k^2 rho^2), phase function,
// extinction to the lens and back to the eye.
FL_FN Real chord_integrand(BeamShape beam, Medium medium, Chord chord, Vec3 d, Real s, Real t_m, bool with_extinction,
                           bool with_profile) {
  Real q = chord.offset * chord.offset + s * s;
  Vec2 rho = Vec2(s * chord.along.x + chord.offset * chord.along.y, s * chord.along.y - chord.offset * chord.along.x);
  Real u = beam_slant_square(beam, rho, q);
  Real root = inversesqrt(u);
  Real across =
      s * (chord.along.x * d.x + chord.along.y * d.y) + chord.offset * (chord.along.y * d.x - chord.along.x * d.y);
  if (FL_NEED_RECTANGLE && beam.squeeze > Real(0)) across = rho.x * d.x + beam.squeeze * rho.y * d.y;
  Real mu = (beam.spread * across + d.z) * root;
  Real value = with_profile ? beam_value(beam, rho, q) : Real(1);
  value = value * root * root * phase_function(mu, medium.anisotropy);
  if (with_extinction) {
    Real z = max(chord.base.z + t_m * d.z, Real(0));
    value *= exp(-medium.extinction_per_m * (chord.t_base_m + t_m + z * u * root));
  }
  return value;
}

// The measure of the chord: integral of dt / w^2 over it.
FL_FN Real chord_measure(Chord chord) { return (chord.t_to_m - chord.t_from_m) / (chord.w_from * chord.w_to); }

// Where a share x in [0, 1] of the chord's measure lies. The measure is even in s, so s is linear in x; t follows from
// the ends alone, without a singularity where s hardly changes (along the axis, through the apex).
FL_FN void chord_point(Chord chord, Real x, FL_OUT(Real) s, FL_OUT(Real) t_m) {
  s = chord.s_from + x * (chord.s_to - chord.s_from);
  t_m = chord.t_from_m +
        (chord.t_to_m - chord.t_from_m) * x * chord.w_from / (chord.w_to + x * (chord.w_from - chord.w_to));
}

#ifdef FL_HAZE_FIELD
// Each node of a quadrature has the mean density of the piece of the chord that it stands for, so no cloud is missed
// between two nodes. A chord shorter than this gets the densities of one as long, m: differences of sums are rough.
FL_CONST float kHazeShortest = 0.1f;

// Mean density between two distances along the camera ray.
FL_FN Real haze_mean(Real from_m, Real to_m) {
  Real middle_m = Real(0.5) * (from_m + to_m);
  Real half_m = Real(0.5) * max(to_m - from_m, Real(kHazeShortest));
  return Real(1) + Real(0.5) * (haze_until(middle_m + half_m) - haze_until(middle_m - half_m)) / half_m;
}

// The pieces of a chord, one after the other.
struct HazePieces {
  Real middle_m;  // of the chord, along the ray
  Real stretch;   // of a short one
  Real end_m;     // of the last piece
  Real until;
};
FL_FN HazePieces haze_pieces(Chord chord) {
  HazePieces pieces;
  Real length_m = chord.t_to_m - chord.t_from_m;
  pieces.middle_m = chord.t_base_m + Real(0.5) * (chord.t_from_m + chord.t_to_m);
  pieces.stretch = max(Real(1), Real(kHazeShortest) / max(length_m, Real(1e-6)));
  pieces.end_m = pieces.middle_m - Real(0.5) * length_m * pieces.stretch;
  pieces.until = haze_until(pieces.end_m);
  return pieces;
}
// Mean density of the next piece, which ends at a share x of the chord's measure.
FL_FN Real haze_piece(FL_INOUT(HazePieces) pieces, Chord chord, Real x) {
  Real s;
  Real t_m;
  chord_point(chord, x, s, t_m);
  Real end_m = pieces.middle_m + (chord.t_base_m + t_m - pieces.middle_m) * pieces.stretch;
  Real until = haze_until(end_m);
  Real density = Real(1) + (until - pieces.until) / max(end_m - pieces.end_m, Real(1e-6));
  pieces.end_m = end_m;
  pieces.until = until;
  return density;
}
// Mean density around a share x of the chord's measure, half_x on both sides.
FL_FN Real haze_around(Chord chord, Real x, Real half_x) {
  Real s;
  Real from_m;
  Real to_m;
  chord_point(chord, max(x - half_x, Real(0)), s, from_m);
  chord_point(chord, min(x + half_x, Real(1)), s, to_m);
  return haze_mean(chord.t_base_m + from_m, chord.t_base_m + to_m);
}
#endif

// In a wide beam 1 / (1 + k^2 rho^2) is a narrow peak along the chord, of half width c about s = middle. With
// s = middle + c sinh(v) places are even in v, and what is integrated is smooth there.
struct WideChord {
  bool used;  // false: the chord is short against the peak, and s does as well
  Real middle;
  Real c;
  Real v_from;
  Real v_length;
};

FL_FN Real wide_asinh(Real x) {
  Real size = log(abs(x) + sqrt(x * x + Real(1)));
  return x < Real(0) ? -size : size;
}

FL_FN WideChord wide_chord(BeamShape beam, Chord chord) {
  WideChord wide;
  wide.used = FL_NEED_WIDE && beam.spread > Real(kWideSpread);
  wide.middle = Real(0);
  wide.c = Real(1);
  wide.v_from = Real(0);
  wide.v_length = Real(1);
  if (!wide.used) return wide;
  Real inverse = Real(1) / (beam.spread * beam.spread);
  Real square = inverse + chord.offset * chord.offset;
  if (FL_NEED_RECTANGLE && beam.squeeze > Real(0)) {
    Vec2 a = chord.along;
    Real rise = a.x * a.x + beam.squeeze * a.y * a.y;
    wide.middle = -chord.offset * a.x * a.y * (Real(1) - beam.squeeze) / rise;
    square = (inverse + chord.offset * chord.offset * (a.y * a.y + beam.squeeze * a.x * a.x)) / rise -
             wide.middle * wide.middle;
  }
  wide.c = sqrt(max(square, Real(1e-12)));
  wide.used = chord.s_to - chord.s_from > wide.c;
  wide.v_from = wide_asinh((chord.s_from - wide.middle) / wide.c);
  wide.v_length = wide_asinh((chord.s_to - wide.middle) / wide.c) - wide.v_from;
  return wide;
}

// The share of the chord's length at a share x of its v; weight: d share / dx.
FL_FN Real wide_share(WideChord wide, Chord chord, Real x, FL_OUT(Real) weight) {
  Real grown = exp(wide.v_from + x * wide.v_length);
  Real shrunk = Real(1) / grown;
  Real scale = wide.c / (chord.s_to - chord.s_from);
  weight = Real(0.5) * (grown + shrunk) * wide.v_length * scale;
  Real s = wide.middle + Real(0.5) * (grown - shrunk) * wide.c;
  return clamp((s - chord.s_from) / (chord.s_to - chord.s_from), Real(0), Real(1));
}

// Gauss-Legendre nodes on [0, 1] and weights that sum to 1, for n = 1 to 8 nodes.
FL_FN uint gauss_index(uint n, uint i) { return n * (n - uint(1)) / uint(2) + i; }

#ifdef FL_HAZE_FIELD
// The beam integral where plumes are: their densities change within the piece of a node. Light, which is smooth, is the
// polynomial through n + 2 nodes; the mean density is read for each of kPlumePieces pieces. Its mean has the weights of
// Gauss, so that even haze is as exact as without plumes.
FL_CONST uint kPlumePieces = uint(12);
FL_FN Real chord_inscatter_plumes(BeamShape beam, Medium medium, Chord chord, Vec3 d, uint few, bool with_extinction) {
  uint n = min(few + uint(2), uint(8));
  HazePieces haze = haze_pieces(chord);
  Real densities[kPlumePieces];
  Real mean = Real(0);
  for (uint j = uint(0); j < kPlumePieces; ++j) {
    densities[j] = haze_piece(haze, chord, Real(j + uint(1)) / Real(kPlumePieces));
    mean += densities[j] / Real(kPlumePieces);
  }
  Real total = Real(0);
  for (uint i = uint(0); i < n; ++i) {
    Real node = kGaussNode[gauss_index(n, i)];
    Real weight = mean * kGaussWeight[gauss_index(n, i)];
    for (uint j = uint(0); j < kPlumePieces; ++j) {
      Real x = (Real(j) + Real(0.5)) / Real(kPlumePieces);
      Real part = (densities[j] - mean) / Real(kPlumePieces);
      for (uint k = uint(0); k < n; ++k) {
        Real other = kGaussNode[gauss_index(n, k)];
        if (k != i) part *= (x - other) / (node - other);
      }
      weight += part;
    }
    Real s;
    Real t_m;
    chord_point(chord, node, s, t_m);
    total += weight * chord_integrand(beam, medium, chord, d, s, t_m, with_extinction, true);
  }
  return total * chord_measure(chord);
}
#endif

// Projective beam integral with n Gauss nodes: in-scattered light over sigma_s J0, 1/m.
FL_FN Real chord_inscatter_gauss(BeamShape beam, Medium medium, Chord chord, Vec3 d, uint n, bool with_extinction) {
  Real total = Real(0);
#ifdef FL_HAZE_FIELD
  if (kPlumes) return chord_inscatter_plumes(beam, medium, chord, d, n, with_extinction);
  HazePieces haze = haze_pieces(chord);
  Real end = Real(0);
#endif
  for (uint i = uint(0); i < n; ++i) {
    Real s;
    Real t_m;
    chord_point(chord, kGaussNode[gauss_index(n, i)], s, t_m);
    Real weight = kGaussWeight[gauss_index(n, i)];
#ifdef FL_HAZE_FIELD
    end += weight;
    weight *= haze_piece(haze, chord, end);
#endif
    total += weight * chord_integrand(beam, medium, chord, d, s, t_m, with_extinction, true);
  }
  return total * chord_measure(chord);
}

// The same for beams wider than kWideSpread, in 1 or more pieces of 8 nodes.
FL_FN Real chord_inscatter_wide(BeamShape beam, Medium medium, Chord chord, Vec3 d, uint pieces, bool with_extinction) {
  WideChord wide = wide_chord(beam, chord);
  Real total = Real(0);
  for (uint i = uint(0); i < uint(8) * pieces; ++i) {
    uint piece = i / uint(8);
    uint node = uint(28) + i - uint(8) * piece;
    Real share = (Real(piece) + kGaussNode[node]) / Real(pieces);
    Real weight = kGaussWeight[node] / Real(pieces);
    if (wide.used) {
      Real stretch;
      share = wide_share(wide, chord, share, stretch);
      weight *= stretch;
    }
    Real s;
    Real t_m;
    chord_point(chord, share, s, t_m);
#ifdef FL_HAZE_FIELD
    weight *= haze_around(chord, share, Real(0.5) * weight);
#endif
    total += weight * chord_integrand(beam, medium, chord, d, s, t_m, with_extinction, true);
  }
  return total * chord_measure(chord);
}

#ifdef FL_MEASURED
// A measured beam: its table may have a peak anywhere, so its intensity f is not looked up at nodes. The table's lines
// give the sums of f, f v and f v^2 over any piece of the chord, v being the place on it; the rest of the integrand,
// which is smooth, is taken at three Gauss nodes, with weights that are exact for f times a polynomial of degree 2. A
// piece is at most 1 / kPiecesPerRad as the lens sees it; n nodes above 3 are more pieces. On a chord of a few steps of
// the lines f is smooth and differences of sums are rough: there it is looked up after all.
FL_CONST float kPiecesPerRad = 1.6f;
FL_CONST float kShortSteps = 4.0f;
FL_FN Real chord_inscatter_measured(BeamShape beam, Medium medium, Chord chord, Vec3 d, uint n, bool with_extinction) {
  // Lengths in the table's gate plane, of which an iris shows the middle.
  Real shown = FL_NEED_IRIS ? Real(1) - beam.hidden : Real(1);
  Real flip = chord.offset < Real(0) ? Real(-1) : Real(1);
  Real offset = abs(chord.offset);
  if (FL_NEED_IRIS) offset *= shown;
  MeasuredLine line = measured_line(beam.measured, offset, chord.along * flip);
  // s = c tan(angle): the line seen from the virtual apex, with the table's spread, and with that of the zoom.
  Real c = sqrt(Real(1) + line.spread * line.spread * offset * offset) / line.spread;
  Real zoomed = max(FL_NEED_IRIS ? beam.spread / shown : beam.spread, Real(1e-3));
  Real c_zoomed = sqrt(Real(1) + zoomed * zoomed * offset * offset) / zoomed;
  Real s_from = flip > Real(0) ? chord.s_from : -chord.s_to;
  Real s_to = flip > Real(0) ? chord.s_to : -chord.s_from;
  Real s_start = chord.s_from;
  if (FL_NEED_IRIS) {
    s_from *= shown;
    s_to *= shown;
    s_start *= shown;
  }
  Real scale = Real(1) / max(s_to - s_from, Real(1e-9));
  Real from_rad = atan(s_from / c);
  Real to_rad = atan(s_to / c);
  bool is_short = !((to_rad - from_rad) * line.steps_per_rad > Real(kShortSteps));
  Real begin = atan(s_from / c_zoomed);
  Real whole = atan(s_to / c_zoomed) - begin;
  uint pieces = uint(clamp(ceil(whole * Real(kPiecesPerRad)), Real(1), Real(8))) + max(n, uint(3)) - uint(3);
  Real v_from = line.by_angle ? from_rad : s_from;
  Vec3 before = measured_sums(line, from_rad);
  Real total = Real(0);
  for (uint i = uint(1); i <= pieces; ++i) {
    bool last = i == pieces;
    Real s_piece = last ? s_to : c_zoomed * tan(begin + whole * Real(i) / Real(pieces));
    Real piece_rad = last ? to_rad : atan(s_piece / c);
    Vec3 after = measured_sums(line, piece_rad);
    Vec3 sums = (after - before) * scale;
    Real v_to = line.by_angle ? piece_rad : s_piece;
    Real middle = Real(0.5) * (v_from + v_to);
    Real half_piece = max(Real(0.5) * (v_to - v_from), Real(1e-9));
    Real first = (sums.y - middle * sums.x) / half_piece;
    Real second = (sums.z - middle * (Real(2) * sums.y - middle * sums.x)) / (half_piece * half_piece);
    for (uint j = uint(0); j < uint(3); ++j) {
      Real x = Real(0.7745966692414834) * (Real(j) - Real(1));
      Real v = middle + half_piece * x;
      Real weight =
          j == uint(1) ? sums.x - second * Real(1.6666666666666667) : (second + x * first) * Real(0.8333333333333334);
      if (line.by_angle) {
        Real tangent = tan(v);
        v = c * tangent;
        weight *= c * (Real(1) + tangent * tangent);  // ds over dv
      }
      Real share = clamp((flip * v - s_start) * scale, Real(0), Real(1));
      if (is_short) {
        share = (Real(i) - Real(0.5) + Real(0.5) * x) / Real(pieces);
        weight = (j == uint(1) ? Real(0.4444444444444444) : Real(0.2777777777777778)) / Real(pieces);
      }
      Real s;
      Real t_m;
      chord_point(chord, share, s, t_m);
#ifdef FL_HAZE_FIELD
      weight *= haze_around(chord, share, Real(0.17) / Real(pieces));
#endif
      total += weight * chord_integrand(beam, medium, chord, d, s, t_m, with_extinction, is_short);
    }
    before = after;
    v_from = v_to;
  }
  return max(total, Real(0)) * chord_measure(chord);
}
#endif

// A rival: midpoint march in t with n equal steps over the same lit interval.
FL_FN Real chord_inscatter_march(BeamShape beam, Medium medium, Chord chord, Vec3 d, uint n, bool with_extinction) {
  Real total = Real(0);
  Real h = (chord.t_to_m - chord.t_from_m) / Real(n);
  for (uint i = uint(0); i < n; ++i) {
    Real t_m = chord.t_from_m + (Real(i) + Real(0.5)) * h;
    Real w = chord.w_base + t_m * chord.w_slope;
    Real s = chord.s_base + chord.v_length * t_m / (chord.w_base * w);
    Real light = chord_integrand(beam, medium, chord, d, s, t_m, with_extinction, true) / (w * w);
#ifdef FL_HAZE_FIELD
    Real from_m = chord.t_base_m + t_m - Real(0.5) * h;
    light *= haze_mean(from_m, from_m + h);
#endif
    total += light;
  }
  return total * h;
}

#ifdef FL_GOBO
// Where the gobo's image is looked up for a position on the line. turn: (cos, sin) of its rotation.
FL_FN Vec2 gobo_position(Chord chord, Real s, Vec2 turn) {
  Vec2 rho = Vec2(s * chord.along.x + chord.offset * chord.along.y, s * chord.along.y - chord.offset * chord.along.x);
  return Vec2(turn.x * rho.x + turn.y * rho.y, turn.x * rho.y - turn.y * rho.x);
}

// The rival march, with a gobo.
FL_FN Vec3 chord_inscatter_march_gobo(BeamShape beam, Medium medium, Chord chord, Vec3 d, uint n, bool with_extinction,
                                      uint gobo, Vec2 turn) {
  Vec3 total = Vec3(0, 0, 0);
  Real h = (chord.t_to_m - chord.t_from_m) / Real(n);
  for (uint i = uint(0); i < n; ++i) {
    Real t_m = chord.t_from_m + (Real(i) + Real(0.5)) * h;
    Real w = chord.w_base + t_m * chord.w_slope;
    Real s = chord.s_base + chord.v_length * t_m / (chord.w_base * w);
    Vec3 through = gobo_at(gobo, gobo_position(chord, s, turn), chord.base.z + t_m * d.z);
    Real light = chord_integrand(beam, medium, chord, d, s, t_m, with_extinction, true) / (w * w);
#ifdef FL_HAZE_FIELD
    Real from_m = chord.t_base_m + t_m - Real(0.5) * h;
    light *= haze_mean(from_m, from_m + h);
#endif
    total += through * light;
  }
  return total * h;
}

// With a gobo: n midpoints in s, each with a look at the gobo.
FL_FN Vec3 chord_inscatter_gobo(BeamShape beam, Medium medium, Chord chord, Vec3 d, uint n, bool with_extinction,
                                uint gobo, Vec2 turn) {
  Vec3 total = Vec3(0, 0, 0);
  WideChord wide = wide_chord(beam, chord);
  for (uint i = uint(0); i < n; ++i) {
    Real s;
    Real t_m;
    Real x = (Real(i) + Real(0.5)) / Real(n);
    Real weight = Real(1);
    if (FL_NEED_WIDE && wide.used) x = wide_share(wide, chord, x, weight);
    chord_point(chord, x, s, t_m);
    Vec3 through = gobo_at(gobo, gobo_position(chord, s, turn), chord.base.z + t_m * d.z);
    Real light = chord_integrand(beam, medium, chord, d, s, t_m, with_extinction, true);
    if (FL_NEED_WIDE) light *= weight;
#ifdef FL_HAZE_FIELD
    light *= haze_around(chord, x, Real(0.5) * weight / Real(n));
#endif
    total += through * light;
  }
  return total * (chord_measure(chord) / Real(n));
}
#endif

// Whether the ray of direction d (any length) can miss the beam's disc in the gobo plane: the line passes it by when
// |N| > |V|, with N and V linear in d. Convex in d, so that a convex set of directions misses when all its corners do,
// on one side. Returns N - |V| for side = +1 and -N - |V| for side = -1: positive means a miss.
FL_FN Real beam_miss(BeamShape beam, Vec3 o, Vec3 d, Real side) {
  Real w = beam.lens_radius_m + beam.spread * o.z;
  Real vx = d.x * w - o.x * beam.spread * d.z;
  Real vy = d.y * w - o.y * beam.spread * d.z;
  // |N| is |o x d|_z: the offset times |V|. The factor w keeps it linear where w is negative or zero.
  return side * (o.x * d.y - o.y * d.x) - sqrt(vx * vx + vy * vy);
}
