#version 460
// Smooth edges: finds the pixels that show more than one surface, or that have neighbours that do, samples what they
// show, and gives each sample the colour of the pixel next to it that shows the same surface. Colours are those of the
// whole picture, so the haze in front of each surface ends where that surface is.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#define FL_USE_POSE
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/bodies.glsl"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/tile_samples.glsl"
layout(local_size_x = FL_THREADS) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;
layout(set = 0, binding = FL_BINDING_EDGES, rgba32f) uniform writeonly image2D edges;
layout(set = 0, binding = FL_BINDING_EDGE_MASKS, std430) writeonly buffer EdgeMasksBuffer { uint edge_masks[]; };

// What the pixels of the tile show, with one more on each side.
#define FL_SIDE (FL_TILE_PX + 2)
shared uint shown_id[FL_SIDE * FL_SIDE];
shared uint shown_normal[FL_SIDE * FL_SIDE];
shared float shown_m[FL_SIDE * FL_SIDE];  // along the unit ray
shared uint mask[FL_EDGE_WORDS];          // the pixels that may have an edge
// The heads whose bodies the tile shows: some of them several times, then each once, in any order.
shared uint found[FL_SIDE * FL_SIDE];
shared uint found_count;
shared uint bodies[FL_SIDE * FL_SIDE];
shared uint body_count;
// Of each pixel of the group: how many samples take the colour of each of nine pixels, six bits each.
shared uint counts[FL_THREADS * 2];

uint at_side(ivec2 p) { return uint((p.y + 1) * FL_SIDE + p.x + 1); }

void load_shown(ivec2 low) {
  ivec2 size = ivec2(int(params.width), int(params.height));
  for (uint i = gl_LocalInvocationIndex; i < FL_SIDE * FL_SIDE; i += FL_THREADS) {
    // Beyond the picture is what its last pixel shows.
    ivec2 pixel = clamp(low + ivec2(int(i % FL_SIDE), int(i / FL_SIDE)) - 1, ivec2(0), size - 1);
    Surface surface = surface_at(pixel, normalize(ray_through(vec2(pixel) + 0.5)));
    shown_id[i] = surface.kind == kNothing  ? 0u
                  : surface.kind == kBox    ? box_face_id(surface.which, surface.normal)
                  : surface.kind == kObject ? object_identity(surface.which | FL_OBJECT)
                                            : surface.which + 1u;
    shown_normal[i] = pack_normal(surface.normal);
    shown_m[i] = surface.t_m;
  }
}

const float kStep = 5e-4;  // of the depth: depths of three pixels in a row that are off a line by less are on a plane
const float kStepPx = 0.25;         // what the place of a neighbour may be off a smooth surface
const float kCrease = 0.03;         // 1 - cosine between the normals of neighbours, 14 degrees: less is no crease
const float kCreaseRatio = 4.0;     // a crease turns by twice as much as the surface on its other side ...
const float kSharpCrease = 0.3;     // ... or by 45 degrees
const ivec2 kWays[4] = ivec2[4](ivec2(1, 0), ivec2(0, 1), ivec2(1, 1), ivec2(1, -1));

float inverse_depth(ivec2 p, ivec2 low) {
  return length(ray_through(vec2(low + p) + 0.5)) / shown_m[at_side(p)];
}
vec3 shown_place(ivec2 p, ivec2 low) {
  return normalize(ray_through(vec2(low + p) + 0.5)) * min(shown_m[at_side(p)], 1e15);
}

// Whether the surface between a pixel and its neighbour has a step. A smooth one goes on at the mean of both normals.
bool has_step(ivec2 p, ivec2 to, ivec2 low) {
  vec3 normals = unpack_normal(shown_normal[at_side(p)]) + unpack_normal(shown_normal[at_side(to)]);
  vec3 apart = shown_place(to, low) - shown_place(p, low);
  float pixel_m = 2.0 / float(params.width) * length(params.right.xyz) * min(shown_m[at_side(p)], 1e15);
  return abs(dot(normals, apart)) > 2.0 * kStepPx * pixel_m;
}

