// Rows of tables of which all threads of a subgroup read the same one, where all are active. GPUs read it once.
// Mesa's lavapipe reads each of its words eight times, thread by thread: with kAlikeReads each thread reads one word in
// eight, and they hand them on. After shadow.glsl.
layout(constant_id = FL_SPEC_ALIKE_READS) const bool kAlikeReads = false;  // subgroups have 8 threads
layout(set = 0, binding = FL_BINDING_SHADOWS, std430) readonly buffer PlaneWordsBuffer { float plane_words[]; };

const uint kRowWords = 4u * (1u + uint(FL_SHADOW_PLANES));  // of a ShadowRow

// Four planes of a shadow that is the same for the whole subgroup.
struct FourPlanes {
  vec4 of[4];
};
FourPlanes planes_alike(uint shadow, uint own[4]) {
  bool low = gl_SubgroupInvocationID < 4u;
  uint first = kRowWords * shadow + 4u + (gl_SubgroupInvocationID & 3u);
  float pair[2] = float[2](plane_words[first + 4u * (low ? own[0] : own[1])],
                           plane_words[first + 4u * (low ? own[2] : own[3])]);
  FourPlanes four;
  [[unroll]] for (uint k = 0u; k < 4u; ++k) {
    [[unroll]] for (uint i = 0u; i < 4u; ++i) four.of[k][i] = subgroupShuffle(pair[k >> 1], 4u * (k & 1u) + i);
  }
  return four;
}
// The next four of an entry of a list.
FourPlanes next_planes_alike(uint entry, inout uint planes) {
  uint own[4];
  [[unroll]] for (int k = 0; k < 4; ++k) own[k] = next_plane(planes);
  return planes_alike(entry_shadow(entry), own);
}
