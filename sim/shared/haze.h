// Haze and fog in the air of a room. Needs turns.h and filter.h.
//
// Droplets of one kind, as the scattering coefficient (1/m) that they would have if they were spread evenly over the
// room. `total` are all of them, `unmixed` those that are still near their machines, where no beam is taken to pass:
//   total'   = inflow - total / tau
//   unmixed' = inflow - unmixed / tau - mixing_hz unmixed
// Beams scatter by total - unmixed: dc/dt = mixing_hz unmixed - c / tau. Both have exact solutions while inflow and
// mixing hold, counted from when they last changed: no error but rounding at any step, and the same bits however the
// time between two changes is cut.
struct RoomAir {
  Real total;       // 1/m, now
  Real unmixed;     // 1/m, now
  Real from_total;  // when inflow or mixing last changed
  Real from_unmixed;
  Real inflow;  // 1/m a second
  Real mixing_hz;
  Turns since_ns;  // since then
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

FL_CONST Real kRoomMixedHz = Real(1e6);  // as fast and faster: what comes is mixed at once

// inflow in [0, 1e6] 1/m a second and mixing_hz >= 0; one that is not is refused: the last one holds. tau_s in
// [1e-6, 1e9]; with any other nothing is lost.
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

// What beams meet, 1/m. Of what has just come the digits go out against each other: its error is that of the total.
FL_FN Real room_scattering(FL_IN(RoomAir) air) { return max(air.total - air.unmixed, Real(0)); }