bool may_have_edge(ivec2 p, ivec2 low) {
  uint own = at_side(p);
  uint id = shown_id[own];
  bool is_box = id == 0u || (id & (FL_BOX_ID | FL_OBJECT)) == FL_BOX_ID;  // a plane, or nothing
  vec3 normal = unpack_normal(shown_normal[own]);
  float inverse = is_box ? 0.0 : inverse_depth(p, low);
  bool edge = false;
  ivec2 size = ivec2(int(params.width), int(params.height));
  for (int w = 0; w < 4; ++w) {
    uint before = at_side(p - kWays[w]);
    uint after = at_side(p + kWays[w]);
    edge = edge || shown_id[before] != id || shown_id[after] != id;
    for (int k = 0; k < (is_box || edge ? 0 : 1); ++k) {
      ivec2 from = low + p - kWays[w];
      ivec2 to = low + p + kWays[w];
      bool inside = all(greaterThanEqual(min(from, to), ivec2(0))) && all(lessThan(max(from, to), size));
      float off = inverse_depth(p - kWays[w], low) + inverse_depth(p + kWays[w], low) - 2.0 * inverse;
      if (inside && abs(off) > kStep * inverse) {
        edge = has_step(p, p - kWays[w], low) || has_step(p, p + kWays[w], low);
      }
      float turn_before = 1.0 - dot(normal, unpack_normal(shown_normal[before]));
      float turn_after = 1.0 - dot(normal, unpack_normal(shown_normal[after]));
      float most = max(turn_before, turn_after);
      float least = min(turn_before, turn_after);
      edge = edge || (most > kCrease && (most > kCreaseRatio * least || most > kSharpCrease));
    }
  }
  return edge;
}

bool is_body(uint id) { return id != 0u && (id & (FL_OBJECT | FL_BOX_ID)) == 0u; }

void find_bodies() {
  for (uint i = gl_LocalInvocationIndex; i < FL_SIDE * FL_SIDE; i += FL_THREADS) {
    uint id = shown_id[i];
    // The first pixel of each body, in the order of rows, has none of it on its left or above it.
    bool left = i % FL_SIDE > 0u && is_body(shown_id[i - 1u]) && (shown_id[i - 1u] - 1u) >> 3 == (id - 1u) >> 3;
    bool above = i >= FL_SIDE && is_body(shown_id[i - FL_SIDE]) && (shown_id[i - FL_SIDE] - 1u) >> 3 == (id - 1u) >> 3;
    if (is_body(id) && !left && !above) found[atomicAdd(found_count, 1u)] = (id - 1u) >> 3;
  }
  barrier();
  uint count = found_count;
  for (uint i = gl_LocalInvocationIndex; i < count; i += FL_THREADS) {
    bool first = true;
    for (uint j = 0u; j < i; ++j) first = first && found[j] != found[i];
    if (first) bodies[atomicAdd(body_count, 1u)] = found[i];
  }
  barrier();
}

// Draws what the pixels of the group, of this number, and their neighbours show. k: as for walk.
void sample_bodies(uint pixels, uint k) {
  uint count = body_count;
  for (uint first = 0u; first == 0u || first < count; first += FL_ROUND_BODIES) {
    uint own = min(count - min(first, count), FL_ROUND_BODIES);
    if (gl_LocalInvocationIndex < pixels) {
      uint pixel = group_pixels[gl_LocalInvocationIndex];
      uint middle = at_side(ivec2(int(pixel % uint(FL_TILE_PX)), int(pixel / uint(FL_TILE_PX))));
      uint bits = 1u << (FL_OBJECTS_SPACE / 4);
      for (uint n = 0u; n < 9u; ++n) {
        uint id = shown_id[middle + (n / 3u) * FL_SIDE + n % 3u - uint(FL_SIDE + 1)];
        for (uint b = 0u; b < own; ++b) bits |= is_body(id) && (id - 1u) >> 3 == bodies[first + b] ? 1u << b : 0u;
      }
      shows[gl_LocalInvocationIndex] = bits;
    }
    if (gl_LocalInvocationIndex < own * 4u) {
      add_body(gl_LocalInvocationIndex, bodies[first + gl_LocalInvocationIndex / 4u], gl_LocalInvocationIndex % 4u);
    }
    if (gl_LocalInvocationIndex == FL_OBJECTS_SPACE && first == 0u) add_objects();
    walk(k);
  }
}

