// The light of displays: docs/decisions/0139. C++ and GLSL; rules in sim/shared/real.h. After beam.h.
//
// Everything is in the space of a display: from its middle to the right, down, and outwards. A cell is a rectangle in
// its plane with a mean luminance and moments; `from` is a vector from the place that is lit to its middle, so from.z =
// -(distance of the place from the plane). Places behind the plane get no light.

// What the edge of a polygon adds to twice its form factor times pi: the angle between two corners, along the normal.
FL_FN Real display_edge(Vec3 a, Vec3 b, Vec3 normal) {
  Vec3 c = cross(a, b);
  Real size = sqrt(dot(c, c));
  if (!(size > Real(0))) return Real(0);
  return dot(c, normal) / size * FL_ATAN2(size, dot(a, b));
}

// The integral over a rectangle of both cosines over the square of the distance: Lambert's sum over its edges, of the
// part above the horizon of the surface. half_x, half_y: halves of its sides.
FL_FN Real display_form(Vec3 from, Real half_x, Real half_y, Vec3 normal) {
  Real sum = Real(0);
  Vec3 leaves = Vec3(0, 0, 0);
  Vec3 enters = Vec3(0, 0, 0);
  Vec3 a = from + Vec3(-half_x, -half_y, 0);
  Real above_a = dot(a, normal);
  for (uint i = uint(0); i < uint(4); ++i) {
    Vec3 b = from + Vec3(i == uint(1) || i == uint(2) ? half_x : -half_x, i < uint(2) ? half_y : -half_y, 0);
    Real above_b = dot(b, normal);
    Vec3 begin = a;
    Vec3 end = b;
    if ((above_a > Real(0)) != (above_b > Real(0))) {
      Vec3 at = a + (b - a) * (above_a / (above_a - above_b));
      if (above_a > Real(0)) {
        end = at;
        leaves = at;
      } else {
        begin = at;
        enters = at;
      }
    }
    if (above_a > Real(0) || above_b > Real(0)) sum += display_edge(begin, end, normal);
    a = b;
    above_a = above_b;
  }
  sum += display_edge(leaves, enters, normal);  // along the horizon
  return max(Real(0.5) * sum, Real(0));
}

// The solid angle of a rectangle, exactly: of the quadrants at its corners, whose angles are added as complex numbers.
FL_FN Real display_corners(Real low, Real high, Real y, Real away) {
  Real rest = y * y + away * away;
  Real near = away * sqrt(low * low + rest);
  Real far = away * sqrt(high * high + rest);
  return FL_ATAN2((high * near - low * far) * y, far * near + low * high * y * y);
}
FL_FN Real display_angle(Vec3 from, Real half_x, Real half_y) {
  Real low = from.x - half_x;
  Real high = from.x + half_x;
  Real angle = display_corners(low, high, from.y + half_y, -from.z) -
               display_corners(low, high, from.y - half_y, -from.z);
  return max(angle, Real(0));
}

// How far the nearest place of a rectangle is, in its plane and off it.
FL_FN Real display_distance(Vec3 place, Real half_x, Real half_y) {
  Real x = max(abs(place.x) - half_x, Real(0));
  Real y = max(abs(place.y) - half_y, Real(0));
  return sqrt(x * x + y * y + place.z * place.z);
}

// Along a ray, the distance between begin and end at which it is nearest the rectangle. The distance is convex.
FL_FN Real display_nearest(Vec3 eye, Vec3 way, Real half_x, Real half_y, Real begin, Real end) {
  Real middle = -dot(eye, way);
  Real reach = sqrt(half_x * half_x + half_y * half_y);
  Real low = clamp(middle - reach, begin, end);
  Real high = clamp(middle + reach, begin, end);
  for (uint i = uint(0); i < uint(16); ++i) {
    Real t = Real(0.5) * (low + high);
    Vec3 at = eye + way * t;
    Real x = at.x - clamp(at.x, -half_x, half_x);
    Real y = at.y - clamp(at.y, -half_y, half_y);
    bool ahead = x * way.x + y * way.y + at.z * way.z < Real(0);
    low = ahead ? t : low;
    high = ahead ? high : t;
  }
  return Real(0.5) * (low + high);
}
