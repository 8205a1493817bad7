#version 460
// Writes the triangles that compute shaders drew into the visibility buffer, as surface.frag does those of the
// rasteriser. FL_TEXTURES, FL_SHEEN: of rigs whose objects have textures, and sheen.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_HEADS
#define FL_STATES_ACCESS readonly
#define FL_USE_POSE
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/bodies.glsl"
#include "render/shaders/lib/normal.glsl"
#ifdef FL_TEXTURES
#include "render/shaders/lib/texture.glsl"
layout(set = 0, binding = FL_BINDING_OBJECT_UVS, std430) readonly buffer UvsBuffer { vec2 object_uvs[]; };
#endif

layout(local_size_x = FL_TILE_PX, local_size_y = FL_TILE_PX) in;
layout(constant_id = FL_SPEC_SHEEN) const bool kSheen = false;
layout(set = 0, binding = FL_BINDING_BODY_VERTICES, std430) readonly buffer VerticesBuffer {
  BodyVertexRow vertices[];
};
layout(set = 0, binding = FL_BINDING_BODY_INDICES, std430) readonly buffer IndicesBuffer { uint indices[]; };
layout(set = 0, binding = FL_BINDING_BODY_CHOICES, std430) readonly buffer ChoicesBuffer { uint choices[]; };
layout(set = 0, binding = FL_BINDING_PIXEL_DEPTHS, std430) buffer DepthsBuffer { uint depths[]; };
layout(set = 0, binding = FL_BINDING_PIXEL_KEYS, std430) readonly buffer KeysBuffer { uint keys[]; };
layout(constant_id = FL_SPEC_JOINED) const bool kJoined = false;
layout(set = 0, binding = FL_BINDING_SURFACE_ID, rg32ui) uniform writeonly uimage2D surface_id;

// The corners of a triangle, from the camera, m.
struct Corners {
  vec3 place_m[3];
  vec3 normal[3];
  uint vertex[3];  // within its level
  uint part;
};

Corners object_corners(BodyLevelRow level, uint triangle) {
  Corners c;
  for (uint i = 0u; i < 3u; ++i) {
    c.vertex[i] = indices[level.index_first + 3u * triangle + i];
    BodyVertexRow v = vertices[level.vertex_first + c.vertex[i]];
    c.place_m[i] = vec3(v.x, v.y, v.z) - params.position.xyz;
    c.normal[i] = vec3(v.normal_x, v.normal_y, v.normal_z);
    if (i == 0u) c.part = v.part;
  }
  return c;
}

Corners body_corners(BodyLevelRow level, uint triangle, uint head) {
  HeadRow row = heads[head];
  TypeRow type = types[row.type];
  HeadState state = states[head];
  Corners c;
  for (uint i = 0u; i < 3u; ++i) {
    c.vertex[i] = indices[level.index_first + 3u * triangle + i];
    BodyVertexRow v = vertices[level.vertex_first + c.vertex[i]];
    uint depth = v.part & uint(FL_PART_DEPTH);
    vec3 p = chain_to_fixture(type, state, depth, vec3(v.x, v.y, v.z), 1.0);
    vec3 n = chain_to_fixture(type, state, depth, vec3(v.normal_x, v.normal_y, v.normal_z), 0.0);
    c.place_m[i] = fixture_to_stage_point(row, p) - params.position.xyz;
    c.normal[i] = fixture_to_stage_direction(row, n);
    if (i == 0u) c.part = v.part;
  }
  return c;
}

// The slot of a body's triangle: the last whose triangles begin no later.
uint slot_of(uint triangle) {
  uint slot = 0u;
  uint end = uint(slots.length());
  while (end - slot > 1u) {
    uint middle = (slot + end) / 2u;
    if (slots[middle].triangle_first <= triangle) slot = middle;
    else end = middle;
  }
  return slot;
}

