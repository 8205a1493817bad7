// Draws a triangle into the samples of pixels with an edge (edges.comp): the nearest depth at each, and with it which
// of the pixel and its neighbours shows that surface best. After triangles.glsl and surface.glsl.
#include "render/shaders/lib/edge_samples.glsl"
layout(set = 0, binding = FL_BINDING_EDGE_MASKS, std430) readonly buffer EdgeMasksBuffer { uint edge_masks[]; };
layout(set = 0, binding = FL_BINDING_EDGE_IDS, std430) readonly buffer EdgeIdsBuffer { EdgeIdRow edge_ids[]; };
layout(set = 0, binding = FL_BINDING_EDGE_SAMPLES, std430) buffer EdgeSamplesBuffer { uint edge_samples[]; };

// Which of 16 pixels in a row, from the first column of a tile on, have an edge: a bit each.
uint edges_of_row(ivec2 first) {
  uint tiles_x = (params.width + uint(FL_TILE_PX - 1)) / uint(FL_TILE_PX);
  uvec2 tile = uvec2(first) / uint(FL_TILE_PX);
  uint bit = uint(first.y) % uint(FL_TILE_PX) * uint(FL_TILE_PX);
  return edge_masks[(tile.y * tiles_x + tile.x) * FL_EDGE_WORDS + bit / 32u] >> (bit % 32u) & 0xffffu;
}

// Towards the camera.
vec3 face_normal(Triangle it) {
  vec3 right = params.right.xyz * (2.0 / float(params.width));
  vec3 down = params.up.xyz * (-2.0 / float(params.height));
  vec3 to_1 = it.h1 - it.h0;
  vec3 to_2 = it.h2 - it.h0;
  vec3 face = cross(right * to_1.x + down * to_1.y + params.forward.xyz * to_1.z,
                    right * to_2.x + down * to_2.y + params.forward.xyz * to_2.z);
  if (dot(face, right * it.h0.x + down * it.h0.y + params.forward.xyz * it.h0.z) > 0.0) face = -face;
  return face * inversesqrt(max(dot(face, face), 1e-30));
}

// The triangles of the workgroup, one a thread.
struct DrawnTriangle {
  Sides sides;
  ivec2 p0;
  ivec2 p1;
  ivec2 p2;
  bool open;
  float nearest_z;
  ivec2 low;
  ivec2 high;
  uint id;  // of its surface
  uint normal;
};
shared DrawnTriangle drawn[FL_GROUP_TRIANGLES];

void begin_drawn(uint number, Triangle it, uint head) {
  DrawnTriangle d;
  // Of an open one from the corner of its block, so that it has the same numbers whichever rows are drawn.
  d.sides = sides_of(it, it.open ? it.low / FL_BLOCK_PX * FL_BLOCK_PX : it.low);
  d.p0 = it.p0;
  d.p1 = it.p1;
  d.p2 = it.p2;
  d.open = it.open;
  d.nearest_z = it.open ? 1.0 : max(it.z.x, max(it.z.y, it.z.z));
  d.low = it.low;
  d.high = it.high;
  d.id = (it.part & FL_OBJECT) != 0u ? object_identity(it.part) : 1u + (head << 3 | it.part & 7u);
  d.normal = pack_normal(face_normal(it));
  drawn[number] = d;
}

// Pairs of a triangle and a pixel with an edge of which it covers samples: they are gathered and then drawn with all
// threads busy, since few of the pixels that a triangle covers have edges.
#define FL_PAIRS FL_GROUP_TRIANGLES
shared uvec2 pairs[FL_PAIRS];  // samples << 16 | number of the triangle; y << 16 | x
shared vec3 pair_sides[FL_PAIRS];   // as Sides, at the pixel's middle
shared uint pair_count;        // of those that have been found: more than FL_PAIRS have no room

