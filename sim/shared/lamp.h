// Lamps: tungsten, LED, discharge, and supplies that chop. Needs turns.h, motion.h and filter.h.
//
// Every lamp keeps its state of when its input last changed, and computes from there in closed form (see motion.h).

// Tungsten.
//
// The filament's heat balance with power laws, C dT/dt = v^2 P (T/Tn)^-r - P (T/Tn)^p with C ~ T^q, has one solution
// curve for all lamps and all voltages. With theta = v^(2/(p+r)) its equilibrium over the full temperature Tn, y = T /
// (theta Tn), and s = theta^(p-q-1) P / (C Tn) t:  dy/ds = y^-q (y^-r - y^p). Near y = 1 a deviation decays as
// exp(-(p+r) s); phi(y) is the coordinate in which it does so everywhere, phi(1) = 0, phi'(1) = -1 (Koenigs'
// linearisation). So a step is phi of y, times exp(-(p+r) ds), y of phi. phi is tabulated over y, and inverted by
// Halley's method on the same table, so that steps add up. Above y = 2.5, which only a lamp sees that is almost off,
// phi would lose digits; there s itself is used, by its series in y^-(p+r).
//
// Error of the table: 0.002 K of the lamp's temperature; of both with float's rounding, compared with an adaptive
// solver at 1e-13, see lamp_test.cpp. Cost: an exponential, a square root and a look-up while the voltage holds; a
// logarithm, two exponentials and a look-up more when it changes.
// Source: r = 1.215 (resistivity of tungsten), p = 4.6 and q = 0.15 for radiation and heat capacity; these give P ~
// v^1.58 (makers: 1.6), T ~ v^0.34 (makers, of colour temperature: 0.42) and light ~ v^2.8 (makers: 3.4), and an
// inrush of 18 times the current.

FL_CONST Real kFilamentR = Real(1.215);
FL_CONST Real kFilamentP = Real(4.6);
FL_CONST Real kFilamentQ = Real(0.15);
FL_CONST Real kFilamentPR = Real(5.815);  // p + r: the decay at full, 1 / tau, over the rate P / (C Tn)
FL_CONST Real kFilamentC = Real(3.45);    // c = p - q - 1: s = y^-c / c for a lamp that only cools
FL_CONST Real kFilamentAmbientK = Real(293.15);

FL_CONST Real kFilamentCold = Real(1.192017415444);          // phi at y = 0
FL_CONST Real kFilamentHot = Real(-0.4618923366243158);      // phi at y without end
FL_CONST Real kFilamentFar = Real(2.5);                      // end of the table
FL_CONST Real kFilamentFarS = Real(0.01230479182093496);     // s from y without end to there

