// Motors: pan, tilt, zoom, focus, iris, wheels, blades, prisms. Needs turns.h.
//
// An axis moves to its target in the shortest time that its speed and acceleration limits allow, and stops there
// (double integrator, |v| <= V, |a| <= A, time-optimal control: accelerate, cruise, brake). While the target is
// constant the motion has a closed form, so a step of any length is exact: step(a) then step(b) equals step(a + b).
// Positions are absolute: an axis of 540 degrees moves the whole way back, never the shorter way round.
//
// A Motor stores its state at the last change of its target and the time since then, and computes from there. So
// rounding does not add up over steps, and the position is bit-identical for any division of the time into steps.
//
// Units: any unit of position u with u/s and u/s^2. Source: L. S. Pontryagin et al., The Mathematical Theory of Optimal
// Processes, chapter 1 (the time-optimal double integrator), with a speed limit added.

struct Axis {
  Real position;  // u
  Real speed;     // u/s
};

// Up to four intervals of constant acceleration from `from` on, then rest at the target.
struct AxisPlan {
  Real slow_s;  // braking to a reduced speed limit
  Real up_s;
  Real cruise_s;
  Real down_s;
  Real side;    // 1: towards larger positions
  Real slowed;  // speed along `side` after slow_s
  Real peak;    // and while cruising
};

FL_INLINE AxisPlan axis_plan(Axis from, Real target, Real speed_max, Real acceleration_max) {
  FL_EXACT AxisPlan plan;
  FL_EXACT Real per_acceleration = exact_quotient(Real(1), acceleration_max);
  // The direction follows from where the axis would stop if it braked now. Mirrored, so that the rest is upwards.
  FL_EXACT Real brake_stop = from.position + from.speed * abs(from.speed) * (Real(0.5) * per_acceleration);
  plan.side = brake_stop <= target ? Real(1) : Real(-1);
  FL_EXACT Real distance = (target - from.position) * plan.side;  // negative: moving away from the target
  FL_EXACT Real v = from.speed * plan.side;
  plan.slowed = min(v, speed_max);
  plan.slow_s = (v - plan.slowed) * per_acceleration;
  FL_EXACT Real rest = distance - Real(0.5) * (v + plan.slowed) * plan.slow_s;
  // Peak speed of the triangle from here: v_peak^2 = A * rest + v^2 / 2, limited to speed_max.
  FL_EXACT Real peak_square = max(acceleration_max * rest + Real(0.5) * plan.slowed * plan.slowed, Real(0));
  plan.peak = max(min(exact_root(peak_square), speed_max), max(plan.slowed, Real(0)));
  plan.up_s = (plan.peak - plan.slowed) * per_acceleration;
  plan.down_s = plan.peak * per_acceleration;
  FL_EXACT Real ramps = Real(0.5) * ((plan.peak + plan.slowed) * plan.up_s + plan.peak * plan.down_s);
  plan.cruise_s = plan.peak > Real(0) ? exact_quotient(max(rest - ramps, Real(0)), plan.peak) : Real(0);
  return plan;
}

// The state of a plan after t_s. Braking is computed backwards from its end, so that it ends exactly at the target. All
// intervals are computed and one is selected: without branches a loop over many axes compiles to vectors.
FL_INLINE Axis axis_follow(AxisPlan plan, Axis from, Real target, Real acceleration_max, Real t_s) {
  FL_EXACT Real start_s = plan.slow_s + plan.up_s;
  FL_EXACT Real left_s = start_s + plan.cruise_s + plan.down_s - t_s;
  FL_EXACT Real brake_speed = plan.side * (acceleration_max * left_s);
  FL_EXACT Real brake_position = target - Real(0.5) * brake_speed * left_s;
  FL_EXACT Real slow_speed = from.speed - plan.side * (acceleration_max * t_s);
  FL_EXACT Real slow_position = from.position + Real(0.5) * (from.speed + slow_speed) * t_s;
  FL_EXACT Real up_s = min(t_s - plan.slow_s, plan.up_s);
  FL_EXACT Real up_speed = plan.slowed + acceleration_max * up_s;
  FL_EXACT Real speed = t_s < start_s ? up_speed : plan.peak;
  FL_EXACT Real way =
      Real(0.5) * ((from.speed * plan.side + plan.slowed) * plan.slow_s + (plan.slowed + speed) * up_s) +
      plan.peak * max(t_s - start_s, Real(0));
  FL_EXACT Axis axis;
  axis.position = t_s < plan.slow_s ? slow_position : from.position + plan.side * way;
  axis.speed = t_s < plan.slow_s ? slow_speed : plan.side * speed;
  axis.position = left_s < plan.down_s ? brake_position : axis.position;
  axis.speed = left_s < plan.down_s ? brake_speed : axis.speed;
  axis.position = left_s > Real(0) ? axis.position : target;  // arrived: exactly at the target, at rest
  axis.speed = left_s > Real(0) ? axis.speed : Real(0);
  return axis;
}