// Where a ray meets the plane of a triangle: the shares of its second and third corner (Moeller and Trumbore 1997).
vec2 shares_at(Corners c, vec3 ray) {
  vec3 to_b = c.place_m[1] - c.place_m[0];
  vec3 to_c = c.place_m[2] - c.place_m[0];
  vec3 across = cross(ray, to_c);
  float volume = dot(to_b, across);
  if (!(abs(volume) > 0.0)) return vec2(1.0 / 3.0);
  return vec2(dot(-c.place_m[0], across), dot(ray, cross(-c.place_m[0], to_b))) / volume;
}

#ifdef FL_TEXTURES
vec2 uv_at(Corners c, vec2 share) {
  return object_uvs[c.vertex[0]] * (1.0 - share.x - share.y) + object_uvs[c.vertex[1]] * share.x +
         object_uvs[c.vertex[2]] * share.y;
}
#endif

void main() {
  uvec2 at = gl_GlobalInvocationID.xy;
  if (at.x >= params.width || at.y >= params.height) return;
  uint pixel = at.y * params.width + at.x;
  uint key = keys[kJoined ? 2u * pixel : pixel];
  if (kJoined) {
    depths[pixel] = keys[2u * pixel + 1u];
    if (key == 0u) return;
  } else if (key == 0u) {
    // The two rounds compute each depth alike, but no rule says so: without a triangle there is nothing.
    if (depths[pixel] != 0u) depths[pixel] = 0u;
    return;
  }
  uint triangle = ~key;
  bool is_object =
      FL_NOT_IN_CODE(params.object_level) != FL_NONE && triangle >= levels[params.object_level].triangle_first;
  Corners c;
  uint id;
  if (is_object) {
    BodyLevelRow level = levels[params.object_level];
    c = object_corners(level, triangle - level.triangle_first);
    id = c.part;
  } else {
    uint slot = slot_of(triangle);
    BodySlotRow body = slots[slot];
    c = body_corners(levels[choices[slot] & FL_CHOICE_LEVEL], triangle - body.triangle_first, body.head);
    id = 1u + (body.head << 3 | c.part & 7u);
  }
  vec3 ray = ray_through(vec2(at) + 0.5);
  vec2 plane = shares_at(c, ray);
  vec2 share = clamp(plane, 0.0, 1.0);
  share /= max(share.x + share.y, 1.0);
  vec3 n = c.normal[0] * (1.0 - share.x - share.y) + c.normal[1] * share.x + c.normal[2] * share.y;
  // As surface.frag: a normal that lies on the far side of its triangle is turned over.
  vec3 face = cross(c.place_m[1] - c.place_m[0], c.place_m[2] - c.place_m[0]);
  if (dot(face, ray) > 0.0) face = -face;
  if (dot(n, face) < 0.0) n = -n;
  uint sheen = 0u;
  if (kSheen && !is_object) {
    sheen = c.part >> FL_PART_SHEEN_SHIFT;
    if (sheen != 0u) id |= FL_BODY_SHEEN;
  }
#ifdef FL_TEXTURES
  if (is_object && (id & FL_OBJECT_TEXTURED) != 0u) {
    vec2 dx = shares_at(c, ray_through(vec2(at) + vec2(1.0, 0.0) + 0.5)) - plane;
    vec2 dy = shares_at(c, ray_through(vec2(at) + vec2(0.0, 1.0) + 0.5)) - plane;
    vec2 uv = uv_at(c, share);
    uint number = id & ~(FL_OBJECT | FL_OBJECT_TEXTURED);
#ifdef FL_SHEEN
    id = textured_identity(number, uv, uv_at(c, share + dx) - uv, uv_at(c, share + dy) - uv, vec2(at) + 0.5, sheen);
#else
    id = textured_identity(number, uv, uv_at(c, share + dx) - uv, uv_at(c, share + dy) - uv, vec2(at) + 0.5);
#endif
  }
#endif
  bool has_sheen = kSheen && (id & FL_BODY_SHEEN) != 0u;  // the same bit of an object
  imageStore(surface_id, ivec2(at), uvec4(has_sheen ? pack_sheen_normal(n, sheen) : pack_normal(n), id, 0u, 0u));
}
