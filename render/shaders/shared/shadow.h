// Shadows of convex bodies in the light of one beam, after beam.h.
//
// Light moves along lines of constant rho = (x, y) / w, w = R0 + k z, that come from the apex (0, 0, -R0 / k). What a
// body hides is the body and all that is behind it: the points inside every plane through the apex and an edge of the
// body's outline, and behind every face that the light enters. All of them are half-spaces of light space, so the
// shadow of a convex body is convex, and a chord has one shadow of it.
//
// h of a plane at a point over w there is linear in x, the share of the chord's measure (chord_point()): the values at
// the chord's two ends give the place where it changes its sign, without a division by a small slope.
//
// Bodies are parallelepipeds: a box in any direction, in the stretched light space of a rectangular beam as well. What
// lies before the lens plane, z < 0, hides nothing. Error: docs/numerics.md.

// A body in light space: its centre, and from there to the middle of a face of each pair, m. Any may be 0.
struct ShadowSolid {
  Vec3 center;
  Vec3 half_edge[3];
};

// Inside: dot(normal, p) <= offset. The normal is a unit vector, or 0.
struct ShadowPlane {
  Vec3 normal;
  Real offset;
};

// Of 6 pairs of faces and edges at most 3 are fronts, 6 are outlines, and 3 backs cross the lens plane.
#define FL_SHADOW_PLANES 12

// First the planes of the outline, then `fronts` faces that the light enters.
struct ShadowPrism {
  uint count;
  uint fronts;
  Real z_min_m;  // no part of the body is nearer to the lens plane
#ifndef FL_SHADOW_EMIT
  ShadowPlane planes[FL_SHADOW_PLANES];
#endif
};

// FL_SHADOW_EMIT(index, normal, offset): what takes the planes in place of the array. An array of a thread's own with
// an index that its neighbours do not share is long code: lavapipe compiled it for 6 s.
FL_FN void shadow_add_plane(FL_INOUT(ShadowPrism) prism, Vec3 normal, Real offset) {
  Real inverse = inversesqrt(dot(normal, normal));
#ifdef FL_SHADOW_EMIT
  FL_SHADOW_EMIT(prism.count, normal * inverse, offset * inverse);
#else
  prism.planes[prism.count].normal = normal * inverse;
  prism.planes[prism.count].offset = offset * inverse;
#endif
  prism.count += uint(1);
}

// A plane through the apex: rho_plane . (x, y, w) <= 0. False: the whole beam is outside it.
FL_FN bool shadow_add_outline(FL_INOUT(ShadowPrism) prism, Real lens_radius_m, Real spread, Vec3 rho_plane) {
  Real across = rho_plane.x * rho_plane.x + rho_plane.y * rho_plane.y;
  Vec3 normal = Vec3(rho_plane.x, rho_plane.y, spread * rho_plane.z);
  if (!(dot(normal, normal) > Real(1e-30))) return true;  // an edge that is seen end on
  if (rho_plane.z > sqrt(across)) return false;
  if (prism.count < uint(FL_SHADOW_PLANES)) shadow_add_plane(prism, normal, -lens_radius_m * rho_plane.z);
  return true;
}

// The unit normal of the faces of pair i, on the side of half_edge[i], and how far they are from the centre. 0 where
// they have no area.
FL_FN Vec3 shadow_face(FL_IN(ShadowSolid) solid, int i, FL_OUT(Real) away) {
  Vec3 n = cross(solid.half_edge[(i + 1) % 3], solid.half_edge[(i + 2) % 3]);
  Real square = dot(n, n);
  n = square > Real(1e-30) ? n * inversesqrt(square) : Vec3(0, 0, 0);
  if (dot(n, solid.half_edge[i]) < Real(0)) n = n * Real(-1);
  away = dot(n, solid.half_edge[i]);
  return n;
}

