// Draws a triangle into the nearest depths of pixels, or into the numbers of the triangles that are there. A pixel
// belongs to a triangle by the rules of Vulkan's rasteriser with 8 bits below the pixel. FL_JOINED: into both at once.
// After triangles.glsl.
#ifdef FL_JOINED
layout(set = 0, binding = FL_BINDING_PIXEL_KEYS, std430) buffer KeysBuffer { uint64_t joined[]; };
#else
layout(constant_id = FL_SPEC_KEYS) const bool kKeys = false;
layout(set = 0, binding = FL_BINDING_PIXEL_DEPTHS, std430) buffer DepthsBuffer { uint depths[]; };
layout(set = 0, binding = FL_BINDING_PIXEL_KEYS, std430) buffer KeysBuffer { uint keys[]; };
#endif

// A point on an edge is within if the edge is at the top or on the left.
bool holds_edge(ivec2 d) { return d.y < 0 || (d.y == 0 && d.x > 0); }

void touch(uint pixel, float z, uint key) {
  uint bits = floatBitsToUint(z);
#ifdef FL_JOINED
  // The nearest depth, and of those at the same one the first triangle. Words only grow, so an old one does no harm.
  if (bits >= uint(joined[pixel] >> 32)) atomicMax(joined[pixel], uint64_t(bits) << 32 | uint64_t(key));
#else
  if (kKeys) {
    if (bits == depths[pixel]) atomicMax(keys[pixel], key);
  } else if (bits > depths[pixel]) {
    atomicMax(depths[pixel], bits);
  }
#endif
}

const bool kAlone = true;
const int kAlonePx = 4;  // of small ones, the most pixels that a thread tests alone

// One whose corners turn to the left. A small one, whose sides fit into 32 bits, is drawn row by row.
struct DrawnTriangle {
  ivec2 p0;
  ivec2 p1;
  ivec2 p2;
  vec3 z;  // at the first corner, and what it grows by with the second and the third side
  ivec2 low;
  ivec2 high;
  uint key;
};

void turn_around(inout Triangle it) {
  ivec2 corner = it.p1;
  it.p1 = it.p2;
  it.p2 = corner;
  it.z = it.z.xzy;
}
// it: turned to the left. area: twice its area.
DrawnTriangle drawn_of(Triangle it, float area, uint number) {
  precise float to_1 = (it.z.y - it.z.x) / area;
  precise float to_2 = (it.z.z - it.z.x) / area;
  return DrawnTriangle(it.p0, it.p1, it.p2, vec3(it.z.x, to_1, to_2), it.low, it.high, ~number);
}

// number: of the triangle, among all of the rig. head: that it belongs to.
DrawnTriangle small_of(Triangle it, uint number, uint head) {
  int area = side(it.p0, it.p1 - it.p0, it.p2);
  if (area < 0) turn_around(it);
  return drawn_of(it, float(abs(area)), number);
}

// Steps to the right from which a side may be no less than `least`, and after which it may be less.
void narrow(int side, int step, int least, inout ivec2 steps) {
  float at = float(least - side) / float(step);
  if (step > 0) steps.x = max(steps.x, int(floor(min(at, 1e6))));
  else if (step < 0) steps.y = min(steps.y, int(floor(max(at, -1e6))) + 1);
  else if (side < least) steps.y = -1;
}

void draw_row(DrawnTriangle w, int y) {
  ivec2 d0 = w.p2 - w.p1;
  ivec2 d1 = w.p0 - w.p2;
  ivec2 d2 = w.p1 - w.p0;
  ivec3 least = ivec3(holds_edge(d0) ? 0 : 1, holds_edge(d1) ? 0 : 1, holds_edge(d2) ? 0 : 1);
  ivec2 p = (ivec2(w.low.x, y) << 8) + 128;
  ivec3 e = ivec3(side(w.p1, d0, p), side(w.p2, d1, p), side(w.p0, d2, p));
  ivec3 by = -256 * ivec3(d0.y, d1.y, d2.y);
  ivec2 steps = ivec2(0, w.high.x - w.low.x);
  if (steps.y >= 4) {  // of a few a test of each pixel is quicker
    narrow(e.x, by.x, least.x, steps);
    narrow(e.y, by.y, least.y, steps);
    narrow(e.z, by.z, least.z, steps);
  }
  e += steps.x * by;
  uint pixel = uint(y) * params.width + uint(w.low.x);
  for (int x = steps.x; x <= steps.y; ++x) {
    if (all(greaterThanEqual(e, least))) {
      precise float z = w.z.x + (float(e.y) * w.z.y + float(e.z) * w.z.z);
      touch(pixel + uint(x), z, w.key);
    }
    e += by;
  }
}

