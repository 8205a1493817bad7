// Phase as an unsigned 64-bit count of 2^-64 turn: wraps exactly, never drifts. Turns is (low word, high word); the
// same type counts nanoseconds.
//
// A step multiplies the exact rate (every bit of a float or double from 2^-64 Hz up) by whole nanoseconds. The only
// error is the rounding to 2^-64 turn: at most 0.7 rate_hz + 4 of these units per step. After 30 days of 1000 steps per
// second that is 7e-10 turn at 1 Hz and 1e-7 turn (1e-10 s) at 1 kHz.

// True if Real is float (24 bits), false if double (53). Selects between formulas.
#ifdef __cplusplus
FL_CONST bool kSingle = Real(1) + Real(1e-10) == Real(1);
#else
FL_CONST bool kSingle = true;  // a GLSL compiler may compute constants in double
#endif

// The bits of a number as a float, and back.
#ifdef __cplusplus
FL_FN uint float_bits(Real x) { return std::bit_cast<uint>(static_cast<float>(x)); }
FL_FN Real bits_float(uint bits) { return Real(std::bit_cast<float>(bits)); }
#else
FL_FN uint float_bits(Real x) { return floatBitsToUint(x); }
FL_FN Real bits_float(uint bits) { return uintBitsToFloat(bits); }
#endif

// Quotients and roots rounded as in IEEE 754, for numbers and results between 1e-30 and 1e30 and for 0. Vulkan allows
// an error of 2.5 units in the last place for a / b and more for sqrt. One step with the exact remainder corrects it,
// except for results within 1e-6 of a unit of the middle between two floats.
#if defined(__cplusplus) && !defined(FL_LOOSE_QUOTIENTS)
FL_FN Real exact_quotient(Real a, Real b) { return a / b; }
FL_FN Real exact_root(Real a) { return sqrt(a); }
#else
// a - x * y where x * y is near a, exact: T. J. Dekker's product of halves, because Vulkan's fma() may round twice.
FL_FN Real exact_rest(Real a, Real x, Real y) {
  Real halver = kSingle ? Real(4097) : Real(134217729);
  FL_EXACT Real x_wide = x * halver;
  FL_EXACT Real x_over = x_wide - x;
  FL_EXACT Real x_high = x_wide - x_over;
  FL_EXACT Real x_low = x - x_high;
  FL_EXACT Real y_wide = y * halver;
  FL_EXACT Real y_over = y_wide - y;
  FL_EXACT Real y_high = y_wide - y_over;
  FL_EXACT Real y_low = y - y_high;
  FL_EXACT Real product = x * y;
  FL_EXACT Real beside = ((x_high * y_high - product) + x_high * y_low + x_low * y_high) + x_low * y_low;
  FL_EXACT Real rest = (a - product) - beside;
  return rest;
}
FL_FN Real exact_quotient(Real a, Real b) {
  FL_EXACT Real near = a / b;
  FL_EXACT Real rest = exact_rest(a, near, b);
  FL_EXACT Real quotient = near + rest / b;
  return quotient;
}
FL_FN Real exact_root(Real a) {
  FL_EXACT Real near = sqrt(a);
  FL_EXACT Real rest = exact_rest(a, near, near);
  FL_EXACT Real root = near > Real(0) ? near + rest / (near + near) : near;
  return root;
}
#endif

// A time or a phase of zero.
FL_FN Turns turns_zero() { return Turns(uint(0), uint(0)); }

FL_FN Turns turns_add(Turns a, Turns b) {
  uint low = a.x + b.x;
  uint carry = low < a.x ? uint(1) : uint(0);
  return Turns(low, a.y + b.y + carry);
}

FL_FN Turns turns_negate(Turns a) { return turns_add(Turns(~a.x, ~a.y), Turns(uint(1), uint(0))); }

FL_FN bool turns_less(Turns a, Turns b) { return a.y < b.y || (a.y == b.y && a.x < b.x); }

FL_FN Turns turns_mul_32(uint a, uint b) {
  uint high = uint(0);
  uint low = uint(0);
  umulExtended(a, b, high, low);
  return Turns(low, high);
}

// High 64 bits of the product of two 64-bit numbers.
FL_FN Turns turns_mul_high(Turns a, Turns b) {
  Turns ab = turns_mul_32(a.x, b.y);
  Turns ba = turns_mul_32(a.y, b.x);
  Turns low =
      turns_add(turns_add(Turns(ab.x, uint(0)), Turns(ba.x, uint(0))), Turns(turns_mul_32(a.x, b.x).y, uint(0)));
  Turns high = turns_add(Turns(ab.y, uint(0)), turns_add(Turns(ba.y, uint(0)), Turns(low.y, uint(0))));
  return turns_add(turns_mul_32(a.y, b.y), high);
}

// Clamps to [0, 1]; NaN gives 0.
FL_FN Real unit_share(Real x) { return x > Real(0) ? min(x, Real(1)) : Real(0); }

