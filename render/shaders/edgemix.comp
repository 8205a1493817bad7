#version 460
// Mixes the colours of pixels with an edge (edges.comp) in a part of the picture (edgeparts.comp). Each sample has the
// colour of the pixel or of one of its neighbours: of one near to it that shows the same surface, and whose plane goes
// through what the sample shows. Where there is none, it has the pixel's.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/edge_surfaces.glsl"
#include "render/shaders/lib/edge_samples.glsl"
#include "render/shaders/lib/edge_slots.glsl"
layout(local_size_x = FL_GROUP_EDGES) in;
layout(set = 0, binding = FL_BINDING_RADIANCE, rgba32f) uniform readonly image2D radiance;
layout(set = 0, binding = FL_BINDING_EDGES, rgba32f) uniform writeonly image2D edges;
layout(set = 0, binding = FL_BINDING_EDGE_IDS, std430) readonly buffer EdgeIdsBuffer { uint edge_ids[]; };
layout(set = 0, binding = FL_BINDING_EDGE_PARTS, std430) readonly buffer EdgePartsBuffer { EdgePartRow edge_parts[]; };
layout(set = 0, binding = FL_BINDING_EDGE_SAMPLES, std430) readonly buffer EdgeSamplesBuffer { uint edge_samples[]; };
layout(push_constant) uniform PartPush { uint part; };

// The planes that the pixels of the tile show, with one more on each side: what is a b pixels off a pixel's middle, at
// the depth z, is |x + a y + b z - w depth| pixels off its plane.
#define FL_SIDE (FL_TILE_PX + 2)
shared vec4 planes[FL_SIDE * FL_SIDE];
shared uint marks[FL_SIDE * FL_SIDE];
#include "render/shaders/lib/edge_tile.glsl"
// Of pixels: how many samples have the colour of each of the nine, six bits each.
#define FL_OWN 4
shared uint counts[2 * FL_GROUP_EDGES];
const uint kNone = 0x100u;  // marks of surfaces have 8 bits

// Where a ray of the picture, whose part ahead is 1, meets a plane of a box: one over how far ahead that is, m.
float box_inverse(uint name, vec3 ray, out vec3 normal) {
  uint axis = name >> 1 & 3u;
  bool high = (name & 1u) != 0u;
  normal = vec3(0.0);
  normal[axis] = high ? 1.0 : -1.0;
  BoxRow box = boxes[(name & ~FL_BOX_ID) >> 3];
  float place = high ? box.high[axis] : box.low[axis];
  return ray[axis] / (place - params.position[axis]);
}

void load_plane(ivec2 low, uint i) {
  ivec2 pixel = low + ivec2(int(i % FL_SIDE), int(i / FL_SIDE)) - 1;
  ivec2 size = ivec2(int(params.width), int(params.height));
  marks[i] = kNone;
  planes[i] = vec4(0.0);
  if (any(lessThan(pixel, ivec2(0))) || any(greaterThanEqual(pixel, size))) return;
  uint name = edge_ids[uint(pixel.y) * params.width + uint(pixel.x)];
  marks[i] = mark_of(name);
  if (name == 0u) return;
  float per_pixel = 0.5 * float(params.height) / length(params.up.xyz);
  vec3 ray = ray_through(vec2(pixel) + 0.5);
  vec3 normal;
  float z;
  if (kBoxes && (name & (FL_BOX_ID | FL_OBJECT)) == FL_BOX_ID) {
    z = params.right.w * box_inverse(name, ray, normal);
  } else {
    normal = triangle_of(imageLoad(surface_id, pixel).xy).normal;
    z = triangle_depth(pixel);
  }
  vec3 right = params.right.xyz * (2.0 / float(params.width));
  vec3 down = params.up.xyz * (-2.0 / float(params.height));
  vec3 by = per_pixel * vec3(dot(normal, ray), dot(normal, right), dot(normal, down));
  planes[i] = vec4(by, by.x / z);
}

