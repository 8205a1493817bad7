// Tone curves: from exposed linear light to the screen. After agx.h.
//
// All but AgX change the largest channel of a colour and keep the ratios of the channels, so that hue and saturation of
// a beam stay what they are. Light above 1.0 then loses saturation, the more the brighter it is, so that the core of a
// beam becomes white whatever its colour: other channels come as near to the largest one as 0.15 e / (1 + 0.15 e), with
// e the light above 1.0. The form and the 0.15 are those of the Khronos PBR Neutral tone mapper (2024).

// IEC 61966-2-1.
FL_FN Real srgb_encoded(Real value) {
  return value <= Real(0.0031308) ? Real(12.92) * value
                                  : Real(1.055) * pow(max(value, Real(0)), Real(1) / Real(2.4)) - Real(0.055);
}

// The rational curve and the six constants that John Hable published for Uncharted 2 (2010): a toe, a straight part, a
// shoulder. His white is 11.2 and his exposure twice the picture's.
FL_FN Real hable_curve(Real x) {
  return (x * (Real(0.15) * x + Real(0.05)) + Real(0.004)) / (x * (Real(0.15) * x + Real(0.5)) + Real(0.06)) -
         Real(1) / Real(15);
}
FL_FN Real filmic_peak(Real peak) {
  return min(hable_curve(Real(2) * min(peak, Real(5.6))) / hable_curve(Real(11.2)), Real(1));
}

// Reinhard and others, "Photographic Tone Reproduction for Digital Images" (2002), equation 4: x (1 + x / w^2) /
// (1 + x) with white at w. w is 16, nearly that of AgX.
FL_FN Real reinhard_peak(Real peak) {
  Real x = min(peak, Real(16));
  return x * (Real(1) + x / Real(256)) / (Real(1) + x);
}

// color: linear Rec. 709, 1.0 = the exposure's brightest. Returns display values 0 to 1, encoded (sRGB). Light that is
// no number is black.
FL_FN Vec3 tone_by_peak(uint curve, Vec3 color) {
  Vec3 light = Vec3(clamp(color.x, Real(0), Real(1e30)), clamp(color.y, Real(0), Real(1e30)),
                    clamp(color.z, Real(0), Real(1e30)));
  Real peak = max(light.x, max(light.y, light.z));
  if (!(peak > Real(0))) return Vec3(Real(0), Real(0), Real(0));
  Real shown = min(peak, Real(1));
  if (curve == uint(FL_TONE_FILMIC)) shown = filmic_peak(peak);
  if (curve == uint(FL_TONE_REINHARD)) shown = reinhard_peak(peak);
  Real above = Real(0.15) * max(peak - Real(1), Real(0));
  Real white = above / (Real(1) + above);
  return Vec3(srgb_encoded(shown * (light.x / peak + white * (Real(1) - light.x / peak))),
              srgb_encoded(shown * (light.y / peak + white * (Real(1) - light.y / peak))),
              srgb_encoded(shown * (light.z / peak + white * (Real(1) - light.z / peak))));
}

FL_FN Vec3 tone_shown(uint curve, Vec3 color) {
  if (curve == uint(FL_TONE_AGX)) return agx(color);
  return tone_by_peak(curve, color);
}
