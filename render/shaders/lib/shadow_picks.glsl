// Which shadows of a beam reach what a supertile shows of its light in the haze (shadowtiles.comp). The places of lists
// differ from frame to frame. Nothing depends on them: the shadows of each beam are in their own order, and if not all
// lists of a frame have room, none of them is read.
layout(set = 0, binding = FL_BINDING_SHADOW_WORDS, std430) FL_PICKS_ACCESS buffer ShadowWordsBuffer {
  ShadowWordRow shadow_words[];
};
layout(set = 0, binding = FL_BINDING_SHADOW_PICKS, std430) FL_PICKS_ACCESS buffer ShadowPicksBuffer {
  uint shadow_words_used;
  uint shadow_picks[];
};

#ifdef FL_PICKS_READ
struct ShadowPicks {
  uint count;  // 0: the beam has no shadow there
  uint first;
  bool listed;  // the rows are those whose numbers stand from `first` on; else they are rows from `first` on
};
ShadowPicks shadow_picks_of(uint supertile, uint beam) {
  ShadowWordRow word = shadow_words[supertile * params.mask_words + (beam >> 5)];
  uint bit = 1u << (beam & 31u);
  if ((word.beams & bit) == 0u) return ShadowPicks(0u, 0u, false);
  uint place = FL_NONE;
  bool all_listed = shadow_words_used <= uint(shadow_picks.length());
  if (all_listed && word.first != FL_NONE) place = shadow_picks[word.first + bitCount(word.beams & (bit - 1u))];
  if (place == FL_NONE) return ShadowPicks(shadow_lists[beam].count, shadow_lists[beam].first, false);
  return ShadowPicks(shadow_picks[place], place + 1u, true);
}
uint shadow_picked(ShadowPicks picks, uint which) {
  uint at = picks.first + which;
  return picks.listed ? shadow_picks[at] : at;
}

// Whether the beam has shadows that reach what is visible of it in the supertile.
bool has_shadows(uint supertile, uint beam) {
  return kShadows && (shadow_words[supertile * params.mask_words + (beam >> 5)].beams >> (beam & 31u) & 1u) != 0u;
}

// The shadows of one chord: all of the picks, or the first 32 that have a bit.
ShadowParts chord_shadows(ShadowPicks picks, uint bits, BeamRow row, BeamShape beam, Chord chord, vec3 ray) {
  ShadowParts parts;
  shadow_parts_clear(parts);
  ShadowChord ends = shadow_chord(row, beam, chord, ray);
  bool all = bits == ~0u;
  for (uint n = 0u; all ? n < picks.count : bits != 0u; ++n) {
    uint which = all ? n : uint(findLSB(bits));
    bits &= bits - 1u;
    float x0;
    float x1;
    if (shadow_part(shadow_picked(picks, which), ends, x0, x1)) shadow_parts_add(parts, x0, x1);
  }
  return parts;
}

// Whether a place in the haze is in one of the beam's shadows there; light space, m.
bool is_in_picked(uint supertile, uint beam, vec3 p) {
  ShadowPicks picks = shadow_picks_of(supertile, beam);
  bool dark = false;
  for (uint k = 0u; k < picks.count && !dark; ++k) {
    uint shadow = shadow_picked(picks, k);
    uint rounds = shadow_rounds(shadow);
    dark = true;
    for (uint round_of = 0u; round_of < rounds && dark; ++round_of) {
      dark = shadow_holds(shadow, round_of, 0u, p, p, 0.0);
    }
  }
  return dark;
}
#endif
