#version 460
// Writes the triangles of small bodies into the visibility buffer, where no larger body and no object is as near.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#define FL_USE_POSE
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/bodies.glsl"
#include "render/shaders/lib/normal.glsl"

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(constant_id = FL_SPEC_SHEEN) const bool kSheen = false;
layout(set = 0, binding = FL_BINDING_BODY_VERTICES, std430) readonly buffer VerticesBuffer {
  BodyVertexRow vertices[];
};
layout(set = 0, binding = FL_BINDING_BODY_INDICES, std430) readonly buffer IndicesBuffer { uint indices[]; };
layout(set = 0, binding = FL_BINDING_BODY_CHOICES, std430) readonly buffer ChoicesBuffer { uint choices[]; };
layout(set = 0, binding = FL_BINDING_SMALL_DEPTHS, std430) buffer DepthsBuffer { uint depths[]; };
layout(set = 0, binding = FL_BINDING_SMALL_KEYS, std430) readonly buffer KeysBuffer { uint keys[]; };
layout(set = 0, binding = FL_BINDING_DEPTH) uniform sampler2D depth_image;
layout(set = 0, binding = FL_BINDING_SURFACE_ID, rg32ui) uniform writeonly uimage2D surface_id;

void main() {
  uvec2 at = gl_GlobalInvocationID.xy;
  if (at.x >= params.width || at.y >= params.height) return;
  uint pixel = at.y * params.width + at.x;
  uint key = keys[pixel];
  if (key == 0u) {
    // The two passes compute each depth alike, but no rule says so: without a triangle there is nothing.
    if (depths[pixel] != 0u) depths[pixel] = 0u;
    return;
  }
  if (uintBitsToFloat(depths[pixel]) <= texelFetch(depth_image, ivec2(at), 0).x) return;
  // The last slot whose triangles begin no later.
  uint triangle = ~key;
  uint slot = 0u;
  uint end = uint(slots.length());
  while (end - slot > 1u) {
    uint middle = (slot + end) / 2u;
    if (slots[middle].numbered != 0u && slots[middle].triangle_first <= triangle) slot = middle;
    else end = middle;
  }
  BodySlotRow body = slots[slot];
  BodyLevelRow level = levels[choices[slot] & FL_CHOICE_LEVEL];
  HeadRow row = heads[body.head];
  TypeRow type = types[row.type];
  HeadState state = states[body.head];
  vec3 corner_m[3];
  vec3 normal[3];
  uint part = 0u;
  for (uint i = 0u; i < 3u; ++i) {
    BodyVertexRow v =
        vertices[level.vertex_first + indices[level.index_first + 3u * (triangle - body.triangle_first) + i]];
    uint depth = v.part & uint(FL_PART_DEPTH);
    vec3 p = chain_to_fixture(type, state, depth, vec3(v.x, v.y, v.z), 1.0);
    vec3 n = chain_to_fixture(type, state, depth, vec3(v.normal_x, v.normal_y, v.normal_z), 0.0);
    corner_m[i] = fixture_to_stage_point(row, p) - params.position.xyz;
    normal[i] = fixture_to_stage_direction(row, n);
    if (i == 0u) part = v.part;
  }
  // Where the ray through the pixel's middle meets the triangle (Moeller and Trumbore 1997).
  vec3 ray = ray_through(vec2(at) + 0.5);
  vec3 to_b = corner_m[1] - corner_m[0];
  vec3 to_c = corner_m[2] - corner_m[0];
  vec3 face = cross(to_b, to_c);
  vec3 across = cross(ray, to_c);
  float volume = dot(to_b, across);
  vec2 share = vec2(1.0 / 3.0);
  if (abs(volume) > 0.0) {
    share = vec2(dot(-corner_m[0], across), dot(ray, cross(-corner_m[0], to_b))) / volume;
    share = clamp(share, 0.0, 1.0);
    share /= max(share.x + share.y, 1.0);
  }
  vec3 n = normal[0] * (1.0 - share.x - share.y) + normal[1] * share.x + normal[2] * share.y;
  // As surface.frag: a normal that lies on the far side of its triangle is turned over.
  if (dot(face, ray) > 0.0) face = -face;
  if (dot(n, face) < 0.0) n = -n;
  uint sheen = kSheen ? part >> FL_PART_SHEEN_SHIFT : 0u;
  if (sheen != 0u) {
    uint id = 1u + ((body.head << 3) | (part & 7u)) | FL_BODY_SHEEN;
    imageStore(surface_id, ivec2(at), uvec4(pack_sheen_normal(n, sheen), id, 0u, 0u));
    return;
  }
  imageStore(surface_id, ivec2(at), uvec4(pack_normal(n), 1u + ((body.head << 3) | part), 0u, 0u));
}