// The shadow of a body. False: it has none in the beam.
FL_FN bool shadow_prism(Real lens_radius_m, Real spread, FL_IN(ShadowSolid) solid, FL_OUT(ShadowPrism) prism) {
  prism.count = uint(0);
  prism.fronts = uint(0);
  Vec3 center = solid.center;
  Real reach_z = abs(solid.half_edge[0].z) + abs(solid.half_edge[1].z) + abs(solid.half_edge[2].z);
  prism.z_min_m = max(center.z - reach_z, Real(0));
  // A face in the plane of the lens hides nothing, whatever rounding makes of it.
  if (!(center.z + reach_z > Real(1e-4))) return false;

  // The faces of pair i have the normal +-normal[i], and are `away` from the centre.
  Vec3 normal[3];
  Real away[3];
  bool front[6];  // 2 i: of +normal[i]
  bool crosses[6];
  Real g[6];  // below 0: the apex is outside that face
  bool any_front = false;
  bool inside = true;  // the apex is
  for (int i = 0; i < 3; ++i) {
    Vec3 v = solid.half_edge[(i + 1) % 3];
    Vec3 w = solid.half_edge[(i + 2) % 3];
    Vec3 n = shadow_face(solid, i, away[i]);
    normal[i] = n;
    Real reach = abs(v.z) + abs(w.z);
    for (int side = 0; side < 2; ++side) {
      Real sign = side == 0 ? Real(1) : Real(-1);
      Real face_z = center.z + sign * solid.half_edge[i].z;
      int face = 2 * i + side;
      g[face] = lens_radius_m * sign * n.z + spread * (sign * dot(n, center) + away[i]);
      front[face] = g[face] < Real(0);
      crosses[face] = face_z - reach < Real(0) && face_z + reach > Real(0);
      any_front = any_front || front[face];
      inside = inside && g[face] > Real(0);
    }
  }
  if (!any_front && !inside) return false;  // it has no thickness for the light

  for (int i = 0; i < 3; ++i) {
    int j = (i + 1) % 3;
    int k = (i + 2) % 3;
    Vec3 along = solid.half_edge[i];
    Vec3 along_w = Vec3(along.x, along.y, spread * along.z);
    for (int corner = 0; corner < 4; ++corner) {
      int at_j = corner & 1;
      int at_k = corner >> 1;
      if (front[2 * j + at_j] == front[2 * k + at_k]) continue;
      Vec3 middle = center + solid.half_edge[j] * (at_j == 0 ? Real(1) : Real(-1)) +
                    solid.half_edge[k] * (at_k == 0 ? Real(1) : Real(-1));
      Vec3 rho_plane = cross(Vec3(middle.x, middle.y, lens_radius_m + spread * middle.z), along_w);
      Real size = dot(rho_plane, rho_plane);
      rho_plane = size > Real(0) ? rho_plane * inversesqrt(size) : Vec3(0, 0, 0);
      // The body is inside.
      if (dot(rho_plane, Vec3(center.x, center.y, lens_radius_m + spread * center.z)) > Real(0)) {
        rho_plane = rho_plane * Real(-1);
      }
      if (!shadow_add_outline(prism, lens_radius_m, spread, rho_plane)) return false;
    }
  }
  // The lens plane cuts off what is before it. Where a back face crosses it, the cut is part of the outline.
  for (int face = 0; face < 6; ++face) {
    if (front[face] || !crosses[face]) continue;
    Real sign = (face & 1) == 0 ? Real(1) : Real(-1);
    Vec3 n = normal[face >> 1] * sign;
    Vec3 rho_plane = Vec3(lens_radius_m * n.x, lens_radius_m * n.y, -(dot(n, center) + away[face >> 1]));
    if (!shadow_add_outline(prism, lens_radius_m, spread, rho_plane)) return false;
  }
  for (int face = 0; face < 6; ++face) {
    if (!front[face] || prism.count >= uint(FL_SHADOW_PLANES)) continue;
    Vec3 n = normal[face >> 1] * ((face & 1) == 0 ? Real(1) : Real(-1));
    shadow_add_plane(prism, n, dot(n, center) + away[face >> 1]);
    prism.fronts += uint(1);
  }
  return true;
}

