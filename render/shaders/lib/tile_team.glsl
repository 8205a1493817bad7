// Teams: kTeam lanes of a subgroup that compute one beam at 4 x 4 Chebyshev nodes of a rectangle. A lane has kPer
// nodes. Node n is at column n & 3 and row n >> 2; lane l has nodes l, l + kTeam, ... After tile_list.glsl.
//
// All functions are called by all lanes of a subgroup together; each team gets its own result.
layout(constant_id = FL_SPEC_TEAM) const uint kTeam = 16;  // 16, or the size of a smaller subgroup: 4 or 8
const uint kPer = 16u / kTeam;
const uint kTeams = uint(FL_GROUP_TILE) / kTeam;
#define FL_LANE_NODES(k) [[unroll]] for (uint k = 0u; k < kPer; ++k)

uint team_lane() { return gl_SubgroupInvocationID & (kTeam - 1u); }
uint team_number() { return thread_number() / kTeam; }
uvec2 node_place(uint k) {
  uint node = team_lane() + kTeam * k;
  return uvec2(node & 3u, node >> 2);
}
// Where the node is, from -1 to 1.
vec2 node_position(uint k) {
  const float kAt[4] = float[4](0.92387953, 0.38268343, -0.38268343, -0.92387953);
  uvec2 place = node_place(k);
  return vec2(kAt[place.x], kAt[place.y]);
}

float team_first(float v) { return subgroupShuffle(v, gl_SubgroupInvocationID & ~(kTeam - 1u)); }
float team_min(float v) {
  [[unroll]] for (uint w = kTeam >> 1; w > 0u; w >>= 1) v = min(v, subgroupShuffleXor(v, w));
  return v;
}
float team_max(float v) { return -team_min(-v); }
uint team_and(uint v) {
  [[unroll]] for (uint w = kTeam >> 1; w > 0u; w >>= 1) v &= subgroupShuffleXor(v, w);
  return v;
}
// Two sums for little more than the shuffles of one: in the first step each half of the team takes one of them.
vec2 team_sum(vec2 v) {
  const uint kHalf = kTeam >> 1;
  bool high = (team_lane() & kHalf) != 0u;
  float sum = (high ? v.y : v.x) + subgroupShuffleXor(high ? v.x : v.y, kHalf);
  [[unroll]] for (uint w = kHalf >> 1; w > 0u; w >>= 1) sum += subgroupShuffleXor(sum, w);
  float other = subgroupShuffleXor(sum, kHalf);
  return high ? vec2(other, sum) : vec2(sum, other);
}
vec4 team_sum(vec4 v) {
  const uint kHalf = kTeam >> 1;
  const uint kQuarter = kTeam >> 2;
  bool high = (team_lane() & kHalf) != 0u;
  vec2 keep = high ? v.zw : v.xy;
  vec2 give = high ? v.xy : v.zw;
  keep += vec2(subgroupShuffleXor(give.x, kHalf), subgroupShuffleXor(give.y, kHalf));
  bool odd = (team_lane() & kQuarter) != 0u;
  float sum = (odd ? keep.y : keep.x) + subgroupShuffleXor(odd ? keep.x : keep.y, kQuarter);
  [[unroll]] for (uint w = kQuarter >> 1; w > 0u; w >>= 1) sum += subgroupShuffleXor(sum, w);
  float other = subgroupShuffleXor(sum, kQuarter);
  keep = odd ? vec2(other, sum) : vec2(sum, other);
  give = vec2(subgroupShuffleXor(keep.x, kHalf), subgroupShuffleXor(keep.y, kHalf));
  return high ? vec4(give, keep) : vec4(keep, give);
}

// The value of node n ^ way, way: a constant.
#define FL_NODE_XOR(f, k, way)                                                              \
  ((uint(way) & (kTeam - 1u)) != 0u ? subgroupShuffleXor(f[k ^ (uint(way) / kTeam)], uint(way) & (kTeam - 1u)) \
                                    : f[k ^ (uint(way) / kTeam)])

// What a place in a row of four nodes adds to its coefficient, from its own sum with or difference from the place
// opposite and from that of the place two further.
vec3 transform_row(uint place) {
  const vec3 kRows[4] = vec3[4](vec3(1.0, 0.25, 0.25), vec3(-1.0, -0.19134172, 0.46193977),
                                vec3(1.0, -0.35355339, 0.35355339), vec3(-1.0, 0.19134172, 0.46193977));
  return kRows[place];
}

// From values at the nodes to coefficients of T_m(x) T_n(y): that of node (m, n) stands where its value was.
void to_coefficients(inout float f[kPer]) {
  float g[kPer];
  vec3 x = transform_row(node_place(0u).x);
  FL_LANE_NODES(k) g[k] = x.x * f[k] + FL_NODE_XOR(f, k, 3);
  FL_LANE_NODES(k) f[k] = x.y * g[k] + x.z * FL_NODE_XOR(g, k, 2);
  vec3 y[kPer];
  FL_LANE_NODES(k) y[k] = transform_row(node_place(k).y);
  FL_LANE_NODES(k) g[k] = y[k].x * f[k] + FL_NODE_XOR(f, k, 12);
  FL_LANE_NODES(k) f[k] = y[k].y * g[k] + y[k].z * FL_NODE_XOR(g, k, 8);
}
