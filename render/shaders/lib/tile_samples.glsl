// What pixels of a tile show at kSamples places each. Each thread has four of the samples of a pixel. All threads place
// triangles of what the tile shows, one each, and then test their own samples against those that touch their pixel: so
// a corner is placed once for many samples, and threads do not part. The nearest depth counts, then the least identity,
// then the least normal: no picture depends on the order of triangles. After bodies.glsl and surface.glsl.
#define FL_THREADS 128
layout(constant_id = FL_SPEC_EDGE_SAMPLES) const uint kSamples = FL_EDGE_SAMPLES_MAX;
layout(set = 0, binding = FL_BINDING_BODY_VERTICES, std430) readonly buffer VerticesBuffer {
  BodyVertexRow vertices[];
};
layout(set = 0, binding = FL_BINDING_BODY_INDICES, std430) readonly buffer IndicesBuffer { uint indices[]; };
layout(set = 0, binding = FL_BINDING_BODY_TREES, std430) readonly buffer TreesBuffer { TreeRow trees[]; };
layout(set = 0, binding = FL_BINDING_BODY_CHOICES, std430) readonly buffer ChoicesBuffer { uint choices[]; };
layout(set = 0, binding = FL_BINDING_HEAD_SLOTS, std430) readonly buffer HeadSlotsBuffer { uint head_slots[]; };

// The identity of a surface: as in the visibility buffer, and of a box this bit, its number << 3 and its face.
#define FL_BOX_ID 0x40000000u
// What is the same all over a surface: of a textured one the two bits alone.
uint object_identity(uint id) {
  const uint kTextured = FL_OBJECT | FL_OBJECT_TEXTURED;
  return (id & kTextured) == kTextured ? kTextured : id;
}
const float kHalfTile = 0.5 * float(FL_TILE_PX);

// The pixels whose samples the threads have: y * FL_TILE_PX + x within the tile.
#define FL_OWN 4
const uint kThreadsPerPixel = kSamples / FL_OWN;
const uint kGroup = FL_THREADS / kThreadsPerPixel;
shared uint group_pixels[FL_THREADS];
shared uint group_numbers[FL_TILE_PX * FL_TILE_PX];  // of each pixel of the tile: its number in the group, or FL_NONE
// The rectangle of these pixels: least x and y, and then what is left to FL_TILE_PX from the largest.
shared uint group_margins[4];

// The samples of this thread, in registers: loops over them are unrolled. Bits of the depth along the camera's axis, m;
// identity; packed normal of the triangle or face; from the tile's middle, in pixels.
uint sample_depth[FL_OWN];
uint sample_id[FL_OWN];
uint sample_normal[FL_OWN];
vec2 sample_place[FL_OWN];
vec2 own_middle;   // of the part of the pixel that they are in: a quarter, a half or all of it
vec2 own_half;     // its half width and height
ivec2 own_pixel;   // within the tile

// The tile's middle and the sides of a pixel: rays of depth 1, and what they change by a pixel.
vec3 middle_ray;
vec3 ray_right;
vec3 ray_down;
// Rows that take a place from the camera to (x, y) times depth and to depth; x and y in pixels from the tile's middle.
vec3 to_x;
vec3 to_y;

void begin_tile(uvec2 low) {
  vec2 size = vec2(float(params.width), float(params.height));
  vec2 middle = vec2(low) + kHalfTile;
  middle_ray = ray_through(middle);
  ray_right = params.right.xyz * (2.0 / size.x);
  ray_down = params.up.xyz * (-2.0 / size.y);
  vec3 across = params.right.xyz / dot(params.right.xyz, params.right.xyz);
  vec3 up = params.up.xyz / dot(params.up.xyz, params.up.xyz);
  vec2 ndc = vec2(2.0, -2.0) * middle / size + vec2(-1.0, 1.0);
  to_x = (across - params.forward.xyz * ndc.x) * (0.5 * size.x);
  to_y = (params.forward.xyz * ndc.y - up) * (0.5 * size.y);
}

