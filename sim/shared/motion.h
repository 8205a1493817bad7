// One motor axis: pan, tilt or zoom.
//
// The axis goes to its target in the shortest time that its speed and acceleration limits allow and stops there
// (double integrator, |v| <= V, |a| <= A, time-optimal control: accelerate, cruise, brake). While the target is
// constant the motion has a closed form, so a step of any length is exact: step(a) then step(b) equals step(a + b).
//
// Units: any unit of position u with u/s and u/s^2. Range: V > 0, A > 0, dt >= 0 and a finite target; anything else
// leaves the axis alone.
// Source: L. S. Pontryagin et al., The Mathematical Theory of Optimal Processes, chapter 1 (the time-optimal double
// integrator), with a speed limit added.

struct Axis {
  Real position;  // u
  Real speed;     // u/s
};

// Moves time on by dt under constant acceleration.
FL_FN void axis_coast(FL_INOUT(Axis) axis, Real acceleration, Real dt_s) {
  axis.position += axis.speed * dt_s + Real(0.5) * acceleration * dt_s * dt_s;
  axis.speed += acceleration * dt_s;
}

FL_FN Axis axis_step(Axis axis, Real target, Real speed_max, Real acceleration_max, Real dt_s) {
  if (!(dt_s > Real(0)) || !(speed_max > Real(0)) || !(acceleration_max > Real(0))) return axis;
  if (!(abs(target) < Real(1e30))) return axis;

  // Towards which side? Where the axis would stop if it braked now decides. Mirror, so that the way is upwards.
  Real brake_stop = axis.position + axis.speed * abs(axis.speed) / (Real(2) * acceleration_max);
  Real side = brake_stop <= target ? Real(1) : Real(-1);
  Real distance = (target - axis.position) * side;  // may be negative: running away from the target
  Real v = axis.speed * side;

  // Faster than the limit (a limit was lowered): brake down to it first.
  Real left_s = dt_s;
  Axis state;
  state.position = Real(0);
  state.speed = v;
  if (state.speed > speed_max) {
    Real slow_s = (state.speed - speed_max) / acceleration_max;
    Real now_s = min(slow_s, left_s);
    axis_coast(state, -acceleration_max, now_s);
    left_s -= now_s;
  }

  // Peak speed of the triangle from here: v_peak^2 = A * rest + v^2 / 2, cut at the limit.
  Real rest = distance - state.position;
  Real peak_square = max(acceleration_max * rest + Real(0.5) * state.speed * state.speed, Real(0));
  Real peak = min(sqrt(peak_square), speed_max);
  peak = max(peak, state.speed);
  Real up_s = (peak - state.speed) / acceleration_max;
  Real down_s = max(peak, Real(0)) / acceleration_max;
  Real ramps = (peak * peak - state.speed * state.speed) / (Real(2) * acceleration_max) +
               peak * peak / (Real(2) * acceleration_max);
  Real cruise_s = peak > Real(0) ? max(rest - ramps, Real(0)) / peak : Real(0);

  if (left_s >= up_s + cruise_s + down_s) {  // arrives: exactly there, at rest
    axis.position = target;
    axis.speed = Real(0);
    return axis;
  }
  Real now_s = min(left_s, up_s);
  axis_coast(state, acceleration_max, now_s);
  left_s -= now_s;
  now_s = min(left_s, cruise_s);
  axis_coast(state, Real(0), now_s);
  left_s -= now_s;
  axis_coast(state, -acceleration_max, left_s);

  axis.position += side * state.position;
  axis.speed = side * state.speed;
  return axis;
}
