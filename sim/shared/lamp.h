// Lamps: tungsten, LED, discharge, and supplies that chop. Needs turns.h, motion.h and filter.h.
//
// Every lamp keeps its state of when its input last changed, and computes from there in closed form (see motion.h).

// Tungsten.
//
// The filament's heat balance with power laws, C dT/dt = v^2 P (T/Tn)^-r - P (T/Tn)^p with C ~ T^q, has one solution
// curve for all lamps and all voltages. With theta = v^(2/(p+r)) its equilibrium over the full temperature Tn, y = T /
// (theta Tn), and s = theta^(p-q-1) P / (C Tn) t:  dy/ds = y^-q (y^-r - y^p). Heating, y < 1: y = x^(1/m), m = 1 + r +
// q; cooling, y > 1: y = x^(-1/c), c = p - q - 1; in both x = 1 - exp(-z), and s = z R(z^(1/2)) with R a smooth
// function: the two tables. A step is z of y, s of z, s + ds, z of s (Newton on the same table, so that steps add up),
// y of z.
//
// Error of the table: 0.007 K of the lamp's temperature (compared with an adaptive solver at 1e-13, see lamp_test.cpp).
// Cost: four logarithms, four exponentials, and Newton's two to four look-ups.
// Source: r = 1.215 (resistivity of tungsten), p = 4.6 and q = 0.15 for radiation and heat capacity; these give P ~
// v^1.58 (makers: 1.6), T ~ v^0.34 (makers, of colour temperature: 0.42) and light ~ v^2.8 (makers: 3.4), and an
// inrush of 18 times the current.

FL_CONST Real kFilamentR = Real(1.215);
FL_CONST Real kFilamentP = Real(4.6);
FL_CONST Real kFilamentQ = Real(0.15);
FL_CONST Real kFilamentPR = Real(5.815);  // p + r: the decay at full, 1 / tau, over the rate P / (C Tn)
FL_CONST Real kFilamentM = Real(2.365);   // m = 1 + r + q, heating
FL_CONST Real kFilamentC = Real(3.45);    // c = p - q - 1, cooling
FL_CONST Real kFilamentHeatTail = Real(0.178233038454797);  // s - z / (p + r) beyond the table, z > 16
FL_CONST Real kFilamentCoolTail = Real(0.080129103997942);
FL_CONST Real kFilamentAmbientK = Real(293.15);

// R at z^(1/2) = i / 8, and its slope over one interval. By Gauss-Legendre quadrature of the curve's ds/dz.
// clang-format off
FL_CONST Real kFilamentHeat[33] = FL_LIST_BEGIN(Real, 33)
    Real(0.422832980972516), Real(0.419551047127365), Real(0.410010751738112), Real(0.395224517926522),
    Real(0.376808755078863), Real(0.356572851030299), Real(0.336096569453507), Real(0.316510774534587),
    Real(0.298486559026917), Real(0.282333408474126), Real(0.268118582236713), Real(0.255765665645682),
    Real(0.245122995038386), Real(0.236006653292911), Real(0.22822575880296), Real(0.221596575647252),
    Real(0.215949916410208), Real(0.211134585685799), Real(0.207018458383581), Real(0.203488111529022),
    Real(0.200447569907974), Real(0.197816543584255), Real(0.195528433544501), Real(0.193528309156522),
    Real(0.19177099807121), Real(0.190219373001809), Real(0.188842873535724), Real(0.187616267306914),
    Real(0.186518633520556), Real(0.185532540934839), Real(0.184643389009915), Real(0.183838882145652),
    Real(0.183108610475222)
