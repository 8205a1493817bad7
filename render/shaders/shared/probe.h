// Reflection probes: what is seen from one place in a box of the room, as a map of directions with levels for
// roughness, and where on the map a place in that box has to look. C++ and GLSL, after sim/shared/real.h and sheen.h.
//
// The map is an octahedron (Meyer et al. 2010, "On Floating-Point Normal Vectors"; Cigolle et al. 2014, "A Survey of
// Efficient Representations for Independent Unit Vectors"). A ray from another place than the probe's is followed to
// the side of the box, and the map is read towards there (Lagarde and Zanuttini 2012, "Local Image-based Lighting with
// Parallax-corrected Cubemaps"). Levels are those of the split sum (Karis 2013, "Real Shading in Unreal Engine 4"): the
// light of a map's level times the share of light that the surface reflects. docs/numerics.md#reflection-probes

// Alpha of the levels: 0 is what rays saw, the next one is this, and each has twice the alpha of the one before, the
// last one 1.
FL_CONST float kProbeAlphaFirst = 0.08f;
FL_CONST float kProbeAlphaLeast = 0.02f;  // below it only level 0 counts: its texels are wider than the highlight

FL_FN uint probe_side(uint level) { return max(uint(64) >> level, uint(8)); }
// The first texel of a level: 4,096, 1,024, 256 and then 64 each.
FL_FN uint probe_first(uint level) {
  uint first = uint(0);
  for (uint l = uint(0); l < level; ++l) first += probe_side(l) * probe_side(l);
  return first;
}
FL_FN Real probe_level_alpha(uint level) {
  return min(Real(kProbeAlphaFirst) * Real(uint(1) << level) * Real(0.5), Real(1));
}

// Which level has this alpha, between two of them.
FL_FN Real probe_level(Real alpha) {
  Real first = log(Real(kProbeAlphaFirst) / Real(kProbeAlphaLeast));
  Real past = log(max(alpha, Real(1e-6)) / Real(kProbeAlphaFirst));
  Real level = past < Real(0) ? Real(1) + past / first : Real(1) + past * Real(1.4426950408889634);
  if (level > Real(4)) level = Real(4) + (level - Real(4)) / Real(0.6438561897747247);  // log2(1 / 0.64)
  return min(max(level, Real(0)), Real(5));
}

// From a unit vector to the square from 0 to 1, and back; what comes back is not normalised: its size says how large a
// texel is there.
FL_FN Vec2 probe_square(Vec3 way) {
  Real sum = abs(way.x) + abs(way.y) + abs(way.z);
  Real x = way.x / sum;
  Real y = way.y / sum;
  if (way.z < Real(0)) {
    Real across = x;
    x = (Real(1) - abs(y)) * (across >= Real(0) ? Real(1) : Real(-1));
    y = (Real(1) - abs(across)) * (y >= Real(0) ? Real(1) : Real(-1));
  }
  return Vec2(Real(0.5) + Real(0.5) * x, Real(0.5) + Real(0.5) * y);
}
FL_FN Vec3 probe_way(Vec2 at) {
  Real x = Real(2) * at.x - Real(1);
  Real y = Real(2) * at.y - Real(1);
  Real z = Real(1) - abs(x) - abs(y);
  Real fold = max(-z, Real(0));
  return Vec3(x + (x >= Real(0) ? -fold : fold), y + (y >= Real(0) ? -fold : fold), z);
}
// Solid angle of a texel over that of one in the middle of a face; way: of probe_way().
FL_FN Real probe_texel_share(Vec3 way) {
  Real square = dot(way, way);
  return Real(1) / (square * sqrt(square));
}
// The texel of a level that stands for (x, y), which may be one beside the map: over an edge the map goes on at the
// same edge, mirrored at its middle.
FL_FN uint probe_texel(int x, int y, int side) {
  int column = x;
  int row = y;
  if (column < 0 || column >= side) {
    column = column < 0 ? -1 - column : 2 * side - 1 - column;
    row = side - 1 - row;
  }
  if (row < 0 || row >= side) {
    row = row < 0 ? -1 - row : 2 * side - 1 - row;
    column = side - 1 - column;
  }
  return uint(row * side + column);
}

