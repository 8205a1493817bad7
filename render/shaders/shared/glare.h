// The camera's glare: a lens sends most of the light of a point to its place in the picture and scatters a share of it.
// Lengths in the picture are in focal lengths, so a distance is the tangent of an angle seen from the axis.
//
// Source of the form: the CIE's equation of disability glare for small angles, 10 / theta^3 + 5 / theta^2 with theta in
// degrees (CIE 146:2002; J. J. Vos, Clin. Exp. Optom. 86, 2003). Polished glass with some dust scatters by such inverse
// powers too (Harvey and Shack). Both powers are rounded off within kGlareCore, 0.1 degrees, where the equation ends,
// and the second one fades beyond kGlareReach, since its integral has no bound:
//
//   g(r) = kGlareSteep C / (2 pi q^3) + (1 - kGlareSteep) K_1(q / R) / (2 pi R q K_0(C / R)),   q^2 = r^2 + C^2,
//
// with C = kGlareCore, R = kGlareReach. The integral of each term over the plane is its factor. Both are exact mixtures
// of Gaussians exp(-t r^2): their weights over d log t are C sqrt(t / pi) exp(-t C^2) and exp(-t C^2 - 1 / (4 t R^2)) /
// (2 K_0(C / R)). The pyramid takes one Gaussian an octave of them. Design and error: docs/decisions/0111.
FL_CONST Real kGlareCore = Real(1.7453310241888e-3);
FL_CONST Real kGlareReach = Real(1);
FL_CONST Real kGlareSteep = Real(0.7556649896420384);  // 10 to 5: the integrals of both powers
FL_CONST Real kGlareK0 = Real(6.466748244562327);      // K_0(C / R)

// Weight of an octave of Gaussians whose variance in each direction is about `variance`.
FL_FN Real glare_octave(Real variance) {
  Real core = kGlareCore * kGlareCore / (Real(2) * variance);
  Real steep = sqrt(core / Real(3.141592653589793));
  Real flat_part = exp(-variance / (Real(2) * kGlareReach * kGlareReach)) / (Real(2) * kGlareK0);
  return Real(1.386294361119891) * exp(-core) * (kGlareSteep * steep + (Real(1) - kGlareSteep) * flat_part);
}

// Weight of level `level` >= 1 of the pyramid, with pixels of `pixel`: by its filters its variance is 5/6 4^level -
// 4/3 pixels, and so an octave reaches farther at the first levels.
FL_FN Real glare_level_weight(int level, Real pixel) {
  Real fours = Real(0.8333333333333333) * exp2(Real(2) * Real(level));
  Real variance = fours - Real(1.3333333333333333);
  return glare_octave(variance * pixel * pixel) * (fours / variance);
}
