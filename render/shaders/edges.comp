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
#include "render/shaders/lib/pixel_samples.glsl"

#define FL_ROWS 4
#define FL_THREADS (FL_TILE_PX * FL_TILE_PX / FL_ROWS)
layout(local_size_x = FL_THREADS) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;
layout(set = 0, binding = FL_BINDING_EDGES, rgba32f) uniform writeonly image2D edges;
layout(set = 0, binding = FL_BINDING_EDGE_MASKS, std430) writeonly buffer EdgeMasksBuffer { uint edge_masks[]; };
layout(set = 0, binding = FL_BINDING_BODY_CHOICES, std430) readonly buffer ChoicesBuffer { uint choices[]; };
layout(set = 0, binding = FL_BINDING_HEAD_SLOTS, std430) readonly buffer HeadSlotsBuffer { uint head_slots[]; };

// What the pixels of the tile show, with one more on each side.
#define FL_SIDE (FL_TILE_PX + 2)
shared uint shown_id[FL_SIDE * FL_SIDE];
shared uint shown_normal[FL_SIDE * FL_SIDE];
shared float shown_m[FL_SIDE * FL_SIDE];  // along the unit ray
shared uint mask[FL_EDGE_WORDS];
shared uint list[FL_TILE_PX * FL_TILE_PX];
shared uint list_count;

uint at_side(ivec2 p) { return uint((p.y + 1) * FL_SIDE + p.x + 1); }

void load_shown(ivec2 low) {
  ivec2 size = ivec2(int(params.width), int(params.height));
  for (uint i = gl_LocalInvocationIndex; i < FL_SIDE * FL_SIDE; i += FL_THREADS) {
    // Beyond the picture is what its last pixel shows.
    ivec2 pixel = clamp(low + ivec2(int(i % FL_SIDE), int(i / FL_SIDE)) - 1, ivec2(0), size - 1);
    Surface surface = surface_at(pixel, normalize(ray_through(vec2(pixel) + 0.5)));
    shown_id[i] = surface.kind == kNothing  ? 0u
                  : surface.kind == kBox    ? box_face_id(surface.which, surface.normal)
                  : surface.kind == kObject ? surface.which | FL_OBJECT
                                            : surface.which + 1u;
    shown_normal[i] = pack_normal(surface.normal);
    shown_m[i] = surface.t_m;
  }
}

const float kCrease = 0.97;   // cosine between the normals of neighbours
const float kStep = 5e-4;     // of the depth: by so much the depths of three pixels in a row are off a line
const ivec2 kWays[4] = ivec2[4](ivec2(1, 0), ivec2(0, 1), ivec2(1, 1), ivec2(1, -1));

float inverse_depth(ivec2 p, ivec2 low) {
  return length(ray_through(vec2(low + p) + 0.5)) / shown_m[at_side(p)];
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
      edge = (inside && abs(off) > kStep * inverse) || dot(normal, unpack_normal(shown_normal[before])) < kCrease ||
             dot(normal, unpack_normal(shown_normal[after])) < kCrease;
    }
  }
  return edge;
}

// The bodies that the pixel and its neighbours show.
void sample_bodies(ivec2 p) {
  uint seen[9];
  for (int i = 0; i < 9; ++i) {
    uint id = shown_id[at_side(p + ivec2(i % 3, i / 3) - 1)];
    bool is_body = id != 0u && (id & (FL_OBJECT | FL_BOX_ID)) == 0u;
    seen[i] = is_body ? (id - 1u) >> 3 : FL_NONE;
    for (int k = 0; k < i; ++k) is_body = is_body && seen[k] != seen[i];
    for (int once = 0; once < (is_body ? 1 : 0); ++once) {
      uint slot = head_slots[seen[i]];
      sample_body(seen[i], slot, choices[slot]);
    }
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

// The neighbour that shows best what a sample shows; the pixel itself where none does.
const float kMisses = 4.0;
int best_neighbour(uint i) {
  uint id = sample_id[i];
  vec2 place = sample_place(i);
  bool is_flat = id == 0u || (id & (FL_BOX_ID | FL_OBJECT)) == FL_BOX_ID;  // one plane, or nothing
  vec3 here = sample_ray(i) * min(sample_depth_m[i], 1e15);
  float per_pixel = is_flat ? 0.0 : 1.0 / (length(ray_down) * sample_depth_m[i]);
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

vec3 color_of(ivec2 pixel, ivec2 p) {
  begin_samples(uvec2(pixel));
  if (kBoxes) sample_boxes();
  if (kBodies) {
    sample_objects();
    sample_bodies(p);
  }
  find_planes(pixel, p);
  uint counts[9] = uint[9](0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u);
  [[unroll]] for (uint i = 0u; i < kSamples; ++i) ++counts[best_neighbour(i)];
  // A pixel without an edge keeps its colour to the bit.
  vec3 sum = vec3(0.0);
  for (int n = 0; n < 9; ++n) {
    if (counts[n] == 0u) continue;
    sum += imageLoad(radiance, pixel + ivec2(n % 3, n / 3) - 1).rgb * (float(counts[n]) / float(kSamples));
  }
  return sum;
}

void main() {
  ivec2 low = ivec2(gl_WorkGroupID.xy) * FL_TILE_PX;
  ivec2 size = ivec2(int(params.width), int(params.height));
  if (gl_LocalInvocationIndex == 0u) list_count = 0u;
  if (gl_LocalInvocationIndex < FL_EDGE_WORDS) mask[gl_LocalInvocationIndex] = 0u;
  load_shown(low);
  barrier();
  for (uint i = gl_LocalInvocationIndex; i < FL_TILE_PX * FL_TILE_PX; i += FL_THREADS) {
    ivec2 p = ivec2(int(i % FL_TILE_PX), int(i / FL_TILE_PX));
    bool edge = all(lessThan(low + p, size)) && may_have_edge(p, low);
    if (edge) {
      // In any order: no pixel depends on another one.
      list[atomicAdd(list_count, 1u)] = i;
      atomicOr(mask[i / 32u], 1u << (i % 32u));
    }
  }
  barrier();
  uint count = list_count;
  for (uint k = gl_LocalInvocationIndex; k < count; k += FL_THREADS) {
    ivec2 p = ivec2(int(list[k] % FL_TILE_PX), int(list[k] / FL_TILE_PX));
    imageStore(edges, low + p, vec4(color_of(low + p, p), 1.0));
  }
  if (gl_LocalInvocationIndex < FL_EDGE_WORDS) {
    uint tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    edge_masks[tile * FL_EDGE_WORDS + gl_LocalInvocationIndex] = mask[gl_LocalInvocationIndex];
  }
}