// True if the limits and the target are valid for a motor: speeds from 1e-9 to 1e9, accelerations from 1e-9 to 1e12,
// targets up to 1e9.
FL_FN bool axis_takes(Real target, Real speed_max, Real acceleration_max) {
  return speed_max >= Real(1e-9) && speed_max <= Real(1e9) && acceleration_max >= Real(1e-9) &&
         acceleration_max <= Real(1e12) && abs(target) <= Real(1e9);
}

// One step from any state. Returns the axis unchanged if axis_takes() is false or the step is not positive and finite.
FL_FN Axis axis_step(Axis axis, Real target, Real speed_max, Real acceleration_max, Real dt_s) {
  if (!(dt_s > Real(0)) || !(dt_s < Real(1e30)) || !axis_takes(target, speed_max, acceleration_max)) return axis;
  return axis_follow(axis_plan(axis, target, speed_max, acceleration_max), axis, target, acceleration_max, dt_s);
}

struct MotorLimits {
  Real speed_max;         // u/s; 0: no motor, the axis is at its target at once
  Real acceleration_max;  // u/s^2
};

// Limits from GDTF's times: RealFade = seconds from one end of the range to the other, ramps included; RealAcceleration
// = seconds from standstill to full speed. A RealAcceleration below 1 ms, or none, counts as 1 ms. An acceleration of
// half the fade or more leaves no cruise: a triangle of speed that takes the whole fade. fade_s <= 0 or NaN: no motor.
FL_FN MotorLimits motor_limits(Real range, Real fade_s, Real acceleration_s) {
  MotorLimits limits;
  limits.speed_max = Real(0);
  limits.acceleration_max = Real(0);
  Real way = abs(range);
  if (!(fade_s > Real(0)) || !(fade_s < Real(1e9)) || !(way > Real(0)) || !(way < Real(1e9))) return limits;
  Real ramp_s = acceleration_s > Real(1e-3) && acceleration_s < Real(1e9) ? acceleration_s : Real(1e-3);
  if (ramp_s < Real(0.5) * fade_s) {
    limits.speed_max = way / (fade_s - ramp_s);
    limits.acceleration_max = limits.speed_max / ramp_s;
  } else {
    limits.acceleration_max = Real(4) * way / (fade_s * fade_s);
    limits.speed_max = limits.acceleration_max * ramp_s;
  }
  return limits;
}

// Position-speed channel, vector mode: the channel sets the speed (share 0 to 1 of the limit, at least 1/1000 of it so
// that the move ends). The acceleration is unchanged. Tracking mode: the limits are unchanged, and a Flex with damping
// 1 smooths.
FL_FN MotorLimits motor_vector(MotorLimits limits, Real share) {
  limits.speed_max *= clamp(share, Real(1e-3), Real(1));
  return limits;
}

struct Motor {
  Axis now;
  Axis from;  // at the last change of the target or the speed limit
  Real target;
  Real speed_max;
  Turns since_ns;  // time since that change
};

FL_FN Motor motor_start(Real position) {
  Motor motor;
  motor.now.position = position;
  motor.now.speed = Real(0);
  motor.from = motor.now;
  motor.target = position;
  motor.speed_max = Real(0);
  motor.since_ns = turns_zero();
  return motor;
}