// A lens shines from its whole disc. Its shadows are the mean over those from some points of the disc, each of equal or
// given weight: cubatures of degree 3 (4 points) and 5 (7 points). They are turned so that an edge across an axis
// passes them at even distances. points: 1, 4 or 7.
FL_FN Vec3 lens_point(uint points, uint which, Real lens_radius_m) {
  if (points == uint(4)) {
    Vec3 first = Vec3(0.6708203932499369, 0.22360679774997896, 0);
    Vec3 turned = (which & uint(1)) == uint(0) ? first : Vec3(-first.y, first.x, 0);
    return turned * (which < uint(2) ? lens_radius_m : -lens_radius_m);
  }
  if (which == uint(0)) return Vec3(0, 0, 0);
  uint third = (which - uint(1)) % uint(3);
  Vec3 first = Vec3(0.8017837257372732, 0.15430334996209188, 0);
  if (third == uint(1)) first = Vec3(0.26726124191242456, 0.7715167498104596, 0);
  if (third == uint(2)) first = Vec3(-0.5345224838248486, 0.6172133998483678, 0);
  return first * (which < uint(4) ? lens_radius_m : -lens_radius_m);
}
FL_FN Real lens_point_weight(uint points, uint which) {
  if (points == uint(7)) return which == uint(0) ? Real(0.25) : Real(0.125);
  return points == uint(4) ? Real(0.25) : Real(1);
}

// Each point stands for the part of the lens around it, a disc of this radius over R0: so the steps between the points'
// edges are ramps.
FL_FN Real lens_part_radius(uint points) { return points == uint(7) ? Real(0.37796447300922725) : Real(0.5); }
// The share of the way from a point to a place at which light passes a front; values: of the front's plane, > 0
// outside. At the outline the largest of all fronts is where it passes the body.
FL_FN Real shadow_front_at(Real at_point, Real at_place) { return at_point / max(at_point - at_place, Real(1e-9)); }
// The share of a disc of this radius around a point that an edge of the outline hides from a place. outside_m: how far
// the place is outside the plane through the point and the edge; across: length of that plane's normal along the lens;
// at: as above.
FL_FN Real shadow_ramp(Real outside, Real half_width) {
  Real x = clamp(Real(0.5) - Real(0.5) * outside / max(half_width, Real(1e-6)), Real(0), Real(1));
  return x * x * (Real(3) - Real(2) * x);
}
FL_FN Real shadow_edge_share(Real outside_m, Real across, Real radius_m, Real at) {
  return shadow_ramp(outside_m, radius_m * across * (Real(1) / max(at, Real(1e-4)) - Real(1)));
}

// The shadow of a body in light from one point of the lens plane: all behind its faces that are lit from there, between
// the planes through the point and its outline. What is before the lens plane adds nothing beyond it. False: no shadow.
FL_FN bool shadow_prism_from(Vec3 point, FL_IN(ShadowSolid) solid, FL_OUT(ShadowPrism) prism) {
  prism.count = uint(0);
  prism.fronts = uint(0);
  Vec3 center = solid.center;
  Real reach_z = abs(solid.half_edge[0].z) + abs(solid.half_edge[1].z) + abs(solid.half_edge[2].z);
  prism.z_min_m = max(center.z - reach_z, Real(0));
  if (!(center.z + reach_z > Real(1e-4))) return false;
  Vec3 normal[3];
  Real away[3];
  bool front[6];  // as in shadow_prism()
  bool any_front = false;
  bool inside = true;  // the point is
  for (int i = 0; i < 3; ++i) {
    Vec3 n = shadow_face(solid, i, away[i]);
    normal[i] = n;
    Real at = dot(n, center - point);
    front[2 * i] = at + away[i] < Real(0);
    front[2 * i + 1] = away[i] - at < Real(0);
    any_front = any_front || front[2 * i] || front[2 * i + 1];
    inside = inside && at + away[i] > Real(0) && away[i] - at > Real(0);
  }
  if (!any_front && !inside) return false;  // it has no thickness for the light
  for (int i = 0; i < 3; ++i) {
    int j = (i + 1) % 3;
    int k = (i + 2) % 3;
    for (int corner = 0; corner < 4; ++corner) {
      int at_j = corner & 1;
      int at_k = corner >> 1;
      if (front[2 * j + at_j] == front[2 * k + at_k]) continue;
      Vec3 middle = center + solid.half_edge[j] * (at_j == 0 ? Real(1) : Real(-1)) +
                    solid.half_edge[k] * (at_k == 0 ? Real(1) : Real(-1));
      Vec3 n = cross(middle - point, solid.half_edge[i]);
      if (!(dot(n, n) > Real(1e-30))) continue;  // an edge that is seen end on
      if (dot(n, center - point) > Real(0)) n = n * Real(-1);
      shadow_add_plane(prism, n, dot(n, point));
    }
  }
  for (int face = 0; face < 6; ++face) {
    if (!front[face]) continue;
    Vec3 n = normal[face >> 1] * ((face & 1) == 0 ? Real(1) : Real(-1));
    shadow_add_plane(prism, n, dot(n, center) + away[face >> 1]);
    prism.fronts += uint(1);
  }
  return true;
}

