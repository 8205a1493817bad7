// Haze and fog in the air of a room. Needs turns.h and filter.h.
//
// Droplets of one kind, as the scattering coefficient (1/m) that they would have if they were spread evenly over the
// room. `total` are all of them, `unmixed` those that are still near their machines, where no beam is taken to pass:
//   total'   = output - total / tau
//   unmixed' = output - unmixed / tau - mixing_hz unmixed
// Beams scatter by total - unmixed: dc/dt = mixing_hz unmixed - c / tau. Both have exact solutions while output and
// mixing hold, counted from when they last changed: no error but rounding at any step, and the same bits however the
// time between two changes is cut.
struct RoomAir {
  Real total;         // 1/m, now
  Real unmixed;       // 1/m, now
  Real from_total;    // when output or mixing last changed
  Real from_unmixed;
  Real output;        // 1/m a second
  Real mixing_hz;
  Turns since_ns;     // since then
};

FL_FN RoomAir room_start() {
  RoomAir air;
  air.total = Real(0);
  air.unmixed = Real(0);
  air.from_total = Real(0);
  air.from_unmixed = Real(0);
  air.output = Real(0);
  air.mixing_hz = Real(0);
  air.since_ns = turns_zero();
  return air;
}

// x' = output - rate_hz x after t_s, from `from`.
FL_FN Real room_relaxed(Real from, Real output, Real rate_hz, Real t_s) {
  Real x = rate_hz * t_s;
  if (!(x > Real(0))) return from + output * t_s;
  return from * decay_share(x) + output * (relax_share(x) / rate_hz);
}

FL_CONST Real kRoomMixedHz = Real(1e6);  // as fast and faster: what comes is mixed at once

// output in [0, 1e6] 1/m a second and mixing_hz >= 0; one that is not is refused: the last one holds. tau_s in
// [1e-6, 1e9]; with any other nothing is lost.
FL_FN RoomAir room_step(RoomAir air, Real tau_s, Real output, Real mixing_hz, Turns dt_ns) {
  if (!(output >= Real(0)) || !(output <= Real(1e6))) output = air.output;
  if (!(mixing_hz >= Real(0))) mixing_hz = air.mixing_hz;
  if (output != air.output || mixing_hz != air.mixing_hz) {
    air.from_total = air.total;
    air.from_unmixed = air.unmixed;
    air.output = output;
    air.mixing_hz = mixing_hz;
    air.since_ns = turns_zero();
  }
  air.since_ns = time_add(air.since_ns, dt_ns);
  Real t_s = time_s(air.since_ns);
  Real loss_hz = tau_s >= Real(1e-6) && tau_s <= Real(1e9) ? Real(1) / tau_s : Real(0);
  air.total = room_relaxed(air.from_total, output, loss_hz, t_s);
  air.unmixed =
      mixing_hz < kRoomMixedHz ? room_relaxed(air.from_unmixed, output, loss_hz + mixing_hz, t_s) : Real(0);
  return air;
}

// What beams meet, 1/m. Of what has just come the digits go out against each other: its error is that of the total.
FL_FN Real room_scattering(FL_IN(RoomAir) air) { return max(air.total - air.unmixed, Real(0)); }
