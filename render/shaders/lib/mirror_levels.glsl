// The pyramid of the mirrored camera's picture, in one image: level 0 at the left, the others below each other at its
// right, each with half the pixels a side of the one before, rounded up (render/mirror.h). A pixel has two texels.
// rgb: radiance times weight, cd/m^2; a: weight, 0 to 1: how much of the pixel is a floor that mirrors, in the camera's
// own picture. In the second: r: the share of the light's way to the camera that is before the mirror, times weight.

// Where level n is, and its size.
ivec4 mirror_level(ivec2 size, int n) {
  ivec4 level = ivec4(0, 0, size);
  for (int i = 0; i < n; ++i) {
    level.xy = i == 0 ? ivec2(size.x, 0) : ivec2(level.x, level.y + level.w);
    level.zw = (level.zw + 1) / 2;
  }
  return level;
}
// The place of a pixel's texel in the image. which: 0 or 1.
ivec2 mirror_texel(ivec2 at, int which) { return ivec2(at.x, 2 * at.y + which); }