// Cuts the part x0..x1 of a chord to what is inside a plane; from, to: h over w at the chord's ends. False: nothing is
// left, and x0 and x1 mean nothing.
FL_FN bool shadow_cut(Real from, Real to, FL_INOUT(Real) x0, FL_INOUT(Real) x1) {
  Real at = from / (from - to);
  x0 = from > Real(0) ? max(x0, at) : x0;
  x1 = !(from > Real(0)) && to > Real(0) ? min(x1, at) : x1;
  return (!(from > Real(0)) || to <= Real(0)) && x1 > x0;
}

// The same for an outline whose edge is a ramp, half_from and half_to wide at the chord's ends: hard is cut where the
// ramp has its middle, outer where it begins, inner where it ends. All are from x to y. A part that is empty has x > y.
FL_FN void shadow_cut_soft(Real from, Real to, Real half_from, Real half_to, FL_INOUT(Vec2) hard, FL_INOUT(Vec2) outer,
                           FL_INOUT(Vec2) inner) {
  if (!shadow_cut(from, to, hard.x, hard.y)) hard.y = Real(-1);
  if (!shadow_cut(from - half_from, to - half_to, outer.x, outer.y)) outer.y = Real(-1);
  if (!shadow_cut(from + half_from, to + half_to, inner.x, inner.y)) inner.y = Real(-1);
}

// What stands for the shadow on a chord that is nowhere wholly within an outline's ramps. shares: of the lens that is
// hidden at a quarter, the middle and three quarters of `outer`. Where they are alike, as on a line of sight along an
// edge, it is as long as their mean says; where they are not, it is hard. Then many lens points and rays make it soft.
FL_FN Vec2 shadow_soft_part(Vec2 hard, Vec2 outer, Vec3 shares) {
  Real middle = Real(0.5) * (outer.x + outer.y);
  Real half_length = Real(0.25) * (shares.x + shares.z) * (outer.y - outer.x);
  Real most = max(shares.x, max(shares.y, shares.z));
  Real least = min(shares.x, min(shares.y, shares.z));
  Real apart = clamp((most - least) * Real(2.5) - Real(0.25), Real(0), Real(1));
  if (!(hard.y > hard.x)) hard = Vec2(middle, middle);
  return Vec2(middle - half_length, middle + half_length) * (Real(1) - apart) + hard * apart;
}

// Disjoint parts of a chord that are in shadow, in shares of its measure, in any order. An empty one is from 2 to 2.
// When more than these do not touch each other, the narrowest is given up.
#define FL_SHADOW_PARTS 6
struct ShadowParts {
  Real from[FL_SHADOW_PARTS];
  Real to[FL_SHADOW_PARTS];
};

FL_FN void shadow_parts_clear(FL_OUT(ShadowParts) parts) {
  for (int i = 0; i < FL_SHADOW_PARTS; ++i) {
    parts.from[i] = Real(2);
    parts.to[i] = Real(2);
  }
}

FL_FN void shadow_parts_add(FL_INOUT(ShadowParts) parts, Real from, Real to) {
  for (int i = 0; i < FL_SHADOW_PARTS; ++i) {
    bool joins = parts.from[i] <= to && parts.to[i] >= from;
    from = joins ? min(from, parts.from[i]) : from;
    to = joins ? max(to, parts.to[i]) : to;
    parts.from[i] = joins ? Real(2) : parts.from[i];
    parts.to[i] = joins ? Real(2) : parts.to[i];
  }
  // It takes the place of the first one that is narrower, and that one the next place, and so on: widest first.
  for (int i = 0; i < FL_SHADOW_PARTS; ++i) {
    bool wider = to - from > parts.to[i] - parts.from[i];
    Real other_from = parts.from[i];
    Real other_to = parts.to[i];
    parts.from[i] = wider ? from : other_from;
    parts.to[i] = wider ? to : other_to;
    from = wider ? other_from : from;
    to = wider ? other_to : to;
  }
}

