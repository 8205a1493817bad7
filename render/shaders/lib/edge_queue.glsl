// Draws rows of small triangles into the samples of pixels with an edge. First threads find the pixels in which a
// triangle may cover a sample, then all of them share out the samples. A triangle has such a pixel in few of its rows,
// so threads that drew what they find would wait for one another. After triangle_samples.glsl, and the triangles of the
// workgroup in `small`, `small_first` and `small_asked`.
#if FL_TRIANGLES > 1 << (32 - FL_EDGE_SLOT_BITS)
#error a number of a triangle does not fit beside that of a pixel
#endif
const uint kFoundMost = 512u;
const uint kAtOnce = 4u;  // samples of a thread
shared uint found_count;              // more than kFoundMost: some found no room
shared uint found_at[kFoundMost];     // the pixel, its row << 16
shared uint found_slot[kFoundMost];   // of its samples; of the triangle << FL_EDGE_SLOT_BITS

// Where a thread goes on.
struct RowPlace {
  uint row;       // among those of all triangles
  uint triangle;  // of that row, or one before
  int x;          // the first column
};

// False: there is no room.
bool put_found(ivec2 at, uint slot, uint triangle) {
  uint number = atomicAdd(found_count, 1u);
  if (number >= kFoundMost) return false;
  found_at[number] = uint(at.y) << 16 | uint(at.x);
  found_slot[number] = triangle << FL_EDGE_SLOT_BITS | slot;
  return true;
}

// Until there are no more rows, or no room.
void find_pixels(inout RowPlace place) {
  uint count = small_asked >> 24;
  uint total = small_asked & 0xffffffu;
  bool room = true;
  while (place.row < total && room) {
    while (place.triangle + 1u < count && small_first[place.triangle + 1u] <= place.row) ++place.triangle;
    DrawnTriangle w = small[place.triangle];
    int y = w.low.y + int(place.row - small_first[place.triangle]);
    place.x = max(place.x, w.low.x);
    while (place.x <= w.high.x && room) {
      uint words = words_of_tile(uvec2(place.x, y) / uint(FL_TILE_PX));
      uint word = edge_masks[words + uint(y) % uint(FL_TILE_PX)];
      int tile = place.x / FL_TILE_PX * FL_TILE_PX;
      uint bits = word & columns_mask(place.x - tile, min(w.high.x - tile, FL_TILE_PX - 1));
      place.x = tile + FL_TILE_PX;
      while (bits != 0u) {
        ivec2 at = ivec2(tile + findLSB(bits), y);
        bits &= bits - 1u;
        // Most are behind what is seen.
        if (is_behind(w.nearest_z, at) || !small_may_cover(w, at)) continue;
        room = put_found(at, edge_slot(words, word, uint(at.x - tile)), place.triangle);
        if (room) continue;
        place.x = at.x;
        bits = 0u;
      }
    }
    if (room) {
      place.row += FL_THREADS;
      place.x = 0;
    }
  }
}

void draw_found() {
  const uint kParts = kSamples / kAtOnce;
  uint count = min(found_count, kFoundMost);
  for (uint i = gl_LocalInvocationIndex; i < count * kParts; i += FL_THREADS) {
    uint number = i / kParts;
    DrawnTriangle w = small[found_slot[number] >> FL_EDGE_SLOT_BITS];
    uint slot = found_slot[number] & ((1u << FL_EDGE_SLOT_BITS) - 1u);
    ivec2 at = ivec2(int(found_at[number] & 0xffffu), int(found_at[number] >> 16));
    Sides s = small_sides(w, at);
    uint first = i % kParts * kAtOnce;
    [[unroll]] for (uint k = 0u; k < kAtOnce; ++k) draw_sample(s, s.at_origin, slot * kSamples, first + k, w.mark);
  }
}

void draw_rows() {
  if (small_asked == 0u) return;
  RowPlace place = RowPlace(gl_LocalInvocationIndex, 0u, 0);
  for (bool more = true; more;) {
    if (gl_LocalInvocationIndex == 0u) found_count = 0u;
    barrier();
    find_pixels(place);
    barrier();
    draw_found();
    more = found_count > kFoundMost;
    barrier();
  }
}
