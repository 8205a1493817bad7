#version 460
// Smooth edges: finds the pixels that may show more than one surface, and writes which surface each pixel shows at its
// middle. After it edgeparts.comp finds room for their samples, beginedges.comp begins these, drawbodies.comp and
// others draw into them, and edgemix.comp gives each sample the colour of a pixel that shows the same surface. Colours
// are those of the whole picture, so the haze in front of each surface ends where that surface is.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/surface.glsl"
#include "render/shaders/lib/edge_surfaces.glsl"
layout(local_size_x = FL_GROUP_EDGES) in;
layout(set = 0, binding = FL_BINDING_EDGE_MASKS, std430) writeonly buffer EdgeMasksBuffer { uint edge_masks[]; };
layout(set = 0, binding = FL_BINDING_EDGE_IDS, std430) writeonly buffer EdgeIdsBuffer { uint edge_ids[]; };
layout(set = 0, binding = FL_BINDING_EDGE_PARTS, std430) buffer EdgePartsBuffer { EdgePartRow edge_parts[]; };

// What the pixels of the tile show, with one more on each side.
#define FL_SIDE (FL_TILE_PX + 2)
shared uint shown_id[FL_SIDE * FL_SIDE];
shared vec3 shown_normal[FL_SIDE * FL_SIDE];  // not of boxes
shared vec3 shown_place[FL_SIDE * FL_SIDE];   // from the camera, m
shared float shown_m[FL_SIDE * FL_SIDE];      // along the unit ray, as of the place
shared float shown_z[FL_SIDE * FL_SIDE];  // as a depth of the buffer: larger is nearer
shared float shown_inverse[FL_SIDE * FL_SIDE];  // one over its depth along the axis, within the picture
shared uint mask[FL_TILE_PX];             // the pixels of a row that may have an edge

uint at_side(ivec2 p) { return uint((p.y + 1) * FL_SIDE + p.x + 1); }

void load_shown(ivec2 low) {
  ivec2 size = ivec2(int(params.width), int(params.height));
  for (uint i = gl_LocalInvocationIndex; i < FL_SIDE * FL_SIDE; i += FL_GROUP_EDGES) {
    // Beyond the picture is what its last pixel shows.
    ivec2 pixel = clamp(low + ivec2(int(i % FL_SIDE), int(i / FL_SIDE)) - 1, ivec2(0), size - 1);
    vec3 way = ray_through(vec2(pixel) + 0.5);
    vec3 ray = normalize(way);
    Surface surface = surface_at(pixel, ray);
    shown_id[i] = surface_name(surface);
    bool is_box = surface.kind == kBox || surface.kind == kNothing;
    shown_normal[i] = is_box ? vec3(0.0) : unpack_normal(pack_normal(surface.normal));
    shown_m[i] = min(surface.t_m, 1e15);
    shown_place[i] = ray * shown_m[i];
    shown_inverse[i] = length(way) / surface.t_m;
    shown_z[i] = surface.kind == kNothing ? 0.0 : params.right.w / (surface.t_m * dot(ray, params.forward.xyz));
  }
}

const float kStep = 5e-4;  // of the depth: depths of three pixels in a row that are off a line by less are on a plane
const float kStepPx = 0.25;         // what the place of a neighbour may be off a smooth surface
const float kCrease = 0.03;         // 1 - cosine between the normals of neighbours, 14 degrees: less is no crease
const float kCreaseRatio = 4.0;     // a crease turns by twice as much as the surface on its other side ...
const float kSharpCrease = 0.3;     // ... or by 45 degrees
const ivec2 kWays[4] = ivec2[4](ivec2(1, 0), ivec2(0, 1), ivec2(1, 1), ivec2(1, -1));

