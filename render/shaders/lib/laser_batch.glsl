// Strips of some rows of lasers in a square of the picture, one workgroup a square: their polynomials, whether these
// do, and whether the row may light something solid there. After laser_strip.glsl and
// laser_masks.glsl, with kExtinction and kAir.
#ifdef FL_USE_HAZE
const bool kTiles = false;  // clouds are not polynomials: between its nodes a fan was off by 1.8e-3 of the picture
#else
layout(constant_id = FL_SPEC_TILES) const bool kTiles = true;  // else every pixel is computed
#endif
const uint kThreads = 256u;
const uint kNotes = kThreads / 32u;
const uint kBatch = kThreads / kPlaces;  // rows at a time
// Of the most light of a row in a square: polynomials are off by no more at the checks.
const float kStripError = 1.5e-3;
const float kLeastLit = 1e-6;    // share of the light of a row that counts as none

shared uint note_bits[kNotes];    // threads that have something to list
shared uint row_words[kThreads];  // words that have a row, in order
shared uint listed[kThreads];     // rows that touch the square, in order
shared LaserStripRow strips[kBatch];
shared vec2 places[kBatch * kPlaces];  // LaserAir.smooth_light and scale
// As bits of floats: the most light of a row at its places, how much of it is lit, and its depths there.
shared uint most_bits[kBatch];
shared uint lit_bits[kBatch];
shared uint near_bits[kBatch];
shared uint far_bits[kBatch];
shared uint off_bits;     // rows of a batch whose polynomials are off, a bit each
shared uint by_strip;     // rows whose air is drawn by polynomials
shared uint by_pixel;     // and those for which the polynomials do not do
shared uint on_surfaces;  // those that may light something solid
shared uint nearest_bits;  // depths of what the square shows, as bits of floats
shared uint farthest_bits;

// The place of a thread among those that have something to list, and how many these are.
uint place_among(bool lists, out uint count) {
  uint note = gl_LocalInvocationIndex / 32u;
  uint bit = 1u << (gl_LocalInvocationIndex % 32u);
  barrier();
  if (gl_LocalInvocationIndex < kNotes) note_bits[gl_LocalInvocationIndex] = 0u;
  barrier();
  if (lists) atomicOr(note_bits[note], bit);
  barrier();
  uint before = uint(bitCount(note_bits[note] & (bit - 1u)));
  count = 0u;
  for (uint w = 0u; w < kNotes; ++w) {
    uint here = uint(bitCount(note_bits[w]));
    if (w < note) before += here;
    count += here;
  }
  return before;
}

// Lists the words of a supertile's bits that have a row, from word `base` on, and returns how many there are.
uint list_words(uint mask, uint base, uint words) {
  uint word = base + gl_LocalInvocationIndex;
  bool lists = word < words && laser_masks[mask + word] != 0u;
  uint count;
  uint at = place_among(lists, count);
  if (lists) row_words[at] = word;
  return count;
}

// Lists the rows of kNotes of these words, from number `from` on, that touch the pixels low to high.
uint list_rows(uint mask, uint from, uint count, vec2 low, vec2 high) {
  barrier();
  uint which = from + gl_LocalInvocationIndex / 32u;
  uint bit = gl_LocalInvocationIndex % 32u;
  uint index = 0u;
  bool lists = false;
  if (which < count) {
    index = 32u * row_words[which] + bit;
    lists = (laser_masks[mask + row_words[which]] >> bit & 1u) != 0u && laser_touches(lasers[index], low, high);
  }
  uint total;
  uint at = place_among(lists, total);
  if (lists) listed[at] = index;
  return total;
}

// Which way the air of a row of the batch is drawn, and whether it lights something solid.
void choose(uint slot, LaserRow row) {
  // One over the depth of a sheet is even in the picture; the corners are somewhat beyond the places.
  float near_m = uintBitsToFloat(near_bits[slot]);
  float far_m = uintBitsToFloat(far_bits[slot]);
  bool is_along = !(near_m > 0.0 && far_m < 2.0 * near_m);
  float beyond = 0.1 * (1.0 / near_m - 1.0 / far_m);
  near_m = 1.0 / (1.0 / near_m + beyond);
  far_m = 1.0 / (1.0 / far_m - beyond);
  // A body is lit somewhat behind the end of the light, in what hides light for it.
  bool has_body = row.end_fixture_1 != FL_NONE || row.end_fixture_2 != FL_NONE;
  float behind_m = 1e-3 + 1e-3 * far_m + row.slack_m + (has_body ? 1.0 : 0.0);
  bool is_free = !is_along && far_m + behind_m < uintBitsToFloat(nearest_bits);
  bool is_hidden = !is_along && near_m > uintBitsToFloat(farthest_bits);
  bool is_off = !kTiles || !is_free || (off_bits >> slot & 1u) != 0u;
  bool is_lit = kAir && uintBitsToFloat(most_bits[slot]) > 0.0 && uintBitsToFloat(lit_bits[slot]) > kLeastLit;
  uint bit = is_hidden ? 0u : 1u << slot;
  if (is_lit && is_off) atomicOr(by_pixel, bit);
  if (is_lit && !is_off) atomicOr(by_strip, bit);
  if (!is_free) atomicOr(on_surfaces, bit);
}

