// Rays through the puffs of plumes (shared/haze_plume.h), in closed form. FL_HAZE_PLUMES before lib/frame.glsl.

// The integral of a puff's density up to a distance t along a ray is scale x plume_erf(per_m (t - middle)), from the
// middle.
struct PuffChord {
  float middle;  // distance of the densest place, m
  float per_m;
  float scale;   // 0: too little to count
};

// The error function, to 1.5e-7 (Abramowitz and Stegun, 7.1.26).
float plume_erf(float x) {
  float a = abs(x);
  float t = 1.0 / (1.0 + 0.3275911 * a);
  float tail = t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429)))) *
               exp(-a * a);
  return x < 0.0 ? tail - 1.0 : 1.0 - tail;
}

// ray: unit. cell: of the grid that the values are interpolated in, over the distance; 0: none.
PuffChord puff_chord(HazePuff puff, vec3 from, vec3 ray, float cell) {
  PuffChord chord;
  chord.middle = dot(puff.center - from, ray);
  if (cell > 0.0) {
    // Interpolation between two rays widens a puff by a sixth of the square of their distance. It is narrower by that.
    float h = cell * max(chord.middle, 0.0);
    float across = 1.0 / (puff.per_across * puff.per_across);
    float along = 1.0 / (puff.per_along * puff.per_along);
    float least = 0.2 * h * h;
    float narrow_across = max(across - h * h / 6.0, least);
    float narrow_along = max(along - h * h / 6.0, least);
    puff.peak *= across / narrow_across * sqrt(along / narrow_along);
    puff.per_across = inversesqrt(narrow_across);
    puff.per_along = inversesqrt(narrow_along);
  }
  vec3 at = haze_puff_scaled(puff, from - puff.center);
  vec3 way = haze_puff_scaled(puff, ray);
  float length_2 = dot(way, way);
  float nearest = -dot(at, way) / length_2;
  vec3 off = at + nearest * way;
  float distance_2 = dot(off, off);
  chord.middle = nearest;
  chord.per_m = sqrt(0.5 * length_2);
  chord.scale = distance_2 < 40.0 ? puff.peak * exp(-0.5 * distance_2) * 0.8862269255 / chord.per_m : 0.0;
  return chord;
}
