// Shutters: the mean light through them over an exposure. Needs turns.h, motion.h and filter.h.
//
// A camera integrates over its exposure; sampling a strobe at one instant would alias with the frame rate. Every flash
// is a trapezoid in time (blades open, stay, close; a pulse has no flat part), so the integral has a closed form. Times
// within a flash are differences of 64-bit phases: they lose no precision after any uptime.
//
// Kinds and parameters are those of GDTF's Shutter1... attributes: rate in Hz, duty cycle or duration, time offset,
// minimum opening. Random kinds have one flash in each period, at a place computed from the period's number and a seed.
// It is the same on replay for any division of the time into steps, and the mean over whole periods equals that of the
// regular kinds.
//
// Error of a mean: 1e-7 of the open share in float, 1e-15 in double, for any rate and any exposure (30 days included).

FL_CONST uint kShutterClosed = uint(0);
FL_CONST uint kShutterOpen = uint(1);
FL_CONST uint kShutterStrobe = uint(2);
FL_CONST uint kShutterPulse = uint(3);       // up and down: a triangle
FL_CONST uint kShutterPulseClose = uint(4);  // opens at once, closes slowly
FL_CONST uint kShutterPulseOpen = uint(5);   // opens slowly, closes at once
FL_CONST uint kShutterRandom = uint(6);
FL_CONST uint kShutterRandomPulse = uint(7);
FL_CONST uint kShutterRandomPulseClose = uint(8);
FL_CONST uint kShutterRandomPulseOpen = uint(9);
FL_CONST uint kShutterEffect = uint(10);  // undefined in GDTF; here four flashes, then a pause of the same length
FL_CONST uint kShutterKindCount = uint(11);
FL_CONST uint kShutterEffectFlashes = uint(4);

// One flash: rises from `low` to `peak` in `rise`, stays for `open`, falls back in `fall`. Lengths in turns, their sum
// at most 1.
struct Flash {
  Real low;
  Real peak;
  Real rise;
  Real open;
  Real fall;
};

struct ShutterParams {
  uint kind;        // kShutter...; any other value is open
  Real rate_hz;     // periods per second; 0: the flashing kinds are open
  Real duty;        // open share of a period, 0 to 1
  Real duration_s;  // open time of a flash; 0: duty is used
  Real offset;      // start of the flash in the period, turns; per fixture
  Real low;         // minimum opening, 0 to 1
  Real travel_s;    // of the blades, from closed to open; 0: at once
  uint seed;        // of random kinds
};

struct Shutter {
  Turns phase;      // of the strobe's period
  uint period;      // number of the period
  uint kind;        // the active kind
  Real level;       // of the blades now, 0 to 1; while flashing it is updated only if the blades have a travel time
  Real from_level;  // at the last change of the kind
  Turns since_ns;   // time since that change
};

// Hash of two numbers: Wellons' 32-bit finalizer ("lowbias32") on each in turn.
FL_FN uint hash_mix(uint a) {
  a ^= a >> uint(16);
  a *= uint(0x7feb352du);
  a ^= a >> uint(15);
  a *= uint(0x846ca68bu);
  a ^= a >> uint(16);
  return a;
}
FL_FN uint hash_two(uint seed, uint index) { return hash_mix(hash_mix(index) ^ (seed * uint(0x9e3779b9u) + uint(1))); }

// travel: of the blades, in turns of this period.
FL_FN Flash shutter_flash(uint kind, Real duty, Real travel, Real low) {
  Real share = unit_share(duty);
  Flash flash;
  flash.low = unit_share(low);
  flash.peak = Real(1);
  flash.rise = Real(0);
  flash.open = share;
  flash.fall = Real(0);
  if (kind == kShutterPulse || kind == kShutterRandomPulse) {
    flash.rise = Real(0.5) * share;
    flash.open = Real(0);
    flash.fall = Real(0.5) * share;
  } else if (kind == kShutterPulseClose || kind == kShutterRandomPulseClose) {
    flash.open = Real(0);
    flash.fall = share;
  } else if (kind == kShutterPulseOpen || kind == kShutterRandomPulseOpen) {
    flash.rise = share;
    flash.open = Real(0);
  } else if (travel > Real(0)) {
    // Blades need `travel` each way. If that exceeds the open time they do not reach the top; if it exceeds the closed
    // time they do not reach the bottom. The mean remains the duty.
    Real way = share > Real(0.5) ? Real(1) - share : share;
    Real ramp = min(travel, way);
    flash.rise = ramp;
    flash.open = share - ramp;
    flash.fall = ramp;
    Real reach = ramp / travel;
    Real span = Real(1) - flash.low;
    if (share > Real(0.5)) {
      flash.low = Real(1) - span * reach;
    } else {
      flash.peak = flash.low + span * reach;
    }
  }
  return flash;
}

