// Triangles of bodies and objects in the picture, for compute shaders: where they are, which pixels they cover, and
// what is drawn of them. FL_DRAWS_EDGES: the samples of pixels with an edge; else what pixels show at their middle.
// After bodies.glsl.
layout(set = 0, binding = FL_BINDING_BODY_VERTICES, std430) readonly buffer VerticesBuffer {
  BodyVertexRow vertices[];
};
layout(set = 0, binding = FL_BINDING_BODY_INDICES, std430) readonly buffer IndicesBuffer { uint indices[]; };
// The rows of the picture that are drawn.
#ifdef FL_DRAWS_EDGES
layout(set = 0, binding = FL_BINDING_EDGE_PARTS, std430) buffer EdgePartsBuffer { EdgePartRow edge_parts[]; };
layout(push_constant) uniform PartPush { uint part; };
int first_row() { return edge_parts[part].first; }
int end_row() { return edge_parts[part].end; }
#else
int first_row() { return 0; }
int end_row() { return int(params.height); }
#endif

const float kSubpixels = 256.0;
const int kSmallExtent = 32000;  // the longest side, so that side() fits into 32 bits within a pixel of the triangle
const float kFarthestPx = 65536.0;  // from the picture's corner: farther places are not exact in float

// As BodySpaceRow: of the body whose triangles the workgroup draws; of objects the first three.
shared vec4 to_picture[12];
shared uint away;  // as BodySpaceRow
layout(set = 0, binding = FL_BINDING_BODY_SPACES, std430) readonly buffer SpacesBuffer { BodySpaceRow spaces[]; };

// With all threads, and a barrier after it. slot: FL_NONE for objects. Of objects both sides are drawn, unless thread 0
// sets `away` before the barrier.
void begin_space(uint slot) {
  uint i = gl_LocalInvocationIndex;
  if (i == 0u) away = slot == FL_NONE ? 0u : spaces[slot].away;
  if (slot == FL_NONE) {
    mat3x4 space = space_of(stage_space());
    if (i < 3u) to_picture[i] = space[i];
  } else if (i < 12u) {
    to_picture[i] = spaces[slot].to_picture[i];
  }
}

// A triangle in the picture: corners in 1/256 of a pixel; the pixels that it may cover; its depths at the corners,
// which are linear in the picture. One that reaches behind the camera is `open`, and has no such corners.
struct Triangle {
  vec3 h0;  // x times w, y times w, w
  vec3 h1;
  vec3 h2;
  ivec2 p0;
  ivec2 p1;
  ivec2 p2;
  ivec2 low;
  ivec2 high;
  int extent;  // longest side of the box round it, in 1/256 of a pixel
  bool open;
  vec3 z;
  uint part;  // of its first corner
};

// All that draw the same triangle must find the same numbers.
float exact_row(vec4 row, BodyVertexRow v) {
  precise float sum = row.x * v.x + row.y * v.y + row.z * v.z + row.w;
  return sum;
}
vec3 homogeneous(BodyVertexRow v) {
  uint first = (v.part & FL_OBJECT) != 0u ? 0u : 3u * (v.part & uint(FL_PART_DEPTH));
  return vec3(exact_row(to_picture[first], v), exact_row(to_picture[first + 1u], v),
              exact_row(to_picture[first + 2u], v));
}
vec3 picture_of(vec3 h) {
  precise float x = h.x / h.z + 0.5 * float(params.width);
  precise float y = h.y / h.z + 0.5 * float(params.height);
  return vec3(x, y, params.right.w / h.z);
}

// Whether all corners are on one side of the picture, or behind its near plane.
bool is_outside(vec3 a, vec3 b, vec3 c) {
  vec3 w = vec3(a.z, b.z, c.z);
  vec3 x = vec3(a.x, b.x, c.x);
  vec3 y = vec3(a.y, b.y, c.y);
  vec2 half_px = 0.5 * vec2(float(params.width), float(params.height)) + 1.0;
  return all(lessThanEqual(w, vec3(params.right.w))) || all(lessThan(x, -half_px.x * w)) ||
         all(greaterThan(x, half_px.x * w)) || all(lessThan(y, -half_px.y * w)) || all(greaterThan(y, half_px.y * w));
}