// Begins the samples of pixel k of the group. From a pixel's middle they are the points of Hammersley, whose rows and
// columns all have one; the upper half of their numbers is on the right, and odd numbers are in the lower half.
void begin_samples(uint k, uint part) {
  own_pixel = ivec2(int(group_pixels[k] % uint(FL_TILE_PX)), int(group_pixels[k] / uint(FL_TILE_PX)));
  vec2 middle = vec2(own_pixel) + 0.5 - kHalfTile;
  own_half = vec2(kThreadsPerPixel > 1u ? 0.25 : 0.5, kThreadsPerPixel > 2u ? 0.25 : 0.5);
  own_middle = middle + (vec2(float(part & 1u), float(part >> 1)) - 0.5) * (1.0 - 2.0 * own_half);
  uint bits = uint(findMSB(kSamples));
  [[unroll]] for (uint i = 0u; i < FL_OWN; ++i) {
    uint n = kThreadsPerPixel > 2u ? (part & 1u) * (kSamples / 2u) + 2u * i + (part >> 1) : part * FL_OWN + i;
    vec2 at = (vec2(float(n), float(bitfieldReverse(n) >> (32u - bits))) + 0.5) / float(kSamples) - 0.5;
    sample_place[i] = middle + at;
    sample_depth[i] = floatBitsToUint(FL_FAR_M);
    sample_id[i] = 0u;
    sample_normal[i] = 0u;
  }
}
vec3 ray_at(vec2 place) { return middle_ray + place.x * ray_right + place.y * ray_down; }

// A space of vertices and of boxes of trees: rows as to_x, to_y and depth.
struct Space {
  vec4 x;
  vec4 y;
  vec4 depth;
};
Space space_of(Placed at) {
  return Space(vec4(dot(at.x_axis, to_x), dot(at.y_axis, to_x), dot(at.z_axis, to_x), dot(at.origin, to_x)),
               vec4(dot(at.x_axis, to_y), dot(at.y_axis, to_y), dot(at.z_axis, to_y), dot(at.origin, to_y)),
               vec4(dot(at.x_axis, params.forward.xyz), dot(at.y_axis, params.forward.xyz),
                    dot(at.z_axis, params.forward.xyz), dot(at.origin, params.forward.xyz)));
}
Space stage_space() { return space_of(Placed(-params.position.xyz, vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1))); }

// Whether a ray of the group's pixels may meet a box; never false where one does.
bool touches_group(Space space, vec3 low, vec3 high) {
  vec4 middle = vec4(0.5 * (low + high), 1.0);
  vec3 half_size = 0.5 * (high - low);
  // What float may lose of each sum of products.
  vec4 slack = 1e-6 * abs(middle) + vec4(half_size * 1.00001, 0.0);
  float middle_depth = dot(space.depth, middle);
  float depth = middle_depth + dot(abs(space.depth), slack);
  vec2 low_px = vec2(float(group_margins[0]), float(group_margins[1])) - (kHalfTile + 0.01);
  vec2 high_px = kHalfTile + 0.01 - vec2(float(group_margins[2]), float(group_margins[3]));
  vec2 at = vec2(dot(space.x, middle), dot(space.y, middle));
  vec2 reach = vec2(dot(abs(space.x), slack), dot(abs(space.y), slack)) + kHalfTile * (depth - middle_depth);
  return depth > 0.0 && all(lessThanEqual(low_px * middle_depth, at + reach)) &&
         all(lessThanEqual(at - reach, high_px * middle_depth));
}

uint box_face_id(uint box, vec3 normal) {
  uint axis = normal.x != 0.0 ? 0u : normal.y != 0.0 ? 1u : 2u;
  return FL_BOX_ID | box << 3 | axis << 1 | (normal[axis] > 0.0 ? 1u : 0u);
}

shared uint box_bits[FL_THREADS / 32];  // of the boxes that a round tests: those that the tile may show

void sample_box(uint b) {
  [[unroll]] for (uint i = 0u; i < FL_OWN; ++i) {
    vec3 ray = ray_at(sample_place[i]);
    vec3 inverse = 1.0 / mix(ray, vec3(1e-12), lessThan(abs(ray), vec3(1e-12)));
    vec3 to_low = (boxes[b].low.xyz - params.position.xyz) * inverse;
    vec3 to_high = (boxes[b].high.xyz - params.position.xyz) * inverse;
    vec3 in_m = min(to_low, to_high);
    vec3 out_m = max(to_low, to_high);
    float enter_m = max(in_m.x, max(in_m.y, in_m.z));
    float leave_m = min(out_m.x, min(out_m.y, out_m.z));
    if (!(enter_m > 0.0 && enter_m <= leave_m && enter_m < uintBitsToFloat(sample_depth[i]))) continue;
    vec3 face = in_m.x >= enter_m ? vec3(1, 0, 0) : in_m.y >= enter_m ? vec3(0, 1, 0) : vec3(0, 0, 1);
    vec3 normal = -sign(ray) * face;
    sample_depth[i] = floatBitsToUint(enter_m);
    sample_id[i] = box_face_id(b, normal);
    sample_normal[i] = pack_normal(normal);
  }
}

