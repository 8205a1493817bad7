// Blurred copies of gobos (goboblurs.comp): what a gobo lets through on average in a disc. A texel has four radii, an
// octave from the first to the last, between which the cubic through them in the logarithm of the radius stands. Each
// octave has a square of its own. A disc has 8 to 16 texels in its radius, of the first square 4 to 8. Error and cost:
// docs/numerics.md.
const float kBlurLeast = 1.0 / float(FL_GOBO_BLUR_LEAST);
const float kBlurMost = float(1 << FL_GOBO_BLUR_LEVELS) / float(FL_GOBO_BLUR_LEAST);

// The texels of the side of a level's square, and where it begins.
uint blur_side(uint level) { return min(uint(FL_GOBO_BLUR_PX), uint(2 * FL_GOBO_BLUR_PX) >> level); }
uvec2 blur_corner(uint level) {
  uint side = blur_side(level);
  return level < 2u ? uvec2(level * side, 0u) : uvec2(2 * FL_GOBO_BLUR_PX, uint(FL_GOBO_BLUR_PX) - 2u * side);
}