// exp(-x) for x >= 0, and 0 beyond x = 40 (4e-18), where library functions become slow near denormal numbers.
FL_FN Real decay_share(Real x) { return x < Real(40) ? exp(-x) : Real(0); }

// In [0, 1]: the fraction of a turn to the full precision of Real; in float the last 2^-25 turn rounds up to 1.
FL_FN Real turns_real(Turns phase) {
  return (Real(phase.y) + Real(phase.x) * Real(2.3283064365386963e-10)) * Real(2.3283064365386963e-10);
}

// In [-0.5, 0.5]: the same phase, the shorter way from 0.
FL_FN Real turns_signed(Turns phase) {
  return (phase.y & uint(0x80000000u)) == uint(0) ? turns_real(phase) : -turns_real(turns_negate(phase));
}

// a - b for two phases within the same turn: in (-1, 1), to the full precision of Real.
FL_FN Real turns_minus(Turns a, Turns b) {
  return turns_less(a, b) ? -turns_real(turns_add(b, turns_negate(a))) : turns_real(turns_add(a, turns_negate(b)));
}

// A phase from a number of turns; whole turns are dropped. 0 for NaN or beyond 1e9.
FL_INLINE Turns turns_from(Real turns) {
  Real size = abs(turns);
  if (!(size < Real(1e9))) return turns_zero();
  Real part = (size - Real(uint(size))) * Real(4294967296.0);
  uint high = uint(part);
  Turns phase = Turns(uint((part - Real(high)) * Real(4294967296.0)), high);
  return turns < Real(0) ? turns_negate(phase) : phase;
}

// A time step in nanoseconds. A step that is negative, NaN, infinite or above 4e9 s gives 0.
FL_FN Turns time_ns(Real dt_s) {
  if (!(dt_s > Real(0)) || !(dt_s <= Real(4.0e9))) return turns_zero();
  uint whole_s = uint(dt_s);
  Turns ns = turns_mul_32(whole_s, uint(1000000000));
  return turns_add(ns, Turns(uint((dt_s - Real(whole_s)) * Real(1.0e9) + Real(0.5)), uint(0)));
}

// The sum of two times, at most 584 years.
FL_FN Turns time_add(Turns a, Turns b) {
  Turns sum = turns_add(a, b);
  return turns_less(sum, a) ? Turns(uint(0xffffffffu), uint(0xffffffffu)) : sum;
}

FL_FN Real time_s(Turns ns) { return (Real(ns.y) * Real(4294967296.0) + Real(ns.x)) * Real(1e-9); }

// The turns at a rate over a time: whole turns (modulo 2^32) and the remaining part of a turn.
struct Advance {
  Turns part;
  uint whole;
};

// 32 bits times a 64-bit fraction.
FL_FN Advance turns_times(uint count, Turns part) {
  Turns low = turns_mul_32(count, part.x);
  Turns high = turns_mul_32(count, part.y);
  Advance sum;
  sum.part = Turns(low.x, low.y + high.x);
  sum.whole = high.y + (sum.part.y < low.y ? uint(1) : uint(0));
  return sum;
}

FL_FN void turns_gather(FL_INOUT(Advance) sum, Turns part, uint whole) {
  sum.part = turns_add(sum.part, part);
  sum.whole += whole + (turns_less(sum.part, part) ? uint(1) : uint(0));
}

// A time as whole seconds and 2^-64 s. dt_ns < 2^32 s.
struct Stretch {
  uint seconds;
  Turns rest;
};

FL_INLINE Stretch turns_stretch(Turns dt_ns) {
  // Whole seconds and nanoseconds; 2^32 ns are 4 s and 294967296 ns.
  Stretch time;
  time.seconds = uint(0);
  Turns ns = dt_ns;
  while (ns.y != uint(0)) {
    time.seconds += uint(4) * ns.y;
    ns = turns_add(Turns(ns.x, uint(0)), turns_mul_32(ns.y, uint(294967296)));
  }
  uint rest = ns.x;
  if (rest >= uint(1000000000)) {
    time.seconds += rest / uint(1000000000);
    rest %= uint(1000000000);
  }
  // The rest as a fraction of a second, rounded: 2^64 / 1e9 = 4 x 2^32 + 1266874889 + 3047500985 x 2^-32.
  time.rest = turns_mul_32(rest, uint(1266874889));
  time.rest.y += uint(4) * rest;
  Turns small = turns_mul_32(rest, uint(3047500985u));
  time.rest = turns_add(time.rest, Turns(small.y + (small.x >> uint(31)), uint(0)));
  return time;
}