FL_LIST_END;
FL_CONST Real kFilamentHeatSlope[33] = FL_LIST_BEGIN(Real, 33)
    Real(0), Real(-0.00651738028097715), Real(-0.0123926414977033), Real(-0.0169026809683819),
    Real(-0.0196196807067156), Real(-0.0205852312489778), Real(-0.0201789609904137), Real(-0.0188826341675285),
    Real(-0.0171162973575121), Real(-0.0151804504333548), Real(-0.0132630629366278), Real(-0.0114687443274558),
    Real(-0.00984765548845189), Real(-0.00841706631866881), Real(-0.00717546239695646), Real(-0.00611115560624078),
    Real(-0.00520737801020232), Real(-0.00444529688243445), Real(-0.003805839773732), Real(-0.00327081978124338),
    Real(-0.00282361139526401), Real(-0.00244950704626331), Real(-0.00213583610664366), Real(-0.00187191275479594),
    Real(-0.00164887265529266), Real(-0.00145945028317781), Real(-0.00129773717144528), Real(-0.00115894846131405),
    Real(-0.00103921340996322), Real(-0.000935396484917099), Real(-0.000844949696011118), Real(-0.000765793474281276),
    Real(-0.000696221925692549)
FL_LIST_END;
FL_CONST Real kFilamentCool[33] = FL_LIST_BEGIN(Real, 33)
    Real(0.289855072463768), Real(0.287697819172379), Real(0.281915547227024), Real(0.273746814595028),
    Real(0.264357393173024), Real(0.254642194686159), Real(0.245199458687812), Real(0.236382821224609),
    Real(0.228370839114967), Real(0.221227232528613), Real(0.21494512261743), Real(0.209476877663012),
    Real(0.204753332386712), Real(0.200695865082952), Real(0.197223901244387), Real(0.194259536040773),
    Real(0.191730315419122), Real(0.189570790848746), Real(0.187723216143695), Real(0.186137627638099),
    Real(0.184771489518467), Real(0.183589056175146), Real(0.182560580352835), Real(0.181661470421262),
    Real(0.180871471826693), Real(0.180173920099061), Real(0.17955508920617), Real(0.179003641524848),
    Real(0.178510174436374), Real(0.178066852554905), Real(0.177667112387592), Real(0.177305426367727),
    Real(0.176977114571668)
FL_LIST_END;
FL_CONST Real kFilamentCoolSlope[33] = FL_LIST_BEGIN(Real, 33)
    Real(0), Real(-0.00416400325033905), Real(-0.00718636297990399), Real(-0.00895376867828734),
    Real(-0.00967572875127656), Real(-0.00965597143289396), Real(-0.0091717769959058), Real(-0.00843275378590561),
    Real(-0.00758132158795837), Real(-0.00670752571484134), Real(-0.00586494457521624), Real(-0.00508326809628835),
    Real(-0.0043770472042374), Real(-0.00375139114684718), Real(-0.00320556562701847), Real(-0.00273526553770351),
    Real(-0.0023340948591073), Real(-0.00199457955990068), Real(-0.00170889085685543), Real(-0.00146936452090869),
    Real(-0.00126885587510706), Real(-0.00110095446346082), Real(-0.000960082032697684), Real(-0.000841501085420227),
    Real(-0.000741262642274192), Real(-0.00065611933187347), Real(-0.000583424528684544), Real(-0.000521031839922809),
    Real(-0.000467203343843308), Real(-0.00042053042917909), Real(-0.000379868050376549), Real(-0.000344281490144226),
    Real(-0.000313003899367127)
FL_LIST_END;
// clang-format on

// R and its slope in u = z^(1/2), 0 <= u < 4.
FL_FN Real filament_table(bool heating, Real u, FL_OUT(Real) slope) {
  Real place = u * Real(8);
  uint i = min(uint(place), uint(31));
  Real t = place - Real(i);
  Real a = heating ? kFilamentHeat[i] : kFilamentCool[i];
  Real b = heating ? kFilamentHeat[i + uint(1)] : kFilamentCool[i + uint(1)];
  Real da = heating ? kFilamentHeatSlope[i] : kFilamentCoolSlope[i];
  Real db = heating ? kFilamentHeatSlope[i + uint(1)] : kFilamentCoolSlope[i + uint(1)];
  // Cubic Hermite: a + t (da + t (c2 + t c3)).
  Real c3 = Real(2) * (a - b) + da + db;
  Real c2 = b - a - da - c3;
  slope = Real(8) * (da + t * (Real(2) * c2 + t * Real(3) * c3));
  return a + t * (da + t * (c2 + t * c3));
}