// phi at y = i / 48, and its slope over one interval. By Gauss-Legendre quadrature of the curve's d ln(phi) / dy.
// clang-format off
FL_CONST Real kFilamentPhi[121] = FL_LIST_BEGIN(Real, 121)
    Real(1.192017415444), Real(1.1917078095343), Real(1.1904233320547), Real(1.1878630992939), Real(1.183828215077),
    Real(1.1781691637372), Real(1.1707705674942), Real(1.1615445697928), Real(1.1504274691257), Real(1.1373778125036),
    Real(1.1223751842465), Real(1.105419309695), Real(1.0865292638461), Real(1.0657426611519), Real(1.0431147516165),
    Real(1.0187173791553), Real(0.99263777957513), Real(0.96497721158983), Real(0.93584942698944),
    Real(0.90537899637945), Real(0.87369951519987), Real(0.84095172117541), Real(0.8072815589551),
    Real(0.77283823046926), Real(0.73777227047752), Real(0.70223368597273), Real(0.66637019567696),
    Real(0.63032560202267), Real(0.59423832301778), Real(0.55824010555974), Real(0.52245493542338),
    Real(0.48699815263929), Real(0.45197577462139), Real(0.41748402347597), Real(0.38360904865843),
    Real(0.35042683170786), Real(0.31800325628619), Real(0.28639432422058), Real(0.25564649667898),
    Real(0.22579713893722), Real(0.19687504732237), Real(0.16890103771819), Real(0.14188857635827),
    Real(0.1158444353708), Real(0.090769357543743), Real(0.066658716927586), Real(0.043503164080101),
    Real(0.021289246897444), Real(0), Real(-0.02038450249831), Real(-0.039886634344288), Real(-0.058530746679052),
    Real(-0.07634274057341), Real(-0.093349682367186), Real(-0.10957946079569), Real(-0.12506048425186),
    Real(-0.13982141606251), Real(-0.15389094533044), Real(-0.16729759068953), Real(-0.18006953421632),
    Real(-0.19223448272076), Real(-0.20381955368212), Real(-0.21485118318912), Real(-0.2253550533724),
    Real(-0.23535603697145), Real(-0.24487815684731), Real(-0.25394455843036), Real(-0.26257749327158),
    Real(-0.27079831204285), Real(-0.27862746550306), Real(-0.28608451210903), Real(-0.29318813110304),
    Real(-0.29995614005024), Real(-0.30640551592889), Real(-0.31255241899507), Real(-0.31841221875003),
    Real(-0.3239995214346), Real(-0.32932819856042), Real(-0.33441141606375), Real(-0.3392616637343),
    Real(-0.3438907846304), Real(-0.34831000424267), Real(-0.35252995921318), Real(-0.35656072545499),
    Real(-0.36041184555047), Real(-0.36409235533446), Real(-0.36761080959284), Real(-0.37097530682701),
    Real(-0.37419351305198), Real(-0.37727268461007), Real(-0.38021968999386), Real(-0.38304103068182),
    Real(-0.38574286099786), Real(-0.38833100701243), Real(-0.39081098450766), Real(-0.39318801603283),
    Real(-0.39546704707973), Real(-0.39765276140889), Real(-0.39974959555976), Real(-0.40176175257838),
    Real(-0.4036932149964), Real(-0.40554775709579), Real(-0.40732895649267), Real(-0.40904020507371),
    Real(-0.41068471931739), Real(-0.41226555003182), Real(-0.41378559153968), Real(-0.4152475903398),
    Real(-0.41665415327371), Real(-0.41800775522447), Real(-0.41931074637369), Real(-0.42056535904166),
    Real(-0.42177371413417), Real(-0.42293782721858), Real(-0.42405961425032), Real(-0.42514089697026),
    Real(-0.42618340799197), Real(-0.42718879559693), Real(-0.42815862825497), Real(-0.42909439888595),
    Real(-0.42999752887803)
FL_LIST_END;
FL_CONST Real kFilamentPhiSlope[121] = FL_LIST_BEGIN(Real, 121)
    Real(0), Real(-0.00073212287776332), Real(-0.0018837426518197), Real(-0.0032692726394678),
    Real(-0.0048251964295536), Real(-0.0065120352602522), Real(-0.0082997474848016), Real(-0.010162834686119),
    Real(-0.012078256128729), Real(-0.014024445261832), Real(-0.015980844120909), Real(-0.017927712484311),
    Real(-0.019846095174498), Real(-0.021717884571092), Real(-0.0235259404946), Real(-0.02525424229485),
    Real(-0.026888054876099), Real(-0.028414094498916), Real(-0.029820682959701), Real(-0.031097880891915),
    Real(-0.032237592831327), Real(-0.033233638520685), Real(-0.034081786764645), Real(-0.034779749983654),
    Real(-0.035327139415023), Real(-0.035725382608332), Real(-0.035977606390665), Real(-0.036088489768851),
    Real(-0.036064092237126), Real(-0.035911663634009), Real(-0.03563944202783), Real(-0.035256446114553),
    Real(-0.034772268313111), Real(-0.034196874187738), Real(-0.033540413071158), Real(-0.032813043870416),
    Real(-0.032024779072925), Real(-0.031185348994342), Real(-0.03030408737457), Real(-0.029389838575577),
    Real(-0.028450885895245), Real(-0.027494899903623), Real(-0.026528905239483), Real(-0.025559263974156),
    Real(-0.024591673447135), Real(-0.02363117638941), Real(-0.022682181158199), Real(-0.02174848999147),
    Real(-0.020833333333333), Real(-0.019939408464067), Real(-0.019068920875268), Real(-0.018223627047913),
    Real(-0.017404877508002), Real(-0.016613659242625), Real(-0.015850636752729), Real(-0.015116191193688),
    Real(-0.014410457208889), Real(-0.013733357194124), Real(-0.013084632842106), Real(-0.012463873907899),
    Real(-0.011870544209201), Real(-0.01130400493214), Real(-0.010763535355632), Real(-0.010248351137521),
    Real(-0.0097576203255906), Real(-0.0092904772680662), Real(-0.0088460346030033), Real(-0.008423393505501),
    Real(-0.0080216523672316), Real(-0.0076399140754315), Real(-0.0072772920491294), Real(-0.0069329151797306),
    Real(-0.0066059318117011), Real(-0.0062955128874604), Real(-0.0060008543690405), Real(-0.0057211790378484),
    Real(-0.0054557377631729), Real(-0.0052038103200121), Real(-0.0049647058274488), Real(-0.0047377628701956),
    Real(-0.0045223493580865), Real(-0.0043178621711868), Real(-0.0041237266318069), Real(-0.0039393958389947),
    Real(-0.0037643498960108), Real(-0.0035980950567996), Real(-0.0034401628135201), Real(-0.0032901089437405),
    Real(-0.0031475125328777), Real(-0.0030119749848375), Real(-0.0028831190315405), Real(-0.0027605877500589),
    Real(-0.0026440435944049), Real(-0.0025331674475768), Real(-0.0024276576982397), Real(-0.0023272293453824),
    Real(-0.0022316131334136), Real(-0.0021405547194282), Real(-0.0020538138737586), Real(-0.001971163714419),
    Real(-0.0018923899756343), Real(-0.001817290310302), Real(-0.0017456736259634), Real(-0.0016773594536394),
    Real(-0.0016121773487193), Real(-0.0015499663229562), Real(-0.0014905743065272), Real(-0.0014338576390493),
    Real(-0.0013796805883932), Real(-0.0013279148961148), Real(-0.0012784393483108), Real(-0.0012311393707092),
    Real(-0.0011859066468199), Real(-0.0011426387579878), Real(-0.0011012388442239), Real(-0.0010616152847187),
    Real(-0.0010236813969809), Real(-0.00098735515358212), Real(-0.00095255891553079), Real(-0.00091921918133806),
    Real(-0.0008872663508833)
