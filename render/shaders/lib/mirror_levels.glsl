// The pyramid of the mirrored camera's picture, in one image: level 0 at the left, the others below each other at its
// right, each with half the pixels a side of the one before, rounded up (render/mirror.h). rgb: radiance, cd/m^2.
// a: the share of the light's way, from where it was seen to the camera, that is before the mirror.

// Where level n is, and its size.
ivec4 mirror_level(ivec2 size, int n) {
  ivec4 level = ivec4(0, 0, size);
  for (int i = 0; i < n; ++i) {
    level.xy = i == 0 ? ivec2(size.x, 0) : ivec2(level.x, level.y + level.w);
    level.zw = (level.zw + 1) / 2;
  }
  return level;
}
