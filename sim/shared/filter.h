// Smoothing of levels, and movement at a constant rate. Needs turns.h and motion.h.

// 1 - exp(-x) for x >= 0, without cancellation for small x; 0 for NaN. Relative error: 2.3e-7 in float, 5e-15 in double
// (filter_test.cpp). The largest error is just past the end of the series, where the subtraction amplifies the rounding
// of exp(-x) by 1 / x.
FL_CONST Real kRelaxSeries = kSingle ? Real(0.25) : Real(0.02);
FL_FN Real relax_share(Real x) {
  if (!(x > Real(0))) return Real(0);
  if (x < kRelaxSeries) {
    Real sum = Real(1) / Real(720) - x * (Real(1) / Real(5040));
    sum = Real(1) / Real(120) - x * sum;
    sum = Real(1) / Real(24) - x * sum;
    sum = Real(1) / Real(6) - x * sum;
    sum = Real(0.5) - x * sum;
    return x * (Real(1) - x * sum);
  }
  return Real(1) - decay_share(x);
}

// Jitter smoothing of a DMX level: a critically damped filter of two poles, tau^2 x'' + 2 tau x' + x = target. Exact
// while the target is constant: only rounding errors, for any step. It never overshoots; a step is at 91 % after 4 tau
// and at 99 % after 6.6 tau. Off by default: tau 0.
struct Smooth {
  Axis now;
  Axis from;  // at the last change of the target
  Real target;
  uint pad;
  Turns since_ns;  // time since that change
};

FL_FN Smooth smooth_start(Real value) {
  Smooth smoothed;
  smoothed.now.position = value;
  smoothed.now.speed = Real(0);
  smoothed.from = smoothed.now;
  smoothed.target = value;
  smoothed.pad = uint(0);
  smoothed.since_ns = turns_zero();
  return smoothed;
}

// tau_s in [1e-6, 1e6]; any other value means no smoothing. A target beyond 1e9 or NaN is ignored.
FL_FN Smooth smooth_step(Smooth smoothed, Real tau_s, Real target, Turns dt_ns) {
  if (!(abs(target) <= Real(1e9))) return smoothed;
  if (!(tau_s >= Real(1e-6)) || !(tau_s <= Real(1e6))) return smooth_start(target);
  if (target != smoothed.target) {
    smoothed.from = smoothed.now;
    smoothed.target = target;
    smoothed.since_ns = turns_zero();
  }
  if (dt_ns == turns_zero()) return smoothed;
  smoothed.since_ns = time_add(smoothed.since_ns, dt_ns);
  FlexLimits limits;
  limits.rate = Real(1) / tau_s;
  limits.damping = Real(1);
  Axis deviation = smoothed.from;
  deviation.position -= target;
  smoothed.now = flex_decay(deviation, limits, time_s(smoothed.since_ns));
  smoothed.now.position += target;
  return smoothed;
}

// A level that moves to its target at a constant rate: blades, dowsers. travel_s: time from 0 to 1; 0: at once.
FL_FN Real slew_at(Real from, Real target, Real travel_s, Real t_s) {
  Real way = travel_s > Real(0) ? t_s / travel_s : Real(1e30);
  return target < from ? max(from - way, target) : min(from + way, target);
}

// The mean of slew_at() from before_s to after_s.
FL_FN Real slew_mean(Real from, Real target, Real travel_s, Real before_s, Real after_s) {
  if (!(after_s > before_s)) return slew_at(from, target, travel_s, after_s);
  Real arrive_s = abs(target - from) * max(travel_s, Real(0));
  Real share = clamp((arrive_s - before_s) / (after_s - before_s), Real(0), Real(1));  // of the time, while moving
  Real mean = Real(0.5) * (slew_at(from, target, travel_s, before_s) + slew_at(from, target, travel_s, after_s));
  return share * mean + (Real(1) - share) * target;
}

struct Slew {
  Real level;  // now, 0 to 1
  Real from;   // at the last change of the target
  Real target;
  uint pad;
  Turns since_ns;  // time since that change
};

FL_FN Slew slew_start(Real level) {
  Slew slew;
  slew.level = level;
  slew.from = level;
  slew.target = level;
  slew.pad = uint(0);
  slew.since_ns = turns_zero();
  return slew;
}

// Returns the mean level over the step; for dt_ns = 0 the current level. A NaN target is ignored. travel_s in (0, 1e4],
// else 0.
FL_FN Real slew_step(FL_INOUT(Slew) slew, Real travel_s, Real target, Turns dt_ns) {
  if (!(abs(target) <= Real(1e9))) return slew.level;
  Real way_s = travel_s > Real(0) && travel_s <= Real(1e4) ? travel_s : Real(0);
  if (target != slew.target) {
    slew.from = slew.level;
    slew.target = target;
    slew.since_ns = turns_zero();
  }
  if (dt_ns == turns_zero() && way_s > Real(0)) return slew.level;
  Real before_s = time_s(slew.since_ns);
  slew.since_ns = time_add(slew.since_ns, dt_ns);
  Real after_s = time_s(slew.since_ns);
  slew.level = slew_at(slew.from, target, way_s, after_s);
  return slew_mean(slew.from, target, way_s, before_s, after_s);
}