FL_LIST_END;
// y at phi = 1.2 - i / 40, to four digits: where its search begins.
FL_CONST Real kFilamentY[67] = FL_LIST_BEGIN(Real, 67)
    Real(0.05), Real(0.1137), Real(0.1674), Real(0.2049), Real(0.2354), Real(0.2618), Real(0.2855), Real(0.3073),
    Real(0.3276), Real(0.3467), Real(0.365), Real(0.3825), Real(0.3994), Real(0.4158), Real(0.4318), Real(0.4474),
    Real(0.4628), Real(0.4779), Real(0.4928), Real(0.5075), Real(0.5221), Real(0.5367), Real(0.5511), Real(0.5656),
    Real(0.58), Real(0.5945), Real(0.609), Real(0.6235), Real(0.6382), Real(0.6529), Real(0.6679), Real(0.6829),
    Real(0.6982), Real(0.7137), Real(0.7294), Real(0.7455), Real(0.7618), Real(0.7785), Real(0.7956), Real(0.8131),
    Real(0.831), Real(0.8496), Real(0.8687), Real(0.8884), Real(0.9089), Real(0.9302), Real(0.9524), Real(0.9756),
    Real(1), Real(1.026), Real(1.053), Real(1.082), Real(1.113), Real(1.146), Real(1.182), Real(1.221), Real(1.264),
    Real(1.312), Real(1.366), Real(1.428), Real(1.5), Real(1.587), Real(1.696), Real(1.839), Real(2.044), Real(2.393),
    Real(2.5)
FL_LIST_END;
// clang-format on

// phi, its slope and its second derivative; 0 <= y <= 2.5.
FL_INLINE Real filament_phi(Real y, FL_OUT(Real) slope, FL_OUT(Real) bend) {
  Real place = y * Real(48);
  uint i = min(uint(place), uint(119));
  Real t = place - Real(i);
  Real a = kFilamentPhi[i];
  Real b = kFilamentPhi[i + uint(1)];
  Real da = kFilamentPhiSlope[i];
  Real db = kFilamentPhiSlope[i + uint(1)];
  // Cubic Hermite: a + t (da + t (c2 + t c3)), written so that few operations wait for another.
  Real way = b - a;
  Real both = da + db;
  Real c3 = both - Real(2) * way;
  Real c2 = (Real(3) * way - da) - both;
  Real t_2 = t * t;
  slope = Real(48) * ((da + t * (Real(2) * c2)) + t_2 * (Real(3) * c3));
  bend = Real(2 * 48 * 48) * (c2 + t * (Real(3) * c3));
  return (a + t * da) + t_2 * (c2 + t * c3);
}

// When Halley's steps are such a share of y, what is left is their cube.
FL_CONST Real kFilamentStop = kSingle ? Real(4e-3) : Real(1e-5);

