// Draws a triangle into the samples of pixels with an edge (edges.comp): the nearest surface at each. After
// triangles.glsl and surface.glsl.
#include "render/shaders/lib/edge_samples.glsl"
#include "render/shaders/lib/edge_slots.glsl"
layout(set = 0, binding = FL_BINDING_EDGE_IDS, std430) readonly buffer EdgeIdsBuffer { EdgeIdRow edge_ids[]; };
layout(set = 0, binding = FL_BINDING_EDGE_SAMPLES, std430) buffer EdgeSamplesBuffer { uint edge_samples[]; };

struct DrawnTriangle {
  Sides sides;
  ivec2 p0;
  ivec2 p1;
  ivec2 p2;
  bool open;
  float nearest_z;
  ivec2 low;
  ivec2 high;
  uint mark;  // of its surface
};

uint mark_of_triangle(Triangle it, uint head) {
  return mark_of((it.part & FL_OBJECT) != 0u ? object_identity(it.part) : 1u + (head << 3 | it.part & 7u));
}
float nearest_of(Triangle it) { return it.open ? 1.0 : max(it.z.x, max(it.z.y, it.z.z)); }

DrawnTriangle drawn_of(Triangle it, uint head) {
  DrawnTriangle d;
  // Of an open one from the corner of its block, so that it has the same numbers whichever rows are drawn.
  d.sides = sides_of(it, it.open ? it.low / FL_BLOCK_PX * FL_BLOCK_PX : it.low);
  d.p0 = it.p0;
  d.p1 = it.p1;
  d.p2 = it.p2;
  d.open = it.open;
  d.nearest_z = nearest_of(it);
  d.low = it.low;
  d.high = it.high;
  d.mark = mark_of_triangle(it, head);
  return d;
}

// Where it fits into 32 bits.
vec3 small_sides_at(Triangle it, float turn, ivec2 pixel) {
  ivec2 p = (pixel << 8) + 128;
  return turn * vec3(float(side(it.p1, it.p2 - it.p1, p)), float(side(it.p2, it.p0 - it.p2, p)),
                     float(side(it.p0, it.p1 - it.p0, p)));
}

// Whether a triangle is behind all that a pixel and its neighbours show.
bool is_behind(float nearest_z, ivec2 at) {
  return nearest_z < edge_ids[uint(at.y) * params.width + uint(at.x)].farthest_z;
}
// Whether it may cover a sample. sides: at the pixel's middle.
bool may_cover(Sides s, vec3 sides) {
  vec3 most = sides + 0.51 * (abs(s.by_x) + abs(s.by_y));
  return min(most.x, min(most.y, most.z)) >= 0.0;
}

// first: of the pixel's samples.
void draw_samples(Sides s, vec3 sides, uint first, uint mark) {
  for (uint n = 0u; n < kSamples; ++n) {
    vec2 place = sample_offset(n);
    precise vec3 inside = sides + place.x * s.by_x + place.y * s.by_y;
    if (!(min(inside.x, min(inside.y, inside.z)) >= 0.0)) continue;
    float z = exact_dot(inside, s.depth);
    if (z > 0.0 && z < 1.0) atomicMax(edge_samples[first + n], sample_word(z, mark));
  }
}

// Bits of the columns first to last of 16; first is no more than last.
uint columns_mask(int first, int last) { return (1u << (last + 1)) - (1u << first); }

// By its thread alone. Most small ones are behind what is seen, or have no edge near them.
void draw_alone(Triangle it, uint head) {
  float nearest_z = nearest_of(it);
  bool ready = false;
  Sides s;
  uint mark = 0u;
  for (int y = it.low.y; y <= it.high.y; ++y) {
    for (int x = it.low.x; x <= it.high.x; x = (x / FL_TILE_PX + 1) * FL_TILE_PX) {
      uint words = words_of_tile(uvec2(x, y) / uint(FL_TILE_PX));
      uint word = edge_masks[words + uint(y) % uint(FL_TILE_PX)];
      int tile = x / FL_TILE_PX * FL_TILE_PX;
      uint bits = word & columns_mask(x - tile, min(it.high.x - tile, FL_TILE_PX - 1));
      for (; bits != 0u; bits &= bits - 1u) {
        ivec2 at = ivec2(tile + findLSB(bits), y);
        if (is_behind(nearest_z, at)) continue;
        if (!ready) {
          s = sides_of(it, it.low);
          mark = mark_of_triangle(it, head);
          ready = true;
        }
        vec3 sides = small_sides_at(it, s.turn, at);
        if (may_cover(s, sides)) draw_samples(s, sides, edge_slot(words, word, uint(at.x - tile)) * kSamples, mark);
      }
    }
  }
}