Triangle triangle_of(BodyLevelRow level, uint t) {
  uint first = level.index_first + 3u * t;
  BodyVertexRow v0 = vertices[level.vertex_first + indices[first]];
  Triangle it;
  it.part = v0.part;
  it.h0 = homogeneous(v0);
  it.h1 = homogeneous(vertices[level.vertex_first + indices[first + 1u]]);
  it.h2 = homogeneous(vertices[level.vertex_first + indices[first + 2u]]);
  vec3 a = picture_of(it.h0);
  vec3 b = picture_of(it.h1);
  vec3 c = picture_of(it.h2);
  it.p0 = ivec2(roundEven(a.xy * kSubpixels));
  it.p1 = ivec2(roundEven(b.xy * kSubpixels));
  it.p2 = ivec2(roundEven(c.xy * kSubpixels));
  it.z = vec3(a.z, b.z, c.z);
  ivec2 low = min(it.p0, min(it.p1, it.p2));
  ivec2 high = max(it.p0, max(it.p1, it.p2));
  it.extent = max(high.x - low.x, high.y - low.y);
  vec2 most = max(abs(a.xy), max(abs(b.xy), abs(c.xy)));
  it.open = !(min(it.h0.z, min(it.h1.z, it.h2.z)) > params.right.w && max(most.x, most.y) < kFarthestPx);
#ifdef FL_DRAWS_EDGES
  low = low >> 8;
  high = high >> 8;
#else
  low = (low + 127) >> 8;
  high = (high - 128) >> 8;
#endif
  ivec2 least = ivec2(0, first_row());
  ivec2 last = ivec2(int(params.width), end_row()) - 1;
  it.low = it.open ? least : max(low, least);
  it.high = it.open ? last : min(high, last);
  if (it.open && is_outside(it.h0, it.h1, it.h2)) it.high = it.low - 1;
  return it;
}

// Twice the area of (a, a + d, p), where it fits into 32 bits.
int side(ivec2 a, ivec2 d, ivec2 p) { return d.x * (p.y - a.y) - d.y * (p.x - a.x); }
// The same in 64 bits, high word first, for corners up to kFarthestPx.
ivec2 wide_side(ivec2 a, ivec2 d, ivec2 p) {
  int high_x, low_x, high_y, low_y;
  imulExtended(d.x, p.y - a.y, high_x, low_x);
  imulExtended(d.y, p.x - a.x, high_y, low_y);
  uint borrow;
  uint low = usubBorrow(uint(low_x), uint(low_y), borrow);
  return ivec2(high_x - high_y - int(borrow), int(low));
}
// From the amount, since the low word of a small negative number is nearly 2^32.
float wide_float(ivec2 v) {
  uvec2 amount = uvec2(v);
  if (v.x < 0) amount = uvec2(~amount.x + (amount.y == 0u ? 1u : 0u), ~amount.y + 1u);
  float size = float(amount.x) * 4294967296.0 + float(amount.y);
  return v.x < 0 ? -size : size;
}

// Whether a triangle of a closed shell shows only its inner side, or nothing. By the exact area in the picture: then
// what such triangles cover is covered by others of their shell that do not face away.
bool faces_away(BodyLevelRow level, uint t, Triangle it) {
  if (t >= level.closed_count || it.open) return false;
  uint way = away >> ((it.part & FL_OBJECT) != 0u ? 0u : 2u * (it.part & uint(FL_PART_DEPTH))) & 3u;
  if (way == 0u) return false;
  ivec2 area = ivec2(0, side(it.p0, it.p1 - it.p0, it.p2));
  if (it.extent > kSmallExtent) area = wide_side(it.p0, it.p1 - it.p0, it.p2);
  else area.x = area.y < 0 ? -1 : 0;
  bool positive = (way == FL_AWAY_POSITIVE) == (t < level.outward_count);
  return area == ivec2(0) || (area.x >= 0) == positive;
}

// Three numbers that are linear in the picture, all 0 or more in the triangle, and whose weighted sum is the depth
// there: at the middle of the pixel `origin`, and what they change by a pixel. NaN: it covers nothing.
struct Sides {
  ivec2 origin;
  float turn;  // -1: the corners turn the other way
  vec3 at_origin;
  vec3 by_x;
  vec3 by_y;
  vec3 depth;
};

vec3 crossed(vec3 a, vec3 b) {
  precise vec3 c = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
  return c;
}

