#version 460
// Which stage box each pixel shows, if nothing is before it: its number, or FL_NONE. One workgroup a tile. Other passes
// cut their rays with that box alone (surface_at(), lib/surface.glsl).
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/mirror.glsl"
#include "render/shaders/lib/box_cull.glsl"
#define FL_ROWS 4  // of a thread
layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX / FL_ROWS) in;
layout(set = 0, binding = FL_BINDING_BOXES, std430) readonly buffer BoxesBuffer { BoxRow boxes[]; };
layout(set = 0, binding = FL_BINDING_PIXEL_BOXES, std430) writeonly buffer PixelBoxesBuffer { uint pixel_boxes[]; };

const uint kThreads = uint(FL_TILE_PX * FL_TILE_PX / FL_ROWS);
shared vec3 near_low[kThreads];  // from the camera; those of a round that the tile may show
shared vec3 near_high[kThreads];
shared uint near_box[kThreads];
shared uint near_count;

struct Nearest {
  vec3 inverse;   // one over each part of the unit ray
  float begin_m;  // where the ray begins
  float m;
  uint box;
};

Nearest nearest_at(ivec2 pixel) {
  vec3 ray = normalize(ray_through(vec2(pixel) + 0.5));
  vec3 inverse = 1.0 / mix(ray, vec3(1e-12), lessThan(abs(ray), vec3(1e-12)));
  return Nearest(inverse, ray_begin(ray) * (1.0 - 1e-5), FL_FAR_M, FL_NONE);
}

void take_nearer(vec3 low, vec3 high, uint box, inout Nearest nearest) {
  vec3 to_low = low * nearest.inverse;
  vec3 to_high = high * nearest.inverse;
  vec3 in_m = min(to_low, to_high);
  vec3 out_m = max(to_low, to_high);
  float enter_m = max(in_m.x, max(in_m.y, in_m.z));
  float leave_m = min(out_m.x, min(out_m.y, out_m.z));
  // In any order: of two at the same distance the first one counts.
  bool closer = enter_m < nearest.m || (enter_m == nearest.m && box < nearest.box);
  bool meets = enter_m > nearest.begin_m && enter_m <= leave_m && closer;
  nearest.m = meets ? enter_m : nearest.m;
  nearest.box = meets ? box : nearest.box;
}

void main() {
  ivec2 low = ivec2(gl_WorkGroupID.xy) * FL_TILE_PX;
  ivec2 pixel = low + ivec2(gl_LocalInvocationID.xy);
  const ivec2 kStep = ivec2(0, FL_TILE_PX / FL_ROWS);
  Nearest nearest[FL_ROWS];
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) nearest[i] = nearest_at(pixel + i * kStep);
  for (uint first = 0u; first < FL_NOT_IN_CODE(params.box_count); first += kThreads) {
    barrier();  // those of the round before have been read
    if (gl_LocalInvocationIndex == 0u) near_count = 0u;
    barrier();
    uint own = first + gl_LocalInvocationIndex;
    if (own < params.box_count && may_show(low, boxes[own].low.xyz, boxes[own].high.xyz)) {
      uint at = atomicAdd(near_count, 1u);
      near_low[at] = boxes[own].low.xyz - params.position.xyz;
      near_high[at] = boxes[own].high.xyz - params.position.xyz;
      near_box[at] = own;
    }
    barrier();
    uint count = near_count;
    for (uint b = 0u; b < count; ++b) {
      [[unroll]] for (int i = 0; i < FL_ROWS; ++i) take_nearer(near_low[b], near_high[b], near_box[b], nearest[i]);
    }
  }
  [[unroll]] for (int i = 0; i < FL_ROWS; ++i) {
    ivec2 at = pixel + i * kStep;
    if (at.x >= int(params.width) || at.y >= int(params.height)) continue;
    pixel_boxes[uint(at.y) * params.width + uint(at.x)] = nearest[i].box;
  }
}
