// What is meant by frost, blades, wheels between two slots, animation wheels and focus: the numbers that the renderer
// and its judge share. How light is integrated through them is each one's own. After sim/shared/real.h.

// The half angle that is drawn where a zoom asks for `zoom`, rad: up to 87.5 degrees, of a measured beam 89. The longer
// side of a rectangle has 1.2 rad at most. aspect: its width over its height, zoom is that of its width; 0: round.
FL_FN Real drawn_half_angle(Real zoom, Real aspect, bool is_measured) {
  Real widest = is_measured ? Real(1.5533430342749532) : Real(1.5271630954950384);
  if (aspect > Real(0)) widest = atan(Real(2.5721516221263188) * min(aspect, Real(1)));
  return clamp(zoom, Real(0), widest);
}

// Frost: the profile falls off ever more softly, the beam widens by up to half and up to 3 degrees, images blur.
// Amounts are chosen by eye; the flux stays.
FL_CONST float kFrostWidens = 0.5f;
FL_CONST float kFrostAdds = 0.05f;
FL_CONST float kFrostBlur = 0.29f;  // radius of the blur at full, in beam radii

// The profile, softened by `amount` 0 to 1 in six steps from 1 - rho^8 to (1 - rho^2)^4.
FL_FN Real softened_profile(Real profile_power, Real amount) {
  // Where the profile stands on that way, 0 to 6.
  Real at = profile_power > Real(3.5)    ? Real(0)
            : profile_power > Real(2.5)  ? Real(1)
            : profile_power > Real(1.5)  ? Real(2)
            : profile_power > Real(0.75) ? Real(3)
            : profile_power > Real(0.42) ? Real(4)
            : profile_power > Real(0.29) ? Real(5)
                                         : Real(6);
  Real step = min(at + floor(clamp(amount, Real(0), Real(1)) * Real(6) + Real(0.5)), Real(6));
  return step < Real(3.5) ? Real(4) - step : Real(1) / (step - Real(2));
}

// An iris cuts the profile: the light within stays as it is and the edge is sharp. Frost and focus soften that edge as
// they soften the rim of an open beam: at 1/6 of their range, one step of the profile, all of the profile fits into the
// iris. What it lets through stays. Returns the share of the profile's radius that is cut off, 0 to 1 - iris.
FL_FN Real iris_hidden(Real iris, Real soft) {
  return (Real(1) - iris) * (Real(1) - clamp(Real(6) * soft, Real(0), Real(1)));
}

// The edge of blade i: 0 bottom, 1 left, 2 top, 3 right, looking along the beam; y of the gobo plane points down. Its
// two ends are in by a and b, shares of the way from the rim to the middle. What has x X + y Y <= z passes.
FL_FN Vec3 blade_edge(uint i, Real a, Real b, Real angle_rad) {
  Vec2 n = i == uint(0) ? Vec2(0, 1) : i == uint(1) ? Vec2(-1, 0) : i == uint(2) ? Vec2(0, -1) : Vec2(1, 0);
  // In by a at one end and by b at the other: a straight line through both.
  Real lean = Real(0.5) * (b - a);
  Vec2 m = Vec2(n.x - n.y * lean, n.y + n.x * lean);
  Real size = sqrt(m.x * m.x + m.y * m.y);
  Real c = cos(angle_rad);
  Real s = sin(angle_rad);
  return Vec3((c * m.x - s * m.y) / size, (s * m.x + c * m.y) / size, (Real(1) - Real(0.5) * (a + b)) / size);
}
// On a surface the edge of a blade is as soft as this, in beam radii, in focus. Chosen by eye.
FL_CONST float kBladeSoft = 0.02f;

// An animation wheel: its image turns about a point beside the beam. All in beam radii; assumptions.
FL_CONST float kAnimationAwayX = 2.0f;  // of that point from the middle of the beam
FL_CONST float kAnimationRadius = 3.2f;

// Where a gobo wheel stands between two slots: its plate is dark but for the slots' openings, which are kWheelOpening
// apart. p: the place in the gate; offset: of the nearest slot's middle. True: p is in the opening of the slot beside.
FL_FN bool wheel_slot_at(Vec2 p, Real offset, FL_OUT(Vec2) at) {
  Real apart = Real(1) / Real(kWheelOpening);
  Real side = offset < Real(0) ? apart : -apart;
  at = Vec2(p.x - offset, p.y);
  bool beside = abs(at.x) > abs(at.x - side);
  if (beside) at.x -= side;
  return beside;
}

// Defocus: light of a point of the gate leaves the lens over its whole opening and meets again where it is in focus,
// 1 / focus_per_m away. At the distance z_m from the lens, light from the rim of the lens is this far from the middle,
// in beam radii; beyond the focus it is on the other side, which is negative.
FL_FN Real focus_shift(Real lens_radius_m, Real spread, Real z_m, Real focus_per_m) {
  if (focus_per_m < Real(0)) return Real(0);
  Real z = max(z_m, Real(0));
  return lens_radius_m * (Real(1) - z * focus_per_m) / max(lens_radius_m + spread * z, Real(1e-9));
}
// The point becomes a disc of this radius.
FL_FN Real focus_blur(Real lens_radius_m, Real spread, Real z_m, Real focus_per_m) {
  return abs(focus_shift(lens_radius_m, spread, z_m, focus_per_m));
}
// The rim of a beam out of focus is softened as by frost: its blur far away is the amount.
FL_FN Real focus_rim(Real lens_radius_m, Real spread, Real focus_per_m) {
  return clamp(lens_radius_m * max(focus_per_m, Real(0)) / max(spread, Real(1e-4)), Real(0), Real(1));
}