// In homogeneous coordinates a triangle is three half spaces through the eye, so that none need be cut at the eye's
// plane. Its corners are not those in 1/256 of a pixel of its neighbours, so it is widened by as much.
Sides open_sides(Triangle it, ivec2 origin) {
  vec2 from = vec2(origin) + 0.5 - 0.5 * vec2(float(params.width), float(params.height));
  precise vec2 a_xy = it.h0.xy - from * it.h0.z;
  precise vec2 b_xy = it.h1.xy - from * it.h1.z;
  precise vec2 c_xy = it.h2.xy - from * it.h2.z;
  vec3 a = vec3(a_xy, it.h0.z);
  vec3 b = vec3(b_xy, it.h1.z);
  vec3 c = vec3(c_xy, it.h2.z);
  vec3 a_out = crossed(b, c);
  vec3 b_out = crossed(c, a);
  vec3 c_out = crossed(a, b);
  float volume = exact_dot(a, a_out);
  float turn = volume < 0.0 ? -1.0 : 1.0;
  Sides s;
  s.origin = origin;
  s.turn = turn;
  s.by_x = turn * vec3(a_out.x, b_out.x, c_out.x);
  s.by_y = turn * vec3(a_out.y, b_out.y, c_out.y);
  precise vec3 at_origin = turn * vec3(a_out.z, b_out.z, c_out.z) + (abs(s.by_x) + abs(s.by_y)) / 256.0;
  s.at_origin = at_origin;
  s.depth = vec3(params.right.w / abs(volume));
  return s;
}
// The same at the middle of a pixel, from the corners.
vec3 sides_at(ivec2 p0, ivec2 p1, ivec2 p2, float turn, ivec2 pixel) {
  ivec2 p = (pixel << 8) + 128;
  return turn * vec3(wide_float(wide_side(p1, p2 - p1, p)), wide_float(wide_side(p2, p0 - p2, p)),
                     wide_float(wide_side(p0, p1 - p0, p)));
}
Sides sides_of(Triangle it, ivec2 origin) {
  if (it.open) return open_sides(it, origin);
  ivec2 d0 = it.p2 - it.p1;
  ivec2 d1 = it.p0 - it.p2;
  ivec2 d2 = it.p1 - it.p0;
  float area = wide_float(wide_side(it.p0, d2, it.p2));
  float turn = area < 0.0 ? -1.0 : 1.0;
  Sides s;
  s.origin = origin;
  s.turn = turn;
  s.at_origin = sides_at(it.p0, it.p1, it.p2, turn, origin);
  s.by_x = (-turn * kSubpixels) * vec3(float(d0.y), float(d1.y), float(d2.y));
  s.by_y = (turn * kSubpixels) * vec3(float(d0.x), float(d1.x), float(d2.x));
  s.depth = it.z / abs(area);
  return s;
}

// The columns of a row in which a triangle may cover a sample; the last is below the first where there are none.
ivec2 columns_of(Sides s, int y) {
  vec3 e = s.at_origin + float(y - s.origin.y) * s.by_y + 0.51 * (abs(s.by_x) + abs(s.by_y));
  vec2 ends = vec2(-1e6, 1e6);
  for (uint k = 0u; k < 3u; ++k) {
    float end = -e[k] / s.by_x[k];
    if (s.by_x[k] > 0.0) ends.x = max(ends.x, end);
    else if (s.by_x[k] < 0.0) ends.y = min(ends.y, end);
    else if (!(e[k] >= 0.0)) ends.y = -2e6;
  }
  ends = clamp(ends, vec2(-2e6), vec2(2e6));
  return s.origin.x + ivec2(int(floor(ends.x)) - 1, int(ceil(ends.y)) + 1);
}

// Parts of a triangle, which threads share out: what a row of pixels has in one strip of columns. Strips are as wide as
// the picture's blocks where rows are enough for all threads, so that few parts are empty.
struct TriangleParts {
  ivec2 low;
  ivec2 high;
  int width;   // of a strip
  int strips;
  int count;
};
TriangleParts parts_of(ivec2 low, ivec2 high) {
  int rows = high.y - low.y + 1;
  int width = rows < FL_THREADS ? FL_TILE_PX : FL_BLOCK_PX;
  int strips = high.x / width - low.x / width + 1;
  return TriangleParts(low, high, width, strips, strips * rows);
}
// The first and the last column of a part that the triangle may reach, the last below the first where there are none;
// and its row.
ivec3 part_pixels(TriangleParts parts, Sides s, int i) {
  int row = parts.strips == 1 ? i : i / parts.strips;
  int strip = (parts.low.x / parts.width + i - row * parts.strips) * parts.width;
  ivec2 ends = ivec2(max(parts.low.x, strip), min(parts.high.x, strip + parts.width - 1));
  int y = parts.low.y + row;
  if (ends.y - ends.x >= 4) {  // of a few a test of each pixel is quicker
    ivec2 columns = columns_of(s, y);
    ends = ivec2(max(ends.x, columns.x), min(ends.y, columns.y));
  }
  return ivec3(ends, y);
}
