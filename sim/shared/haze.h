// Haze and fog in the air of a room. Needs turns.h and filter.h.
//
// The amount of droplets is given as a scattering coefficient (1/m): the value if they were spread evenly over the
// room. `total` are all droplets. `unmixed` are those still near their machines, where no beam is assumed to pass:
//   total'   = inflow - total / tau
//   unmixed' = inflow - unmixed / tau - mixing_hz unmixed
// Beams scatter by total - unmixed: dc/dt = mixing_hz unmixed - c / tau. Both have exact solutions while inflow and
// mixing are constant, computed from their last change. So the only error is rounding, and the result is bit-identical
// for any division of the time into steps.
struct RoomAir {
  Real total;       // 1/m, current
  Real unmixed;     // 1/m, current
  Real from_total;  // at the last change of inflow or mixing
  Real from_unmixed;
  Real inflow;  // 1/m per second
  Real mixing_hz;
  Turns since_ns;  // time since that change
};

FL_FN RoomAir room_start() {
  RoomAir air;
  air.total = Real(0);
  air.unmixed = Real(0);
  air.from_total = Real(0);
  air.from_unmixed = Real(0);
  air.inflow = Real(0);
  air.mixing_hz = Real(0);
  air.since_ns = turns_zero();
  return air;
}

// x' = inflow - rate_hz x after t_s, from `from`.
FL_FN Real room_relaxed(Real from, Real inflow, Real rate_hz, Real t_s) {
  Real x = rate_hz * t_s;
  if (!(x > Real(0))) return from + inflow * t_s;
  return from * decay_share(x) + inflow * (relax_share(x) / rate_hz);
}

FL_CONST Real kRoomMixedHz = Real(1e6);  // at this rate or above, new droplets mix at once

// inflow in [0, 1e6] 1/m per second and mixing_hz >= 0; an invalid value is ignored and the last one kept. tau_s in
// [1e-6, 1e9]; with any other value nothing is lost.
FL_FN RoomAir room_step(RoomAir air, Real tau_s, Real inflow, Real mixing_hz, Turns dt_ns) {
  if (!(inflow >= Real(0)) || !(inflow <= Real(1e6))) inflow = air.inflow;
  if (!(mixing_hz >= Real(0))) mixing_hz = air.mixing_hz;
  if (inflow != air.inflow || mixing_hz != air.mixing_hz) {
    air.from_total = air.total;
    air.from_unmixed = air.unmixed;
    air.inflow = inflow;
    air.mixing_hz = mixing_hz;
    air.since_ns = turns_zero();
  }
  air.since_ns = time_add(air.since_ns, dt_ns);
  Real t_s = time_s(air.since_ns);
  Real loss_hz = tau_s >= Real(1e-6) && tau_s <= Real(1e9) ? Real(1) / tau_s : Real(0);
  air.total = room_relaxed(air.from_total, inflow, loss_hz, t_s);
  air.unmixed = mixing_hz < kRoomMixedHz ? room_relaxed(air.from_unmixed, inflow, loss_hz + mixing_hz, t_s) : Real(0);
  return air;
}

// The scattering coefficient for beams, 1/m. Cancellation: shortly after the haze starts, its absolute error is that of
// the total.
FL_FN Real room_scattering(FL_IN(RoomAir) air) { return max(air.total - air.unmixed, Real(0)); }