// What a level takes of the light from a direction beside the one that it looks to: as facets of GGX mirror it to an
// eye that looks straight down at them. facing: the cosine between the two directions.
FL_FN Real probe_lobe(Real alpha, Real facing) {
  Real square = alpha * alpha;
  Real half_square = Real(0.5) + Real(0.5) * facing;  // of the cosine between the facet and either
  Real width = Real(1) - half_square * (Real(1) - square);
  Real cosine = max(facing, Real(0));
  Real lit = cosine / (cosine + sqrt(cosine * cosine + square * (Real(1) - cosine * cosine)));  // Smith's masking
  return lit * square * square / (width * width);
}

// How much a probe counts at a place: 1 in its box, 0 from blend_m beside it on.
FL_FN Real probe_weight(Vec3 place, Vec3 low, Vec3 high, Real blend_m) {
  Vec3 beside = max(max(low - place, place - high), Vec3(Real(0)));
  return max(Real(1) - max(beside.x, max(beside.y, beside.z)) / blend_m, Real(0));
}

// From the probe's centre to where a ray from a place leaves the box. A place beside the box is moved to its side.
FL_FN Vec3 probe_toward(Vec3 place, Vec3 way, Vec3 low, Vec3 high, Vec3 center) {
  Vec3 from = min(max(place, low), high);
  Real end = Real(1e30);
  end = abs(way.x) > Real(1e-9) ? min(end, ((way.x > Real(0) ? high.x : low.x) - from.x) / way.x) : end;
  end = abs(way.y) > Real(1e-9) ? min(end, ((way.y > Real(0) ? high.y : low.y) - from.y) / way.y) : end;
  end = abs(way.z) > Real(1e-9) ? min(end, ((way.z > Real(0) ? high.z : low.z) - from.z) / way.z) : end;
  return from + way * max(end, Real(0)) - center;
}

// Facets whose slopes lie in the plane of the eye and the normal, one after the other: each stands for the facets with
// its slope along that plane, whose slopes across it are those of Student's distribution once more. At a slant the
// light that they mirror is a streak towards the eye: a slope along the plane turns a ray twice as far as it is itself,
// one across it less by the cosine.
FL_CONST uint kProbeFacets = uint(8);
struct ProbeFacet {
  Vec3 way;    // into which it mirrors the eye
  Real share;  // how much of it the eye sees and the light reaches; 0: it mirrors into the surface
  Real alpha;  // of those across
  Real fresnel;  // Schlick's share at their angle: at a slant it is several times as large for those that mirror far
};
FL_FN ProbeFacet probe_facet(uint k, Real alpha, Vec3 normal, Vec3 to_eye) {
  ProbeFacet facet;
  Real cosine = max(dot(normal, to_eye), Real(1e-3));
  Vec3 along = to_eye - normal * cosine;
  Real across = sqrt(max(dot(along, along), Real(1e-12)));
  Real q = (Real(2) * Real(k) + Real(1)) / Real(kProbeFacets) - Real(1);
  Real slope = alpha * q * inversesqrt(Real(1) - q * q);
  Vec3 up = normalize(normal + along * (slope / across));
  Real seen = max(dot(to_eye, up), Real(0));
  Real past = max(Real(1) - seen, Real(0));
  facet.fresnel = past * past * past * past * past;
  facet.way = up * (Real(2) * seen) - to_eye;
  Real lit = max(dot(normal, facet.way), Real(0));
  Real square = alpha * alpha;
  facet.share = max(cosine + slope * across, Real(0)) * lit /
                max(lit + sqrt(lit * lit + square * (Real(1) - min(lit * lit, Real(1)))), Real(1e-6));
  // Those that stand beside each other in the streak meet.
  facet.alpha = min(sqrt(square + slope * slope) * max(seen, Real(0.25)), Real(1));
  return facet;
}

// Where in the table of shares a surface is, from 0 to 1 along both axes: by its roughness, by the cosine to the eye.
FL_FN Vec2 probe_share_place(Real alpha, Real cosine) {
  return Vec2(sqrt(min(max(alpha, Real(0)), Real(1))), sqrt(min(max(cosine, Real(0)), Real(1))));
}