// y of phi, from the table's end at y = 2.5 to cold.
FL_INLINE Real filament_y(Real phi) {
  Real place = clamp((Real(1.2) - phi) * Real(40), Real(0), Real(65.9));
  uint first = uint(place);
  Real y = kFilamentY[first] + (place - Real(first)) * (kFilamentY[first + uint(1)] - kFilamentY[first]);
  for (uint i = uint(0); i < uint(8); ++i) {
    Real slope;
    Real bend;
    Real miss = filament_phi(y, slope, bend) - phi;
    Real step = miss * slope / (slope * slope - Real(0.5) * miss * bend);
    y = clamp(y - step, Real(1e-3), kFilamentFar);
    if (!(abs(step) > kFilamentStop * y)) break;
  }
  return phi == Real(0) ? Real(1) : y;
}

// s from y without end to y >= 2.5, by the logarithm of y to the base of 2; the first term that is left out is 1e-17 of
// it.
FL_FN Real filament_far_s(Real log_y) {
  Real w = exp2(-kFilamentPR * log_y);
  Real sum = Real(1) / Real(38.34);
  sum = sum * w + Real(1) / Real(32.525);
  sum = sum * w + Real(1) / Real(26.71);
  sum = sum * w + Real(1) / Real(20.895);
  sum = sum * w + Real(1) / Real(15.08);
  sum = sum * w + Real(1) / Real(9.265);
  return exp2(-kFilamentC * log_y) * (Real(1) / kFilamentC + w * sum);
}

// And back.
FL_FN Real filament_far_log_y(Real s) {
  Real log_y = -log2(kFilamentC * s) * (Real(1) / kFilamentC);
  for (uint i = uint(0); i < uint(3); ++i) {  // Newton, from 1e-3; ds / d log2(y) is known
    Real w = exp2(-kFilamentPR * log_y);
    Real slope = Real(-0.6931471805599453) * exp2(-kFilamentC * log_y) / (Real(1) - w);
    log_y -= (filament_far_s(log_y) - s) / slope;
  }
  return log_y;
}

struct FilamentType {
  Real full_k;  // temperature at full voltage, 1000 to 3700 K
  Real tau_s;   // time constant at full: 0.003 (small) to 0.35 (2 kW)
};

struct Filament {
  Real kelvin;  // now; also the colour temperature of its light (a grey body)
  Real from_k;  // when the voltage was last changed
  Real volt;
  // What a step needs of that, computed once:
  Real from;      // phi of from_k; where the lamp is off, (from_k / full)^-c
  Real end_k;     // equilibrium at this voltage
  Real decay_hz;  // (p + r) ds / dt; where the lamp is off, how fast (T / full)^-c grows; 0: beyond the table
  Turns since_ns;  // since then
};

FL_FN Filament filament_start(Real kelvin) {
  Filament filament;
  filament.kelvin = max(kelvin, kFilamentAmbientK);
  filament.from_k = filament.kelvin;
  filament.volt = Real(-1);  // none yet
  filament.from = Real(0);
  filament.end_k = Real(0);
  filament.decay_hz = Real(0);
  filament.since_ns = turns_zero();
  return filament;
}

FL_CONST Real kFilamentOff = Real(1e-4);  // volts below this heat nothing

FL_FN bool filament_takes(FilamentType type, Real volt) {
  return volt >= Real(0) && volt < Real(1e3) && type.tau_s >= Real(1e-6) && type.tau_s <= Real(1e6) &&
         type.full_k >= Real(500) && type.full_k <= Real(1e4);
}

// Begins a stretch at this voltage.
FL_INLINE Filament filament_aim(Filament filament, FilamentType type, Real volt) {
  filament.from_k = filament.kelvin;
  filament.volt = volt;
  filament.since_ns = turns_zero();
  Real full = filament.from_k / type.full_k;
  if (volt < kFilamentOff) {  // off: dT/dt = -T^(p-q)
    filament.from = exp2(log2(full) * -kFilamentC);
    filament.end_k = type.full_k;
    filament.decay_hz = (kFilamentC / kFilamentPR) / type.tau_s;
    return filament;
  }
  // Powers by their logarithms to the base of 2.
  Real log_theta = log2(volt) * (Real(2) / kFilamentPR);
  filament.end_k = exp2(log_theta) * type.full_k;
  Real y = filament.from_k / filament.end_k;
  filament.decay_hz = y < kFilamentFar ? exp2(kFilamentC * log_theta) / type.tau_s : Real(0);
  Real slope;
  Real bend;
  filament.from = filament_phi(min(y, kFilamentFar), slope, bend);
  return filament;
}