// By how much a neighbour misses a sample: apart, in pixels; how far its plane is off, in pixels.
const float kNoNeighbour = 4.0;
float neighbour_misses(vec2 apart, float off) { return 0.05 * dot(apart, apart) + off; }

// Of the nine, in rows. at: of the first of the nine among the planes. place: from the pixel's middle.
uint best_pixel(uint at, uint word, vec2 place) {
  uint mark = sample_mark(word);
  float z = sample_depth(word);
  float least = kNoNeighbour;
  uint best = 4u;
  [[unroll]] for (uint n = 0u; n < 9u; ++n) {
    uint there = at + n / 3u * FL_SIDE + n % 3u;
    if (marks[there] != mark) continue;
    vec2 apart = place - vec2(float(n % 3u), float(n / 3u)) + 1.0;
    vec4 plane = planes[there];
    float off = abs(plane.x + apart.x * plane.y + apart.y * plane.z - z * plane.w);
    float misses = neighbour_misses(apart, off);
    best = misses < least ? n : best;
    least = min(least, misses);
  }
  return best;
}

vec3 color_of(ivec2 pixel, uvec2 counted) {
  vec3 sum = vec3(0.0);
  for (int n = 0; n < 9; ++n) {
    uint count = (n < 5 ? counted.x >> (6 * n) : counted.y >> (6 * (n - 5))) & 63u;
    if (count == 0u) continue;
    sum += imageLoad(radiance, pixel + ivec2(n % 3, n / 3) - 1).rgb * (float(count) / float(kSamples));
  }
  return sum;
}

void main() {
  uint own = gl_LocalInvocationIndex;
  uvec2 tile = uvec2(gl_WorkGroupID.x, uint(edge_parts[part].first) / FL_TILE_PX + gl_WorkGroupID.y);
  uint words = words_of_tile(tile);
  ivec2 low = ivec2(tile) * FL_TILE_PX;
  load_edge_masks(words);
  barrier();
  uint count = edge_pixel_count();
  if (count == 0u) return;
  uint first_pixel = edge_masks[words + FL_TILE_PX];
  list_edge_pixels();
  for (uint i = own; i < FL_SIDE * FL_SIDE; i += FL_GROUP_EDGES) load_plane(low, i);
  const uint kThreads = kSamples / FL_OWN;  // of a pixel
  const uint kPixels = FL_GROUP_EDGES / kThreads;
  for (uint first = 0u; first < count; first += kPixels) {
    barrier();
    for (uint i = own; i < 2u * kPixels; i += FL_GROUP_EDGES) counts[i] = 0u;
    barrier();
    uint number = first + own / kThreads;
    if (number < count) {
      uint p = edge_pixels[number];
      uint at = p / FL_TILE_PX * FL_SIDE + p % FL_TILE_PX;
      uint from = own % kThreads * FL_OWN;
      uvec2 counted = uvec2(0u);
      [[unroll]] for (uint i = 0u; i < FL_OWN; ++i) {
        uint word = edge_samples[(first_pixel + number) * kSamples + from + i];
        uint best = best_pixel(at, word, sample_offset(from + i));
        counted += best < 5u ? uvec2(1u << (6u * best), 0u) : uvec2(0u, 1u << (6u * (best - 5u)));
      }
      if (counted.x != 0u) atomicAdd(counts[2u * (own / kThreads)], counted.x);
      if (counted.y != 0u) atomicAdd(counts[2u * (own / kThreads) + 1u], counted.y);
    }
    barrier();
    if (own < kPixels && first + own < count) {
      uint p = edge_pixels[first + own];
      ivec2 pixel = low + ivec2(int(p % FL_TILE_PX), int(p / FL_TILE_PX));
      imageStore(edges, pixel, vec4(color_of(pixel, uvec2(counts[2u * own], counts[2u * own + 1u])), 1.0));
    }
  }
}