// A pixel of the nine round a pair's, as the plane that it shows. How far the plane is off a sample, in pixels, is
// |a + (bx, by) . place - c depth|; place: from the pixel's middle, in pixels.
struct NearPlane {
  float a;
  float bx;
  float by;
  float c;
  float turned;
};
shared NearPlane near_planes[9 * FL_PAIRS];
shared uint near_pixels[FL_PAIRS];  // those that show the triangle's surface: a bit each

void find_planes(uint pair) {
  uint number = pairs[pair].x & 0xffffu;
  ivec2 pixel = ivec2(int(pairs[pair].y & 0xffffu), int(pairs[pair].y >> 16));
  ivec2 last = ivec2(int(params.width), int(params.height)) - 1;
  vec3 face = unpack_normal(drawn[number].normal);
  float per_pixel = 0.5 * float(params.height) / length(params.up.xyz);
  vec3 ray = ray_through(vec2(pixel) + 0.5) * per_pixel;
  vec3 right = params.right.xyz * (per_pixel * 2.0 / float(params.width));
  vec3 down = params.up.xyz * (per_pixel * -2.0 / float(params.height));
  uint near = 0u;
  for (uint n = 0u; n < 9u; ++n) {
    ivec2 to = ivec2(int(n % 3u), int(n / 3u)) - 1;
    ivec2 there = clamp(pixel + to, ivec2(0), last);
    // All are read before it is known which are needed: waiting once is quicker.
    uint id = edge_ids[uint(there.y) * params.width + uint(there.x)].id;
    float depth = triangle_depth(there);
    vec3 normal = triangle_of(imageLoad(surface_id, there).xy).normal;
    if (there != pixel + to || id != drawn[number].id) continue;
    near |= 1u << n;
    // Through the neighbour's middle, at its depth; depths of the buffer are those of the near plane over true ones.
    near_planes[9u * pair + n] =
        NearPlane(exact_dot(normal, ray), exact_dot(normal, right), exact_dot(normal, down),
                  (exact_dot(normal, ray) + float(to.x) * exact_dot(normal, right) +
                   float(to.y) * exact_dot(normal, down)) / depth, 2.0 * (1.0 - exact_dot(normal, face)));
  }
  near_pixels[pair] = near;
}

// Draws four samples of a pair. Each takes the pixel that shows best what it shows: one near to it, the plane of which
// goes through it and is turned as the triangle is. Where none does, the pixel itself.
#define FL_OWN 4
void draw_samples(uint pair, uint first) {
  uint hits = pairs[pair].x >> (16u + first) & 15u;
  if (hits == 0u) return;
  Sides s = drawn[pairs[pair].x & 0xffffu].sides;
  ivec2 at = ivec2(int(pairs[pair].y & 0xffffu), int(pairs[pair].y >> 16));
  vec2 place[FL_OWN];
  float z[FL_OWN];
  float least[FL_OWN];
  uint best[FL_OWN];
  [[unroll]] for (uint i = 0u; i < FL_OWN; ++i) {
    place[i] = sample_offset(first + i);
    precise vec3 inside = pair_sides[pair] + place[i].x * s.by_x + place[i].y * s.by_y;
    z[i] = exact_dot(inside, s.depth);
    least[i] = kNoNeighbour;
    best[i] = 4u;
  }
  for (uint near = near_pixels[pair]; near != 0u; near &= near - 1u) {
    uint n = uint(findLSB(near));
    NearPlane plane = near_planes[9u * pair + n];
    vec2 to = vec2(float(n % 3u), float(n / 3u)) - 1.0;
    [[unroll]] for (uint i = 0u; i < FL_OWN; ++i) {
      precise float off = abs(plane.a + plane.bx * place[i].x + plane.by * place[i].y - plane.c * z[i]);
      float own = neighbour_misses(to - place[i], off, plane.turned);
      best[i] = own < least[i] ? n : best[i];
      least[i] = min(least[i], own);
    }
  }
  uint to = (uint(at.y - rows.first) * params.width + uint(at.x)) * kSamples + first;
  [[unroll]] for (uint i = 0u; i < FL_OWN; ++i) {
    bool hit = (hits >> i & 1u) != 0u && z[i] > 0.0 && z[i] < 1.0;
    if (hit) atomicMax(edge_samples[to + i], sample_bits(z[i]) | best[i]);
  }
}

