// What a tile of FL_SURFACE_PX x FL_SURFACE_PX pixels shows: the plane in its middle, and spheres round its places. One
// workgroup has one tile; each thread has kRows pixels, one below the other, and kBlockThreads threads in a row have
// a block of 16 x 8 pixels. After surface.glsl, tile_test.glsl, thin.glsl and tile_list.glsl.
//
// All functions but cone_touches...() are called by all threads of the group together.
layout(constant_id = FL_SPEC_GROUP) const uint kGroup = 512;  // threads: 128, 256 or 512
const uint kRows = uint(FL_SURFACE_PX * FL_SURFACE_PX) / kGroup;
#define FL_BLOCKS 8u
const uint kBlockThreads = kGroup / FL_BLOCKS;

// The pixels of this thread.
Surface surface[kRows];
vec3 offset_m[kRows];  // of the surface point from the camera
bool on_plane[kRows];  // shows the tile's plane

// The plane that the pixel in the middle shows, if that is a box or an object: its unit normal, and normal . place,
// from the camera. The normal 0 is no plane.
shared vec4 tile_plane;
// Boxes round the places of block b: those on the tile's plane in row 2 b, all others in row 2 b + 1. As integers in
// the order of floats, from the camera.
shared int box_low[2u * FL_BLOCKS][3];
shared int box_high[2u * FL_BLOCKS][3];
// Spheres round these boxes, then round all places on the plane and round all others. w: radius, below 0 without any.
shared vec4 spheres[2u * FL_BLOCKS + 2u];
// Places off the plane may be far behind each other, as bodies in front of bodies are. So those of block b also have a
// sphere for each slice of the depths that they have in the tile, in FL_SLICES rows from FL_SLICES b on; a bit for each
// slice with places.
#define FL_SLICES 16u
shared int slice_low[FL_SLICES * FL_BLOCKS][3];
shared int slice_high[FL_SLICES * FL_BLOCKS][3];
shared vec4 slice_spheres[FL_SLICES * FL_BLOCKS];
shared uint slice_bits[FL_BLOCKS];
shared uint others_near;  // bits of distances along rays
shared uint others_far;
const float kDeep = 1.05;  // far over near, from which on slices are used

// Order-preserving integer of a float.
int ordered(float x) {
  int bits = floatBitsToInt(x);
  return bits ^ ((bits >> 31) & 0x7fffffff);
}
float from_ordered(int bits) { return intBitsToFloat(bits ^ ((bits >> 31) & 0x7fffffff)); }

// First pixel of this thread, from the tile's first.
uvec2 first_pixel() {
  uint number = thread_number();
  uint quarter = number / (2u * kBlockThreads);
  uint row = number % (2u * kBlockThreads) / 16u;
  return uvec2((quarter & 1u) * 16u + (number & 15u), (quarter >> 1) * 16u + row * kRows);
}
uint own_block() { return thread_number() / kBlockThreads; }

// place_m: of the surface, from the camera.
bool is_on_plane(vec4 plane, Surface surface, vec3 place_m) {
  const float kSlack = 2e-5;  // of the distance
  return (surface.kind == kBox || surface.kind == kObject) && surface.normal == plane.xyz &&
         abs(dot(plane.xyz, place_m) - plane.w) <= kSlack * abs(plane.w);
}

// low > high without a place.
void add_box(uint at, vec3 low_m, vec3 high_m) {
  if (subgroupBallotBitCount(subgroupBallot(low_m.x <= high_m.x)) == 0u) return;
  // Larger subgroups have more than one block.
  bool is_one_block = gl_SubgroupSize <= kBlockThreads;
  if (is_one_block) {
    low_m = subgroupMin(low_m);
    high_m = subgroupMax(high_m);
  }
  if (low_m.x > high_m.x || (is_one_block && !subgroupElect())) return;
  for (int i = 0; i < 3; ++i) {
    atomicMin(box_low[at][i], ordered(low_m[i]));
    atomicMax(box_high[at][i], ordered(high_m[i]));
  }
}

vec4 sphere_round(ivec3 low, ivec3 high) {
  if (low.x > high.x) return vec4(0.0, 0.0, 0.0, -1.0);
  vec3 low_m = vec3(from_ordered(low.x), from_ordered(low.y), from_ordered(low.z));
  vec3 high_m = vec3(from_ordered(high.x), from_ordered(high.y), from_ordered(high.z));
  return vec4(0.5 * (low_m + high_m), 0.5001 * length(high_m - low_m) + 1e-4);
}

