// Light of a beam that a surface with sheen reflects: isotropic GGX with Smith's height-correlated masking and
// Schlick's Fresnel term, over a diffuse part that gets what the sheen leaves (Walter et al. 2007, "Microfacet Models
// for Refraction through Rough Surfaces"; Heitz 2014, "Understanding the Masking-Shadowing Function"; Ashikhmin and
// Shirley 2000, "An Anisotropic Phong BRDF Model", for the diffuse part). C++ and GLSL, after sim/shared/real.h.
//
// Roughness and metal are those of glTF: alpha = roughness^2; what is no metal reflects kSheenDielectric of the light
// that comes straight down, a metal its own colour. A metal has no diffuse part.
//
// Light that a facet throws onto another facet is lost, so rough metals are darker than they are. The function is the
// same with light and eye exchanged, and no direction gets more light than there is. Figures: docs/numerics.md#sheen.

// Smoother surfaces count as this: alpha 0.01, a highlight of about a degree. Sharper ones are narrower than pixels.
FL_CONST float kSheenRoughnessLeast = 0.1f;
FL_CONST float kSheenDielectric = 0.04f;
FL_CONST float kSheenFacingLeast = 1e-3f;  // cosine to the eye, of faces that are seen edge on

struct Sheen {
  Vec3 straight;  // share of light that is reflected straight back
  Vec3 diffuse;   // reflectance of the diffuse part
  Real alpha;
};

FL_FN Sheen sheen_of(Vec3 color, Vec3 diffuse, Real roughness, Real metal) {
  Sheen sheen;
  Real rough = max(roughness, Real(kSheenRoughnessLeast));
  sheen.alpha = rough * rough;
  sheen.straight = mix(Vec3(Real(kSheenDielectric)), color, metal);
  sheen.diffuse = diffuse * (Real(1) - metal);
  return sheen;
}

// Alpha for light from a disc that is seen under a half angle of lens_rad. A facet turns light by twice as much as it
// is turned itself, and across the plane of incidence by the cosine `facing` less, so that the disc is an ellipse of
// slopes. A circle of its area is added: the peak is right for discs much narrower and much wider than the highlight.
FL_FN Real sheen_alpha(Real alpha, Real lens_rad, Real facing) {
  return min(sqrt(alpha * alpha + Real(0.25) * lens_rad * lens_rad / max(facing, Real(0.05))), Real(1));
}

// What Ashikhmin and Shirley multiply a diffuse part with, for each of the two directions.
FL_FN Real sheen_left(Real cosine) {
  Real x = Real(1) - Real(0.5) * cosine;
  Real square = x * x;
  return Real(1) - square * square * x;
}

// The direction that a facet has which mirrors one of the two into the other.
FL_FN Vec3 sheen_facet(Vec3 to_eye, Vec3 to_light) {
  Vec3 sum = to_eye + to_light;
  return sum * inversesqrt(max(dot(sum, sum), Real(1e-12)));
}

// What facets send to the eye if each mirrors all light, 1/sr, and Schlick's share at their angle. lens_rad: as
// sheen_alpha() has it. All directions are unit vectors away from the surface.
FL_FN Real sheen_lobe(Real alpha, Real lens_rad, Vec3 normal, Vec3 to_eye, Vec3 to_light, FL_OUT(Real) fresnel) {
  Vec3 facet = sheen_facet(to_eye, to_light);
  Vec3 aside = cross(normal, facet);  // its square is 1 - cosine^2 without cancellation
  Real across = dot(aside, aside);
  Real facing = min(max(dot(to_light, facet), Real(0)), Real(1));
  Real wide = sheen_alpha(alpha, lens_rad, facing);
  Real square = wide * wide;
  Real width = square + across * (Real(1) - square);
  Real out_cosine = max(dot(normal, to_eye), Real(kSheenFacingLeast));
  Real in_cosine = max(dot(normal, to_light), Real(0));
  Real masking = out_cosine * sqrt(square + (Real(1) - square) * in_cosine * in_cosine) +
                 in_cosine * sqrt(square + (Real(1) - square) * out_cosine * out_cosine);
  Real x = Real(1) - facing;
  fresnel = x * x * x * x * x;
  return square * Real(0.15915494309189535) / (width * width * masking);
}

// The sheen alone, of a surface that reflects `straight` of the light straight back, 1/sr.
FL_FN Vec3 sheen_gloss(Vec3 straight, Real alpha, Real lens_rad, Vec3 normal, Vec3 to_eye, Vec3 to_light) {
  Real fresnel;
  Real lobe = sheen_lobe(alpha, lens_rad, normal, to_eye, to_light, fresnel);
  return (straight * (Real(1) - fresnel) + Vec3(fresnel)) * lobe;
}

// The diffuse part, over its reflectance and sheen_left() of the cosine to the light, 1/sr: 28 / (23 pi), less what the
// sheen reflects straight back.
FL_FN Real sheen_rest(Vec3 normal, Vec3 to_eye) {
  Real out_cosine = max(dot(normal, to_eye), Real(kSheenFacingLeast));
  return Real(0.3875076875280931) * (Real(1) - Real(kSheenDielectric)) * sheen_left(out_cosine);
}

// All that is reflected, 1/sr.
FL_FN Vec3 sheen_reflected(Sheen sheen, Real lens_rad, Vec3 normal, Vec3 to_eye, Vec3 to_light) {
  Real rest = sheen_rest(normal, to_eye) * sheen_left(max(dot(normal, to_light), Real(0)));
  return sheen.diffuse * rest + sheen_gloss(sheen.straight, sheen.alpha, lens_rad, normal, to_eye, to_light);
}
