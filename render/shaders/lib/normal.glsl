// Unit vectors as 2 x 16 bits (octahedral: Cigolle et al. 2014, "A Survey of Efficient Representations for Independent
// Unit Vectors").
uint pack_normal(vec3 n) {
  vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
  if (n.z < 0.0) p = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
  return packSnorm2x16(p);
}
vec3 unpack_normal(uint packed) {
  vec2 p = unpackSnorm2x16(packed);
  vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
  if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
  return normalize(n);
}

// The same with 13 bits, and in the last three bits of each half the number of a material with sheen, below 64. Read as
// above the normal is right to 3e-4.
uint pack_sheen_normal(vec3 n, uint sheen) {
  vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
  if (n.z < 0.0) p = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
  ivec2 at = ivec2(round(clamp(p, -1.0, 1.0) * 4095.0)) * 8 | ivec2(sheen & 7u, sheen >> 3 & 7u);
  return uint(at.x) & 0xffffu | uint(at.y) << 16;
}
vec3 unpack_sheen_normal(uint packed, out uint sheen) {
  sheen = packed & 7u | (packed >> 16 & 7u) << 3;
  ivec2 at = ivec2(int(packed << 16) >> 19, int(packed) >> 19);
  vec2 p = vec2(at) / 4095.0;
  vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
  if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
  return normalize(n);
}