// The advance at a rate in [0, 1e6] Hz; a negative or NaN rate gives 0, a higher one is clamped.
FL_INLINE Advance turns_over(Real rate_hz, Stretch time) {
  Advance sum;
  sum.part = turns_zero();
  sum.whole = uint(0);
  if (!(rate_hz > Real(0))) return sum;
  Real rate = min(rate_hz, Real(1.0e6));
  uint whole_hz = uint(rate);
  Turns part_hz = turns_from(rate - Real(whole_hz));
  if (time.seconds != uint(0)) {
    sum = turns_times(time.seconds, part_hz);
    sum.whole += whole_hz * time.seconds;
  }
#ifdef __cplusplus  // the same sum in two 128-bit products
  __extension__ using Wide = unsigned __int128;
  const Wide rest_bits = std::bit_cast<std::uint64_t>(time.rest);
  const Wide way = whole_hz * rest_bits + ((rest_bits * std::bit_cast<std::uint64_t>(part_hz)) >> 64);
  turns_gather(sum, std::bit_cast<Turns>(static_cast<std::uint64_t>(way)), static_cast<uint>(way >> 64));
  return sum;
#else
  if (whole_hz != uint(0)) {
    Advance more = turns_times(whole_hz, time.rest);
    turns_gather(sum, more.part, more.whole);
  }
  turns_gather(sum, turns_mul_high(part_hz, time.rest), uint(0));
  return sum;
#endif
}

// The advance at a rate over dt_ns nanoseconds. dt_ns < 2^32 s.
FL_INLINE Advance turns_advance(Real rate_hz, Turns dt_ns) { return turns_over(rate_hz, turns_stretch(dt_ns)); }

FL_FN Real advance_turns(Advance advance) { return Real(advance.whole) + turns_real(advance.part); }

// The phase after a time at a constant rate of either sign.
FL_INLINE Turns turns_go(Turns phase, Real rate_hz, Stretch time) {
  Turns way = turns_over(abs(rate_hz), time).part;
  return turns_add(phase, rate_hz < Real(0) ? turns_negate(way) : way);
}
FL_INLINE Turns turns_step(Turns phase, Real rate_hz, Turns dt_ns) {
  return turns_go(phase, rate_hz, turns_stretch(dt_ns));
}

// A motor with continuous rotation (gobo, prism, animation wheel, pan without stops), with a ramp between rates.
struct Spin {
  Turns phase;   // current
  Real rate_hz;  // current; turns per second, signed
  uint pad;
  Turns from_phase;  // at the last change of the target
  Real from_hz;
  Real target_hz;
  Turns since_ns;  // time since that change
};

// start: the initial phase, per fixture.
FL_FN Spin spin_start(Turns start) {
  Spin spin;
  spin.phase = start;
  spin.rate_hz = Real(0);
  spin.pad = uint(0);
  spin.from_phase = start;
  spin.from_hz = Real(0);
  spin.target_hz = Real(0);
  spin.since_ns = turns_zero();
  return spin;
}

// At its target rate, and the target is unchanged.
FL_INLINE bool spin_steady(FL_IN(Spin) spin, Real target_hz) {
  return target_hz == spin.target_hz && spin.rate_hz == target_hz;
}

// ramp_hz_s: how fast the rate changes, turns per second per second; 0: at once. A target that is NaN or beyond 1e6 Hz
// is ignored.
FL_INLINE void spin_move(FL_INOUT(Spin) spin, Real ramp_hz_s, Real target_hz, Turns dt_ns) {
  if (!(abs(target_hz) <= Real(1.0e6))) return;
  if (spin_steady(spin, target_hz)) {
    spin.phase = turns_step(spin.phase, target_hz, dt_ns);
    return;
  }
  if (target_hz != spin.target_hz) {
    spin.from_phase = spin.phase;
    spin.from_hz = spin.rate_hz;
    spin.target_hz = target_hz;
    spin.since_ns = turns_zero();
  }
  spin.since_ns = time_add(spin.since_ns, dt_ns);
  Real ramp_s = ramp_hz_s > Real(0) ? abs(target_hz - spin.from_hz) / ramp_hz_s : Real(0);
  Turns ramp_ns = time_ns(ramp_s);
  if (turns_less(spin.since_ns, ramp_ns)) {
    Real t_s = time_s(spin.since_ns);
    Real gain_hz_s = target_hz < spin.from_hz ? -ramp_hz_s : ramp_hz_s;
    spin.rate_hz = spin.from_hz + gain_hz_s * t_s;
    spin.phase = turns_add(turns_step(spin.from_phase, spin.from_hz, spin.since_ns),
                           turns_from(Real(0.5) * gain_hz_s * t_s * t_s));
  } else if (dt_ns != turns_zero()) {
    spin.rate_hz = target_hz;
    // The turns lost or gained by the ramp, added to those at the target rate.
    spin.phase = turns_add(turns_step(spin.from_phase, target_hz, spin.since_ns),
                           turns_from(Real(0.5) * (spin.from_hz - target_hz) * ramp_s));
  }
}

// The shorter way from one phase to another, in turns, [-0.5, 0.5].
FL_FN Real turns_way(Turns from, Turns to) { return turns_signed(turns_add(to, turns_negate(from))); }
