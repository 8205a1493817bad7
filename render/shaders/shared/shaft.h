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

// The same as what lies between three pairs of planes: dot(normal, place) is within `reach` of a middle. The normals
// are turned to where the light goes, and `speed` is what dot(normal, place) grows by along a metre of light.
struct ShaftSlabs {
  Vec3 normal_0;
  Vec3 normal_1;
  Vec3 normal_2;
  Vec3 middle;
  Vec3 speed;
  Real reach;  // 0: the solid is flat, and hides nothing
};

FL_FN ShaftSlabs shaft_slabs(FL_IN(ShaftSolid) solid, Vec3 sun) {
  ShaftSlabs slabs;
  slabs.normal_0 = cross(solid.half_1, solid.half_2);
  slabs.normal_1 = cross(solid.half_2, solid.half_0);
  slabs.normal_2 = cross(solid.half_0, solid.half_1);
  slabs.reach = abs(dot(slabs.normal_2, solid.half_2));
  slabs.speed = Vec3(dot(slabs.normal_0, sun), dot(slabs.normal_1, sun), dot(slabs.normal_2, sun));
  if (slabs.speed.x < Real(0)) slabs.normal_0 = slabs.normal_0 * Real(-1);
  if (slabs.speed.y < Real(0)) slabs.normal_1 = slabs.normal_1 * Real(-1);
  if (slabs.speed.z < Real(0)) slabs.normal_2 = slabs.normal_2 * Real(-1);
  slabs.speed = abs(slabs.speed);
  slabs.middle = Vec3(dot(slabs.normal_0, solid.center), dot(slabs.normal_1, solid.center),
                      dot(slabs.normal_2, solid.center));
  return slabs;
}

// The part of a ray, from one place to another, for which a solid hides the sun: from there back towards the pane, at
// a distance of nearest_m or more and before the pane, the path is in the solid. In the plane of x and the distance
// this is a convex figure of eight edges; what it covers of x follows from all pairs of a lower and an upper bound of
// the distance. from_c, to_c: how far behind the pane the two places are.
FL_FN bool shaft_shadow(FL_IN(ShaftSlabs) slabs, Vec3 from, Vec3 to, Real from_c, Real to_c, Real nearest_m,
                        FL_INOUT(Real) x0, FL_INOUT(Real) x1) {
  Vec3 a = Vec3(dot(slabs.normal_0, from), dot(slabs.normal_1, from), dot(slabs.normal_2, from)) - slabs.middle;
  Vec3 b = Vec3(dot(slabs.normal_0, to), dot(slabs.normal_1, to), dot(slabs.normal_2, to)) - slabs.middle;
  for (int i = 0; i < 3; ++i) {
    Real speed = slabs.speed[i];
    // Between this pair of planes and another, from the pane on, and up to the place.
    for (int j = 0; j < 3; ++j) {
      if (i == j) continue;
      if (!shadow_cut((a[i] - slabs.reach) * slabs.speed[j] - (a[j] + slabs.reach) * speed,
                      (b[i] - slabs.reach) * slabs.speed[j] - (b[j] + slabs.reach) * speed, x0, x1)) {
        return false;
      }
    }
    if (!shadow_cut(a[i] - slabs.reach - from_c * speed, b[i] - slabs.reach - to_c * speed, x0, x1)) return false;
    if (!shadow_cut(nearest_m * speed - a[i] - slabs.reach, nearest_m * speed - b[i] - slabs.reach, x0, x1)) {
      return false;
    }
  }
  return shadow_cut(nearest_m - from_c, nearest_m - to_c, x0, x1) && slabs.reach > Real(0);
}

// Disjoint dark parts of a ray in a shaft, ascending. When there are more than these, the narrowest are given up.
#define FL_SHAFT_PARTS 16
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

// Lines on the glass through the point E that the sun's light through the camera crosses: the picture of a ray lies on
// one of them, from E on. In places of the glass, where its rectangle goes from -1 to 1, four fans of lines have p
// along u, against u, along v and against v, and q = (the other - that of E) / p is between -1 and 1. E may lie
// anywhere.
struct ShaftFan {
  Real q_low;  // of the lines that meet the rectangle; none do if it is not below q_high
  Real q_high;
  Real p_low;  // between which the rectangle lies
  Real p_high;
};

FL_FN ShaftFan shaft_fan(uint side, Vec2 eye) {
  Vec2 low = Vec2(-1, -1) - eye;
  Vec2 high = Vec2(1, 1) - eye;
  bool upright = side >= uint(2);
  bool turned = (side & uint(1)) != uint(0);
  Vec2 p = upright ? Vec2(low.y, high.y) : Vec2(low.x, high.x);
  Vec2 other = upright ? Vec2(low.x, high.x) : Vec2(low.y, high.y);
  if (turned) p = Vec2(-p.y, -p.x);
  ShaftFan fan;
  fan.p_low = max(p.x, Real(0));
  fan.p_high = p.y;
  fan.q_low = Real(1);
  fan.q_high = Real(-1);
  if (!(p.y > Real(0))) return fan;
  // The steepest line meets a near corner, if it is not beyond 45 degrees there.
  Real near_low = -other.x >= fan.p_low ? Real(-1) : other.x / fan.p_low;
  Real near_high = other.y >= fan.p_low ? Real(1) : other.y / fan.p_low;
  fan.q_low = other.x < Real(0) ? near_low : min(other.x / fan.p_high, Real(1));
  fan.q_high = other.y > Real(0) ? near_high : max(other.y / fan.p_high, Real(-1));
  return fan;
}

// The side of the fan that the picture of a ray lies in; way: u and v of the ray.
FL_FN uint shaft_fan_side(Vec2 way) {
  bool upright = abs(way.y) > abs(way.x);
  return (upright ? uint(2) : uint(0)) + ((upright ? way.y : way.x) < Real(0) ? uint(1) : uint(0));
}
FL_FN Vec2 shaft_fan_place(uint side, Vec2 eye, Real q, Real p) {
  Real along = (side & uint(1)) != uint(0) ? -p : p;
  return eye + (side >= uint(2) ? Vec2(q * p, along) : Vec2(along, q * p));
}

// Of exp(-loss y), y from -1/2 to 1/2: its mean, and the slope of the line with the least squares; for a loss between
// -FL_SHAFT_PIECE_LOSS and FL_SHAFT_PIECE_LOSS.
#define FL_SHAFT_PIECE_LOSS 0.5
FL_FN Vec2 shaft_line(Real loss) {
  Real square = loss * loss;
  return Vec2(Real(1) + square * (Real(1) / Real(24) + square / Real(1920)),
              -loss * (Real(1) + square * (Real(1) / Real(40) + square / Real(4480))));
}