// Whether the surface between a pixel and its neighbour has a step. A smooth one goes on at the mean of both normals.
// pixel_m: the size of the pixel there.
bool has_step(uint own, uint to, float pixel_m) {
  vec3 normals = shown_normal[own] + shown_normal[to];
  vec3 apart = shown_place[to] - shown_place[own];
  return abs(dot(normals, apart)) > 2.0 * kStepPx * pixel_m;
}

bool may_have_edge(ivec2 p, ivec2 low) {
  uint own = at_side(p);
  uint id = shown_id[own];
  bool is_box = id == 0u || (id & (FL_BOX_ID | FL_OBJECT)) == FL_BOX_ID;  // a plane, or nothing
  vec3 normal = shown_normal[own];
  float inverse = shown_inverse[own];
  float pixel_m = 2.0 / float(params.width) * length(params.right.xyz) * shown_m[own];
  bool edge = false;
  ivec2 size = ivec2(int(params.width), int(params.height));
  [[unroll]] for (int w = 0; w < 4; ++w) {
    uint before = at_side(p - kWays[w]);
    uint after = at_side(p + kWays[w]);
    edge = edge || shown_id[before] != id || shown_id[after] != id;
    if (!is_box && !edge) {
      ivec2 from = low + p - kWays[w];
      ivec2 to = low + p + kWays[w];
      bool inside = all(greaterThanEqual(min(from, to), ivec2(0))) && all(lessThan(max(from, to), size));
      float off = shown_inverse[before] + shown_inverse[after] - 2.0 * inverse;
      if (inside && abs(off) > kStep * inverse) {
        edge = has_step(own, before, pixel_m) || has_step(own, after, pixel_m);
      }
      float turn_before = 1.0 - dot(normal, shown_normal[before]);
      float turn_after = 1.0 - dot(normal, shown_normal[after]);
      float most = max(turn_before, turn_after);
      float least = min(turn_before, turn_after);
      edge = edge || (most > kCrease && (most > kCreaseRatio * least || most > kSharpCrease));
    }
  }
  return edge;
}

// The farthest depth that a pixel and its neighbours show at their middles, a little farther.
float farthest(ivec2 p) {
  float z = 1.0;
  for (int n = 0; n < 9; ++n) z = min(z, shown_z[at_side(p + ivec2(n % 3, n / 3) - 1)]);
  return 0.999 * z;
}

void main() {
  ivec2 low = ivec2(gl_WorkGroupID.xy) * FL_TILE_PX;
  ivec2 size = ivec2(int(params.width), int(params.height));
  if (gl_LocalInvocationIndex < FL_TILE_PX) mask[gl_LocalInvocationIndex] = 0u;
  load_shown(low);
  barrier();
  for (uint i = gl_LocalInvocationIndex; i < FL_TILE_PX * FL_TILE_PX; i += FL_GROUP_EDGES) {
    ivec2 p = ivec2(int(i % FL_TILE_PX), int(i / FL_TILE_PX));
    if (any(greaterThanEqual(low + p, size))) continue;
    uint pixel = uint(low.y + p.y) * params.width + uint(low.x + p.x);
    edge_ids[pixel] = shown_id[at_side(p)];
    if (!may_have_edge(p, low)) continue;
    atomicOr(mask[p.y], 1u << p.x);
    edge_ids[params.height * params.width + pixel] = floatBitsToUint(farthest(p));
  }
  barrier();
  if (gl_LocalInvocationIndex >= FL_TILE_PX) return;
  uint tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  uint before = 0u;
  for (uint y = 0u; y < gl_LocalInvocationIndex; ++y) before += uint(bitCount(mask[y]));
  uint own = mask[gl_LocalInvocationIndex];
  edge_masks[tile * FL_EDGE_WORDS + gl_LocalInvocationIndex] = before << 16 | own;
  uint count = before + uint(bitCount(own));
  if (gl_LocalInvocationIndex == FL_TILE_PX - 1u && count > 0u) {
    atomicAdd(edge_parts[gl_WorkGroupID.y].count, count);
  }
}
