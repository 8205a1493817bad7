// Polynomials of smooth beams, summed over the threads of a workgroup in a fixed order. After tile_class.glsl and
// tile_list.glsl.
#define FL_SUM_SLOTS 32

shared float light_sums[FL_SUM_SLOTS * FL_TILE_LIGHT];

// The sums of one round over the group's threads: each thread adds its beam, color 0 for none. Thread
// k < FL_TILE_LIGHT gets coefficient k / 3 of channel k % 3. All threads call it together.
float tile_light_sum(vec3 color) {
  bool has_beam = color != vec3(0.0);
  bool any = subgroupBallotBitCount(subgroupBallot(has_beam)) > 0u;
  uint own = thread_number();
  float total = 0.0;
  // With more than FL_SUM_SLOTS subgroups they take turns.
  for (uint first = 0u; first < gl_NumSubgroups; first += uint(FL_SUM_SLOTS)) {
    bool turn = gl_SubgroupID >= first && gl_SubgroupID < first + uint(FL_SUM_SLOTS);
    if (turn) {
      uint slot = (gl_SubgroupID - first) * uint(FL_TILE_LIGHT);
      if (any) {
        [[unroll]] for (int k = 0; k < 16; ++k) {
          // Not 0 times what a thread without a beam has there.
          vec3 sum = subgroupAdd(has_beam ? fit_light[k] * color : vec3(0.0));
          if (subgroupElect()) {
            light_sums[slot + 3u * uint(k)] = sum.r;
            light_sums[slot + 3u * uint(k) + 1u] = sum.g;
            light_sums[slot + 3u * uint(k) + 2u] = sum.b;
          }
        }
      } else {
        for (uint k = gl_SubgroupInvocationID; k < uint(FL_TILE_LIGHT); k += gl_SubgroupSize) {
          light_sums[slot + k] = 0.0;
        }
      }
    }
    barrier();
    if (own < uint(FL_TILE_LIGHT)) {
      for (uint s = first; s < min(first + uint(FL_SUM_SLOTS), gl_NumSubgroups); ++s) {
        total += light_sums[(s - first) * uint(FL_TILE_LIGHT) + own];
      }
    }
    barrier();
  }
  return total;
}

// T_0 to T_3.
vec4 chebyshev(float x) { return vec4(1.0, x, 2.0 * x * x - 1.0, (4.0 * x * x - 3.0) * x); }