FL_FN Real filament_s_of_z(bool heating, Real z) {
  if (!(z < Real(16))) return z / kFilamentPR + (heating ? kFilamentHeatTail : kFilamentCoolTail);
  Real slope;
  return z * filament_table(heating, sqrt(z), slope);
}

FL_FN Real filament_z_of_s(bool heating, Real s) {
  Real tail = heating ? kFilamentHeatTail : kFilamentCoolTail;
  Real z = kFilamentPR * (s - tail);
  if (!(z < Real(16))) return z;
  z = max(z, (heating ? kFilamentM : kFilamentC) * s);  // both are below: Newton comes from one side
  for (uint i = uint(0); i < uint(8); ++i) {
    Real u = min(sqrt(z), Real(4));
    Real slope;
    Real value = filament_table(heating, u, slope);
    Real step = (s - z * value) / (value + Real(0.5) * u * slope);
    z = max(z + step, Real(0));
    if (!(abs(step) > Real(1e-7) * z)) break;
  }
  return z;
}

// -ln(1 - x) for 0 <= x < 1.
FL_FN Real filament_z_of_x(Real x) {
  if (x < Real(2e-3))
    return x * (Real(1) + x * (Real(0.5) + x * (Real(1) / Real(3) + x * (Real(0.25) + x * Real(0.2)))));
  return -log(Real(1) - x);
}

struct FilamentType {
  Real full_k;  // temperature at full voltage, 1000 to 3700 K
  Real tau_s;   // time constant at full: 0.003 (small) to 0.35 (2 kW)
};

// The temperature after t_s at `volt` (rms over the rated voltage, 0 to 1.2), from any temperature. Exact but for the
// table. Refused, and the temperature left alone: a step or a voltage that is no number or negative, an infinite step.
FL_FN Real filament_after(Real kelvin, FilamentType type, Real volt, Real t_s) {
  if (!(t_s > Real(0)) || !(t_s < Real(1e30)) || !(volt >= Real(0)) || !(volt < Real(1e3))) return kelvin;
  if (!(type.tau_s >= Real(1e-6)) || !(type.tau_s <= Real(1e6)) || !(type.full_k >= Real(500)) ||
      !(type.full_k <= Real(1e4)))
    return kelvin;
  Real full = max(kelvin, kFilamentAmbientK) / type.full_k;
  Real t = t_s / (type.tau_s * kFilamentPR);
  if (volt < Real(1e-4)) {  // off: dT/dt = -T^(p-q)
    full = pow(pow(full, -kFilamentC) + kFilamentC * t, -Real(1) / kFilamentC);
    return max(full * type.full_k, kFilamentAmbientK);
  }
  // Powers by their logarithms to the base of 2.
  Real log_theta = log2(volt) * (Real(2) / kFilamentPR);
  Real log_y = log2(full) - log_theta;
  bool heating = log_y < Real(0);
  Real x = exp2(heating ? kFilamentM * log_y : -kFilamentC * log_y);
  log_y = Real(0);
  if (x < Real(1)) {
    Real s = filament_s_of_z(heating, filament_z_of_x(x)) + exp2(kFilamentC * log_theta) * t;
    x = relax_share(filament_z_of_s(heating, s));
    log_y = log2(x) * (heating ? Real(1) / kFilamentM : -Real(1) / kFilamentC);
  }
  return max(exp2(log_y + log_theta) * type.full_k, kFilamentAmbientK);
}

struct Filament {
  Real kelvin;  // now; also the colour temperature of its light (a grey body)
  Real from_k;  // when the voltage was last changed
  Real volt;
  Turns since_ns;  // since then
};

