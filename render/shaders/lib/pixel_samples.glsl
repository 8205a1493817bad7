// What a pixel shows at kSamples places: cuts their rays with boxes and with the trees of triangles. After bodies.glsl
// and surface.glsl.
layout(constant_id = FL_SPEC_EDGE_SAMPLES) const uint kSamples = FL_EDGE_SAMPLES_MAX;
layout(set = 0, binding = FL_BINDING_BODY_VERTICES, std430) readonly buffer VerticesBuffer {
  BodyVertexRow vertices[];
};
layout(set = 0, binding = FL_BINDING_BODY_INDICES, std430) readonly buffer IndicesBuffer { uint indices[]; };
layout(set = 0, binding = FL_BINDING_BODY_TREES, std430) readonly buffer TreesBuffer { TreeRow trees[]; };

// The identity of a surface: as in the visibility buffer, and of a box this bit, its number << 3 and its face.
#define FL_BOX_ID 0x40000000u

// Loops over the samples are unrolled, so that these arrays are in registers: on an H100 the edges of 1,000 bodies at
// 3840 x 2160 take 5.1 ms, 10.5 without.
// Of each sample: depth along the camera's axis, m; identity; packed normal of the triangle or face.
float sample_depth_m[FL_EDGE_SAMPLES_MAX];
uint sample_id[FL_EDGE_SAMPLES_MAX];
uint sample_normal[FL_EDGE_SAMPLES_MAX];
float samples_end_m;  // the largest depth of a sample

// The pixel's middle and its sides: rays of depth 1, and what they change by a pixel.
vec3 middle_ray;
vec3 ray_right;
vec3 ray_down;
// Rows that take a place from the camera to (x, y) times depth and to depth; x and y in pixels from the pixel's middle.
vec3 to_x;
vec3 to_y;

// From the pixel's middle, in pixels: the points of Hammersley, whose rows and columns all have one.
vec2 sample_place(uint i) {
  uint bits = uint(findMSB(kSamples));
  return (vec2(float(i), float(bitfieldReverse(i) >> (32u - bits))) + 0.5) / float(kSamples) - 0.5;
}
vec3 sample_ray(uint i) {
  vec2 place = sample_place(i);
  return middle_ray + place.x * ray_right + place.y * ray_down;
}

void begin_samples(uvec2 pixel) {
  vec2 size = vec2(float(params.width), float(params.height));
  middle_ray = ray_through(vec2(pixel) + 0.5);
  ray_right = params.right.xyz * (2.0 / size.x);
  ray_down = params.up.xyz * (-2.0 / size.y);
  vec3 across = params.right.xyz / dot(params.right.xyz, params.right.xyz);
  vec3 up = params.up.xyz / dot(params.up.xyz, params.up.xyz);
  vec2 ndc = vec2(2.0, -2.0) * (vec2(pixel) + 0.5) / size + vec2(-1.0, 1.0);
  to_x = (across - params.forward.xyz * ndc.x) * (0.5 * size.x);
  to_y = (params.forward.xyz * ndc.y - up) * (0.5 * size.y);
  [[unroll]] for (uint i = 0u; i < kSamples; ++i) {
    sample_depth_m[i] = FL_FAR_M;
    sample_id[i] = 0u;
    sample_normal[i] = 0u;
  }
  samples_end_m = FL_FAR_M;
}

// The rays of a pixel in some space: they start at `from`, and those of depth 1 end between `low` and `high`.
struct Bundle {
  vec3 from;
  vec3 low;
  vec3 high;
};
Bundle bundle_of(vec3 from, vec3 ray, vec3 right, vec3 down) {
  vec3 reach = 0.5 * (abs(right) + abs(down)) + 1e-6 * abs(ray) + 1e-12;
  return Bundle(from, ray - reach, ray + reach);
}
// Whether a ray may meet a box before samples_end_m; never false where one does.
bool touches_box(Bundle bundle, vec3 box_low, vec3 box_high) {
  vec3 slack = 2e-6 * (abs(bundle.from) + abs(box_low) + abs(box_high)) + 1e-6;
  // At depth t the rays are between t low and t high.
  vec3 by_high = (box_low - slack - bundle.from) / bundle.high;
  vec3 by_low = (box_high + slack - bundle.from) / bundle.low;
  vec3 enter = max(mix(vec3(0.0), by_high, greaterThan(bundle.high, vec3(0.0))),
                   mix(vec3(0.0), by_low, lessThan(bundle.low, vec3(0.0))));
  vec3 leave = min(mix(vec3(FL_FAR_M), by_high, lessThan(bundle.high, vec3(0.0))),
                   mix(vec3(FL_FAR_M), by_low, greaterThan(bundle.low, vec3(0.0))));
  // Where an interval holds 0, its bounds are far from those of a ray of 0.
  return max(enter.x, max(enter.y, enter.z)) <= min(min(leave.x, min(leave.y, leave.z)), samples_end_m) * 1.00001;
}

