// From exposed linear light to the screen: AgX (Troy Sobotka), with the 6th-order fit of its curve that Benjamin
// Wrensch published for GLSL (2023), then a little more contrast and saturation, as stage colours want. Last comes the
// dither for 8 bits.

FL_CONST Real kAgxEvMin = Real(-12.47393);
FL_CONST Real kAgxEvMax = Real(4.026069);
FL_CONST Real kAgxContrast = Real(1.25);
FL_CONST Real kAgxSaturation = Real(1.3);

FL_FN Real agx_curve(Real linear_value) {
  Real ev = log2(max(linear_value, Real(1e-10)));
  Real x = (clamp(ev, kAgxEvMin, kAgxEvMax) - kAgxEvMin) / (kAgxEvMax - kAgxEvMin);
  Real x2 = x * x;
  Real x4 = x2 * x2;
  Real y = Real(15.5) * x4 * x2 - Real(40.14) * x4 * x + Real(31.96) * x4 - Real(6.868) * x2 * x + Real(0.4298) * x2 +
           Real(0.1191) * x - Real(0.00232);
  return pow(max(y, Real(0)), kAgxContrast);
}

// color: linear Rec. 709, 1.0 = the exposure's brightest. Returns display values 0 to 1, encoded (gamma 2.2, near
// sRGB).
FL_FN Vec3 agx(Vec3 color) {
  Vec3 inset =
      Vec3(Real(0.842479062253094) * color.x + Real(0.0784335999999992) * color.y + Real(0.0792237451477643) * color.z,
           Real(0.0423282422610123) * color.x + Real(0.878468636469772) * color.y + Real(0.0791661274605434) * color.z,
           Real(0.0423756549057051) * color.x + Real(0.0784336) * color.y + Real(0.879142973793104) * color.z);
  Vec3 v = Vec3(agx_curve(inset.x), agx_curve(inset.y), agx_curve(inset.z));
  Real luma = Real(0.2126) * v.x + Real(0.7152) * v.y + Real(0.0722) * v.z;
  v = Vec3(luma + kAgxSaturation * (v.x - luma), luma + kAgxSaturation * (v.y - luma),
           luma + kAgxSaturation * (v.z - luma));
  return Vec3(clamp(Real(1.19687900512017) * v.x - Real(0.0980208811401368) * v.y - Real(0.0990297440797205) * v.z,
                    Real(0), Real(1)),
              clamp(Real(-0.0528968517574562) * v.x + Real(1.15190312990417) * v.y - Real(0.0989611768448433) * v.z,
                    Real(0), Real(1)),
              clamp(Real(-0.0529716355144438) * v.x - Real(0.0980434501171241) * v.y + Real(1.15107367264116) * v.z,
                    Real(0), Real(1)));
}

// Adds less than half a step of 255 either way, by the place of the pixel alone. Rounding to 8 bits then has no mean
// error over neighbours, and smooth light has no rings. Whole steps stay what they are. The offsets fill the unit
// interval evenly over any few neighbours (M. Roberts, "The unreasonable effectiveness of quasirandom sequences",
// 2018). They are counted in integers, so they are the same on every device.
FL_FN Vec3 dithered(Vec3 shown, uint x, uint y) {
  uint place = x * uint(3242174889u) + y * uint(2447445414u);
  Real offset = ((Real(place >> uint(8)) + Real(0.5)) / Real(16777216) - Real(0.5)) * Real(0.999 / 255.0);
  return Vec3(clamp(shown.x + offset, Real(0), Real(1)), clamp(shown.y + offset, Real(0), Real(1)),
              clamp(shown.z + offset, Real(0), Real(1)));
}
