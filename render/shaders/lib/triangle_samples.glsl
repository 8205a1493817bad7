// Draws a triangle into the samples of pixels with an edge (edges.comp): the nearest depth at each, and with it which
// of the pixel and its neighbours shows that surface best. After triangles.glsl and surface.glsl.
#include "render/shaders/lib/edge_samples.glsl"
layout(set = 0, binding = FL_BINDING_EDGE_MASKS, std430) readonly buffer EdgeMasksBuffer { uint edge_masks[]; };
layout(set = 0, binding = FL_BINDING_EDGE_IDS, std430) readonly buffer EdgeIdsBuffer { uint edge_ids[]; };
layout(set = 0, binding = FL_BINDING_EDGE_SAMPLES, std430) buffer EdgeSamplesBuffer { uint edge_samples[]; };

bool has_edge(ivec2 at) {
  uint tiles_x = (params.width + uint(FL_TILE_PX - 1)) / uint(FL_TILE_PX);
  uvec2 tile = uvec2(at) / uint(FL_TILE_PX);
  uvec2 in_tile = uvec2(at) % uint(FL_TILE_PX);
  uint bit = in_tile.y * uint(FL_TILE_PX) + in_tile.x;
  return (edge_masks[(tile.y * tiles_x + tile.x) * FL_EDGE_WORDS + bit / 32u] >> (bit % 32u) & 1u) != 0u;
}

// The pixels of the nine that show a surface: a bit each.
uint pixels_with(ivec2 at, uint id) {
  uint with = 0u;
  ivec2 size = ivec2(int(params.width), int(params.height));
  for (int n = 0; n < 9; ++n) {
    ivec2 there = at + ivec2(n % 3, n / 3) - 1;
    bool inside = all(greaterThanEqual(there, ivec2(0))) && all(lessThan(there, size));
    if (inside && edge_ids[uint(there.y) * params.width + uint(there.x)] == id) with |= 1u << n;
  }
  return with;
}

// Which of the pixels `with` shows best what a sample shows at `place`, in pixels from the middle of `at`: one near to
// it, the plane of which goes through it, and is turned as the triangle is. Where none does, the pixel itself.
uint best_pixel(ivec2 at, uint with, vec2 place, float depth_m, vec3 normal) {
  vec3 ray = ray_through(vec2(at) + 0.5 + place);
  vec3 here = ray * depth_m;
  float per_pixel = 1.0 / (2.0 / float(params.height) * length(params.up.xyz) * depth_m);
  float least = kNoNeighbour;
  uint best = 4u;
  for (; with != 0u; with &= with - 1u) {
    int n = findLSB(with);
    ivec2 to = ivec2(n % 3, n / 3) - 1;
    Surface there = triangle_at(at + to);
    vec3 at_there = ray_through(vec2(at + to) + 0.5) * (params.right.w / triangle_depth(at + to));
    float off = abs(dot(there.normal, here - at_there)) * per_pixel;
    float own = neighbour_misses(vec2(to) - place, off, 2.0 * (1.0 - dot(there.normal, normal)));
    best = own < least ? uint(n) : best;
    least = min(least, own);
  }
  return best;
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

// The pixels `begin`, `begin` + `stride` and so on of those that it may cover.
void draw_samples(Triangle it, uint id, int begin, int stride) {
  Sides s = sides_of(it, it.low);
  vec3 reach = 0.5 * (abs(s.by_x) + abs(s.by_y));
  vec3 normal = face_normal(it);
  int across = it.high.x - it.low.x + 1;
  int count = across * (it.high.y - it.low.y + 1);
  for (int i = begin; i < count; i += stride) {
    ivec2 from = ivec2(i % across, i / across);
    ivec2 at = it.low + from;
    if (!has_edge(at)) continue;
    vec3 e = s.at_origin + (float(from.x) * s.by_x + float(from.y) * s.by_y);
    vec3 most = e + reach;
    if (!(min(most.x, min(most.y, most.z)) >= 0.0)) continue;
    uint first = (uint(at.y - rows.first) * params.width + uint(at.x)) * kSamples;
    uint with = FL_NONE;
    for (uint n = 0u; n < kSamples; ++n) {
      vec2 place = sample_offset(n);
      vec3 inside = e + place.x * s.by_x + place.y * s.by_y;
      float z = dot(inside, s.depth);
      if (!(min(inside.x, min(inside.y, inside.z)) >= 0.0 && z > 0.0 && z < 1.0)) continue;
      uint nearest = sample_bits(z);
      if (nearest < (edge_samples[first + n] & ~15u)) continue;
      if (with == FL_NONE) with = pixels_with(at, id);
      atomicMax(edge_samples[first + n], nearest | best_pixel(at, with, place, params.right.w / z, normal));
    }
  }
}
