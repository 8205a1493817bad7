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

// One thread draws it.
void draw_pixels(Triangle it, uint key) {
  int area = side(it.p0, it.p1 - it.p0, it.p2);
  if (area == 0) return;
  if (area < 0) {
    ivec2 corner = it.p1;
    it.p1 = it.p2;
    it.p2 = corner;
    it.z = it.z.xzy;
    area = -area;
  }
  ivec2 d0 = it.p2 - it.p1;
  ivec2 d1 = it.p0 - it.p2;
  ivec2 d2 = it.p1 - it.p0;
  ivec3 least = ivec3(holds_edge(d0) ? 0 : 1, holds_edge(d1) ? 0 : 1, holds_edge(d2) ? 0 : 1);
  precise float to_1 = (it.z.y - it.z.x) / float(area);
  precise float to_2 = (it.z.z - it.z.x) / float(area);
  for (int y = it.low.y; y <= it.high.y; ++y) {
    for (int x = it.low.x; x <= it.high.x; ++x) {
      ivec2 p = (ivec2(x, y) << 8) + 128;
      ivec3 e = ivec3(side(it.p1, d0, p), side(it.p2, d1, p), side(it.p0, d2, p));
      if (any(lessThan(e, least))) continue;
      precise float z = it.z.x + (float(e.y) * to_1 + float(e.z) * to_2);
      touch(uint(y) * params.width + uint(x), z, key);
    }
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

// All threads of the workgroup draw it together.
void draw_pixels_together(Triangle it, uint key) {
  ivec2 area = wide_side(it.p0, it.p1 - it.p0, it.p2);
  if (area == ivec2(0)) return;
  if (area.x < 0) {
    ivec2 corner = it.p1;
    it.p1 = it.p2;
    it.p2 = corner;
    it.z = it.z.xzy;
    area = wide_side(it.p0, it.p1 - it.p0, it.p2);
  }
  Sides s = sides_of(it, it.low);
  ivec2 d0 = it.p2 - it.p1;
  ivec2 d1 = it.p0 - it.p2;
  ivec2 d2 = it.p1 - it.p0;
  ivec2 by_0 = wide_step(d0);
  ivec2 by_1 = wide_step(d1);
  ivec2 by_2 = wide_step(d2);
  precise float to_1 = (it.z.y - it.z.x) / wide_float(area);
  precise float to_2 = (it.z.z - it.z.x) / wide_float(area);
  TriangleParts parts = parts_of(it.low, it.high);
  for (int i = int(gl_LocalInvocationIndex); i < parts.count; i += FL_GROUP_TRIANGLES) {
    ivec3 pixels = part_pixels(parts, s, i);
    ivec2 p = (pixels.xz << 8) + 128;
    ivec2 e0 = wide_side(it.p1, d0, p);
    ivec2 e1 = wide_side(it.p2, d1, p);
    ivec2 e2 = wide_side(it.p0, d2, p);
    for (int x = pixels.x; x <= pixels.y; ++x) {
      if (within(e0, holds_edge(d0)) && within(e1, holds_edge(d1)) && within(e2, holds_edge(d2))) {
        precise float z = it.z.x + (wide_float(e1) * to_1 + wide_float(e2) * to_2);
        touch(uint(pixels.z) * params.width + uint(x), z, key);
      }
      e0 = wide_sum(e0, by_0);
      e1 = wide_sum(e1, by_1);
      e2 = wide_sum(e2, by_2);
    }
  }
}

// The same for one that reaches behind the camera.
void draw_open_together(Triangle it, uint key) {
  Sides s = open_sides(it, it.low);
  TriangleParts parts = parts_of(it.low, it.high);
  for (int i = int(gl_LocalInvocationIndex); i < parts.count; i += FL_GROUP_TRIANGLES) {
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

void draw_together(Triangle it, uint key) {
  if (it.open) draw_open_together(it, key);
  else draw_pixels_together(it, key);
}

// Triangles that all threads draw together.
shared Triangle wide[FL_GROUP_TRIANGLES];
shared uint wide_triangles[FL_GROUP_TRIANGLES];
shared uint wide_count;

// The part that is in a block of pixels, by all threads. number: of the triangle, among all of the rig.
void draw_block(Triangle it, uint number, ivec2 block, uint head) { draw_together(in_block(it, block), ~number); }

// Triangles `base` and on of a level, one a thread. first_number: of the level's first triangle. slot: FL_NONE for
// objects. has_wide: false where one thread may draw any of them.
void draw_triangles(BodyLevelRow level, uint slot, uint head, uint first_number, uint base, bool has_wide) {
  if (has_wide) {
    if (gl_LocalInvocationIndex == 0u) wide_count = 0u;
    barrier();
  }
  uint t = base + gl_LocalInvocationIndex;
  if (t < level.index_count / 3u) {
    Triangle it = triangle_of(level, t);
    if (!is_drawn(it)) {
    } else if (!has_wide || is_drawn_alone(it)) {
      draw_pixels(it, ~(first_number + t));
    } else if (is_drawn_together(it) || !leave_blocks(it, slot, t)) {
      uint at = atomicAdd(wide_count, 1u);
      wide[at] = it;
      wide_triangles[at] = t;
    }
  }
  if (!has_wide) return;
  barrier();
  uint count = wide_count;
  for (uint i = 0u; i < count; ++i) {
    // Block by block, as drawblocks.comp does: then its depths are the same.
    ivec2 last = wide[i].high / FL_BLOCK_PX;
    for (ivec2 block = wide[i].low / FL_BLOCK_PX; block.y <= last.y; ++block.y) {
      for (block.x = wide[i].low.x / FL_BLOCK_PX; block.x <= last.x; ++block.x) {
        draw_block(wide[i], first_number + wide_triangles[i], block, head);
      }
    }
  }
}
