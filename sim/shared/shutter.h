// Strobe: the share of an exposure during which the shutter is open.
//
// A camera integrates over its exposure; sampling the strobe at one instant would beat against the frame rate. With
// F(p) = floor(p) d + min(frac(p), d), the open time up to phase p (turns) at duty d, the mean over p0..p1 is
// (F(p1) - F(p0)) / (p1 - p0): exact at any rate and any frame time.

// p0 in [0, 1): phase at the start of the exposure; turns >= 0: turns during it. Returns 0 to 1.
FL_FN Real shutter_open_share(Real p0, Real turns, Real duty) {
  Real at_start = min(p0, duty);
  if (!(turns > Real(1e-6))) return p0 < duty ? Real(1) : Real(0);  // too short to integrate: the state at the start
  Real p1 = p0 + turns;
  Real whole = floor(p1);
  Real at_end = whole * duty + min(p1 - whole, duty);
  return min(max((at_end - at_start) / turns, Real(0)), Real(1));
}
