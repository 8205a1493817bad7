// Reads the rows of a shadow map (shadow_row_line.glsl). The row is the nearest, and a place a 64th of the line within
// the beam: edges are half of that off. After shadow_map.glsl.
layout(set = 0, binding = FL_BINDING_BEAM_MAPS, std430) readonly buffer ShadowRowsBuffer { uvec4 shadow_rows[]; };

bool has_row(RowLine line) { return kMapRows && line.offset < 1.5; }

// Of eight keys in four words, k and k + 4 in word k: a bit for each that is below the ray's key. The highest bit of
// each half of a difference is set where the ray's key is the larger one.
uint keys_below(uint key, uvec4 words) {
  uvec4 behind = key - words;
  uint some = (behind.x >> 15 & 0x10001u) | (behind.y >> 14 & 0x20002u) | (behind.z >> 13 & 0x40004u) |
              (behind.w >> 12 & 0x80008u);
  return (some | some >> 12) & 0xffu;
}
// Four bits to four bytes.
uint bytes_of(uint bits) { return (bits * 0x00204081u & 0x01010101u) * 0xffu; }

// A bit for each place of the line: whether the ray is behind a body there.
uvec2 row_bits(uint beam, RowLine line) {
  const float kHalf = 0.5 * float(FL_MAP_ROWS);
  uint own = uint(clamp(int(kHalf * line.offset + kHalf), 0, FL_MAP_ROWS - 1));
  uint at = (beam * kMapWords + kMapRowsAt + own * uint(FL_MAP_ROW_WORDS)) / 4u;
  uint key = row_key(line.z_m) * 0x10001u + 0x7fff7fffu;
  uint some = keys_below(key, shadow_rows[at]);
  uint whole = keys_below(key, shadow_rows[at + 1u]);
  uvec2 bits = uvec2(bytes_of(whole & 15u), bytes_of(whole >> 4));
  for (uint mixed = some & ~whole; mixed != 0u; mixed &= mixed - 1u) {
    uint group = uint(findLSB(mixed));
    uint byte = keys_below(key, shadow_rows[at + 2u + group]) << 8u * (group & 3u);
    bits |= group < 4u ? uvec2(byte, 0u) : uvec2(0u, byte);
  }
  return bits;
}

// The chord among the places of its line: where it begins, and how much of it a place is.
struct RowSpan {
  float from;
  float per_place;  // share of the chord
  uvec2 changes;  // bits of the places within it that differ from the one before
  bool dark;      // its begin is
};
RowSpan row_span(RowLine line, uvec2 bits) {
  const float kHalf = 0.5 * float(FL_MAP_ROWS);
  float scale = kHalf * inversesqrt(max(1.0 - line.offset * line.offset, 1e-6));
  RowSpan span;
  span.from = kHalf + scale * line.s_from;
  float places = scale * (line.s_to - line.s_from);
  span.per_place = 1.0 / max(places, 1e-6);
  int first = clamp(int(span.from), 0, FL_MAP_ROWS - 1);
  int last = clamp(int(ceil(span.from + places)) - 1, first, FL_MAP_ROWS - 1);
  uvec2 differ = bits ^ uvec2(bits.x << 1 | bits.x & 1u, bits.y << 1 | bits.x >> 31);
  // Of the places after `first` up to `last`.
  uvec2 after = uvec2(first < 32 ? 0xfffffffeu << first : 0u, first < 32 ? 0xffffffffu : 0xfffffffeu << (first - 32));
  uvec2 until =
      uvec2(last < 32 ? 0xffffffffu >> (31 - last) : 0xffffffffu, last < 32 ? 0u : 0xffffffffu >> (63 - last));
  span.changes = differ & after & until;
  span.dark = ((first < 32 ? bits.x >> first : bits.y >> (first - 32)) & 1u) != 0u;
  return span;
}
// The share of the chord at the next place where light and dark change. After `changes` is not 0.
float row_next(inout RowSpan span) {
  bool is_low = span.changes.x != 0u;
  uint word = is_low ? span.changes.x : span.changes.y;
  int place = findLSB(word) + (is_low ? 0 : 32);
  word &= word - 1u;
  span.changes = is_low ? uvec2(word, span.changes.y) : uvec2(0u, word);
  return clamp((float(place) - span.from) * span.per_place, 0.0, 1.0);
}

ShadowParts row_parts(uint beam, RowLine line) {
  ShadowParts parts;
  shadow_parts_clear(parts);
  RowSpan span = row_span(line, row_bits(beam, line));
  float from = 0.0;
  while ((span.changes.x | span.changes.y) != 0u) {
    float at = row_next(span);
    if (span.dark) shadow_parts_add(parts, from, at);
    span.dark = !span.dark;
    from = at;
  }
  if (span.dark) shadow_parts_add(parts, from, 1.0);
  return parts;
}
