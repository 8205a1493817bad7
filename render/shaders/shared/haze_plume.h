// Plumes of haze in front of machines (fixtures/simulate/plume.h), beside the haze of haze_field.h, which it needs.
//
// A plume is a row of Gaussian puffs along one axis. Their densities are over that of the haze that a frame counts as
// even. Value noise of one layer, which moves along the axis, makes them patchy: a factor of 1 + 0.5 n, n within -1
// and 1 with a mean of 0. Light that goes to the eye through a puff is lost in it, without the noise. On its way from
// a lamp none is lost.

// 48 bytes, in float.
struct HazePuff {
  Vec3 center;
  Real per_across;  // 1 / standard deviation, 1/m
  Vec3 axis;        // unit
  Real per_along;
  Real peak;        // density in its middle, over that of even haze
  uint plume;
  uint pad_0;
  uint pad_1;
};

struct HazePlumes {
  Real even_share;        // of the scattering that counts as even haze: what is in the room
  Real scattering_per_m;  // of a density of 1
  Real shift_m;           // that noise has moved along the axes, beyond whole 32 cubes
  uint count;             // puffs
};

FL_CONST Real kPlumeNoise = Real(0.5);
FL_CONST Real kPlumeCubeM = Real(1.2);
FL_CONST Real kPlumeNoiseMS = Real(1);  // speed of the noise

// A vector in widths of the puff.
FL_FN Vec3 haze_puff_scaled(FL_IN(HazePuff) puff, Vec3 v) {
  return puff.per_across * v + ((puff.per_along - puff.per_across) * dot(v, puff.axis)) * puff.axis;
}

FL_FN Real haze_puff_density(FL_IN(HazePuff) puff, Vec3 place) {
  Vec3 from = haze_puff_scaled(puff, place - puff.center);
  return puff.peak * exp(Real(-0.5) * dot(from, from));
}

// The factor at a place in a plume. blur_m: what is smaller does not count.
FL_FN Real haze_plume_factor(Vec3 axis, uint plume, Real shift_m, Vec3 place, Real blur_m) {
  Real fade = clamp(kPlumeCubeM / max(blur_m, Real(1e-6)) - Real(1), Real(0), Real(1));
  if (!(fade > Real(0))) return Real(1);
  Vec3 side = normalize(abs(axis.z) < Real(0.9) ? Vec3(-axis.y, axis.x, 0) : Vec3(0, -axis.z, axis.y));
  HazeLayer layer;
  layer.drift = Vec3(0, 0, 0);
  layer.per_m = Real(1) / kPlumeCubeM;
  layer.cell_x = uint(0);
  layer.cell_y = uint(0);
  layer.cell_z = uint(0);
  layer.seed = haze_hash(plume + uint(77));
  layer.weight = Real(1);
  // The axis is first: the lattice repeats along x alone, and shift_m starts again where it does.
  Vec3 at = Vec3(dot(place, axis) - shift_m, dot(place, side), dot(place, cross(axis, side)));
  return Real(1) + kPlumeNoise * fade * haze_layer(layer, at);
}
