// Draws a triangle into the samples of pixels with an edge (edges.comp): the nearest surface at each. After
// triangles.glsl and surface.glsl.
#include "render/shaders/lib/edge_samples.glsl"
#include "render/shaders/lib/edge_slots.glsl"
layout(set = 0, binding = FL_BINDING_EDGE_IDS, std430) readonly buffer EdgeIdsBuffer { uint edge_ids[]; };
layout(set = 0, binding = FL_BINDING_EDGE_SAMPLES, std430) buffer EdgeSamplesBuffer { uint edge_samples[]; };

// One that a workgroup draws, a part a thread.
struct WideTriangle {
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

// number: of the triangle, among all of the rig. head: that it belongs to.
WideTriangle wide_of(Triangle it, uint number, uint head) {
  WideTriangle d;
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

// Whether a triangle is behind all that a pixel and its neighbours show.
bool is_behind(float nearest_z, ivec2 at) {
  return nearest_z < uintBitsToFloat(edge_ids[(params.height + uint(at.y)) * params.width + uint(at.x)]);
}
// Whether it may cover a sample. sides: at the pixel's middle.
bool may_cover(Sides s, vec3 sides) {
  vec3 most = sides + 0.51 * (abs(s.by_x) + abs(s.by_y));
  return min(most.x, min(most.y, most.z)) >= 0.0;
}

// Sample n of a pixel whose samples begin at `first`.
void draw_sample(Sides s, vec3 sides, uint first, uint n, uint mark) {
  vec2 place = sample_offset(n);
  precise vec3 inside = sides + place.x * s.by_x + place.y * s.by_y;
  if (!(min(inside.x, min(inside.y, inside.z)) >= 0.0)) return;
  float z = exact_dot(inside, s.depth);
  if (z > 0.0 && z < 1.0) atomicMax(edge_samples[first + n], sample_word(z, mark));
}
void draw_samples(Sides s, vec3 sides, uint first, uint mark) {
  for (uint n = 0u; n < kSamples; ++n) draw_sample(s, sides, first, n, mark);
}

// Bits of the columns first to last of 16; first is no more than last.
uint columns_mask(int first, int last) { return (1u << (last + 1)) - (1u << first); }

const bool kAlone = false;  // rows are shared out: edge_queue.glsl

// One whose sides fit into 32 bits.
struct DrawnTriangle {
  ivec2 p0;
  ivec2 p1;
  ivec2 p2;
  vec3 depth;  // as of Sides
  float turn;
  float nearest_z;
  ivec2 low;
  ivec2 high;
  uint mark;
};

DrawnTriangle small_of(Triangle it, uint number, uint head) {
  float area = float(side(it.p0, it.p1 - it.p0, it.p2));
  return DrawnTriangle(it.p0, it.p1, it.p2, it.z / abs(area), area < 0.0 ? -1.0 : 1.0, nearest_of(it), it.low, it.high,
                       mark_of_triangle(it, head));
}

// Of a small one at the middle of a pixel.
vec3 small_sides_at(DrawnTriangle w, ivec2 pixel) {
  ivec2 p = (pixel << 8) + 128;
  return w.turn * vec3(float(side(w.p1, w.p2 - w.p1, p)), float(side(w.p2, w.p0 - w.p2, p)),
                       float(side(w.p0, w.p1 - w.p0, p)));
}
Sides small_sides(DrawnTriangle w, ivec2 origin) {
  ivec2 d0 = w.p2 - w.p1;
  ivec2 d1 = w.p0 - w.p2;
  ivec2 d2 = w.p1 - w.p0;
  Sides s;
  s.origin = origin;
  s.turn = w.turn;
  s.at_origin = small_sides_at(w, origin);
  s.by_x = (-w.turn * kSubpixels) * vec3(float(d0.y), float(d1.y), float(d2.y));
  s.by_y = (w.turn * kSubpixels) * vec3(float(d0.x), float(d1.x), float(d2.x));
  s.depth = w.depth;
  return s;
}

bool small_may_cover(DrawnTriangle w, ivec2 pixel) {
  vec3 by_x = kSubpixels * abs(vec3(float(w.p2.y - w.p1.y), float(w.p0.y - w.p2.y), float(w.p1.y - w.p0.y)));
  vec3 by_y = kSubpixels * abs(vec3(float(w.p2.x - w.p1.x), float(w.p0.x - w.p2.x), float(w.p1.x - w.p0.x)));
  vec3 most = small_sides_at(w, pixel) + 0.51 * (by_x + by_y);
  return min(most.x, min(most.y, most.z)) >= 0.0;
}

// At the middle of a pixel sides are exact, so that they do not depend on the part that is drawn.
void draw_part(WideTriangle d, ivec3 pixels) {
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

// The part that is in a block of pixels, by all threads.
void draw_block(Triangle it, uint number, ivec2 block, uint head) {
  WideTriangle d = wide_of(in_block(it, block), number, head);
  TriangleParts parts = parts_of(d.low, d.high);
  for (int i = int(gl_LocalInvocationIndex); i < parts.count; i += FL_THREADS) {
    draw_part(d, part_pixels(parts, d.sides, i));
  }
}