// The next shadow from x on. False: there is none. Then the rest of the chord is lit.
FL_FN bool shadow_parts_next(FL_IN(ShadowParts) parts, Real x, FL_OUT(Real) from, FL_OUT(Real) to) {
  from = Real(2);
  to = Real(2);
  for (int i = 0; i < FL_SHADOW_PARTS; ++i) {
    bool nearer = parts.from[i] >= x && parts.from[i] < from;
    from = nearer ? parts.from[i] : from;
    to = nearer ? parts.to[i] : to;
  }
  return from < Real(1.5);
}

// Where light is let through only on parts of a chord, more of it here than there: the nodes of the whole chord stay,
// and only their weights change. Sums over the parts of their weight times the integrals of the Legendre polynomials
// over [0, 1] give them. values: as many as there are nodes, 2 to 8.
struct ShadowWeights {
  Real values[8];
};
FL_FN void shadow_weights_clear(FL_OUT(ShadowWeights) weights) {
  for (int k = 0; k < 8; ++k) weights.values[k] = Real(0);
}
FL_FN void shadow_weights_add(FL_INOUT(ShadowWeights) weights, Real share, Real from, Real to) {
  // (2 k + 1) times the integral of P_k is the difference of its neighbours.
  Real u = Real(2) * from - Real(1);
  Real v = Real(2) * to - Real(1);
  Real u_before = Real(1);
  Real v_before = Real(1);
  Real u_here = u;
  Real v_here = v;
  weights.values[0] += share * (to - from);
  for (int k = 1; k < 8; ++k) {
    Real u_next = (Real(2 * k + 1) * u * u_here - Real(k) * u_before) / Real(k + 1);
    Real v_next = (Real(2 * k + 1) * v * v_here - Real(k) * v_before) / Real(k + 1);
    weights.values[k] += share * Real(0.5) * ((v_next - v_before) - (u_next - u_before));
    u_before = u_here;
    v_before = v_here;
    u_here = u_next;
    v_here = v_next;
  }
}
// From the dark parts to the lit ones.
FL_FN void shadow_weights_invert(FL_INOUT(ShadowWeights) weights) {
  for (int k = 0; k < 8; ++k) weights.values[k] = (k == 0 ? Real(1) : Real(0)) - weights.values[k];
}
// What the weight of a node at x is multiplied with; 1 where all of the chord was added.
FL_FN Real shadow_weight(FL_IN(ShadowWeights) weights, uint nodes, Real x) {
  Real u = Real(2) * x - Real(1);
  Real before = Real(1);
  Real here = u;
  Real sum = weights.values[0];
  for (int k = 1; k < 8; ++k) {
    sum += uint(k) < nodes ? weights.values[k] * here : Real(0);
    Real next = (Real(2 * k + 1) * u * here - Real(k) * before) / Real(k + 1);
    before = here;
    here = next;
  }
  return sum;
}
// As chord_inscatter_gauss(), of 2 nodes or more.
FL_FN Real chord_inscatter_shaded(BeamShape beam, Medium medium, Chord chord, Vec3 d, uint n,
                                  FL_IN(ShadowWeights) weights, bool with_extinction) {
  Real total = Real(0);
#ifdef FL_HAZE_FIELD
  HazePieces haze = haze_pieces(chord);
  Real end = Real(0);
#endif
  for (uint i = uint(0); i < n; ++i) {
    Real s;
    Real t_m;
    Real x = kGaussNode[gauss_index(n, i)];
    chord_point(chord, x, s, t_m);
    Real weight = kGaussWeight[gauss_index(n, i)];
#ifdef FL_HAZE_FIELD
    end += weight;
    weight *= haze_piece(haze, chord, end);
#endif
    weight *= shadow_weight(weights, n, x);
    total += weight * chord_integrand(beam, medium, chord, d, s, t_m, with_extinction, true);
  }
  return max(total, Real(0)) * chord_measure(chord);
}

