#version 460
// Draws small bodies: a workgroup a body, a thread a triangle. The first pass finds the nearest depth of each pixel,
// the second the first triangle at that depth: the picture does not depend on the order of threads. A pixel belongs
// to a triangle by the rules of Vulkan's rasteriser with 8 bits below the pixel. The rasteriser itself takes 1 ns a
// triangle on an H200, where a thirtieth of the GPU serves it.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#define FL_USE_POSE
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/bodies.glsl"

layout(local_size_x = FL_GROUP_SMALL) in;
layout(constant_id = FL_SPEC_SMALL_KEYS) const bool kKeys = false;
layout(set = 0, binding = FL_BINDING_BODY_VERTICES, std430) readonly buffer VerticesBuffer {
  BodyVertexRow vertices[];
};
layout(set = 0, binding = FL_BINDING_BODY_INDICES, std430) readonly buffer IndicesBuffer { uint indices[]; };
layout(set = 0, binding = FL_BINDING_BODY_CHOICES, std430) readonly buffer ChoicesBuffer { uint choices[]; };
layout(set = 0, binding = FL_BINDING_SMALL_DEPTHS, std430) buffer DepthsBuffer { uint depths[]; };
layout(set = 0, binding = FL_BINDING_SMALL_KEYS, std430) buffer KeysBuffer { uint keys[]; };

const float kSubpixels = 256.0;
const float kFarthestPx = 65536.0;  // from the picture's corner: farther places are not exact in float

// Rows that take a point behind so many joints to (x times w, y times w, w); x and y in pixels from the picture's
// middle.
shared vec4 to_picture[4][3];

// Both passes must find the same depths.
precise vec3 picture_of(BodyVertexRow v) {
  uint depth = v.part & uint(FL_PART_DEPTH);
  vec4 p = vec4(v.x, v.y, v.z, 1.0);
  precise float w = dot(to_picture[depth][2], p);
  precise float x = dot(to_picture[depth][0], p) / w + 0.5 * float(params.width);
  precise float y = dot(to_picture[depth][1], p) / w + 0.5 * float(params.height);
  return vec3(x, y, params.right.w / w);
}

// A triangle in the picture: corners in 1/256 of a pixel, in the order that makes its area positive; the pixels whose
// middles may be within; its depth at the first corner and towards the others.
struct Triangle {
  ivec2 p0;
  ivec2 p1;
  ivec2 p2;
  ivec2 low;
  ivec2 high;
  int extent;  // longest side of the box round it, in 1/256 of a pixel
  vec3 z;
};

Triangle triangle_of(BodyLevelRow level, uint t) {
  uint first = level.index_first + 3u * t;
  vec3 a = picture_of(vertices[level.vertex_first + indices[first]]);
  vec3 b = picture_of(vertices[level.vertex_first + indices[first + 1u]]);
  vec3 c = picture_of(vertices[level.vertex_first + indices[first + 2u]]);
  Triangle it;
  it.p0 = ivec2(roundEven(a.xy * kSubpixels));
  it.p1 = ivec2(roundEven(b.xy * kSubpixels));
  it.p2 = ivec2(roundEven(c.xy * kSubpixels));
  it.z = vec3(a.z, b.z, c.z);
  ivec2 low = min(it.p0, min(it.p1, it.p2));
  ivec2 high = max(it.p0, max(it.p1, it.p2));
  it.low = max((low + 127) >> 8, ivec2(0));
  it.high = min((high - 128) >> 8, ivec2(int(params.width), int(params.height)) - 1);
  it.extent = max(high.x - low.x, high.y - low.y);
  vec2 most = max(abs(a.xy), max(abs(b.xy), abs(c.xy)));
  if (!(max(most.x, most.y) < kFarthestPx)) it.high = it.low - 1;
  return it;
}

// Twice the area of (a, a + d, p), where it fits into 32 bits.
int side(ivec2 a, ivec2 d, ivec2 p) { return d.x * (p.y - a.y) - d.y * (p.x - a.x); }
// The same in 64 bits, high word first, for bodies up to FL_SMALL_BODY_PX.
ivec2 wide_side(ivec2 a, ivec2 d, ivec2 p) {
  int high_x, low_x, high_y, low_y;
  imulExtended(d.x, p.y - a.y, high_x, low_x);
  imulExtended(d.y, p.x - a.x, high_y, low_y);
  uint borrow;
  uint low = usubBorrow(uint(low_x), uint(low_y), borrow);
  return ivec2(high_x - high_y - int(borrow), int(low));
}
float wide_float(ivec2 v) { return float(v.x) * 4294967296.0 + float(uint(v.y)); }
// A point on an edge is within if the edge is at the top or on the left.
bool holds_edge(ivec2 d) { return d.y < 0 || (d.y == 0 && d.x > 0); }

void touch(uint pixel, float z, uint key) {
  uint bits = floatBitsToUint(z);
  if (kKeys) {
    if (bits == depths[pixel]) atomicMax(keys[pixel], key);
  } else if (bits > depths[pixel]) {
    atomicMax(depths[pixel], bits);
  }
}