void find_end() {
  samples_end_m = 0.0;
  [[unroll]] for (uint i = 0u; i < kSamples; ++i) samples_end_m = max(samples_end_m, sample_depth_m[i]);
}

uint box_face_id(uint box, vec3 normal) {
  uint axis = normal.x != 0.0 ? 0u : normal.y != 0.0 ? 1u : 2u;
  return FL_BOX_ID | box << 3 | axis << 1 | (normal[axis] > 0.0 ? 1u : 0u);
}

void sample_boxes() {
  Bundle bundle = bundle_of(params.position.xyz, middle_ray, ray_right, ray_down);
  for (uint b = 0u; b < params.box_count; ++b) {
    vec3 low = boxes[b].low.xyz;
    vec3 high = boxes[b].high.xyz;
    if (!touches_box(bundle, low, high)) continue;
    [[unroll]] for (uint i = 0u; i < kSamples; ++i) {
      vec3 ray = sample_ray(i);
      vec3 inverse = 1.0 / mix(ray, vec3(1e-12), lessThan(abs(ray), vec3(1e-12)));
      vec3 to_low = (low - params.position.xyz) * inverse;
      vec3 to_high = (high - params.position.xyz) * inverse;
      vec3 in_m = min(to_low, to_high);
      vec3 out_m = max(to_low, to_high);
      float enter_m = max(in_m.x, max(in_m.y, in_m.z));
      float leave_m = min(out_m.x, min(out_m.y, out_m.z));
      if (!(enter_m > 0.0 && enter_m <= leave_m && enter_m < sample_depth_m[i])) continue;
      vec3 face = in_m.x >= enter_m ? vec3(1, 0, 0) : in_m.y >= enter_m ? vec3(0, 1, 0) : vec3(0, 0, 1);
      vec3 normal = -sign(ray) * face;
      sample_depth_m[i] = enter_m;
      sample_id[i] = box_face_id(b, normal);
      sample_normal[i] = pack_normal(normal);
    }
    find_end();
  }
}

precise vec3 crossed(vec3 a, vec3 b) {
  precise vec3 c = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
  return c;
}

// A space of vertices: its place in the picture (rows as to_x, to_y and depth), and its axes.
struct Space {
  vec4 rows[3];
  Placed at;
};
Space space_of(Placed at) {
  Space space;
  vec3 row[3] = vec3[3](to_x, to_y, params.forward.xyz);
  for (int i = 0; i < 3; ++i) {
    space.rows[i] =
        vec4(dot(at.x_axis, row[i]), dot(at.y_axis, row[i]), dot(at.z_axis, row[i]), dot(at.origin, row[i]));
  }
  space.at = at;
  return space;
}
precise vec3 place_in(Space space, BodyVertexRow v) {
  vec4 p = vec4(v.x, v.y, v.z, 1.0);
  precise vec3 place = vec3(dot(space.rows[0], p), dot(space.rows[1], p), dot(space.rows[2], p));
  return place;
}

