// What a small flat mirror makes of a beam of light. C++ and GLSL, after sim/shared/real.h.
//
// Light comes along the lines of the lamp's beam (beam.h), as if from its apex behind the lens, and leaves the mirror
// as the law of reflection says. It leaves as a round beam: a disc of the area that the mirror shows to the light takes
// the place of the square. A place behind the mirror's spot is lit by all of the lens that it sees in the mirror, so
// the spot is the mirror's outline, grown as the light spreads, blurred by an image of the lens: at L metres from the
// mirror discs of radius h (1 + L / D) and R L / r, for a mirror of radius h, an apex D and a lens of radius R, r
// metres away. Their convolution ends at the sum of both, which is linear in L as the radius of a beam is. The profile
// is that of five whose mean square radius is nearest to that of the convolution at L = r; what is left of the
// difference, up to 9 % of the radius, scales the beam. Errors: docs/numerics.md#mirrors.

// Mirrors that light passes at less than this sine send none: less than 1e-4 of what a ball reflects.
FL_CONST float kMirrorGrazing = 0.01f;

// The profile of a mirror's beam, and what its radius is multiplied with. mirror_radius_m: of a disc of the mirror's
// area; apex_per_m: 1 / D, 0 for light that is parallel.
FL_FN Real mirror_profile(Real mirror_radius_m, Real lens_radius_m, Real distance_m, Real apex_per_m,
                          FL_OUT(Real) scale) {
  Real image = max(lens_radius_m, Real(1e-6));
  Real outline = mirror_radius_m * (Real(1) + distance_m * apex_per_m);
  Real ratio = min(image, outline) / max(image, outline);
  // Mean square radius of the convolution over the square of its outer radius, 1/4 to 1/2.
  Real square = Real(0.5) * (Real(1) + ratio * ratio) / ((Real(1) + ratio) * (Real(1) + ratio));
  // The same of 1 - rho^(2m) is (m + 1) / (2 m + 4), and 1/4 of (1 - rho^2)^2. Steps in the middle between them.
  Real power = Real(4);
  Real own = Real(0.4166666666666667);
  if (square < Real(0.4083333333333333)) {
    power = Real(3);
    own = Real(0.4);
  }
  if (square < Real(0.3875)) {
    power = Real(2);
    own = Real(0.375);
  }
  if (square < Real(0.3541666666666667)) {
    power = Real(1);
    own = Real(0.3333333333333333);
  }
  if (square < Real(0.2916666666666667)) {
    power = Real(0.5);
    own = Real(0.25);
  }
  scale = sqrt(square / own);
  return power;
}

// The direction of light behind a mirror.
FL_FN Vec3 mirror_reflect(Vec3 light, Vec3 normal) { return light - normal * (Real(2) * dot(light, normal)); }

// Radius of the beam at the mirror, of a side mirror_m, whose normal has this cosine to the light.
FL_FN Real mirror_radius(Real mirror_m, Real cosine, Real scale) {
  return scale * mirror_m * sqrt(max(cosine, Real(0)) * Real(0.3183098861837907));
}
// Its spread, for a mirror distance_m from the lens. At most 1: what touches a lens would have more.
FL_FN Real mirror_spread(Real radius_m, Real lens_radius_m, Real distance_m, Real apex_per_m, Real scale) {
  return min(radius_m * apex_per_m + scale * lens_radius_m / max(distance_m, Real(1e-6)), Real(1));
}
