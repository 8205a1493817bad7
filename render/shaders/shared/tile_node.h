// One beam along one node's ray of a tile: what tells whether the beam is smooth over the tile, and its light there.
// After beam.h. Design and error: docs/decisions/0100.
//
// With q = 1 - rho^2 for the line's offset rho, the light of a chord that crosses the whole disc is
//
//   L = q^(p + 1/2) h,   h = 1 / |V| x integral over -1..1 of (1 - x^2)^p g dx,   s = sqrt(q) x,
//
// with p = 1, or 1/m of a soft profile, and g smooth: the phase function, the slant, the extinction, and (1 - r^m) / (1
// - r) of a flat profile, r = |rho|^2. h is even in sqrt(q), so it is smooth through the rim, q = 0. The quadrature is
// Gauss-Gegenbauer of weight 1 - x^2; of a chord that is cut it is Gauss-Legendre between the cuts.

// Positive nodes and weights on -1..1; the middle node is 0. Roots of the Jacobi polynomials P_3, P_5 of (1, 1) and of
// the Legendre polynomials.
FL_CONST Real kRimNode3 = Real(0.654653670707977144);
FL_CONST Real kRimWeight3 = Real(0.311111111111111111);
FL_CONST Real kRimMiddle3 = Real(0.711111111111111111);
FL_CONST Real kRimNode5a = Real(0.468848793470714214);
FL_CONST Real kRimNode5b = Real(0.830223896278566930);
FL_CONST Real kRimWeight5a = Real(0.336839460734335403);
FL_CONST Real kRimWeight5b = Real(0.0860176821228074532);
FL_CONST Real kRimMiddle5 = Real(0.487619047619047619);
FL_CONST Real kCutNode3 = Real(0.774596669241483377);
FL_CONST Real kCutWeight3 = Real(0.555555555555555556);
FL_CONST Real kCutMiddle3 = Real(0.888888888888888889);
FL_CONST Real kCutNode5a = Real(0.538469310105683091);
FL_CONST Real kCutNode5b = Real(0.906179845938663993);
FL_CONST Real kCutWeight5a = Real(0.478628670499366468);
FL_CONST Real kCutWeight5b = Real(0.236926885056189088);
FL_CONST Real kCutMiddle5 = Real(0.568888888888888889);

struct TileNode {
  bool alive;       // some of the ray is in the slab
  bool is_whole;    // the chord crosses the whole disc, as far as this ray sees
  Real half_chord;  // sqrt(max(q, 0))
  Real light;       // L over J0 and sigma_s; 0 outside the disc
  Real h;           // of the whole chord
};

// p of the profile.
FL_FN Real rim_power(Real profile_power) {
  return profile_power < Real(0.75) ? floor(Real(1) / profile_power + Real(0.5)) : Real(1);
}

// q^(p + 1/2), for q >= 0.
FL_FN Real rim_factor(Real q, Real power) {
  Real value = q * sqrt(q);
  if (power > Real(1.5)) value *= q;
  if (power > Real(2.5)) value *= q;
  if (power > Real(3.5)) value *= q;
  return value;
}

// g at place s of the line, x its share of a whole chord; of a cut chord the profile times the smooth part.
FL_FN Real tile_integrand(BeamShape beam, Medium medium, Chord chord, ChordLine line, Vec3 d, Real s, Real x,
                          bool is_whole, bool with_extinction) {
  Real t_m = Real(0);
  if (with_extinction) {
    t_m = min(max(chord_t(chord, s), line.t_from_m - chord.t_base_m), line.t_to_m - chord.t_base_m);
  }
  Real value = chord_integrand(beam, medium, chord, d, s, t_m, with_extinction, false);
  Real r = chord.offset * chord.offset + s * s;
  if (!is_whole) return value * beam_profile(r, beam.profile_power);
  if (beam.profile_power > Real(1.5)) {
    Real sum = Real(1) + r;
    if (beam.profile_power > Real(2.5)) sum += r * r;
    if (beam.profile_power > Real(3.5)) sum += r * r * r;
    value *= sum;
  }
  Real rim = Real(1) - x * x;
  if (beam.profile_power < Real(0.75)) value *= rim;
  if (beam.profile_power < Real(0.42)) value *= rim;
  if (beam.profile_power < Real(0.29)) value *= rim;
  return value;
}

#ifdef FL_HAZE_FIELD
// Mean density of haze that is not even, half_s on both sides of a place of the line.
FL_FN Real tile_density(Chord chord, ChordLine line, Real s, Real half_s) {
  Real low = line.t_from_m - chord.t_base_m;
  Real high = line.t_to_m - chord.t_base_m;
  Real from_m = min(max(chord_t(chord, s - half_s), low), high);
  Real to_m = min(max(chord_t(chord, s + half_s), low), high);
  return haze_mean(chord.t_base_m + from_m, chord.t_base_m + to_m);
}
#define FL_TIMES_DENSITY(s, half_s) * tile_density(chord, line, s, half_s)
#else
#define FL_TIMES_DENSITY(s, half_s)
#endif

