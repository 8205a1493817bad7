// Light of smooth beams: sums over the teams of a workgroup in a fixed order, as polynomials. After tile_team.glsl.
shared float node_sums[16 * FL_TILE_LIGHT + 12];  // of 16 teams at a time; also the middles of entries before
shared float group_light[FL_TILE_LIGHT];

// T_0 to T_3.
vec4 chebyshev(float x) { return vec4(1.0, x, 2.0 * x * x - 1.0, (4.0 * x * x - 3.0) * x); }

// Puts into group_light the coefficients 3 (4 n + m) + channel of T_m(x) T_n(y) of the light that the teams' lanes have
// at their nodes. All threads of the group call it together.
void sum_light(vec3 light[kPer]) {
  uint number = thread_number();
  uint team = team_number();
  float sum = 0.0;
  for (uint first = 0u; first < kTeams; first += 16u) {
    barrier();
    if (team >= first && team < first + 16u) {
      FL_LANE_NODES(k) {
        uint at = (team - first) * uint(FL_TILE_LIGHT) + 3u * (team_lane() + kTeam * k);
        node_sums[at] = light[k].r;
        node_sums[at + 1u] = light[k].g;
        node_sums[at + 2u] = light[k].b;
      }
    }
    barrier();
    if (number < uint(FL_TILE_LIGHT)) {
      for (uint t = 0u; t < 16u; ++t) sum += node_sums[t * uint(FL_TILE_LIGHT) + number];
    }
  }
  barrier();
  if (number < uint(FL_TILE_LIGHT)) node_sums[number] = sum;
  barrier();
  if (number < uint(FL_TILE_LIGHT)) {
    const float kAt[4] = float[4](0.92387953, 0.38268343, -0.38268343, -0.92387953);
    uint channel = number % 3u;
    uint m = number / 3u & 3u;
    uint n = number / 12u;
    float value = 0.0;
    for (uint j = 0u; j < 4u; ++j) {
      float row = 0.0;
      for (uint i = 0u; i < 4u; ++i) row += node_sums[3u * (4u * j + i) + channel] * chebyshev(kAt[i])[m];
      value += row * chebyshev(kAt[j])[n];
    }
    group_light[number] = value * (m > 0u ? 0.5 : 0.25) * (n > 0u ? 0.5 : 0.25);
  }
  barrier();
}

// What tile_class() compares with: light, h and rho at the rectangle's middle, of so many entries.
void store_middle(uint slot, vec3 middle) {
  node_sums[3u * slot] = middle.x;
  node_sums[3u * slot + 1u] = middle.y;
  node_sums[3u * slot + 2u] = middle.z;
}
vec3 stored_middle(uint slot) {
  return vec3(node_sums[3u * slot], node_sums[3u * slot + 1u], node_sums[3u * slot + 2u]);
}