// One thread draws it.
void draw(Triangle it, uint key) {
  int area = side(it.p0, it.p1 - it.p0, it.p2);
  if (area == 0) return;
  if (area < 0) {
    ivec2 corner = it.p1;
    it.p1 = it.p2;
    it.p2 = corner;
    it.z = it.z.xzy;
    area = -area;
  }
  ivec2 d0 = it.p2 - it.p1;
  ivec2 d1 = it.p0 - it.p2;
  ivec2 d2 = it.p1 - it.p0;
  ivec3 least = ivec3(holds_edge(d0) ? 0 : 1, holds_edge(d1) ? 0 : 1, holds_edge(d2) ? 0 : 1);
  // Depth is linear in the picture.
  precise float to_1 = (it.z.y - it.z.x) / float(area);
  precise float to_2 = (it.z.z - it.z.x) / float(area);
  for (int y = it.low.y; y <= it.high.y; ++y) {
    for (int x = it.low.x; x <= it.high.x; ++x) {
      ivec2 p = (ivec2(x, y) << 8) + 128;
      ivec3 e = ivec3(side(it.p1, d0, p), side(it.p2, d1, p), side(it.p0, d2, p));
      if (any(lessThan(e, least))) continue;
      precise float z = it.z.x + (float(e.y) * to_1 + float(e.z) * to_2);
      touch(uint(y) * params.width + uint(x), z, key);
    }
  }
}

bool within(ivec2 side, bool edge) { return side.x > 0 || (side.x == 0 && (side.y != 0 || edge)); }

// All threads draw it together.
void draw_wide(Triangle it, uint key) {
  ivec2 area = wide_side(it.p0, it.p1 - it.p0, it.p2);
  if (area == ivec2(0)) return;
  if (area.x < 0) {
    ivec2 corner = it.p1;
    it.p1 = it.p2;
    it.p2 = corner;
    it.z = it.z.xzy;
    area = wide_side(it.p0, it.p1 - it.p0, it.p2);
  }
  ivec2 d0 = it.p2 - it.p1;
  ivec2 d1 = it.p0 - it.p2;
  ivec2 d2 = it.p1 - it.p0;
  precise float to_1 = (it.z.y - it.z.x) / wide_float(area);
  precise float to_2 = (it.z.z - it.z.x) / wide_float(area);
  int across = it.high.x - it.low.x + 1;
  int count = across * (it.high.y - it.low.y + 1);
  for (int i = int(gl_LocalInvocationIndex); i < count; i += FL_GROUP_SMALL) {
    ivec2 at = it.low + ivec2(i % across, i / across);
    ivec2 p = (at << 8) + 128;
    ivec2 e0 = wide_side(it.p1, d0, p);
    ivec2 e1 = wide_side(it.p2, d1, p);
    ivec2 e2 = wide_side(it.p0, d2, p);
    if (!within(e0, holds_edge(d0)) || !within(e1, holds_edge(d1)) || !within(e2, holds_edge(d2))) continue;
    precise float z = it.z.x + (wide_float(e1) * to_1 + wide_float(e2) * to_2);
    touch(uint(at.y) * params.width + uint(at.x), z, key);
  }
}

// Triangles that all threads draw together, of one round.
shared Triangle wide[FL_GROUP_SMALL];
shared uint wide_keys[FL_GROUP_SMALL];
shared uint wide_count;
const int kAlonePx = 128;     // the most pixels that a thread tests alone
const int kAloneExtent = 16384;  // and the longest side, so that side() fits into 32 bits

void main() {
  uint slot = gl_WorkGroupID.y * FL_SLOTS_X + gl_WorkGroupID.x;
  if (slot >= uint(slots.length())) return;
  uint choice = choices[slot];
  if (choice == FL_CHOICE_NONE || (choice & FL_CHOICE_SMALL) == 0u) return;
  BodySlotRow body = slots[slot];
  uint thread = gl_LocalInvocationIndex;
  if (thread < 4u && meshes[body.mesh].sphere[thread].w >= 0.0) {  // so many joints move some vertex
    HeadRow row = heads[body.head];
    Placed at = place(row, types[row.type], states[body.head], thread);
    vec3 across = params.right.xyz * (0.5 * float(params.width) / dot(params.right.xyz, params.right.xyz));
    vec3 down = params.up.xyz * (-0.5 * float(params.height) / dot(params.up.xyz, params.up.xyz));
    vec3 ahead = params.forward.xyz;
    to_picture[thread][0] =
        vec4(dot(at.x_axis, across), dot(at.y_axis, across), dot(at.z_axis, across), dot(at.origin, across));
    to_picture[thread][1] =
        vec4(dot(at.x_axis, down), dot(at.y_axis, down), dot(at.z_axis, down), dot(at.origin, down));
    to_picture[thread][2] =
        vec4(dot(at.x_axis, ahead), dot(at.y_axis, ahead), dot(at.z_axis, ahead), dot(at.origin, ahead));
  }
  if (thread == 0u) wide_count = 0u;
  barrier();
  BodyLevelRow level = levels[choice & FL_CHOICE_LEVEL];
  uint triangles = level.index_count / 3u;
  bool has_wide = (choice & FL_CHOICE_WIDE) != 0u;
  for (uint base = 0u; base < triangles; base += FL_GROUP_SMALL) {
    uint t = base + thread;
    if (t < triangles) {
      Triangle it = triangle_of(level, t);
      ivec2 size = it.high - it.low + 1;
      if (size.x > 0 && size.y > 0) {
        if (has_wide && (size.x * size.y > kAlonePx || it.extent > kAloneExtent)) {
          uint at = atomicAdd(wide_count, 1u);
          wide[at] = it;
          wide_keys[at] = ~(body.triangle_first + t);
        } else {
          draw(it, ~(body.triangle_first + t));
        }
      }
    }
    if (!has_wide) continue;
    barrier();
    uint together = wide_count;
    for (uint i = 0u; i < together; ++i) draw_wide(wide[i], wide_keys[i]);
    barrier();
    if (thread == 0u) wide_count = 0u;
    barrier();
  }
}