// Where a motor stops if it brakes now; the same from each moment of the braking.
FL_FN Real motor_stop(Motor motor, Real acceleration_max) {
  if (!(acceleration_max > Real(0))) return motor.now.position;
  return motor.now.position + motor.now.speed * abs(motor.now.speed) / (Real(2) * acceleration_max);
}

// The target of a wheel, which repeats every `period`: the nearest of the equivalent positions. It is chosen when the
// target changes and kept while the wheel moves, so that the direction does not depend on the steps.
FL_FN Real motor_nearest(Motor motor, Real target, Real period) {
  if (!(period > Real(0)) || !(abs(target) <= Real(1e9))) return target;
  Real same = target + period * floor((motor.target - target) / period + Real(0.5));
  if (abs(same - motor.target) <= Real(1e-6) * period) return motor.target;
  return target + period * floor((motor.now.position - target) / period + Real(0.5));
}

// The first part of a step: applies a new target or speed limit. A target that is NaN or beyond 1e9 is ignored.
FL_INLINE Motor motor_aim(Motor motor, MotorLimits limits, Real target) {
  if (!(abs(target) <= Real(1e9))) return motor;
  if (!axis_takes(target, limits.speed_max, limits.acceleration_max)) {  // no motor
    if (limits.speed_max == Real(0)) motor = motor_start(target);
    return motor;
  }
  if (target != motor.target || limits.speed_max != motor.speed_max) {
    motor.from = motor.now;
    motor.target = target;
    motor.speed_max = limits.speed_max;
    motor.since_ns = turns_zero();
  }
  return motor;
}

// The state since_ns after motor_aim() changed the target.
FL_INLINE Axis motor_at(Axis from, Real target, Real speed_max, Real acceleration_max, Turns since_ns) {
  return axis_follow(axis_plan(from, target, speed_max, acceleration_max), from, target, acceleration_max,
                     time_s(since_ns));
}

FL_INLINE Motor motor_step(Motor motor, MotorLimits limits, Real target, Turns dt_ns) {
  motor = motor_aim(motor, limits, target);
  if (dt_ns == turns_zero() || !axis_takes(target, limits.speed_max, limits.acceleration_max)) return motor;
  motor.since_ns = time_add(motor.since_ns, dt_ns);
  if (motor.now.position == target && motor.now.speed == Real(0)) return motor;
  motor.now = motor_at(motor.from, target, limits.speed_max, limits.acceleration_max, motor.since_ns);
  return motor;
}

// A load on a motor through a spring and a damper: x'' + 2 damping rate x' + rate^2 x = rate^2 u(t), u the motor's
// position.
//
// With damping 1 it is jerk smoothing: its impulse response is positive and of area 1. So it keeps the motor's limits
// of speed and acceleration, never overshoots, and limits the jerk to 2 A rate / e. It lags the motor by 2 / rate and
// settles to 1e-6 of a step in 17 / rate. With lower damping it is the resonance of a belt or a yoke, with overshoot.
// The motor's position is a parabola in each interval of its plan, so each interval has an exact solution: the only
// error is rounding.
struct Flex {
  Axis now;
  Axis from;  // at the last change of the motor's target or speed limit
};

struct FlexLimits {
  Real rate;     // rad/s: 2 pi times the resonance in Hz, or 2 / lag for smoothing; [1e-3, 1e6], else rigid
  Real damping;  // (0, 1]
};

// Smoothing with a lag of lag_s: of jerk (some 0.02 to 0.1 s), or of tracking mode's steps (some 0.1 to 0.5 s).
FL_FN FlexLimits flex_smoothing(Real lag_s) {
  FlexLimits limits;
  limits.rate = lag_s > Real(0) ? Real(2) / lag_s : Real(0);
  limits.damping = Real(1);
  return limits;
}

// A belt or a yoke that rings at resonance_hz (some 8 to 30).
FL_FN FlexLimits flex_belt(Real resonance_hz, Real damping) {
  FlexLimits limits;
  limits.rate = Real(6.283185307179586477) * resonance_hz;
  limits.damping = damping;
  return limits;
}

