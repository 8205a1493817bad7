// Light of a beam with a pattern in it (gobos, wheels, blur) along a chord. After beam.h, where FL_GOBO is defined.
//
// What is integrated over the chord's measure is a product of two: the profile times the pattern, which is rough and
// cheap, and the rest W (phase function, 1 / (1 + k^2 rho^2), extinction), which is smooth and takes most of the time.
// W is computed at four Gauss nodes, and the polynomial of degree 3 through them stands for it. The rough factor is
// sampled as often as its detail asks, each sample with the polynomial there. Error and cost against midpoints of the
// product: docs/numerics.md.

// Not for beams wider than kWideSpread: 1 / (1 + k^2 rho^2) is a peak there.

// W along a chord: its values at the nodes, and the polynomial through them, even_0 + even_2 y^2 + y (odd_1 + odd_3
// y^2) with y = 2 x - 1. x: share of the chord's length.
struct ChordWeight {
  Real at_node[4];
  Real even_0;
  Real even_2;
  Real odd_1;
  Real odd_3;
};

FL_FN ChordWeight chord_weight(BeamShape beam, Medium medium, Chord chord, Vec3 d, bool with_extinction) {
  ChordWeight weight;
#ifdef FL_HAZE_FIELD
  HazePieces haze = haze_pieces(chord);
  Real end = Real(0);
#endif
  for (uint i = uint(0); i < uint(4); ++i) {
    Real s;
    Real t_m;
    chord_point(chord, kGaussNode[uint(6) + i], s, t_m);
    weight.at_node[i] = chord_integrand(beam, medium, chord, d, s, t_m, with_extinction, false);
#ifdef FL_HAZE_FIELD
    end += kGaussWeight[uint(6) + i];
    weight.at_node[i] *= haze_piece(haze, chord, end);
#endif
  }
  // The nodes lie at y = -outer, -inner, inner, outer.
  Real outer = Real(0.8611363115940526);
  Real inner = Real(0.3399810435848563);
  Real apart = Real(1) / (outer * outer - inner * inner);
  Real even_outer = Real(0.5) * (weight.at_node[3] + weight.at_node[0]);
  Real even_inner = Real(0.5) * (weight.at_node[2] + weight.at_node[1]);
  Real odd_outer = Real(0.5) * (weight.at_node[3] - weight.at_node[0]) / outer;
  Real odd_inner = Real(0.5) * (weight.at_node[2] - weight.at_node[1]) / inner;
  weight.even_2 = (even_outer - even_inner) * apart;
  weight.even_0 = even_inner - inner * inner * weight.even_2;
  weight.odd_3 = (odd_outer - odd_inner) * apart;
  weight.odd_1 = odd_inner - inner * inner * weight.odd_3;
  return weight;
}

FL_FN Real chord_weight_at(ChordWeight weight, Real x) {
  Real y = Real(2) * x - Real(1);
  Real square = y * y;
  return weight.even_0 + square * weight.even_2 + y * (weight.odd_1 + square * weight.odd_3);
}

#ifdef FL_GOBO
// n samples of the pattern and the profile at midpoints.
FL_FN Vec3 chord_inscatter_taps(BeamShape beam, Chord chord, ChordWeight weight, Vec3 d, uint n, uint gobo, Vec2 turn) {
  Vec3 total = Vec3(0, 0, 0);
  for (uint i = uint(0); i < n; ++i) {
    Real x = (Real(i) + Real(0.5)) / Real(n);
    Real s;
    Real t_m;
    chord_point(chord, x, s, t_m);
    Vec2 rho = Vec2(s * chord.along.x + chord.offset * chord.along.y, s * chord.along.y - chord.offset * chord.along.x);
    Real light = beam_value(beam, rho, s * s + chord.offset * chord.offset) * chord_weight_at(weight, x);
    total += gobo_at(gobo, gobo_position(chord, s, turn), chord.base.z + t_m * d.z) * light;
  }
  return total * (chord_measure(chord) / Real(n));
}
#endif
