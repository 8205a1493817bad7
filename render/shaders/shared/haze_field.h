// Haze that is not even: its density at a place, over that of even haze. Needs nothing but real.h.
//
// Layers of value noise: -1 or 1 at random at the corners of cubes, between them smooth (3 f^2 - 2 f^3), each layer
// with cubes of half the size and 0.7 of the weight. The lattice of each layer is turned against the stage, so that no
// clouds lie along its axes, and drifts with the wind, smaller ones faster, so that clouds change as they move. The
// sum n is within -1 and 1, and n (3 - n^2) / 2 has more contrast within the same bounds. Both are as often above 0 as
// below, so the mean of the density, 1 + noise x that, is 1, and it is never negative.
//
// Above it the haze thins with height: 1 / (1 + (z / height)^4).
//
// The band limit: the smallest cubes have a side of size_m / 4; a layer whose cubes are smaller than two of what
// `blur_m` says fades, and is gone at one.
#define FL_HAZE_LAYERS 3

// 48 bytes, in float.
struct HazeLayer {
  Vec3 drift;   // of its lattice, in cubes: what is beyond whole ones
  Real per_m;   // cubes a metre
  uint cell_x;  // whole cubes of the drift
  uint cell_y;
  uint cell_z;
  uint seed;
  Real weight;  // of all layers: 1
  uint pad_0;
  uint pad_1;
  uint pad_2;
};

struct HazeField {
  HazeLayer layers[FL_HAZE_LAYERS];
  Real noise;         // 0 to 1
  Real per_height;    // 1 / height, 1/m; 0: as much at every height
  Real from_m;        // the part of the rays from the camera that the table of densities has (lib/haze.glsl)
  Real length_m;
};

// Mixes bits: "lowbias32" of Wellons' hash prospector.
FL_FN uint haze_hash(uint x) {
  x = (x ^ (x >> uint(16))) * uint(0x7feb352du);
  x = (x ^ (x >> uint(15))) * uint(0x846ca68bu);
  return x ^ (x >> uint(16));
}
// The random signs of a row of corners, a bit each. Along x they repeat after 32 cubes, along y and
// z they do not.
FL_FN uint haze_row(uint seed, uint y, uint z) {
  return haze_hash(seed + y * uint(0x9e3779b9u) + z * uint(0x85ebca6bu));
}
FL_FN Real haze_between(uint row, uint x, Real f) {
  Real low = Real((row >> (x & uint(31))) & uint(1));
  Real high = Real((row >> ((x + uint(1)) & uint(31))) & uint(1));
  return mix(low, high, f);
}

// A layer's lattice against that of the layer before, and of the first one against the stage.
FL_FN Vec3 haze_turned(Vec3 p) {
  return Vec3(Real(0.8) * p.y + Real(0.6) * p.z, Real(-0.8) * p.x + Real(0.36) * p.y - Real(0.48) * p.z,
              Real(-0.6) * p.x - Real(0.48) * p.y + Real(0.64) * p.z);
}

// p: in the layer's turned axes, m.
FL_FN Real haze_layer(FL_IN(HazeLayer) layer, Vec3 p) {
  Vec3 at = p * layer.per_m - layer.drift;
  Vec3 low = floor(at);
  Vec3 f = at - low;
  f = f * f * (Vec3(3, 3, 3) - Real(2) * f);
  uint x = uint(int(low.x)) - layer.cell_x;
  uint y = uint(int(low.y)) - layer.cell_y;
  uint z = uint(int(low.z)) - layer.cell_z;
  Real near = mix(haze_between(haze_row(layer.seed, y, z), x, f.x),
                  haze_between(haze_row(layer.seed, y + uint(1), z), x, f.x), f.y);
  Real far = mix(haze_between(haze_row(layer.seed, y, z + uint(1)), x, f.x),
                 haze_between(haze_row(layer.seed, y + uint(1), z + uint(1)), x, f.x), f.y);
  return Real(2) * mix(near, far, f.z) - Real(1);
}

// place: on the stage, m. blur_m: what is smaller does not count.
FL_FN Real haze_density(FL_IN(HazeField) field, Vec3 place, Real blur_m) {
  Real sum = Real(0);
  Vec3 p = place;
  for (uint i = uint(0); i < uint(FL_HAZE_LAYERS); ++i) {
    p = haze_turned(p);
    Real cells = Real(1) / max(field.layers[i].per_m * blur_m, Real(1e-6));
    sum += field.layers[i].weight * clamp(cells - Real(1), Real(0), Real(1)) * haze_layer(field.layers[i], p);
  }
  Real density = Real(1) + field.noise * sum * (Real(1.5) - Real(0.5) * sum * sum);
  Real height = max(place.z, Real(0)) * field.per_height;
  height *= height;
  return density / (Real(1) + height * height);
}
