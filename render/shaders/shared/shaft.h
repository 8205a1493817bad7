// The light of the sun behind a pane of glass: docs/decisions/0138. C++ and GLSL; rules in sim/shared/real.h. After
// shadow.h.
//
// The light is parallel, so places along a ray have their picture on the glass on a straight line, and everything is
// linear in the share x, 0 to 1, of the part of a ray that is in the shaft: u and v on the glass, c behind it, and how
// far light has gone. In a cell between the middles of four texels the glass is a polynomial of x of degree 2.

// Integrals over y from 0 to 1 of exp(-loss y), y exp(-loss y) and y^2 exp(-loss y), for loss >= 0.
FL_FN Vec3 shaft_moments(Real loss) {
  if (loss < Real(0.7)) {
    Vec3 sum = Vec3(Real(1), Real(0.5), Real(0.3333333333333333));
    if (loss == Real(0)) return sum;
    Real term = Real(1);
    for (uint n = uint(1); n <= uint(9); ++n) {
      term *= -loss / Real(n);
      sum += term * Vec3(Real(1) / Real(n + uint(1)), Real(1) / Real(n + uint(2)), Real(1) / Real(n + uint(3)));
    }
    return sum;
  }
  Real end = exp(-loss);
  Real whole = (Real(1) - end) / loss;
  Real first = (whole - end) / loss;
  return Vec3(whole, first, (Real(2) * first - end) / loss);
}

// Integral over y from 0 to 1 of the polynomial through three values, at 0, 1/2 and 1, times the light that is left:
// exp(-g), where g goes from gone_begin to gone_end, both >= 0.
FL_FN Vec3 shaft_cell(Vec3 begin, Vec3 middle, Vec3 end, Real gone_begin, Real gone_end) {
  // From the end on where more is left.
  bool turned = gone_end < gone_begin;
  Vec3 a = turned ? end : begin;
  Vec3 b = turned ? begin : end;
  Vec3 bent = Real(2) * (a + b) - Real(4) * middle;
  Vec3 slope = b - a - bent;
  Vec3 m = shaft_moments(abs(gone_end - gone_begin));
  return exp(-min(gone_begin, gone_end)) * (a * m.x + slope * m.y + bent * m.z);
}

// Keeps of x0..x1 what is between -1 and 1; from, to: the value at x = 0 and 1.
FL_FN bool shaft_cut(Real from, Real to, FL_INOUT(Real) x0, FL_INOUT(Real) x1) {
  return shadow_cut(from - Real(1), to - Real(1), x0, x1) && shadow_cut(Real(-1) - from, Real(-1) - to, x0, x1);
}

// A solid in a shaft: a parallelepiped around a centre.
struct ShaftSolid {
  Vec3 center;
  Vec3 half_0;
  Vec3 half_1;
  Vec3 half_2;
};

// The part of a ray, from one place to another, for which a solid hides the sun: from there back towards the pane, at
// a distance of nearest_m or more and before the pane, the path is in the solid. In the plane of x and the distance
// this is a convex figure of eight edges; what it covers of x follows from all pairs of a lower and an upper bound of
// the distance. from_c, to_c: how far behind the pane the two places are.
FL_FN bool shaft_shadow(FL_IN(ShaftSolid) solid, Vec3 sun, Vec3 from, Vec3 to, Real from_c, Real to_c, Real nearest_m,
                        FL_INOUT(Real) x0, FL_INOUT(Real) x1) {
  Real low_from[4];
  Real low_to[4];
  Real high_from[4];
  Real high_to[4];
  Real speed[4];
  Vec3 a = from - solid.center;
  Vec3 b = to - solid.center;
  Real reach = abs(dot(cross(solid.half_0, solid.half_1), solid.half_2));
  for (uint i = uint(0); i < uint(3); ++i) {
    Vec3 n = i == uint(0)   ? cross(solid.half_1, solid.half_2)
             : i == uint(1) ? cross(solid.half_2, solid.half_0)
                            : cross(solid.half_0, solid.half_1);
    Real along = dot(n, sun);
    if (along < Real(0)) n = n * Real(-1);
    speed[i] = abs(along);
    low_from[i] = dot(n, a) - reach;
    low_to[i] = dot(n, b) - reach;
    high_from[i] = dot(n, a) + reach;
    high_to[i] = dot(n, b) + reach;
  }
  low_from[3] = nearest_m;
  low_to[3] = nearest_m;
  high_from[3] = from_c;
  high_to[3] = to_c;
  speed[3] = Real(1);
  for (uint i = uint(0); i < uint(4); ++i) {
    for (uint j = uint(0); j < uint(4); ++j) {
      if (!shadow_cut(low_from[i] * speed[j] - high_from[j] * speed[i], low_to[i] * speed[j] - high_to[j] * speed[i],
                      x0, x1)) {
        return false;
      }
    }
  }
  return reach > Real(0);
}

// Disjoint dark parts of a ray in a shaft, ascending. When there are more than these, the narrowest are given up.
#define FL_SHAFT_PARTS 8
struct ShaftDark {
  uint count;
  Real from[FL_SHAFT_PARTS];
  Real to[FL_SHAFT_PARTS];
};

FL_FN void shaft_add_dark(FL_INOUT(ShaftDark) dark, Real x0, Real x1) {
  // Takes out those that it touches.
  uint kept = uint(0);
  for (uint i = uint(0); i < dark.count; ++i) {
    if (dark.to[i] < x0 || dark.from[i] > x1) {
      dark.from[kept] = dark.from[i];
      dark.to[kept] = dark.to[i];
      kept += uint(1);
    } else {
      x0 = min(x0, dark.from[i]);
      x1 = max(x1, dark.to[i]);
    }
  }
  if (kept == uint(FL_SHAFT_PARTS)) {
    uint least = uint(0);
    for (uint i = uint(1); i < kept; ++i) {
      if (dark.to[i] - dark.from[i] < dark.to[least] - dark.from[least]) least = i;
    }
    dark.count = kept;
    if (x1 - x0 <= dark.to[least] - dark.from[least]) return;
    kept -= uint(1);
    for (uint i = least; i < kept; ++i) {
      dark.from[i] = dark.from[i + uint(1)];
      dark.to[i] = dark.to[i + uint(1)];
    }
  }
  uint at = kept;
  for (; at > uint(0) && dark.from[at - uint(1)] > x0; --at) {
    dark.from[at] = dark.from[at - uint(1)];
    dark.to[at] = dark.to[at - uint(1)];
  }
  dark.from[at] = x0;
  dark.to[at] = x1;
  dark.count = kept + uint(1);
}