void sample_boxes() {
  Space space = stage_space();
  for (uint first = 0u; first < params.box_count; first += FL_THREADS) {
    barrier();  // the bits of the round before have been read
    if (gl_LocalInvocationIndex < FL_THREADS / 32) box_bits[gl_LocalInvocationIndex] = 0u;
    barrier();
    uint own = first + gl_LocalInvocationIndex;
    if (own < params.box_count && touches_group(space, boxes[own].low.xyz, boxes[own].high.xyz)) {
      atomicOr(box_bits[gl_LocalInvocationIndex / 32u], 1u << (gl_LocalInvocationIndex % 32u));
    }
    barrier();
    for (uint word = 0u; word < FL_THREADS / 32; ++word) {
      for (uint bits = box_bits[word]; bits != 0u; bits &= bits - 1u) {
        sample_box(first + word * 32u + uint(findLSB(bits)));
      }
    }
  }
}

// Bodies are drawn a few at a time: a space for each number of joints of each, and one for the scene's objects.
#define FL_ROUND_BODIES 7
#define FL_SPACES (4 * FL_ROUND_BODIES + 1)
#define FL_OBJECTS_SPACE (4 * FL_ROUND_BODIES)
shared Space spaces[FL_SPACES];
shared uvec2 space_mesh[FL_SPACES];               // first vertex; added to the parts of vertices
shared uint shows[FL_THREADS];  // of each pixel of the group: a bit for each body that it or a neighbour shows
// Nodes of trees, with the number of their space in the low bits.
#define FL_SPACE_BITS 5
#define FL_STACK 1024
#define FL_STACK_SPARE 72  // nodes below each other, at most
#define FL_LEAVES (FL_THREADS / 4)
shared uint stack[FL_STACK];
shared uint stack_size;
shared uint leaves[FL_THREADS + FL_LEAVES];
shared uint leaf_count;

precise vec3 crossed(vec3 a, vec3 b) {
  precise vec3 c = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
  return c;
}
precise vec3 place_in(Space space, BodyVertexRow v) {
  vec4 p = vec4(v.x, v.y, v.z, 1.0);
  precise vec3 place = vec3(dot(space.x, p), dot(space.y, p), dot(space.depth, p));
  return place;
}
vec3 turned_in(Space space, vec3 v) {
  return vec3(dot(space.x.xyz, v), dot(space.y.xyz, v), dot(space.depth.xyz, v));
}

// In homogeneous coordinates (x depth, y depth, depth) a triangle is three half spaces through the eye, so that none
// need be cut at the eye's plane. Two triangles with a common edge find the same numbers for it but for their sign.
// In bits, so that a thread reads 16 bytes at a time.
shared uvec4 side_a[FL_THREADS];  // w: six times the volume between the eye and the triangle
shared uvec4 side_b[FL_THREADS];  // w: identity
shared uvec4 side_c[FL_THREADS];  // w: packed normal
shared uint triangle_count;
// Of each pixel of the group: a bit for each triangle that may touch it.
#define FL_TOUCH_WORDS (FL_THREADS / 32)
shared uint touching[FL_THREADS * FL_TOUCH_WORDS];

// Whether a triangle may touch the rectangle round a place.
bool touches_rectangle(vec3 a, vec3 b, vec3 c, vec2 place, vec2 half_size) {
  vec3 middle = vec3(place, 1.0);
  vec3 most = vec3(dot(a, middle), dot(b, middle), dot(c, middle)) + half_size.x * abs(vec3(a.x, b.x, c.x)) +
              half_size.y * abs(vec3(a.y, b.y, c.y));
  return min(most.x, min(most.y, most.z)) >= 0.0;
}