bool within(ivec2 side, bool edge) { return side.x > 0 || (side.x == 0 && (side.y != 0 || edge)); }
ivec2 wide_sum(ivec2 a, ivec2 b) {
  uint carry;
  uint low = uaddCarry(uint(a.y), uint(b.y), carry);
  return ivec2(a.x + b.x + int(carry), int(low));
}
// What a side changes by from a pixel to the next one on its right.
ivec2 wide_step(ivec2 d) {
  ivec2 by;
  imulExtended(-256, d.y, by.x, by.y);
  return by;
}

// One that a workgroup draws, a part a thread.
struct WideTriangle {
  Sides sides;
  DrawnTriangle drawn;
};

// As small_of().
WideTriangle wide_of(Triangle it, uint number, uint head) {
  ivec2 area = wide_side(it.p0, it.p1 - it.p0, it.p2);
  if (area.x < 0) {
    turn_around(it);
    area = wide_side(it.p0, it.p1 - it.p0, it.p2);
  }
  return WideTriangle(sides_of(it, it.low), drawn_of(it, wide_float(area), number));
}

void draw_part(DrawnTriangle w, ivec3 pixels) {
  ivec2 d0 = w.p2 - w.p1;
  ivec2 d1 = w.p0 - w.p2;
  ivec2 d2 = w.p1 - w.p0;
  ivec2 by_0 = wide_step(d0);
  ivec2 by_1 = wide_step(d1);
  ivec2 by_2 = wide_step(d2);
  ivec2 p = (pixels.xz << 8) + 128;
  ivec2 e0 = wide_side(w.p1, d0, p);
  ivec2 e1 = wide_side(w.p2, d1, p);
  ivec2 e2 = wide_side(w.p0, d2, p);
  for (int x = pixels.x; x <= pixels.y; ++x) {
    if (within(e0, holds_edge(d0)) && within(e1, holds_edge(d1)) && within(e2, holds_edge(d2))) {
      precise float z = w.z.x + (wide_float(e1) * w.z.y + wide_float(e2) * w.z.z);
      touch(uint(pixels.z) * params.width + uint(x), z, w.key);
    }
    e0 = wide_sum(e0, by_0);
    e1 = wide_sum(e1, by_1);
    e2 = wide_sum(e2, by_2);
  }
}

// One that reaches behind the camera, by all threads.
void draw_open(Triangle it, uint key) {
  Sides s = open_sides(it, it.low);
  TriangleParts parts = parts_of(it.low, it.high);
  for (int i = int(gl_LocalInvocationIndex); i < parts.count; i += FL_THREADS) {
    ivec3 pixels = part_pixels(parts, s, i);
    for (int x = pixels.x; x <= pixels.y; ++x) {
      vec2 at = vec2(ivec2(x, pixels.z) - it.low);
      precise vec3 e = s.at_origin + (at.x * s.by_x + at.y * s.by_y);
      float z = exact_dot(e, s.depth);
      if (!(min(e.x, min(e.y, e.z)) >= 0.0 && z > 0.0 && z < 1.0)) continue;
      touch(uint(pixels.z) * params.width + uint(x), z, key);
    }
  }
}

// All of its parts, by all threads.
void draw_parts(WideTriangle w) {
  TriangleParts parts = parts_of(w.drawn.low, w.drawn.high);
  for (int i = int(gl_LocalInvocationIndex); i < parts.count; i += FL_THREADS) {
    draw_part(w.drawn, part_pixels(parts, w.sides, i));
  }
}

// The part that is in a block of pixels, by all threads.
void draw_block(Triangle it, uint number, ivec2 block, uint head) {
  it = in_block(it, block);
  if (it.open) draw_open(it, ~number);
  else draw_parts(wide_of(it, number, head));
}