// In homogeneous coordinates (x depth, y depth, depth) a triangle is three half spaces through the eye, so that none
// need be cut at the eye's plane. Two triangles with a common edge find the same numbers for it but for their sign.
void sample_triangle(Space space, uint vertex_first, uint triangle, uint id) {
  BodyVertexRow a = vertices[vertex_first + indices[3u * triangle]];
  BodyVertexRow b = vertices[vertex_first + indices[3u * triangle + 1u]];
  BodyVertexRow c = vertices[vertex_first + indices[3u * triangle + 2u]];
  vec3 pa = place_in(space, a);
  vec3 pb = place_in(space, b);
  vec3 pc = place_in(space, c);
  vec3 side_a = crossed(pb, pc);
  vec3 side_b = crossed(pc, pa);
  vec3 side_c = crossed(pa, pb);
  float volume = dot(pa, side_a);
  if (volume < 0.0) {
    side_a = -side_a;
    side_b = -side_b;
    side_c = -side_c;
    volume = -volume;
  }
  vec3 most = vec3(side_a.z, side_b.z, side_c.z) + 0.5 * (abs(vec3(side_a.x, side_b.x, side_c.x)) +
                                                          abs(vec3(side_a.y, side_b.y, side_c.y)));
  if (!(volume > 0.0 && min(most.x, min(most.y, most.z)) >= 0.0)) return;
  vec3 to_b = vec3(b.x - a.x, b.y - a.y, b.z - a.z);
  vec3 to_c = vec3(c.x - a.x, c.y - a.y, c.z - a.z);
  vec3 face = cross(space.at.x_axis * to_b.x + space.at.y_axis * to_b.y + space.at.z_axis * to_b.z,
                    space.at.x_axis * to_c.x + space.at.y_axis * to_c.y + space.at.z_axis * to_c.z);
  face = normalize(face);
  if (dot(face, middle_ray) > 0.0) face = -face;
  uint normal = pack_normal(face);
  [[unroll]] for (uint i = 0u; i < kSamples; ++i) {
    vec3 place = vec3(sample_place(i), 1.0);
    precise vec3 inside = vec3(dot(side_a, place), dot(side_b, place), dot(side_c, place));
    float depth_m = volume / (inside.x + inside.y + inside.z);
    bool hit = min(inside.x, min(inside.y, inside.z)) >= 0.0 && depth_m > params.right.w && depth_m < sample_depth_m[i];
    sample_depth_m[i] = hit ? depth_m : sample_depth_m[i];
    sample_id[i] = hit ? id + a.part : sample_id[i];
    sample_normal[i] = hit ? normal : sample_normal[i];
  }
  find_end();
}

// id: added to the parts of vertices.
void sample_tree(Placed at, uint root, uint vertex_first, uint id) {
  vec3 yz = cross(at.y_axis, at.z_axis);
  vec3 zx = cross(at.z_axis, at.x_axis);
  vec3 xy = cross(at.x_axis, at.y_axis);
  float volume = dot(at.x_axis, yz);
  if (!(abs(volume) > 0.0)) return;
  mat3 inverse = transpose(mat3(yz, zx, xy)) / volume;
  Bundle bundle = bundle_of(-(inverse * at.origin), inverse * middle_ray, inverse * ray_right, inverse * ray_down);
  Space space = space_of(at);
  uint end = trees[root].skip;
  for (uint n = root; n < end;) {
    TreeRow node = trees[n];
    bool touches = touches_box(bundle, vec3(node.low_x, node.low_y, node.low_z),
                               vec3(node.high_x, node.high_y, node.high_z));
    uint first = node.leaf >> FL_TREE_COUNT_BITS;
    uint count = touches ? node.leaf & ((1u << FL_TREE_COUNT_BITS) - 1u) : 0u;
    for (uint t = 0u; t < count; ++t) sample_triangle(space, vertex_first, first + t, id);
    n = touches ? n + 1u : node.skip;
  }
}

void sample_objects() {
  if (params.object_level == FL_NONE) return;
  Placed at = Placed(-params.position.xyz, vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1));
  BodyLevelRow level = levels[params.object_level];
  sample_tree(at, level.trees[0], level.vertex_first, 0u);
}

void sample_body(uint head, uint slot, uint choice) {
  BodyLevelRow level = levels[choice & FL_CHOICE_LEVEL];
  HeadRow row = heads[head];
  TypeRow type = types[row.type];
  HeadState state = states[head];
  for (uint joints = 0u; joints < 4u; ++joints) {
    if (level.trees[joints] == FL_NONE) continue;
    sample_tree(place(row, type, state, joints), level.trees[joints], level.vertex_first, 1u + (head << 3));
  }
}
