// Draws the triangles of a workgroup, one a thread: small ones alone, larger ones together, and the largest later, by a
// workgroup for each block of pixels (drawblocks.comp). After triangles.glsl and what draws (triangle_pixels.glsl or
// triangle_samples.glsl).
layout(set = 0, binding = FL_BINDING_DRAW_BLOCKS, std430) buffer DrawBlocksBuffer {
  DrawBlocksHead blocks_head;
  DrawBlockRow blocks[];
};

const int kAlonePx = 128;        // the most pixels that a thread tests alone
const int kAloneExtent = 16384;  // and the longest side, so that side() fits into 32 bits
const int kTogetherPx = 2048;    // and that a workgroup tests

// Triangles that all threads draw together, of one round.
shared Triangle wide[FL_GROUP_TRIANGLES];
shared uint wide_triangles[FL_GROUP_TRIANGLES];
shared uint wide_count;

// name_of: what a triangle is drawn as, its surface or its number; head: that of its body.
#ifdef FL_DRAWS_EDGES
uint name_of(uint first_number, uint t, Triangle it, uint head) {
  if ((it.part & FL_OBJECT) != 0u) return object_identity(it.part);
  return 1u + (head << 3 | it.part & 7u);
}
void draw_one(Triangle it, uint name) { draw_samples(it, name, 0, 1); }
void draw_wide(Triangle it, uint name) { draw_samples(it, name, int(gl_LocalInvocationIndex), FL_GROUP_TRIANGLES); }
#else
uint name_of(uint first_number, uint t, Triangle it, uint head) { return ~(first_number + t); }
void draw_one(Triangle it, uint name) { draw_pixels(it, name); }
void draw_wide(Triangle it, uint name) { draw_together(it, name); }
#endif

// The part of a triangle that is in a block.
Triangle in_block(Triangle it, ivec2 block) {
  it.low = max(it.low, block * FL_BLOCK_PX);
  it.high = min(it.high, block * FL_BLOCK_PX + (FL_BLOCK_PX - 1));
  return it;
}

// From where to where a triangle reaches in rows of pixels.
ivec2 reach_in(Triangle it, int first, int last) {
  if (it.open) return ivec2(it.low.x, it.high.x);
  vec2 low_high = vec2(float(first) - 1.0, float(last) + 2.0) * kSubpixels;
  vec2 corners[3] = vec2[3](vec2(it.p0), vec2(it.p1), vec2(it.p2));
  vec2 reach = vec2(1e9, -1e9);
  for (int i = 0; i < 3; ++i) {
    vec2 a = corners[i];
    vec2 d = corners[(i + 1) % 3] - a;
    vec2 at = d.y != 0.0 ? (low_high - a.y) / d.y : vec2(0.0, 1.0);
    float enter = clamp(min(at.x, at.y), 0.0, 1.0);
    float leave = clamp(max(at.x, at.y), 0.0, 1.0);
    if (max(a.y, a.y + d.y) < low_high.x || min(a.y, a.y + d.y) > low_high.y) continue;
    reach.x = min(reach.x, a.x + min(enter * d.x, leave * d.x));
    reach.y = max(reach.y, a.x + max(enter * d.x, leave * d.x));
  }
  reach = clamp(reach / kSubpixels, vec2(-1e6), vec2(1e6));
  return clamp(ivec2(int(floor(reach.x)) - 1, int(ceil(reach.y)) + 1), ivec2(it.low.x, it.low.x - 1),
               ivec2(it.high.x + 1, it.high.x));
}

// Leaves a triangle to drawblocks.comp. False: there is no room for all of it.
bool leave_blocks(Triangle it, uint slot, uint t) {
  for (int y = it.low.y / FL_BLOCK_PX; y <= it.high.y / FL_BLOCK_PX; ++y) {
    ivec2 reach = reach_in(it, y * FL_BLOCK_PX, y * FL_BLOCK_PX + (FL_BLOCK_PX - 1));
    if (reach.x > reach.y) continue;
    ivec2 columns = reach / FL_BLOCK_PX;
    uint count = uint(columns.y - columns.x + 1);
    uint at = atomicAdd(blocks_head.asked, count);
    uint room = min(count, uint(FL_BLOCKS_MAX) - min(at, uint(FL_BLOCKS_MAX)));
    atomicMax(blocks_head.groups_x, min(at + room, uint(FL_BLOCKS_MAX)));
    for (uint i = 0u; i < room; ++i) {
      blocks[at + i] = DrawBlockRow(slot, t, uint(columns.x) + i, uint(y));
    }
    if (room < count) return false;
  }
  return true;
}

// Triangles `base` and on of a level, as many as the workgroup has rounds for. slot: FL_NONE for objects. has_wide:
// false where one thread may draw any of them.
void draw_rounds(BodyLevelRow level, uint slot, uint head, uint first_number, uint base, bool has_wide) {
  uint triangles = min(level.index_count / 3u, base + uint(FL_ROUND_TRIANGLES));
  for (; base < triangles; base += FL_GROUP_TRIANGLES) {
    if (has_wide) {
      if (gl_LocalInvocationIndex == 0u) wide_count = 0u;
      barrier();
    }
    uint t = base + gl_LocalInvocationIndex;
    if (t < triangles) {
      Triangle it = triangle_of(level, t);
      ivec2 size = it.high - it.low + 1;
      if (size.x > 0 && size.y > 0) {
        bool alone = !has_wide || !it.open && size.x * size.y <= kAlonePx && it.extent <= kAloneExtent;
        bool together = !it.open && size.x <= kTogetherPx && size.x * size.y <= kTogetherPx;
        if (alone) {
          draw_one(it, name_of(first_number, t, it, head));
        } else if (together || !leave_blocks(it, slot, t)) {
          uint at = atomicAdd(wide_count, 1u);
          wide[at] = it;
          wide_triangles[at] = t;
        }
      }
    }
    if (!has_wide) continue;
    barrier();
    uint count = wide_count;
    for (uint i = 0u; i < count; ++i) {
      uint name = name_of(first_number, wide_triangles[i], wide[i], head);
      // Block by block, as drawblocks.comp does: then its depths are the same.
      ivec2 last = wide[i].high / FL_BLOCK_PX;
      for (ivec2 block = wide[i].low / FL_BLOCK_PX; block.y <= last.y; ++block.y) {
        for (block.x = wide[i].low.x / FL_BLOCK_PX; block.x <= last.x; ++block.x) {
          draw_wide(in_block(wide[i], block), name);
        }
      }
    }
    barrier();
  }
}