// With all threads. The pairs are then gone.
void draw_pairs() {
  barrier();
  uint count = min(pair_count, uint(FL_PAIRS));
  if (gl_LocalInvocationIndex < count) find_planes(gl_LocalInvocationIndex);
  barrier();
  if (gl_LocalInvocationIndex == 0u) pair_count = 0u;
  const uint kParts = kSamples / FL_OWN;
  for (uint i = gl_LocalInvocationIndex; i < kParts * count; i += FL_GROUP_TRIANGLES) {
    draw_samples(i / kParts, i % kParts * FL_OWN);
  }
  barrier();
}

// The samples of a pixel that a triangle covers: a bit each. sides: its sides at the pixel's middle.
uint covered_samples(Sides s, vec3 sides) {
  uint covered = 0u;
  for (uint n = 0u; n < kSamples; ++n) {
    vec2 place = sample_offset(n);
    precise vec3 inside = sides + place.x * s.by_x + place.y * s.by_y;
    covered |= min(inside.x, min(inside.y, inside.z)) >= 0.0 ? 1u << n : 0u;
  }
  return covered;
}

// The columns of a row in which a triangle may cover a sample; the last is below the first where there are none.
ivec2 columns_of(Sides s, int y) {
  vec3 e = s.at_origin + float(y - s.origin.y) * s.by_y + 0.51 * (abs(s.by_x) + abs(s.by_y));
  vec2 ends = vec2(-1e6, 1e6);
  for (uint k = 0u; k < 3u; ++k) {
    float end = -e[k] / s.by_x[k];
    if (s.by_x[k] > 0.0) ends.x = max(ends.x, end);
    else if (s.by_x[k] < 0.0) ends.y = min(ends.y, end);
    else if (!(e[k] >= 0.0)) ends.y = -2e6;
  }
  ends = clamp(ends, vec2(-2e6), vec2(2e6));
  return s.origin.x + ivec2(int(floor(ends.x)) - 1, int(ceil(ends.y)) + 1);
}

// Pixels with an edge in part `i` of a triangle: a row of one of the tiles that it reaches into. Bits from `first` on.
uint edges_in_part(DrawnTriangle d, int tiles, int i, out ivec2 first) {
  int row = tiles == 1 ? i : i / tiles;
  first = ivec2((d.low.x / FL_TILE_PX + i - row * tiles) * FL_TILE_PX, d.low.y + row);
  ivec2 ends = ivec2(d.low.x, d.high.x);
  if (d.high.x - d.low.x >= FL_TILE_PX) {  // of a small one a test of each pixel is quicker
    ivec2 columns = columns_of(d.sides, first.y);
    ends = ivec2(max(ends.x, columns.x), min(ends.y, columns.y));
  }
  ends = clamp(ends - first.x, ivec2(0, -1), ivec2(FL_TILE_PX));
  if (ends.x > ends.y || ends.x == FL_TILE_PX) return 0u;
  uint within = (1u << min(ends.y + 1, FL_TILE_PX)) - (1u << ends.x);
  return edges_of_row(first) & within;
}

// The samples of a pixel that a triangle covers and that may show it.
uint samples_of(DrawnTriangle d, ivec2 at, out vec3 sides) {
  vec2 way = vec2(at - d.sides.origin);
  precise vec3 at_middle = d.sides.at_origin + way.x * d.sides.by_x + way.y * d.sides.by_y;
  sides = at_middle;
  vec3 most = sides + 0.51 * (abs(d.sides.by_x) + abs(d.sides.by_y));
  if (!(min(most.x, min(most.y, most.z)) >= 0.0)) return 0u;
  if (d.nearest_z < edge_ids[uint(at.y) * params.width + uint(at.x)].farthest_z) return 0u;
  if (!d.open) sides = sides_at(d.p0, d.p1, d.p2, d.sides.turn, at);
  return covered_samples(d.sides, sides);
}