// The free decay of a deviation from the steady motion.
FL_FN Axis flex_decay(Axis deviation, FlexLimits limits, Real t_s) {
  Axis after;
  Real w = limits.rate;
  Real swing = Real(1) - limits.damping * limits.damping;
  Real e = decay_share(limits.damping * w * t_s);
  if (e == Real(0)) {
    after.position = Real(0);
    after.speed = Real(0);
    return after;
  }
  if (!(swing > Real(1e-6))) {  // critical
    Real pull = deviation.speed + w * deviation.position;
    after.position = e * (deviation.position + pull * t_s);
    after.speed = e * (deviation.speed - w * pull * t_s);
    return after;
  }
  Real w_d = w * sqrt(swing);
  Real s = sin(w_d * t_s);
  Real c = cos(w_d * t_s);
  Real drag = limits.damping * w / w_d;
  after.position = e * (deviation.position * (c + drag * s) + deviation.speed * (s / w_d));
  after.speed = e * (deviation.speed * (c - drag * s) - deviation.position * (w * w / w_d * s));
  return after;
}

// One interval of t_s with the motor at u and constant acceleration a.
FL_FN Axis flex_stretch(Axis flex, FlexLimits limits, Axis u, Real a, Real t_s) {
  // Steady motion behind a parabola: x_p = u - (2 d / w) u' + ((4 d^2 - 1) / w^2) u''.
  Real lag_s = Real(2) * limits.damping / limits.rate;
  Real bend = (Real(4) * limits.damping * limits.damping - Real(1)) / (limits.rate * limits.rate) * a;
  Axis deviation;
  deviation.position = flex.position - (u.position - lag_s * u.speed + bend);
  deviation.speed = flex.speed - (u.speed - lag_s * a);
  Axis after = flex_decay(deviation, limits, t_s);
  Real speed = u.speed + a * t_s;
  after.position += u.position + Real(0.5) * (u.speed + speed) * t_s - lag_s * speed + bend;
  after.speed += speed - lag_s * a;
  return after;
}

// The flex t_s after the start of the plan, from its own state at that start.
FL_FN Axis flex_follow(Axis flex, FlexLimits limits, AxisPlan plan, Axis from, Real target, Real acceleration_max,
                       Real t_s) {
  Real left_s = t_s;
  Axis u = from;
  for (uint i = uint(0); i < uint(5); ++i) {
    Real length_s = left_s;
    Real a = Real(0);
    if (i == uint(0)) {
      length_s = plan.slow_s;
      a = -acceleration_max;
    } else if (i == uint(1)) {
      length_s = plan.up_s;
      a = acceleration_max;
    } else if (i == uint(2)) {
      length_s = plan.cruise_s;
    } else if (i == uint(3)) {
      length_s = plan.down_s;
      a = -acceleration_max;
    } else {
      u.position = target;
      u.speed = Real(0);
    }
    length_s = min(length_s, left_s);
    if (!(length_s > Real(0))) continue;
    a *= plan.side;
    flex = flex_stretch(flex, limits, u, a, length_s);
    left_s -= length_s;
    Real speed = u.speed + a * length_s;
    u.position += Real(0.5) * (u.speed + speed) * length_s;
    u.speed = speed;
  }
  return flex;
}

FL_FN Flex flex_start(Real position) {
  Flex flex;
  flex.now.position = position;
  flex.now.speed = Real(0);
  flex.from = flex.now;
  return flex;
}

// The step for `motor = motor_step(before, ...)`. A damping outside (0, 1] counts as 1.
FL_FN Flex flex_step(Flex flex, FlexLimits limits, Motor before, Motor motor, MotorLimits drive) {
  if (!axis_takes(motor.target, drive.speed_max, drive.acceleration_max) || !(limits.rate >= Real(1e-3)) ||
      !(limits.rate <= Real(1e6))) {
    flex.now = motor.now;
    flex.from = motor.now;
    return flex;
  }
  if (!(limits.damping > Real(0)) || !(limits.damping <= Real(1))) limits.damping = Real(1);
  if (motor.target != before.target || motor.speed_max != before.speed_max) flex.from = flex.now;
  if (motor.since_ns == turns_zero()) return flex;
  AxisPlan plan = axis_plan(motor.from, motor.target, drive.speed_max, drive.acceleration_max);
  flex.now =
      flex_follow(flex.from, limits, plan, motor.from, motor.target, drive.acceleration_max, time_s(motor.since_ns));
  return flex;
}