FL_FN Filament filament_start(Real kelvin) {
  Filament filament;
  filament.kelvin = max(kelvin, kFilamentAmbientK);
  filament.from_k = filament.kelvin;
  filament.volt = Real(-1);  // none yet
  filament.since_ns = turns_zero();
  return filament;
}

FL_FN Filament filament_step(Filament filament, FilamentType type, Real volt, Turns dt_ns) {
  if (!(volt >= Real(0)) || !(volt < Real(1e3)) || dt_ns == turns_zero()) return filament;
  if (volt != filament.volt) {
    filament.from_k = filament.kelvin;
    filament.volt = volt;
    filament.since_ns = turns_zero();
  }
  filament.since_ns = time_add(filament.since_ns, dt_ns);
  filament.kelvin = filament_after(filament.from_k, type, volt, time_s(filament.since_ns));
  return filament;
}

// Current over the rated current: 18 times when cold, which a real supply's resistance brings to 10 to 15.
FL_FN Real filament_current(Real kelvin, FilamentType type, Real volt) {
  return volt * pow(max(kelvin, kFilamentAmbientK) / type.full_k, -kFilamentR);
}

// Natural logarithm of a grey body's luminous power, 500 to 4000 K: the integral of Planck's law over the CIE 1924
// luminous efficiency in steps of 10 nm, fitted in 1000 / T to 4e-4.
FL_FN Real filament_log_light(Real kelvin) {
  Real x = Real(1000) / clamp(kelvin, Real(500), Real(4000));
  return x * (Real(-26.62683571) + x * (Real(2.189450535) + x * (Real(-0.5614537306) +
                                                                 x * (Real(0.1215594012) + x * Real(-0.01031564376)))));
}

// Light over the light at full; below 500 K (1e-15 of it) none. Relative error 6e-4.
FL_FN Real filament_light(Real kelvin, FilamentType type) {
  if (!(kelvin > Real(500))) return Real(0);
  return exp(filament_log_light(kelvin) - filament_log_light(type.full_k));
}

// The voltage that gives a temperature in the end, and the temperature that gives a share of light: what a dimmer has
// to do for a level that is meant as light.
FL_FN Real filament_volt(Real kelvin, FilamentType type) {
  return pow(max(kelvin, Real(0)) / type.full_k, Real(0.5) * kFilamentPR);
}

// Supplies that chop.
//
// A phase-cut dimmer conducts during the last `share` of each half wave. A filament of 10 ms and more sees the rms; a
// shorter one, or an LED without a capacitor, is stepped per half wave or sees mains_mean. PWM is a strobe:
// shutter_step with its rate and duty.

// rms over the rated voltage.
FL_FN Real phase_cut_rms(Real share) {
  Real conducts = unit_share(share);
  Real cut = Real(1) - conducts;
  Real angle = Real(6.283185307179586477) * cut;
  return share > Real(0) ? sqrt(max(conducts + sin(angle) * Real(0.159154943091895336), Real(0))) : Real(0);
}

// Energy from the beginning of a half wave to `p` of it, over the energy of a whole one.
FL_FN Real mains_energy(Real p, Real cut) {
  Real angle = Real(6.283185307179586477);
  if (!(p > cut)) return Real(0);
  return (p - cut) - (sin(angle * p) - sin(angle * cut)) / angle;
}

// Mean power over an exposure, 1 for full conduction over whole half waves. phase: in half waves at the start; advance:
// half waves during it (turns_advance at twice the mains frequency).
FL_FN Real mains_mean(Turns phase, Advance advance, Real share) {
  Real cut = share > Real(0) ? Real(1) - min(share, Real(1)) : Real(1);
  Real turns = advance_turns(advance);
  Real p = turns_real(phase);
  if (!(turns > Real(1e-4)))
    return p > cut ? Real(2) * sin(Real(3.14159265358979324) * p) * sin(Real(3.14159265358979324) * p) : Real(0);
  Turns end = turns_add(phase, advance.part);
  Real whole = Real(advance.whole) + (turns_less(end, phase) ? Real(1) : Real(0));
  Real energy = whole * mains_energy(Real(1), cut) + mains_energy(turns_real(end), cut) - mains_energy(p, cut);
  return max(energy / turns, Real(0));
}