// The light of a chord up to a share x of its measure, as a polynomial in u = 2 x - 1: what Gauss nodes of the whole
// chord interpolate, in even haze. Each further part of a chord then costs a polynomial, and no light is computed anew.
// FL_SERIES_NODES_MAX: of the including file, 6 or 8. FL_UNROLL: what tells its compiler to write a loop out.
#ifndef FL_UNROLL
#define FL_UNROLL
#endif
#ifndef FL_SERIES_NODES_MAX
#define FL_SERIES_NODES_MAX 8
#endif
struct ShadowSeries {
  Real powers[FL_SERIES_NODES_MAX + 1];  // of u
  Real whole;                            // up to x = 1
};
// n: 2 to FL_SERIES_NODES_MAX.
FL_FN void shadow_series(BeamShape beam, Medium medium, Chord chord, Vec3 d, uint n, bool with_extinction,
                         FL_OUT(ShadowSeries) series) {
  Real mean[FL_SERIES_NODES_MAX + 2];  // of the light times P_k
  for (int k = 0; k < FL_SERIES_NODES_MAX + 2; ++k) mean[k] = Real(0);
  Real measure = chord_measure(chord);
  FL_UNROLL for (uint i = uint(0); i < n; ++i) {
    Real s;
    Real t_m;
    Real x = kGaussNode[gauss_index(n, i)];
    chord_point(chord, x, s, t_m);
    Real weight = kGaussWeight[gauss_index(n, i)];
    weight *= measure * chord_integrand(beam, medium, chord, d, s, t_m, with_extinction, true);
    Real u = Real(2) * x - Real(1);
    Real before = Real(1);
    Real here = u;
    mean[0] += weight;
    for (int k = 1; k < FL_SERIES_NODES_MAX; ++k) {
      mean[k] += uint(k) < n ? weight * here : Real(0);
      Real next = (Real(2 * k + 1) * u * here - Real(k) * before) / Real(k + 1);
      before = here;
      here = next;
    }
  }
  // (2 k + 1) times the integral of P_k is the difference of its neighbours: a sum of v[k] P_k.
  Real v[FL_SERIES_NODES_MAX + 1];
  v[0] = Real(0.5) * (mean[0] - mean[1]);
  for (int k = 1; k <= FL_SERIES_NODES_MAX; ++k) v[k] = Real(0.5) * (mean[k - 1] - mean[k + 1]);
  series.whole = mean[0];
  series.powers[0] = v[0] - Real(0.5) * v[2] + Real(0.375) * v[4] - Real(0.3125) * v[6];
  series.powers[1] = v[1] - Real(1.5) * v[3] + Real(1.875) * v[5];
  series.powers[2] = Real(1.5) * v[2] - Real(3.75) * v[4] + Real(6.5625) * v[6];
  series.powers[3] = Real(2.5) * v[3] - Real(8.75) * v[5];
  series.powers[4] = Real(4.375) * v[4] - Real(19.6875) * v[6];
  series.powers[5] = Real(7.875) * v[5];
  series.powers[6] = Real(14.4375) * v[6];
#if FL_SERIES_NODES_MAX > 6
  series.powers[0] += Real(0.2734375) * v[8];
  series.powers[1] -= Real(2.1875) * v[7];
  series.powers[2] -= Real(9.84375) * v[8];
  series.powers[3] += Real(19.6875) * v[7];
  series.powers[4] += Real(54.140625) * v[8];
  series.powers[5] -= Real(43.3125) * v[7];
  series.powers[6] -= Real(93.84375) * v[8];
  series.powers[7] = Real(26.8125) * v[7];
  series.powers[8] = Real(50.2734375) * v[8];
#endif
}
FL_FN Real shadow_series_until(FL_IN(ShadowSeries) series, Real x) {
  Real u = Real(2) * x - Real(1);
  Real sum = series.powers[FL_SERIES_NODES_MAX];
  for (int k = FL_SERIES_NODES_MAX - 1; k >= 0; --k) sum = sum * u + series.powers[k];
  return sum;
}

// The part x0..x1 of a chord.
FL_FN Chord chord_part(Chord chord, Real x0, Real x1) {
  Chord part = chord;
  chord_point(chord, x0, part.s_from, part.t_from_m);
  chord_point(chord, x1, part.s_to, part.t_to_m);
  part.w_from = max(chord.w_base + part.t_from_m * chord.w_slope, Real(1e-9));
  part.w_to = max(chord.w_base + part.t_to_m * chord.w_slope, Real(1e-9));
  return part;
}