// chord and line are those of beam_line(). `many`: five nodes, else three. Beams as wide as kWideSpread, rectangles,
// measured ones and irises are not for this.
FL_FN TileNode tile_node(BeamShape beam, Medium medium, Chord chord, ChordLine line, Vec3 d, bool many,
                         bool with_extinction) {
  TileNode node;
  Real q = Real(1) - chord.offset * chord.offset;
  node.half_chord = sqrt(max(q, Real(0)));
  node.alive = line.t_to_m > line.t_from_m;
  Real s_from = max(line.s_a, -node.half_chord);
  Real s_to = min(line.s_b, node.half_chord);
  node.is_whole = line.s_a <= -node.half_chord && line.s_b >= node.half_chord;
  // Outside the rim h is continued: a pair of values over the middle changes its sign there, as c^2 does.
  Real middle = node.is_whole ? Real(0) : Real(0.5) * (s_from + s_to);
  Real c = min(sqrt(abs(q)), Real(1));
  Real half_length = node.is_whole ? c : max(Real(0.5) * (s_to - s_from), Real(0));
  Real center = tile_integrand(beam, medium, chord, line, d, middle, Real(0), node.is_whole, with_extinction)
      FL_TIMES_DENSITY(middle, half_length * (many ? Real(0.24) : Real(0.35)));
  Real sum = Real(0);
  if (!many) {
    Real x = node.is_whole ? kRimNode3 : kCutNode3;
    Real ds = half_length * x;
    Real pair = tile_integrand(beam, medium, chord, line, d, middle + ds, x, node.is_whole, with_extinction)
                    FL_TIMES_DENSITY(middle + ds, half_length * Real(0.3)) +
                tile_integrand(beam, medium, chord, line, d, middle - ds, x, node.is_whole, with_extinction)
                    FL_TIMES_DENSITY(middle - ds, half_length * Real(0.3));
    if (node.is_whole && q < Real(0)) pair = Real(4) * center - pair;
    sum = (node.is_whole ? kRimMiddle3 : kCutMiddle3) * center + (node.is_whole ? kRimWeight3 : kCutWeight3) * pair;
  } else {
    sum = (node.is_whole ? kRimMiddle5 : kCutMiddle5) * center;
    for (uint i = uint(0); i < uint(2); ++i) {
      Real rim = i == uint(0) ? kRimNode5a : kRimNode5b;
      Real cut = i == uint(0) ? kCutNode5a : kCutNode5b;
      Real x = node.is_whole ? rim : cut;
      Real ds = half_length * x;
      Real pair = tile_integrand(beam, medium, chord, line, d, middle + ds, x, node.is_whole, with_extinction)
                      FL_TIMES_DENSITY(middle + ds, half_length * Real(0.2)) +
                  tile_integrand(beam, medium, chord, line, d, middle - ds, x, node.is_whole, with_extinction)
                      FL_TIMES_DENSITY(middle - ds, half_length * Real(0.2));
      // (1 - x^2)^(p - 1) is the same on both sides of the rim.
      if (node.is_whole && q < Real(0)) {
        Real shape = tile_integrand(beam, medium, chord, line, d, middle, x, true, with_extinction)
            FL_TIMES_DENSITY(middle, half_length * Real(0.24));
        pair = Real(4) * shape - pair;
      }
      Real rim_weight = i == uint(0) ? kRimWeight5a : kRimWeight5b;
      Real cut_weight = i == uint(0) ? kCutWeight5a : kCutWeight5b;
      sum += (node.is_whole ? rim_weight : cut_weight) * pair;
    }
  }
  Real inverse = Real(1) / max(chord.v_length, Real(1e-12));
  node.h = sum * inverse;
  Real factor = node.is_whole ? rim_factor(max(q, Real(0)), rim_power(beam.profile_power)) : half_length;
  node.light = node.alive && q > Real(0) ? node.h * factor : Real(0);
  return node;
}

// A chord that something cuts, with a profile of p = 1. With g = g_0 + g_1 s + g_2 s^2, the light is
//
//   L = sum of g_j M_j,   M_j = integral over s_a..s_b of (c^2 - s^2) s^j ds,   c^2 = max(q, 0),
//
// where s_a and s_b are cut off at -c and c. g_j and the places of the cuts are smooth through the rim.
FL_FN Vec3 cut_moments(Real c_square, Real s_a, Real s_b) {
  Real c = sqrt(c_square);
  Real a = clamp(s_a, -c, c);
  Real b = clamp(s_b, -c, c);
  Real aa = a * a;
  Real bb = b * b;
  Real third = (bb * b - aa * a) * Real(0.3333333333333333);
  Real fourth = (bb * bb - aa * aa) * Real(0.25);
  Real fifth = (bb * bb * b - aa * aa * a) * Real(0.2);
  Vec3 m = Vec3(c_square * (b - a) - third, c_square * Real(0.5) * (bb - aa) - fourth, c_square * third - fifth);
  return b > a ? m : Vec3(0, 0, 0);
}

// Where g of a cut chord is sampled: at the middle and at this share of half the fitted length, which has its least
// error for a cubic.
FL_CONST Real kFitNode = Real(0.866025403784438647);
// Below it a quadratic in s would be dominated by rounding.
FL_CONST Real kFitHalfMin = Real(0.1);

// g_0, g_1, g_2 from g at middle - kFitNode half, middle, middle + kFitNode half.
FL_FN Vec3 cut_fit(Real before, Real center, Real after, Real middle, Real half_length) {
  Real inverse = Real(1) / half_length;
  Real first = (after - before) * inverse * (Real(0.5) / kFitNode);
  Real second = (Real(0.5) * (after + before) - center) * inverse * inverse * Real(1.3333333333333333);
  return Vec3(center - middle * (first - middle * second), first - Real(2) * middle * second, second);
}
