// Draws triangles of a body or of objects. Each thread places its own and draws it if it has few pixels (kAlone); then
// all threads draw the rows of the others, so that none waits for one with more. After triangle_pixels.glsl or
// triangle_samples.glsl. FL_TRIANGLES: of a workgroup.
shared DrawnTriangle small[FL_TRIANGLES];
shared uint small_first[FL_TRIANGLES];  // the number of their first row, among those of all
shared uint small_asked;                // how many they are << 24, and their rows
shared uint left[FL_TRIANGLES];         // blocks had no room for them
shared uint left_count;

#ifdef FL_DRAWS_EDGES
#include "render/shaders/lib/edge_queue.glsl"
bool is_drawn_alone(DrawnTriangle w) { return false; }
void draw_alone(DrawnTriangle w) {}
#else
bool is_drawn_alone(DrawnTriangle w) {
  ivec2 size = w.high - w.low + 1;
  return size.x * size.y <= kAlonePx;
}
void draw_alone(DrawnTriangle w) {
  for (int y = w.low.y; y <= w.high.y; ++y) draw_row(w, y);
}

void draw_rows() {
  uint count = small_asked >> 24;
  uint total = small_asked & 0xffffffu;
  uint at = 0u;
  for (uint i = gl_LocalInvocationIndex; i < total; i += FL_THREADS) {
    while (at + 1u < count && small_first[at + 1u] <= i) ++at;
    draw_row(small[at], small[at].low.y + int(i - small_first[at]));
  }
}
#endif

// Triangles `base` and on of a level, one a thread. first_number: of the level's first triangle. slot: FL_NONE for
// objects. is_wide: false where all are small, and one thread may draw any of them.
void draw_triangles(BodyLevelRow level, uint slot, uint head, uint first_number, uint base, bool is_wide) {
  uint own = gl_LocalInvocationIndex;
  is_wide = is_wide || !kAlone;
  if (is_wide) {
    if (own == 0u) {
      small_asked = 0u;
      left_count = 0u;
    }
    barrier();
  }
  uint t = base + own;
  if (own < FL_TRIANGLES && t < level.index_count / 3u) {
    Triangle it = triangle_of(level, t);
    if (!is_drawn(it) || faces_away(level, t, it)) {
    } else if (!is_wide || is_small(it)) {
      DrawnTriangle w = small_of(it, first_number + t, head);
      if (!is_wide || is_drawn_alone(w)) {
        draw_alone(w);
      } else {
        uint asked = atomicAdd(small_asked, 1u << 24 | uint(it.high.y - it.low.y + 1));
        small[asked >> 24] = w;
        small_first[asked >> 24] = asked & 0xffffffu;
      }
    } else if (!leave_blocks(it, slot, t)) {
      left[atomicAdd(left_count, 1u)] = t;
    }
  }
  if (!is_wide) return;
  barrier();
  draw_rows();
  for (uint i = 0u; i < left_count; ++i) {
    // Block by block, as drawblocks.comp does: then its depths are the same.
    Triangle it = triangle_of(level, left[i]);
    ivec2 last = it.high / FL_BLOCK_PX;
    for (ivec2 block = it.low / FL_BLOCK_PX; block.y <= last.y; ++block.y) {
      for (block.x = it.low.x / FL_BLOCK_PX; block.x <= last.x; ++block.x) {
        draw_block(it, first_number + left[i], block, head);
      }
    }
  }
}