void place_triangle(uint number, uint triangle) {
  Space space = spaces[number];
  uvec2 mesh = space_mesh[number];
  BodyVertexRow a = vertices[mesh.x + indices[3u * triangle]];
  BodyVertexRow b = vertices[mesh.x + indices[3u * triangle + 1u]];
  BodyVertexRow c = vertices[mesh.x + indices[3u * triangle + 2u]];
  vec3 pa = place_in(space, a);
  vec3 pb = place_in(space, b);
  vec3 pc = place_in(space, c);
  vec2 low = vec2(float(group_margins[0]), float(group_margins[1]));
  vec2 high = float(FL_TILE_PX - 1) - vec2(float(group_margins[2]), float(group_margins[3]));
  if (min(pa.z, min(pb.z, pc.z)) > params.right.w) {
    vec2 at_a = pa.xy / pa.z;
    vec2 at_b = pb.xy / pb.z;
    vec2 at_c = pc.xy / pc.z;
    // Samples are within half a pixel of a pixel's middle.
    low = max(low, floor(min(at_a, min(at_b, at_c)) + (kHalfTile - 0.01)));
    high = min(high, floor(max(at_a, max(at_b, at_c)) + (kHalfTile + 0.01)));
  }
  vec3 a_side = crossed(pb, pc);
  float volume = dot(pa, a_side);
  if (!(abs(volume) > 0.0 && all(lessThanEqual(low, high)))) return;
  float turn = volume < 0.0 ? -1.0 : 1.0;
  // A plane's normal is turned by the transpose of what turns its places; towards the camera.
  vec3 face = -turn * cross(turned_in(space, vec3(b.x - a.x, b.y - a.y, b.z - a.z)),
                            turned_in(space, vec3(c.x - a.x, c.y - a.y, c.z - a.z)));
  vec3 a_out = a_side * turn;
  vec3 b_out = crossed(pc, pa) * turn;
  vec3 c_out = crossed(pa, pb) * turn;
  uint at = FL_NONE;
  for (float y = low.y; y <= high.y; ++y) {
    for (float x = low.x; x <= high.x; ++x) {
      uint k = group_numbers[uint(y) * uint(FL_TILE_PX) + uint(x)];
      if (k == FL_NONE || (shows[k] >> (number / 4u) & 1u) == 0u) continue;
      if (!touches_rectangle(a_out, b_out, c_out, vec2(x, y) + (0.5 - kHalfTile), vec2(0.501))) continue;
      if (at == FL_NONE) at = atomicAdd(triangle_count, 1u);
      atomicOr(touching[k * FL_TOUCH_WORDS + at / 32u], 1u << (at % 32u));
    }
  }
  if (at == FL_NONE) return;
  vec3 normal = normalize(to_x * face.x + to_y * face.y + params.forward.xyz * face.z);
  side_a[at] = uvec4(floatBitsToUint(a_out), floatBitsToUint(volume * turn));
  uint part = kSheen && (a.part & FL_OBJECT) == 0u ? a.part & 7u : a.part;
  side_b[at] = uvec4(floatBitsToUint(b_out), object_identity(mesh.y + part));
  side_c[at] = uvec4(floatBitsToUint(c_out), pack_normal(normal));
}

void sample_triangle(uint t) {
  uvec4 row_a = side_a[t];
  uvec4 row_b = side_b[t];
  uvec4 row_c = side_c[t];
  vec3 a = uintBitsToFloat(row_a.xyz);
  vec3 b = uintBitsToFloat(row_b.xyz);
  vec3 c = uintBitsToFloat(row_c.xyz);
  if (kThreadsPerPixel > 1u && !touches_rectangle(a, b, c, own_middle, own_half * 1.001)) return;
  float volume = uintBitsToFloat(row_a.w);
  uvec2 id = uvec2(row_b.w, row_c.w);
  [[unroll]] for (uint i = 0u; i < FL_OWN; ++i) {
    vec3 place = vec3(sample_place[i], 1.0);
    precise vec3 inside = vec3(dot(a, place), dot(b, place), dot(c, place));
    float depth_m = volume / (inside.x + inside.y + inside.z);
    uint depth = floatBitsToUint(depth_m);
    bool hit = min(inside.x, min(inside.y, inside.z)) >= 0.0 && depth_m > params.right.w;
    bool first = id.x < sample_id[i] || (id.x == sample_id[i] && id.y < sample_normal[i]);
    hit = hit && (depth < sample_depth[i] || (depth == sample_depth[i] && first));
    sample_depth[i] = hit ? depth : sample_depth[i];
    sample_id[i] = hit ? id.x : sample_id[i];
    sample_normal[i] = hit ? id.y : sample_normal[i];
  }
}