// By all threads. At the middle of a pixel sides are exact, so that they do not depend on the part that is drawn.
void draw_together(DrawnTriangle d) {
  TriangleParts parts = parts_of(d.low, d.high);
  for (int i = int(gl_LocalInvocationIndex); i < parts.count; i += FL_GROUP_TRIANGLES) {
    ivec3 pixels = part_pixels(parts, d.sides, i);
    for (int x = pixels.x; x <= pixels.y; x = (x / FL_TILE_PX + 1) * FL_TILE_PX) {
      uint words = words_of_tile(uvec2(x, pixels.z) / uint(FL_TILE_PX));
      uint word = edge_masks[words + uint(pixels.z) % uint(FL_TILE_PX)];
      int tile = x / FL_TILE_PX * FL_TILE_PX;
      uint bits = word & columns_mask(x - tile, min(pixels.y - tile, FL_TILE_PX - 1));
      for (; bits != 0u; bits &= bits - 1u) {
        ivec2 at = ivec2(tile + findLSB(bits), pixels.z);
        vec2 way = vec2(at - d.sides.origin);
        precise vec3 sides = d.sides.at_origin + way.x * d.sides.by_x + way.y * d.sides.by_y;
        if (!may_cover(d.sides, sides) || is_behind(d.nearest_z, at)) continue;
        if (!d.open) sides = sides_at(d.p0, d.p1, d.p2, d.sides.turn, at);
        draw_samples(d.sides, sides, edge_slot(words, word, uint(at.x - tile)) * kSamples, d.mark);
      }
    }
  }
}

// Triangles that all threads draw together.
shared DrawnTriangle wide;
shared Triangle wide_triangle;
shared uint wide_threads[FL_GROUP_TRIANGLES];
shared uint wide_count;
shared bool wide_blocks;

// As triangle_pixels.glsl. With all threads.
void draw_block(Triangle it, uint number, ivec2 block, uint head) {
  draw_together(drawn_of(in_block(it, block), head));
}

void draw_triangles(BodyLevelRow level, uint slot, uint head, uint first_number, uint base, bool has_wide) {
  uint own = gl_LocalInvocationIndex;
  if (has_wide) {
    if (own == 0u) wide_count = 0u;
    barrier();
  }
  bool by_blocks = false;
  Triangle it;
  if (base + own < level.index_count / 3u) {
    it = triangle_of(level, base + own);
    if (is_drawn(it)) {
      if (!has_wide || is_drawn_alone(it)) {
        draw_alone(it, head);
      } else {
        by_blocks = !is_drawn_together(it) && !leave_blocks(it, slot, base + own);
        if (by_blocks || is_drawn_together(it)) wide_threads[atomicAdd(wide_count, 1u)] = own;
      }
    }
  }
  if (!has_wide) return;
  barrier();
  uint count = wide_count;
  for (uint i = 0u; i < count; ++i) {
    barrier();  // the one before has been drawn
    if (own == wide_threads[i]) {
      wide_triangle = it;
      wide_blocks = by_blocks;
      wide = drawn_of(it, head);
    }
    barrier();
    if (!wide_blocks) {
      draw_together(wide);
      continue;
    }
    // Block by block, as drawblocks.comp does: then its depths are the same.
    ivec2 last = wide_triangle.high / FL_BLOCK_PX;
    for (ivec2 block = wide_triangle.low / FL_BLOCK_PX; block.y <= last.y; ++block.y) {
      for (block.x = wide_triangle.low.x / FL_BLOCK_PX; block.x <= last.x; ++block.x) {
        draw_block(wide_triangle, 0u, block, head);
      }
    }
  }
}