// The temperature t_s after a stretch began far above its end.
FL_FN Real filament_from_far(Filament filament, FilamentType type, Real t_s) {
  Real log_theta = log2(filament.volt) * (Real(2) / kFilamentPR);
  Real s = filament_far_s(log2(filament.from_k / type.full_k) - log_theta) +
           exp2(kFilamentC * log_theta) * t_s / (type.tau_s * kFilamentPR);
  if (s < kFilamentFarS) return exp2(filament_far_log_y(s) + log_theta) * type.full_k;
  Real phi = kFilamentHot * decay_share(kFilamentPR * s);
  return filament_y(phi) * filament.end_k;
}

FL_INLINE Real filament_at(Filament filament, FilamentType type, Real t_s) {
  Real kelvin;
  if (filament.volt < kFilamentOff) {
    kelvin = exp2(log2(filament.from + filament.decay_hz * t_s) * (-Real(1) / kFilamentC)) * filament.end_k;
  } else if (filament.decay_hz > Real(0)) {
    Real phi = filament.from * decay_share(filament.decay_hz * t_s);
    kelvin = phi == Real(0) ? filament.end_k : filament_y(phi) * filament.end_k;
  } else {
    kelvin = filament_from_far(filament, type, t_s);
  }
  return max(kelvin, kFilamentAmbientK);
}

// The temperature after t_s at `volt` (rms over the rated voltage, 0 to 1.2), from any temperature. Exact but for the
// table. Refused, and the temperature left alone: a step or a voltage that is no number or negative, an infinite step.
FL_FN Real filament_after(Real kelvin, FilamentType type, Real volt, Real t_s) {
  if (!(t_s > Real(0)) || !(t_s < Real(1e30)) || !filament_takes(type, volt)) return kelvin;
  return filament_at(filament_aim(filament_start(kelvin), type, volt), type, t_s);
}

// `type` is the same at every step.
FL_INLINE Filament filament_step(Filament filament, FilamentType type, Real volt, Turns dt_ns) {
  if (dt_ns == turns_zero() || !filament_takes(type, volt)) return filament;
  if (volt != filament.volt) filament = filament_aim(filament, type, volt);
  filament.since_ns = time_add(filament.since_ns, dt_ns);
  filament.kelvin = filament_at(filament, type, time_s(filament.since_ns));
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

// Where a voltage leads in the end.
FL_FN Real filament_rest(Real volt, FilamentType type) {
  if (!(volt > Real(1e-4))) return kFilamentAmbientK;
  return max(type.full_k * exp2(log2(volt) * (Real(2) / kFilamentPR)), kFilamentAmbientK);
}

// The temperature of a share of light, 1e-9 to 1: the inverse of filament_light(), within 1e-6 of the temperature.
FL_FN Real filament_kelvin(Real light, FilamentType type) {
  if (!(light > Real(1e-9))) return kFilamentAmbientK;
  if (light >= Real(1)) return type.full_k;
  Real wanted = log(light) + filament_log_light(type.full_k);
  // In x = 1000 / T the logarithm of light is nearly a line; Newton by secants of two points on it.
  Real x = Real(1000) / type.full_k;
  Real slope = Real(-24);
  Real value = filament_log_light(type.full_k);
  for (uint i = uint(0); i < uint(6); ++i) {
    Real step = (wanted - value) / slope;
    if (!(abs(step) > Real(1e-7))) break;
    Real next = filament_log_light(Real(1000) / (x + step));
    slope = (next - value) / step;
    x += step;
    value = next;
    if (!(slope < Real(-1))) break;
  }
  return Real(1000) / x;
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
  uint pad;
  Turns since_ns;  // since then
};

FL_FN Led led_start(Real level) {
  Led led;
  led.level = level;
  led.heat = Real(0);
  led.from_level = level;
  led.from_heat = Real(0);
  led.target = level;
  led.pad = uint(0);
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
    Real begin = off != Real(0) ? (before_s > Real(0) ? decay_share(before_s / type.rise_s) : Real(1)) : Real(0);
    led.level = level;
    if (begin > Real(0)) {
      Real length = (after_s - before_s) / type.rise_s;
      Real share = relax_share(length);
      if (length > Real(0)) mean = level + off * begin * (share / length);
      led.level = level + off * (begin * (Real(1) - share));
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
  uint pad;
  Turns since_ns;  // since then
};

FL_FN Discharge discharge_start() {
  Discharge lamp;
  lamp.warm = Real(0);
  lamp.lit = uint(0);
  lamp.from_warm = Real(0);
  lamp.from_lit = uint(0);
  lamp.power = uint(0);
  lamp.pad = uint(0);
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