// With no more leaves than a quarter of the threads. k: the pixel whose samples this thread has, or FL_NONE.
void draw_leaves(uint first, uint count, uint k) {
  if (gl_LocalInvocationIndex == 0u) triangle_count = 0u;
  for (uint i = gl_LocalInvocationIndex; i < kGroup * FL_TOUCH_WORDS; i += FL_THREADS) touching[i] = 0u;
  barrier();
  if (gl_LocalInvocationIndex / 4u < count) {
    uint entry = leaves[first + gl_LocalInvocationIndex / 4u];
    uint leaf = trees[entry >> FL_SPACE_BITS].leaf;
    uint t = gl_LocalInvocationIndex % 4u;
    if (t < (leaf & ((1u << FL_TREE_COUNT_BITS) - 1u))) {
      place_triangle(entry & ((1u << FL_SPACE_BITS) - 1u), (leaf >> FL_TREE_COUNT_BITS) + t);
    }
  }
  barrier();
  uint words = k == FL_NONE ? 0u : (triangle_count + 31u) / 32u;
  for (uint word = 0u; word < words; ++word) {
    for (uint bits = touching[k * FL_TOUCH_WORDS + word]; bits != 0u; bits &= bits - 1u) {
      sample_triangle(word * 32u + uint(findLSB(bits)));
    }
  }
}

void visit(uint entry) {
  uint number = entry & ((1u << FL_SPACE_BITS) - 1u);
  uint n = entry >> FL_SPACE_BITS;
  TreeRow node = trees[n];
  if (!touches_group(spaces[number], vec3(node.low_x, node.low_y, node.low_z),
                    vec3(node.high_x, node.high_y, node.high_z))) {
    return;
  }
  if (node.leaf != 0u) {
    leaves[atomicAdd(leaf_count, 1u)] = entry;
  } else {
    uint at = atomicAdd(stack_size, 2u);
    stack[at] = n + 1u << FL_SPACE_BITS | number;
    stack[at + 1u] = trees[n + 1u].skip << FL_SPACE_BITS | number;
  }
}

// Draws all triangles below the nodes of the stack that touch the group's pixels. k: as for draw_leaves.
void walk(uint k) {
  for (;;) {
    barrier();
    uint size = stack_size;
    uint found = leaf_count;
    barrier();  // all have read them
    if (size == 0u && found == 0u) break;
    if (size == 0u || found >= FL_LEAVES) {
      uint count = min(found, uint(FL_LEAVES));
      draw_leaves(found - count, count, k);
      if (gl_LocalInvocationIndex == 0u) leaf_count = found - count;
    } else {
      // Each node may leave one more than it was. With one at a time there are never more than are below each other.
      uint room = uint(FL_STACK) - size;
      uint count = room > uint(FL_STACK_SPARE) ? min(min(size, uint(FL_THREADS)), room - uint(FL_STACK_SPARE)) : 1u;
      uint entry = gl_LocalInvocationIndex < count ? stack[size - count + gl_LocalInvocationIndex] : 0u;
      barrier();
      if (gl_LocalInvocationIndex == 0u) stack_size = size - count;
      barrier();
      if (gl_LocalInvocationIndex < count) visit(entry);
    }
  }
}

void add_root(uint number, uint root, uint vertex_first, uint id, Placed at) {
  spaces[number] = space_of(at);
  space_mesh[number] = uvec2(vertex_first, id);
  stack[atomicAdd(stack_size, 1u)] = root << FL_SPACE_BITS | number;
}

// The space of so many joints of one body.
void add_body(uint number, uint head, uint joints) {
  uint choice = choices[head_slots[head]];
  BodyLevelRow level = levels[choice & FL_CHOICE_LEVEL];
  if (level.trees[joints] == FL_NONE) return;
  HeadRow row = heads[head];
  Placed at = place(row, types[row.type], states[head], joints);
  float volume = dot(at.x_axis, cross(at.y_axis, at.z_axis));
  if (abs(volume) > 0.0) add_root(number, level.trees[joints], level.vertex_first, 1u + (head << 3), at);
}

void add_objects() {
  if (params.object_level == FL_NONE) return;
  BodyLevelRow level = levels[params.object_level];
  add_root(FL_OBJECTS_SPACE, level.trees[0], level.vertex_first, 0u,
           Placed(-params.position.xyz, vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)));
}
