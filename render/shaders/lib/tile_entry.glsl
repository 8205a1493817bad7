// Beams of which a workgroup's teams compute the nodes: those with whole chords first, then those with cut ones, each
// in patch order, so that the teams of a subgroup do the same. After tile_class.glsl and tile_sum.glsl.
#define FL_ENTRIES_MAX (FL_GROUP_TILE + 4)
shared uint entry_ids[FL_ENTRIES_MAX];
shared uint entry_bits[FL_ENTRIES_MAX];  // TileGuess::bits; 0: no beam
shared uint entry_fits[FL_ENTRIES_MAX];  // two halves

struct TileEntry {
  uint id;
  uint bits;
  vec2 fit;
  vec3 middle;
};

// Each thread adds its beam, or none. Returns the number of the first entry with cut chords, and that of all. All
// threads of the group call it together, when the entries before have been read.
uvec2 add_entry(bool is_beam, uint id, TileGuess guess) {
  bool whole = is_beam && (guess.bits & kGuessWhole) != 0u;
  bool cut = is_beam && (guess.bits & kGuessCut) != 0u;
  uvec2 count;
  uvec2 slots = ordered_slots(whole, cut, count);
  uint cut_first = (count.x + 3u) & ~3u;  // subgroups have at most 4 teams
  if (whole || cut) {
    uint slot = whole ? slots.x : cut_first + slots.y;
    entry_ids[slot] = id;
    entry_bits[slot] = guess.bits;
    entry_fits[slot] = packHalf2x16(guess.fit);
    store_middle(slot, guess.middle);
  }
  uint number = thread_number();
  if (number < 4u && count.x + number < cut_first) {
    entry_ids[count.x + number] = 0u;
    entry_bits[count.x + number] = 0u;
    entry_fits[count.x + number] = packHalf2x16(vec2(0.0, 1.0));
    store_middle(count.x + number, vec3(0.0));
  }
  barrier();
  return uvec2(cut_first, cut_first + count.y);
}

TileEntry entry_at(uint slot) {
  return TileEntry(entry_ids[slot], entry_bits[slot], unpackHalf2x16(entry_fits[slot]), stored_middle(slot));
}