// What the pixel and its neighbours show: identity, and the plane through the place, from the camera.
uint near_id[9];
vec4 near_plane[9];  // xyz: normal; w: normal . place, m

void find_planes(ivec2 pixel, ivec2 p) {
  ivec2 size = ivec2(int(params.width), int(params.height));
  for (int n = 0; n < 9; ++n) {
    ivec2 there = pixel + ivec2(n % 3, n / 3) - 1;
    uint at = at_side(p + ivec2(n % 3, n / 3) - 1);
    bool inside = all(greaterThanEqual(there, ivec2(0))) && all(lessThan(there, size));
    near_id[n] = inside ? shown_id[at] : FL_NONE;
    vec3 normal = unpack_normal(shown_normal[at]);
    near_plane[n] = vec4(normal, dot(normal, normalize(ray_through(vec2(there) + 0.5)) * min(shown_m[at], 1e15)));
  }
}

// The neighbour that shows best what sample i shows; the pixel itself where none does.
const float kMisses = 4.0;
int best_neighbour(uint i) {
  uint id = sample_id[i];
  float depth_m = uintBitsToFloat(sample_depth[i]);
  vec2 place = sample_place[i] - (vec2(own_pixel) + 0.5 - kHalfTile);
  bool is_flat = id == 0u || (id & (FL_BOX_ID | FL_OBJECT)) == FL_BOX_ID;  // one plane, or nothing
  vec3 here = ray_at(sample_place[i]) * min(depth_m, 1e15);
  float per_pixel = is_flat ? 0.0 : 1.0 / (length(ray_down) * depth_m);
  vec3 normal = unpack_normal(sample_normal[i]);
  float least = kMisses;
  int best = 4;
  for (int n = 0; n < 9; ++n) {
    vec2 apart = vec2(ivec2(n % 3, n / 3) - 1) - place;
    float off = abs(dot(near_plane[n].xyz, here) - near_plane[n].w) * per_pixel;
    float turned = is_flat ? 0.0 : 2.0 * (1.0 - dot(near_plane[n].xyz, normal));
    float own = near_id[n] == id ? 0.05 * dot(apart, apart) + off + turned : kMisses;
    best = own < least ? n : best;
    least = min(least, own);
  }
  return best;
}

// Adds what the samples of this thread take to the counts of pixel k.
void count_samples(ivec2 low, uint k) {
  find_planes(low + own_pixel, own_pixel);
  uvec2 own = uvec2(0u);
  [[unroll]] for (uint i = 0u; i < FL_OWN; ++i) {
    int best = best_neighbour(i);
    own += best < 5 ? uvec2(1u << (6 * best), 0u) : uvec2(0u, 1u << (6 * (best - 5)));
  }
  atomicAdd(counts[2u * k], own.x);
  atomicAdd(counts[2u * k + 1u], own.y);
}

// A pixel without an edge keeps its colour to the bit.
vec3 color_of(ivec2 pixel, uint k) {
  vec3 sum = vec3(0.0);
  for (int n = 0; n < 9; ++n) {
    uint count = (n < 5 ? counts[2u * k] >> (6 * n) : counts[2u * k + 1u] >> (6 * (n - 5))) & 63u;
    if (count == 0u) continue;
    sum += imageLoad(radiance, pixel + ivec2(n % 3, n / 3) - 1).rgb * (float(count) / float(kSamples));
  }
  return sum;
}

