// The samples of a pixel with an edge: a word each, of what is nearest there. Its high 24 bits are those of the depth,
// reversed, so that the nearest is the largest; the low 8 stand for the surface. 0: nothing. After edge_surfaces.glsl.
layout(constant_id = FL_SPEC_EDGE_SAMPLES) const uint kSamples = FL_EDGE_SAMPLES_MAX;

// From the pixel's middle: the points of Hammersley, whose rows and columns all have one.
vec2 sample_offset(uint n) {
  uint bits = uint(findMSB(kSamples));
  return (vec2(float(n), float(bitfieldReverse(n) >> (32u - bits))) + 0.5) / float(kSamples) - 0.5;
}

// z: a depth below 1, whose two high bits are not set.
uint sample_word(float z, uint mark) { return (floatBitsToUint(z) << 2 & 0xffffff00u) | mark; }
float sample_depth(uint word) { return uintBitsToFloat((word & 0xffffff00u) >> 2); }
uint sample_mark(uint word) { return word & 0xffu; }

// Of a surface's name: 0 of nothing; else 128 and more of a box, and less of anything else. Few others have the same.
uint mark_of(uint name) {
  if (name == 0u) return 0u;
  uint mixed = name * 2654435769u >> 9;
  bool box = (name & (FL_BOX_ID | FL_OBJECT)) == FL_BOX_ID;
  return box ? 128u + mixed % 128u : 1u + mixed % 127u;
}
