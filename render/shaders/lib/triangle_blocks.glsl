// Who draws a triangle: small ones the thread that has it, larger ones its workgroup (triangle_groups.glsl), and the
// largest a workgroup for each block of pixels (drawblocks.comp). After triangles.glsl.
layout(set = 0, binding = FL_BINDING_DRAW_BLOCKS, std430) buffer DrawBlocksBuffer {
  DrawBlocksHead blocks_head;
  DrawBlockRow blocks[];
};
#ifdef FL_DRAWS_EDGES
#define FL_BLOCKS_ASKED edge_parts[part].blocks_asked
#define FL_BLOCKS_GROUPS edge_parts[part].blocks_x
#else
#define FL_BLOCKS_ASKED blocks_head.asked
#define FL_BLOCKS_GROUPS blocks_head.groups_x
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
    uint at = atomicAdd(FL_BLOCKS_ASKED, count);
    uint room = min(count, uint(FL_BLOCKS_MAX) - min(at, uint(FL_BLOCKS_MAX)));
    atomicMax(FL_BLOCKS_GROUPS, min(at + room, uint(FL_BLOCKS_MAX)));
    for (uint i = 0u; i < room; ++i) {
      blocks[at + i] = DrawBlockRow(slot, t, uint(columns.x) + i, uint(y));
    }
    if (room < count) return false;
  }
  return true;
}

bool is_drawn(Triangle it) { return all(lessThanEqual(it.low, it.high)); }
bool is_small(Triangle it) { return !it.open && it.extent <= kSmallExtent; }