// LED: the driver follows its level as an RC does; the heat follows the power, and hot LEDs give less light.

struct LedType {
  Real rise_s;  // time constant of the driver, 0.001 to 0.005; 0: at once
  Real heat_s;  // time constant of the heat sink, minutes; 0: no droop
  Real droop;   // share of light lost when hot at full level, 0 to 0.3
};

struct Led {
  Real level;       // of the current, 0 to 1
  Real heat;        // 0 to 1: what full level leads to
  Real from_level;  // when the target was last changed
  Real from_heat;
  Real target;
  Turns since_ns;  // since then
};

FL_FN Led led_start(Real level) {
  Led led;
  led.level = level;
  led.heat = Real(0);
  led.from_level = level;
  led.from_heat = Real(0);
  led.target = level;
  led.since_ns = turns_zero();
  return led;
}

// Returns the mean light over the step, 0 to 1; for dt_ns = 0 the light now. Exact, but that the droop of the step's
// end stands for the whole step: off by at most droop * dt / heat_s. A target outside 0 to 1 is cut; no number is
// refused.
FL_INLINE Real led_step(FL_INOUT(Led) led, LedType type, Real target, Turns dt_ns) {
  Real droop = type.heat_s >= Real(1e-6) && type.heat_s <= Real(1e6) ? unit_share(type.droop) : Real(0);
  if (!(abs(target) <= Real(1e9))) return led.level * (Real(1) - droop * led.heat);
  Real level = unit_share(target);
  if (level != led.target) {
    led.from_level = led.level;
    led.from_heat = led.heat;
    led.target = level;
    led.since_ns = turns_zero();
  }
  if (dt_ns == turns_zero()) return led.level * (Real(1) - droop * led.heat);
  Real before_s = time_s(led.since_ns);
  led.since_ns = time_add(led.since_ns, dt_ns);
  Real after_s = time_s(led.since_ns);
  Real off = led.from_level - level;
  Real mean = level;
  bool slow = type.rise_s >= Real(1e-6) && type.rise_s <= Real(1e6);
  if (slow) {
    if (off != Real(0)) {
      Real begin = before_s > Real(0) ? decay_share(before_s / type.rise_s) : Real(1);
      Real length = (after_s - before_s) / type.rise_s;
      Real share = relax_share(length);
      if (length > Real(0)) mean = level + off * begin * (share / length);
      led.level = level + off * (begin * (Real(1) - share));
    } else {
      led.level = level;
    }
  } else {
    led.level = level;
  }
  if (type.heat_s >= Real(1e-6) && type.heat_s <= Real(1e6)) {
    // dheat/dt = (level(t) - heat) / heat_s, with level(t) = target + off exp(-t / rise_s).
    Real rate = Real(1) / type.heat_s;
    Real cooled = decay_share(after_s * rate);
    led.heat = level + (led.from_heat - level) * cooled;
    if (slow) {
      Real gap = Real(1) / type.rise_s - rate;  // of the two rates
      Real both = abs(gap) * after_s < Real(1e-3)
                      ? after_s * decay_share(after_s * Real(0.5) * (rate + Real(1) / type.rise_s))
                      : (cooled - decay_share(after_s / type.rise_s)) / gap;
      led.heat += off * rate * both;
    }
    led.heat = unit_share(led.heat);
  }
  return unit_share(mean) * (Real(1) - droop * led.heat);
}

// Discharge: an arc that strikes, runs up, and cannot strike while it is hot. Its dimmer is a dowser (slew_step).