// With all threads: parts `begin`, `begin` + `stride` and so on, of a thread's own triangle; none where `begin` is
// below 0. The last pairs are left undrawn.
void gather_pairs(uint number, int begin, int stride) {
  DrawnTriangle d = drawn[number];
  int tiles = d.high.x / FL_TILE_PX - d.low.x / FL_TILE_PX + 1;
  int count = begin < 0 ? 0 : tiles * (d.high.y - d.low.y + 1);
  int i = begin;
  uint bits = 0u;
  ivec2 first = ivec2(0);
  for (;;) {
    while (bits != 0u || i < count) {
      if (bits == 0u) {
        bits = edges_in_part(d, tiles, i, first);
        i += stride;
        continue;
      }
      ivec2 at = first + ivec2(findLSB(bits), 0);
      vec3 sides;
      uint covered = samples_of(d, at, sides);
      if (covered != 0u) {
        uint to = atomicAdd(pair_count, 1u);
        if (to >= FL_PAIRS) break;
        pairs[to] = uvec2(covered << 16 | number, uint(at.y) << 16 | uint(at.x));
        pair_sides[to] = sides;
      }
      bits &= bits - 1u;
    }
    barrier();
    uint found = pair_count;
    barrier();  // all have read it
    if (found > FL_PAIRS / 2u) draw_pairs();
    if (found <= FL_PAIRS) break;
  }
}

void begin_pairs() {
  if (gl_LocalInvocationIndex == 0u) pair_count = 0u;
  barrier();
}

// As triangle_pixels.glsl.
void draw_block(Triangle it, uint number, ivec2 block, uint head) {
  begin_pairs();
  if (gl_LocalInvocationIndex == 0u) begin_drawn(0u, in_block(it, block), head);
  barrier();
  gather_pairs(0u, int(gl_LocalInvocationIndex), FL_GROUP_TRIANGLES);
  draw_pairs();
}

shared uint wide[FL_GROUP_TRIANGLES];  // the triangles that all threads look at together
shared uint wide_count;
shared ivec4 wide_blocks;  // from which block to which; of one that is not drawn in blocks the last is below the first

void draw_triangles(BodyLevelRow level, uint slot, uint head, uint first_number, uint base, bool has_wide) {
  if (gl_LocalInvocationIndex == 0u) wide_count = 0u;
  begin_pairs();
  uint own = gl_LocalInvocationIndex;
  int begin = -1;
  bool by_blocks = false;
  Triangle it;
  if (base + own < level.index_count / 3u) {
    it = triangle_of(level, base + own);
    if (is_drawn(it)) {
      if (is_drawn_alone(it)) begin = 0;
      else if (!is_drawn_together(it)) by_blocks = !leave_blocks(it, slot, base + own);
      if (begin < 0 && (by_blocks || is_drawn_together(it))) wide[atomicAdd(wide_count, 1u)] = own;
      begin_drawn(own, it, head);
    }
  }
  barrier();
  gather_pairs(own, begin, 1);
  uint count = wide_count;
  for (uint i = 0u; i < count; ++i) {
    if (own == wide[i]) {
      wide_blocks = by_blocks ? ivec4(it.low / FL_BLOCK_PX, it.high / FL_BLOCK_PX) : ivec4(0, 0, -1, -1);
    }
    barrier();
    ivec4 ends = wide_blocks;
    if (ends.z < 0) {
      gather_pairs(wide[i], int(own), FL_GROUP_TRIANGLES);
      continue;
    }
    // Block by block, as drawblocks.comp does: then its depths are the same.
    draw_pairs();
    for (ivec2 block = ends.xy; block.y <= ends.w; ++block.y) {
      for (block.x = ends.x; block.x <= ends.z; ++block.x) {
        if (own == wide[i]) begin_drawn(own, in_block(it, block), head);
        barrier();
        gather_pairs(wide[i], int(own), FL_GROUP_TRIANGLES);
        draw_pairs();
      }
    }
  }
  draw_pairs();
}
