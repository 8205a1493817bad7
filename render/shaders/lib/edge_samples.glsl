// The samples of a pixel with an edge: a word each. Its high 28 bits are those of the depth there, reversed, so that
// the nearest is the largest; the low four say which of nine pixels has its colour, in rows. After frame.glsl.
layout(constant_id = FL_SPEC_EDGE_SAMPLES) const uint kSamples = FL_EDGE_SAMPLES_MAX;

// From the pixel's middle: the points of Hammersley, whose rows and columns all have one.
vec2 sample_offset(uint n) {
  uint bits = uint(findMSB(kSamples));
  return (vec2(float(n), float(bitfieldReverse(n) >> (32u - bits))) + 0.5) / float(kSamples) - 0.5;
}

// Of a depth below 1, whose two high bits are not set.
uint sample_bits(float z) { return floatBitsToUint(z) << 2 & ~15u; }

// By how much a neighbour that shows the same surface misses a sample: apart, in pixels; how far its plane is off, in
// pixels; 1 - cosine between the normals, doubled. With kNoNeighbour or more it is none.
const float kNoNeighbour = 4.0;
float neighbour_misses(vec2 apart, float off, float turned) {
  precise float misses = 0.05 * (apart.x * apart.x + apart.y * apart.y) + off + turned;
  return misses;
}