struct DischargeType {
  Real ignite_s;       // from power to the arc, cold
  Real run_up_s;       // time constant of the run-up; some 0.3 of the minutes that makers state
  Real cool_s;         // time constant of cooling
  Real restrike_warm;  // the arc can strike at this warmth and below, (0, 1)
  Real first_light;    // share of the light right after striking, 0 to 1
};

struct Discharge {
  Real warm;       // 0 cold to 1 run up
  uint lit;        // 1: the arc burns
  Real from_warm;  // when the power was last switched
  uint from_lit;
  uint power;      // 1: on
  Turns since_ns;  // since then
};

FL_FN Discharge discharge_start() {
  Discharge lamp;
  lamp.warm = Real(0);
  lamp.lit = uint(0);
  lamp.from_warm = Real(0);
  lamp.from_lit = uint(0);
  lamp.power = uint(0);
  lamp.since_ns = turns_zero();
  return lamp;
}

FL_FN Real discharge_share(Real t_s, Real tau_s) { return tau_s >= Real(1e-6) ? decay_share(t_s / tau_s) : Real(0); }

// Seconds from power on to the arc, from a warmth: the hot-restrike lockout, then the ignition.
FL_FN Real discharge_strike_s(Real warm, DischargeType type) {
  Real locked_s = Real(0);
  if (warm > type.restrike_warm && type.restrike_warm > Real(0) && type.cool_s > Real(0))
    locked_s = type.cool_s * log(warm / type.restrike_warm);
  return locked_s + (type.ignite_s > Real(0) ? type.ignite_s : Real(0));
}

// Mean light of an arc that began at `warm`, between two times after it began.
FL_FN Real discharge_light(Real warm, DischargeType type, Real before_s, Real after_s) {
  Real first = unit_share(type.first_light);
  Real cold = (Real(1) - warm) * discharge_share(before_s, type.run_up_s);
  Real length = type.run_up_s >= Real(1e-6) ? (after_s - before_s) / type.run_up_s : Real(0);
  if (length > Real(0)) cold *= relax_share(length) / length;
  return Real(1) - (Real(1) - first) * cold;
}

// Returns the mean light over the step, 0 to 1; for dt_ns = 0 the light now.
FL_FN Real discharge_step(FL_INOUT(Discharge) lamp, DischargeType type, uint power, Turns dt_ns) {
  if (power != lamp.power) {
    lamp.from_warm = lamp.warm;
    lamp.from_lit = power == uint(0) ? uint(0) : lamp.lit;
    lamp.lit = lamp.from_lit;
    lamp.power = power;
    lamp.since_ns = turns_zero();
  }
  Real before_s = time_s(lamp.since_ns);
  lamp.since_ns = time_add(lamp.since_ns, dt_ns);
  Real after_s = time_s(lamp.since_ns);
  if (power == uint(0)) {
    lamp.warm = lamp.from_warm * discharge_share(after_s, type.cool_s);
    return Real(0);
  }
  Real strike_s = lamp.from_lit != uint(0) ? Real(0) : discharge_strike_s(lamp.from_warm, type);
  Real struck_warm =
      lamp.from_lit != uint(0) ? lamp.from_warm : lamp.from_warm * discharge_share(strike_s, type.cool_s);
  if (!(after_s >= strike_s)) {
    lamp.warm = lamp.from_warm * discharge_share(after_s, type.cool_s);
    return Real(0);
  }
  lamp.lit = uint(1);
  lamp.warm = Real(1) - (Real(1) - struck_warm) * discharge_share(after_s - strike_s, type.run_up_s);
  Real burns_s = min(after_s - before_s, after_s - strike_s);
  Real light = discharge_light(struck_warm, type, max(after_s - burns_s - strike_s, Real(0)), after_s - strike_s);
  return after_s > before_s ? light * (burns_s / (after_s - before_s)) : light;
}

// Colour temperature on the way from a fresh arc to one that has run up.
FL_FN Real discharge_kelvin(Discharge lamp, Real first_k, Real full_k) { return mix(first_k, full_k, lamp.warm); }
