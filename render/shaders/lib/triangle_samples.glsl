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
  bool small;  // its sides fit into 32 bits
  float nearest_z;
  ivec2 low;
  ivec2 high;
  uint mark;  // of its surface
};

DrawnTriangle drawn_of(Triangle it, uint head) {
  DrawnTriangle d;
  // Of an open one from the corner of its block, so that it has the same numbers whichever rows are drawn.
  d.sides = sides_of(it, it.open ? it.low / FL_BLOCK_PX * FL_BLOCK_PX : it.low);
  d.p0 = it.p0;
  d.p1 = it.p1;
  d.p2 = it.p2;
  d.open = it.open;
  d.small = is_drawn_alone(it);
  d.nearest_z = it.open ? 1.0 : max(it.z.x, max(it.z.y, it.z.z));
  d.low = it.low;
  d.high = it.high;
  d.mark = mark_of((it.part & FL_OBJECT) != 0u ? object_identity(it.part) : 1u + (head << 3 | it.part & 7u));
  return d;
}

vec3 small_sides_at(DrawnTriangle d, ivec2 pixel) {
  ivec2 p = (pixel << 8) + 128;
  return d.sides.turn * vec3(float(side(d.p1, d.p2 - d.p1, p)), float(side(d.p2, d.p0 - d.p2, p)),
                             float(side(d.p0, d.p1 - d.p0, p)));
}

void draw_samples(DrawnTriangle d, ivec2 at, uint words, uint word) {
  vec2 way = vec2(at - d.sides.origin);
  precise vec3 sides = d.sides.at_origin + way.x * d.sides.by_x + way.y * d.sides.by_y;
  vec3 most = sides + 0.51 * (abs(d.sides.by_x) + abs(d.sides.by_y));
  if (!(min(most.x, min(most.y, most.z)) >= 0.0)) return;
  // It is behind all that the pixel and its neighbours show.
  if (d.nearest_z < edge_ids[uint(at.y) * params.width + uint(at.x)].farthest_z) return;
  if (d.small) sides = small_sides_at(d, at);
  else if (!d.open) sides = sides_at(d.p0, d.p1, d.p2, d.sides.turn, at);
  uint first = edge_slot(words, word, uint(at.x) % FL_TILE_PX) * kSamples;
  for (uint n = 0u; n < kSamples; ++n) {
    vec2 place = sample_offset(n);
    precise vec3 inside = sides + place.x * d.sides.by_x + place.y * d.sides.by_y;
    if (!(min(inside.x, min(inside.y, inside.z)) >= 0.0)) continue;
    float z = exact_dot(inside, d.sides.depth);
    if (z > 0.0 && z < 1.0) atomicMax(edge_samples[first + n], sample_word(z, d.mark));
  }
}

// Parts `begin`, `begin` + `stride` and so on (triangles.glsl).
void draw_parts(DrawnTriangle d, int begin, int stride) {
  TriangleParts parts = parts_of(d.low, d.high);
  for (int i = begin; i < parts.count; i += stride) {
    ivec2 first = part_first(parts, i);
    uint words = words_of_tile(uvec2(first) / uint(FL_TILE_PX));
    uint word = edge_masks[words + uint(first.y) % uint(FL_TILE_PX)];
    if ((word & 0xffffu) == 0u) continue;
    ivec2 ends = part_columns(parts, d.sides, first);
    if (ends.x > ends.y) continue;
    uint bits = word & ((1u << (ends.y + 1)) - (1u << ends.x));
    for (; bits != 0u; bits &= bits - 1u) draw_samples(d, first + ivec2(findLSB(bits), 0), words, word);
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
  draw_parts(drawn_of(in_block(it, block), head), int(gl_LocalInvocationIndex), FL_GROUP_TRIANGLES);
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
        draw_parts(drawn_of(it, head), 0, 1);
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
      draw_parts(wide, int(own), FL_GROUP_TRIANGLES);
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