// Takes the next pixels of the mask that there are threads for, from number `first` on.
void begin_group(uint first) {
  if (gl_LocalInvocationIndex < 4u) group_margins[gl_LocalInvocationIndex] = uint(FL_TILE_PX);
  barrier();
  for (uint i = gl_LocalInvocationIndex; i < FL_TILE_PX * FL_TILE_PX; i += FL_THREADS) {
    uint number = 0u;  // of pixels with an edge before this one
    for (uint w = 0u; w < i / 32u; ++w) number += uint(bitCount(mask[w]));
    number += uint(bitCount(mask[i / 32u] & ((1u << (i % 32u)) - 1u)));
    bool own = (mask[i / 32u] >> (i % 32u) & 1u) != 0u && number >= first && number < first + kGroup;
    group_numbers[i] = own ? number - first : FL_NONE;
    if (own) {
      group_pixels[number - first] = i;
      uint x = i % uint(FL_TILE_PX);
      uint y = i / uint(FL_TILE_PX);
      atomicMin(group_margins[0], x);
      atomicMin(group_margins[1], y);
      atomicMin(group_margins[2], uint(FL_TILE_PX - 1) - x);
      atomicMin(group_margins[3], uint(FL_TILE_PX - 1) - y);
    }
  }
  for (uint i = gl_LocalInvocationIndex; i < 2u * kGroup; i += FL_THREADS) counts[i] = 0u;
  barrier();
}

void main() {
  ivec2 low = ivec2(gl_WorkGroupID.xy) * FL_TILE_PX;
  ivec2 size = ivec2(int(params.width), int(params.height));
  if (gl_LocalInvocationIndex < FL_EDGE_WORDS) mask[gl_LocalInvocationIndex] = 0u;
  if (gl_LocalInvocationIndex == 0u) {
    found_count = 0u;
    body_count = 0u;
    stack_size = 0u;
    leaf_count = 0u;
  }
  load_shown(low);
  barrier();
  for (uint i = gl_LocalInvocationIndex; i < FL_TILE_PX * FL_TILE_PX; i += FL_THREADS) {
    ivec2 p = ivec2(int(i % FL_TILE_PX), int(i / FL_TILE_PX));
    if (all(lessThan(low + p, size)) && may_have_edge(p, low)) atomicOr(mask[i / 32u], 1u << (i % 32u));
  }
  barrier();
  uint count = 0u;
  for (uint word = 0u; word < FL_EDGE_WORDS; ++word) count += uint(bitCount(mask[word]));
  if (gl_LocalInvocationIndex < FL_EDGE_WORDS) {
    uint tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    edge_masks[tile * FL_EDGE_WORDS + gl_LocalInvocationIndex] = mask[gl_LocalInvocationIndex];
  }
  if (count == 0u) return;
  begin_tile(uvec2(low));
  if (kBodies) find_bodies();
  for (uint first = 0u; first < count; first += kGroup) {
    uint pixels = min(count - first, kGroup);
    begin_group(first);
    uint k = gl_LocalInvocationIndex / kThreadsPerPixel;
    if (k >= pixels) k = FL_NONE;
    begin_samples(k == FL_NONE ? 0u : k, gl_LocalInvocationIndex % kThreadsPerPixel);
    if (kBoxes) sample_boxes();
    if (kBodies) sample_bodies(pixels, k);
    if (k != FL_NONE) count_samples(low, k);
    barrier();
    if (gl_LocalInvocationIndex < pixels) {
      ivec2 pixel = low + ivec2(int(group_pixels[gl_LocalInvocationIndex] % FL_TILE_PX),
                                int(group_pixels[gl_LocalInvocationIndex] / FL_TILE_PX));
      imageStore(edges, pixel, vec4(color_of(pixel, gl_LocalInvocationIndex), 1.0));
    }
    barrier();
  }
}