// The light of a whole flash above `low`, in turns.
FL_FN Real flash_light(Flash flash) {
  return (flash.peak - flash.low) * (flash.open + Real(0.5) * (flash.rise + flash.fall));
}

// The light above `low` in the turns 0 to `length`, of a flash that starts at `start` (may be negative).
FL_FN Real flash_integral(Flash flash, Real start, Real length) {
  Real light = Real(0);
  Real a = max(start, Real(0));
  Real b = min(start + flash.rise, length);
  if (b > a) light += (b - a) * ((Real(0.5) * (a + b) - start) / flash.rise);
  Real open = start + flash.rise;
  Real fall = open + flash.open;
  a = max(open, Real(0));
  b = min(fall, length);
  if (b > a) light += b - a;
  Real shut = fall + flash.fall;
  a = max(fall, Real(0));
  b = min(shut, length);
  if (b > a) light += (b - a) * ((shut - Real(0.5) * (a + b)) / flash.fall);
  return light * (flash.peak - flash.low);
}

// The level at one instant, `at` turns after the start of the flash.
FL_FN Real flash_level(Flash flash, Real at) {
  if (!(at >= Real(0))) return flash.low;
  Real share = Real(0);
  if (at < flash.rise) {
    share = at / flash.rise;
  } else if (at < flash.rise + flash.open) {
    share = Real(1);
  } else if (at < flash.rise + flash.open + flash.fall) {
    share = (flash.rise + flash.open + flash.fall - at) / flash.fall;
  }
  return flash.low + (flash.peak - flash.low) * unit_share(share);  // rounding of a short ramp can exceed [0, 1]
}

// The start of the flash in a period.
FL_FN Turns shutter_start(ShutterParams params, Flash flash, uint period) {
  if (params.kind < kShutterRandom || params.kind > kShutterRandomPulseOpen) return turns_zero();
  Real room = max(Real(1) - (flash.rise + flash.open + flash.fall), Real(0));
  return turns_from(room * (Real(hash_two(params.seed, period) >> uint(8)) * Real(5.9604644775390625e-8)));
}

// The number of flashes in a period.
FL_FN uint shutter_count(uint kind) { return kind == kShutterEffect ? kShutterEffectFlashes : uint(1); }

// The light above `low` in a part of one period: `length` turns from `phase` on.
FL_FN Real shutter_piece(ShutterParams params, Flash flash, uint period, Turns phase, Real length) {
  uint count = shutter_count(params.kind);
  Turns start = shutter_start(params, flash, period);
  Real light = Real(0);
  for (uint i = uint(0); i < count; ++i) {
    // Flashes of an effect are an eighth of a period apart.
    Turns begin = turns_add(start, Turns(uint(0), i << uint(29)));
    light += flash_integral(flash, turns_minus(begin, phase), length);
  }
  return light;
}

// The level at one instant of a period.
FL_FN Real shutter_instant(ShutterParams params, Flash flash, uint period, Turns phase) {
  uint count = shutter_count(params.kind);
  Turns start = shutter_start(params, flash, period);
  Real level = flash.low;
  for (uint i = uint(0); i < count; ++i) {
    Turns begin = turns_add(start, Turns(uint(0), i << uint(29)));
    level = max(level, flash_level(flash, turns_minus(phase, begin)));
  }
  return level;
}

// The blades' travel time: above 0 and at most 1000 s, else 0.
FL_FN Real shutter_travel_s(ShutterParams params) {
  return params.travel_s > Real(0) && params.travel_s <= Real(1000) ? params.travel_s : Real(0);
}

// The open share of a period.
FL_FN Real shutter_duty(ShutterParams params, Real rate_hz) {
  return params.duration_s > Real(0) ? min(params.duration_s, Real(1e9)) * rate_hz : params.duty;
}

// The flash for these parameters; the flashes of an effect take an eighth of its period each.
FL_FN Flash shutter_shape(ShutterParams params) {
  Real scale = params.kind == kShutterEffect ? Real(8) : Real(1);
  Real rate_hz = min(params.rate_hz, Real(1e6)) * scale;
  Flash flash =
      shutter_flash(params.kind, shutter_duty(params, rate_hz), shutter_travel_s(params) * rate_hz, params.low);
  if (scale > Real(1)) {
    flash.rise /= scale;
    flash.open /= scale;
    flash.fall /= scale;
  }
  return flash;
}