// middle, half_square: of the square, pixels. Rows begin to begin + count of the list. air: of a pixel px from the
// middle that shows something at end_m; with FL_LASER_PIXELS light of rows whose polynomials do not do is added to it.
void find_strips(uint begin, uint count, vec2 middle, float half_square, vec2 own_px, float own_m, inout vec3 air) {
  uint thread = gl_LocalInvocationIndex;
  uint slot = thread / kPlaces;
  uint place = thread % kPlaces;
  if (thread == 0u) {
    by_strip = 0u;
    by_pixel = 0u;
    on_surfaces = 0u;
    off_bits = 0u;
  }
  if (place == 0u) {
    most_bits[slot] = 0u;
    lit_bits[slot] = 0u;
    near_bits[slot] = floatBitsToUint(FL_FAR_M);
    far_bits[slot] = 0u;
  }
  barrier();
  // First the places of all rows; then, where these do not do, the pixels. One call in a loop, since it is long code.
  uint left = 1u;
  for (bool at_places = true; left != 0u;) {
    LaserRow row = lasers[listed[begin + (at_places ? min(slot, count - 1u) : uint(findLSB(left)))]];
    LaserSheet sheet = laser_sheet(row);
    vec2 px = own_px;
    float end_m = own_m;
    bool works = true;
    if (at_places) {
      LaserStripRow strip = laser_strip(row, sheet, middle, half_square);
      if (place == 0u) strips[slot] = strip;
      px = strip_px(strip, strip_place(place));
      end_m = FL_FAR_M;
      works = slot < count && strip.size.x > 0.0;
    }
    LaserPixel view = LaserPixel(ray_through(middle + px), laser_step_x(), laser_step_y());
#ifdef FL_USE_HAZE
    haze_begin(middle + px);
#endif
    LaserAir seen;
    seen.light = 0.0;
    if (works) seen = laser_in_air(sheet, view, end_m, params.anisotropy, params.position.w, kExtinction);
#ifdef FL_LASER_PIXELS
    if (!at_places) {
      air += row.light.rgb * seen.light;
      left &= left - 1u;
      continue;
    }
#endif
    if (works) {
      places[thread] = vec2(seen.smooth_light, seen.scale);
      atomicMax(most_bits[slot], floatBitsToUint(abs(seen.light)));
      atomicMax(lit_bits[slot], floatBitsToUint(abs(seen.lit)));
      atomicMin(near_bits[slot], floatBitsToUint(seen.is_along ? 0.0 : abs(max(seen.near_m, 0.0))));
      atomicMax(far_bits[slot], floatBitsToUint(seen.is_along ? FL_FAR_M : abs(max(seen.far_m, 0.0))));
    }
    barrier();
    if (place < kNodes) {
      uint across = place / kNodesAlong;
      vec4 along_weight = weights_along(place % kNodesAlong);
      vec3 across_weight = weights_across(across);
      vec2 value = vec2(0.0);
      for (uint j = 0u; j < kNodesAcross; ++j) {
        uint first = slot * kPlaces + j * kNodesAlong;
        value += across_weight[j] * (along_weight.x * places[first] + along_weight.y * places[first + 1u] +
                                     along_weight.z * places[first + 2u] + along_weight.w * places[first + 3u]);
      }
      strips[slot].smooth_light[across][place % kNodesAlong] = value.x;
      strips[slot].scale[across][place % kNodesAlong] = value.y;
    }
    barrier();
    float most = uintBitsToFloat(most_bits[slot]);
    if (works && place >= kNodes && !(abs(light_of_strip(strips[slot], px) - seen.light) <= kStripError * most)) {
      atomicOr(off_bits, 1u << slot);
    }
    barrier();
    if (works && place == 0u) choose(slot, row);
    barrier();
    at_places = false;
#ifdef FL_LASER_PIXELS
    left = by_pixel;
#else
    left = 0u;
#endif
  }
}
