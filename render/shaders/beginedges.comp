#version 460
// Begins the samples of pixels with an edge (edges.comp) in a part of the picture (edgeparts.comp): with the nearest
// box at each, or with nothing.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/edge_surfaces.glsl"
#include "render/shaders/lib/edge_samples.glsl"
#include "render/shaders/lib/box_cull.glsl"
layout(local_size_x = FL_GROUP_EDGES) in;
layout(set = 0, binding = FL_BINDING_EDGE_MASKS, std430) buffer EdgeMasksBuffer { uint edge_masks[]; };
layout(set = 0, binding = FL_BINDING_EDGE_PARTS, std430) buffer EdgePartsBuffer { EdgePartRow edge_parts[]; };
layout(set = 0, binding = FL_BINDING_EDGE_SAMPLES, std430) writeonly buffer EdgeSamplesBuffer { uint edge_samples[]; };
layout(push_constant) uniform PartPush { uint part; };

#include "render/shaders/lib/edge_tile.glsl"
shared uint first_pixel;                 // the number of the first one
shared uint near_boxes[FL_GROUP_EDGES];  // of a round: those that the tile may show
shared uint near_count;

// Each thread has so many samples of a pixel, in registers: loops over them are unrolled.
#define FL_OWN 4
const uint kThreadsPerPixel = kSamples / FL_OWN;
ivec2 own_pixel;  // within the tile
uint own_first;   // the number of its first sample
float own_m[FL_OWN];  // depth along the camera's axis
uint own_id[FL_OWN];

void sample_box(ivec2 low, uint b) {
  [[unroll]] for (uint i = 0u; i < FL_OWN; ++i) {
    vec3 ray = ray_through(vec2(low + own_pixel) + 0.5 + sample_offset(own_first + i));
    vec3 inverse = 1.0 / mix(ray, vec3(1e-12), lessThan(abs(ray), vec3(1e-12)));
    vec3 to_low = (boxes[b].low.xyz - params.position.xyz) * inverse;
    vec3 to_high = (boxes[b].high.xyz - params.position.xyz) * inverse;
    vec3 in_m = min(to_low, to_high);
    vec3 out_m = max(to_low, to_high);
    float enter_m = max(in_m.x, max(in_m.y, in_m.z));
    float leave_m = min(out_m.x, min(out_m.y, out_m.z));
    if (!(enter_m > 0.0 && enter_m <= leave_m && enter_m <= own_m[i])) continue;
    vec3 face = in_m.x >= enter_m ? vec3(1, 0, 0) : in_m.y >= enter_m ? vec3(0, 1, 0) : vec3(0, 0, 1);
    uint id = box_face_id(b, -sign(ray) * face);
    own_id[i] = enter_m < own_m[i] ? id : min(own_id[i], id);
    own_m[i] = enter_m;
  }
}

void sample_boxes(ivec2 low) {
  for (uint first = 0u; first < FL_NOT_IN_CODE(params.box_count); first += FL_GROUP_EDGES) {
    barrier();  // those of the round before have been read
    if (gl_LocalInvocationIndex == 0u) near_count = 0u;
    barrier();
    uint own = first + gl_LocalInvocationIndex;
    // In any order: the nearest counts, and of two at the same depth the one with the lower name.
    if (own < params.box_count && may_show(low, boxes[own].low.xyz, boxes[own].high.xyz)) {
      near_boxes[atomicAdd(near_count, 1u)] = own;
    }
    barrier();
    uint count = near_count;
    for (uint i = 0u; i < count; ++i) sample_box(low, near_boxes[i]);
  }
}

void main() {
  uint tile_row = uint(edge_parts[part].first) / FL_TILE_PX + gl_WorkGroupID.y;
  uint first_word = (tile_row * gl_NumWorkGroups.x + gl_WorkGroupID.x) * FL_EDGE_WORDS;
  ivec2 low = ivec2(int(gl_WorkGroupID.x), int(tile_row)) * FL_TILE_PX;
  load_edge_masks(first_word);
  barrier();
  uint count = edge_pixel_count();
  if (count == 0u) return;
  if (gl_LocalInvocationIndex == 0u) {
    // The order of tiles changes nothing but where their samples are.
    first_pixel = atomicAdd(edge_parts[tile_row].next, count);
    edge_masks[first_word + FL_TILE_PX] = first_pixel;
  }
  if (kBoxes) list_edge_pixels();
  barrier();
  uint to = first_pixel * kSamples;
  if (!kBoxes) {
    for (uint i = gl_LocalInvocationIndex; i < count * kSamples; i += FL_GROUP_EDGES) edge_samples[to + i] = 0u;
    return;
  }
  const uint kPixels = FL_GROUP_EDGES / kThreadsPerPixel;
  for (uint first = 0u; first < count; first += kPixels) {
    uint number = first + gl_LocalInvocationIndex / kThreadsPerPixel;
    uint pixel = edge_pixels[min(number, count - 1u)];
    own_pixel = ivec2(int(pixel % uint(FL_TILE_PX)), int(pixel / uint(FL_TILE_PX)));
    own_first = gl_LocalInvocationIndex % kThreadsPerPixel * FL_OWN;
    [[unroll]] for (uint i = 0u; i < FL_OWN; ++i) {
      own_m[i] = FL_FAR_M;
      own_id[i] = 0u;
    }
    sample_boxes(low);
    if (number >= count) continue;
    [[unroll]] for (uint i = 0u; i < FL_OWN; ++i) {
      edge_samples[to + number * kSamples + own_first + i] =
          own_id[i] != 0u ? sample_word(min(params.right.w / own_m[i], 0.999), mark_of(own_id[i])) : 0u;
    }
  }
}