FL_FN bool shutter_flashes(ShutterParams params) {
  return params.kind >= kShutterStrobe && params.kind < kShutterKindCount && params.rate_hz > Real(0);
}

FL_FN Shutter shutter_begin() {
  Shutter shutter;
  shutter.phase = turns_zero();
  shutter.period = uint(0);
  shutter.kind = kShutterKindCount;  // none yet: the first kind is applied at once
  shutter.level = Real(1);
  shutter.from_level = Real(1);
  shutter.since_ns = turns_zero();
  return shutter;
}

// One step with constant parameters. Returns the mean opening over the step; for dt_ns = 0 the current opening.
FL_INLINE Real shutter_step(FL_INOUT(Shutter) shutter, ShutterParams params, Turns dt_ns) {
  bool flashes = shutter_flashes(params);
  uint kind = flashes ? params.kind : (params.kind == kShutterClosed ? kShutterClosed : kShutterOpen);
  if (kind != shutter.kind) {
    if (shutter.kind == kShutterKindCount) shutter.level = kind == kShutterClosed ? Real(0) : Real(1);
    if (shutter.kind < kShutterStrobe || shutter.kind == kShutterKindCount) {  // the first flash starts at once
      shutter.phase = turns_zero();
      shutter.period = uint(0);
    }
    shutter.kind = kind;
    shutter.from_level = shutter.level;
    shutter.since_ns = turns_zero();
  }

  if (!flashes) {  // the blades move to one end
    Real target = kind == kShutterClosed ? Real(0) : Real(1);
    if (shutter.level == target) return target;
    Real travel_s = shutter_travel_s(params);
    Real before_s = time_s(shutter.since_ns);
    shutter.since_ns = time_add(shutter.since_ns, dt_ns);
    Real after_s = time_s(shutter.since_ns);
    shutter.level = slew_at(shutter.from_level, target, travel_s, after_s);
    return slew_mean(shutter.from_level, target, travel_s, before_s, after_s);
  }

  // Phases count from the start of the flash in the period.
  Turns shift = params.offset == Real(0) ? turns_zero() : turns_negate(turns_from(params.offset));
  Turns phase = turns_add(shutter.phase, shift);
  uint period = shutter.period + (turns_less(phase, shift) ? uint(1) : uint(0));
  Advance advance = turns_advance(params.rate_hz, dt_ns);
  Real turns = advance_turns(advance);
  Turns before = shutter.phase;
  shutter.phase = turns_add(before, advance.part);
  shutter.period += advance.whole + (turns_less(shutter.phase, before) ? uint(1) : uint(0));
  Turns end = turns_add(phase, advance.part);
  uint edges = advance.whole + (turns_less(end, phase) ? uint(1) : uint(0));
  Real to_edge = phase == turns_zero() ? Real(1) : turns_real(turns_negate(phase));
  Real travel_s = shutter_travel_s(params);

  if (kind == kShutterStrobe && !(travel_s > Real(0))) {  // the most common case: the code below without slopes
    Real low = unit_share(params.low);
    Real open = unit_share(shutter_duty(params, min(params.rate_hz, Real(1e6))));
    Real at = turns_real(phase);
    Real at_end = turns_real(end);
    if (!(turns > Real(0))) return at_end < open ? Real(1) : low;
    // The open turns from `phase` on, those of whole periods, and those up to the end.
    Real share = edges == uint(0)
                     ? max(min(open - at, turns), Real(0))
                     : max(min(open - at, to_edge), Real(0)) + Real(edges - uint(1)) * open + min(open, at_end);
    return clamp(low + share * (Real(1) - low) / turns, Real(0), Real(1));
  }

  Flash flash = shutter_shape(params);
  if (!(turns > Real(0))) return shutter_instant(params, flash, period + edges, end);
  // Blades with a travel time continue from their current level when the kind changes.
  if (travel_s > Real(0)) shutter.level = shutter_instant(params, flash, period + edges, end);

  Real light = Real(0);
  if (edges == uint(0)) {
    light = shutter_piece(params, flash, period, phase, turns);
  } else {
    light = shutter_piece(params, flash, period, phase, to_edge);
    light += Real(edges - uint(1)) * (Real(shutter_count(params.kind)) * flash_light(flash));
    light += shutter_piece(params, flash, period + edges, turns_zero(), turns_real(end));
  }
  return clamp(flash.low + light / turns, Real(0), Real(1));
}
