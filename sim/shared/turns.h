// Phase as an unsigned 64-bit count of 2^-64 turn: wraps exactly, never drifts. Turns is (low word, high word).
//
// A rate in Hz becomes an integer number of 2^-64 turns a nanosecond, so that steps of integer nanoseconds add up
// exactly: step(a) then step(b) equals step(a + b) to the bit. The rate is rounded down to 2^-64 turn/ns = 5.4e-11 Hz
// for a whole number of hertz.

FL_FN Turns turns_add(Turns a, Turns b) {
  uint low = a.x + b.x;
  uint carry = low < a.x ? uint(1) : uint(0);
  return Turns(low, a.y + b.y + carry);
}

// Low 64 bits of the product of two 32-bit numbers.
FL_FN Turns turns_mul_32(uint a, uint b) {
  uint a0 = a & uint(0xffff);
  uint a1 = a >> uint(16);
  uint b0 = b & uint(0xffff);
  uint b1 = b >> uint(16);
  uint p00 = a0 * b0;
  uint p01 = a0 * b1;
  uint p10 = a1 * b0;
  uint p11 = a1 * b1;
  uint middle = (p00 >> uint(16)) + (p01 & uint(0xffff)) + (p10 & uint(0xffff));
  return Turns((p00 & uint(0xffff)) | (middle << uint(16)),
               p11 + (p01 >> uint(16)) + (p10 >> uint(16)) + (middle >> uint(16)));
}

// Low 64 bits of a 64-bit number times a 64-bit number.
FL_FN Turns turns_mul(Turns a, Turns b) {
  Turns product = turns_mul_32(a.x, b.x);
  product.y += a.x * b.y + a.y * b.x;
  return product;
}

// 2^-64 turn a nanosecond for a rate in [0, 1e6] Hz; negative and NaN give 0. Whole hertz are exact integers; only the
// fraction of a hertz is rounded to Real.
FL_FN Turns turns_per_ns(Real rate_hz) {
  if (!(rate_hz > Real(0))) return Turns(0, 0);
  Real rate = min(rate_hz, Real(1.0e6));
  Real whole_hz = floor(rate);
  // 2^64 / 1e9 = 18446744073.7 = 4 x 2^32 + 1266874889.7
  Turns whole = turns_mul(Turns(uint(1266874889), uint(4)), Turns(uint(whole_hz), uint(0)));
  Real part = (rate - whole_hz) * Real(4.294967296);  // of the fraction, in units of 2^-32 turn a nanosecond
  Real part_high = floor(part);
  return turns_add(whole, Turns(uint((part - part_high) * Real(4294967040.0)), uint(part_high)));
}

// The phase after dt_ns nanoseconds (low word, high word) at a constant rate.
FL_FN Turns turns_step(Turns phase, Real rate_hz, Turns dt_ns) {
  return turns_add(phase, turns_mul(turns_per_ns(rate_hz), dt_ns));
}

// In [0, 1): the top bits as a fraction of a turn.
FL_FN Real turns_fraction(Turns phase) { return Real(phase.y >> uint(8)) * Real(5.9604644775390625e-8); }