// After find_shapes(), where the tile has places off the plane.
void find_slices() {
  uint number = thread_number();
  if (number == 0u) {
    others_near = floatBitsToUint(kNothingM);
    others_far = 0u;
  }
  if (number < FL_BLOCKS) slice_bits[number] = 0u;
  for (uint s = number; s < FL_SLICES * FL_BLOCKS; s += kGroup) {
    for (int i = 0; i < 3; ++i) {
      slice_low[s][i] = 0x7fffffff;
      slice_high[s][i] = int(0x80000000);
    }
  }
  barrier();
  for (int i = 0; i < int(kRows); ++i) {
    if (surface[i].kind == kNothing || on_plane[i]) continue;
    atomicMin(others_near, floatBitsToUint(surface[i].t_m));
    atomicMax(others_far, floatBitsToUint(surface[i].t_m));
  }
  barrier();
  float near_m = uintBitsToFloat(others_near);
  float far_m = uintBitsToFloat(others_far);
  if (!(far_m > kDeep * near_m)) return;  // the same for all threads
  float per_m = float(FL_SLICES) / (far_m - near_m);
  for (int i = 0; i < int(kRows); ++i) {
    if (surface[i].kind == kNothing || on_plane[i]) continue;
    uint slice = min(uint((surface[i].t_m - near_m) * per_m), FL_SLICES - 1u);
    uint at = own_block() * FL_SLICES + slice;
    atomicOr(slice_bits[own_block()], 1u << slice);
    for (int k = 0; k < 3; ++k) {
      atomicMin(slice_low[at][k], ordered(offset_m[i][k]));
      atomicMax(slice_high[at][k], ordered(offset_m[i][k]));
    }
  }
  barrier();
  for (uint s = number; s < FL_SLICES * FL_BLOCKS; s += kGroup) {
    slice_spheres[s] = sphere_round(ivec3(slice_low[s][0], slice_low[s][1], slice_low[s][2]),
                                    ivec3(slice_high[s][0], slice_high[s][1], slice_high[s][2]));
  }
  barrier();
}

// Fills tile_plane, on_plane and spheres. first: the thread's first pixel; middle: the pixel in the middle, in the
// picture.
void find_shapes(uvec2 first, uvec2 middle) {
  uint number = thread_number();
  if (number < 2u * FL_BLOCKS) {
    for (int i = 0; i < 3; ++i) {
      box_low[number][i] = 0x7fffffff;
      box_high[number][i] = int(0x80000000);
    }
  }
  for (int i = 0; i < int(kRows); ++i) {
    if (first + uvec2(0, i) != middle) continue;
    bool is_flat = surface[i].kind == kBox || surface[i].kind == kObject;
    tile_plane = is_flat ? vec4(surface[i].normal, dot(surface[i].normal, offset_m[i])) : vec4(0.0);
  }
  barrier();
  vec4 plane = tile_plane;
  for (int i = 0; i < int(kRows); ++i) on_plane[i] = is_on_plane(plane, surface[i], offset_m[i]);
  for (uint other = 0u; other < 2u; ++other) {
    vec3 low_m = vec3(2.0 * kNothingM);
    vec3 high_m = vec3(-2.0 * kNothingM);
    for (int i = 0; i < int(kRows); ++i) {
      if (surface[i].kind == kNothing || on_plane[i] != (other == 0u)) continue;
      low_m = min(low_m, offset_m[i]);
      high_m = max(high_m, offset_m[i]);
    }
    add_box(2u * own_block() + other, low_m, high_m);
  }
  barrier();
  if (number < 2u * FL_BLOCKS + 2u) {
    bool is_whole = number >= 2u * FL_BLOCKS;
    ivec3 low = ivec3(0x7fffffff);
    ivec3 high = ivec3(0x80000000);
    uint end = is_whole ? 2u * FL_BLOCKS : number + 1u;
    for (uint b = is_whole ? number - 2u * FL_BLOCKS : number; b < end; b += 2u) {
      low = min(low, ivec3(box_low[b][0], box_low[b][1], box_low[b][2]));
      high = max(high, ivec3(box_high[b][0], box_high[b][1], box_high[b][2]));
    }
    spheres[number] = sphere_round(low, high);
  }
  barrier();
}

// Whether the cone reaches a sphere. bound: beam_bound(row, FL_THIN_ON_SURFACE).
bool cone_touches(BeamRow row, BeamShape bound, vec4 sphere) {
  if (sphere.w < 0.0) return false;
  vec3 p = row.eye.xyz + to_light(row, sphere.xyz);
  // What float loses of a place grows with its distance from the lens and from the camera.
  float radius = sphere.w + 1e-6 * (length(row.eye.xyz) + length(p));
  float spread = row.y_axis.w;
  float side = radius * sqrt(1.0 + spread * spread);
  if (kRectangle && row.squeeze > 0.0) side = radius * (max(1.0, inversesqrt(row.squeeze)) + spread);
  return p.z > -radius && p.z < row.axis.w + radius &&
         length(p.xy) < bound.lens_radius_m + spread * max(p.z, 0.0) + side;
}

// Whether it reaches a place of a block off the plane.
bool cone_touches_others(BeamRow row, BeamShape bound, uint block) {
  if (!cone_touches(row, bound, spheres[2u * block + 1u])) return false;
  bool touches = slice_bits[block] == 0u;
  for (uint bits = slice_bits[block]; bits != 0u && !touches; bits &= bits - 1u) {
    touches = cone_touches(row, bound, slice_spheres[block * FL_SLICES + uint(findLSB(bits))]);
  }
  return touches;
}
