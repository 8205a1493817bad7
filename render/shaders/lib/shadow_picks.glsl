// Which shadows of a beam reach what a rectangle of pixels shows of its light in the haze: by supertile
// (shadowtiles.comp), and by tile of FL_FINE_PX where beams are taken together (shade.comp). The places of lists differ
// from frame to frame. Nothing depends on them: the shadows of each beam are in their own order, and if not all lists
// of one of the two have room, none of it is read.
layout(set = 0, binding = FL_BINDING_SHADOW_WORDS, std430) FL_PICKS_ACCESS buffer ShadowWordsBuffer {
  ShadowWordRow shadow_words[];
};
layout(set = 0, binding = FL_BINDING_SHADOW_PICKS, std430) FL_PICKS_ACCESS buffer ShadowPicksBuffer {
  uint shadow_words_used;
  uint shade_words_used;  // by lists of shade.comp, behind those of shadowtiles.comp
  uint shadow_picks[];
};

#ifdef FL_PICKS_READ
struct ShadowPicks {
  uint count;  // 0: the beam has no shadow there
  uint first;
  bool listed;  // entries (shadow.glsl) stand from `first` on; else all planes of the rows from `first` on count
};
bool is_in_word(ShadowWordRow word, uint beam) { return (word.beams >> (beam & 31u) & 1u) != 0u; }
// Where the list of a beam of a word stands; FL_NONE: it has none, or not `all` lists of its kind have room.
uint list_place(ShadowWordRow word, uint beam, bool all) {
  if (!all || word.first == FL_NONE) return FL_NONE;
  return shadow_picks[word.first + bitCount(word.beams & ((1u << (beam & 31u)) - 1u))];
}
ShadowPicks shadow_picks_of(uint supertile, uint beam) {
  ShadowWordRow word = shadow_words[supertile * params.mask_words + (beam >> 5)];
  if (!is_in_word(word, beam)) return ShadowPicks(0u, 0u, false);
  if (kMaps) return ShadowPicks(1u, 0u, false);  // the map is one
  uint place = list_place(word, beam, shadow_words_used <= uint(shadow_picks.length()));
  if (place == FL_NONE) return ShadowPicks(shadow_lists[beam].count, shadow_lists[beam].first, false);
  return ShadowPicks(shadow_picks[place], place + 1u, true);
}
uint shadow_picked(ShadowPicks picks, uint which) {
  uint at = picks.first + which;
  return picks.listed ? shadow_picks[at] : shadow_whole(at);
}

// Whether the beam has shadows that reach what is visible of it in the supertile.
bool has_shadows(uint supertile, uint beam) {
  return kShadows && is_in_word(shadow_words[supertile * params.mask_words + (beam >> 5)], beam);
}

// Whether a place in the haze that the supertile shows is in the beam's shadows there, from all points of its lens;
// light space, m.
bool is_in_picked(uint supertile, uint beam, vec3 p) {
  ShadowPicks picks = shadow_picks_of(supertile, beam);
  if (kMaps) return picks.count > 0u && map_hides_place(beam, beams[beam], p);
  uint points = 0u;
  for (uint k = 0u; k < picks.count && points != kAllPoints; ++k) {
    uint entry = shadow_picked(picks, k);
    uint planes = entry_planes(entry);
    uint rounds = plane_rounds(planes);
    bool dark = true;
    for (uint round_of = 0u; round_of < rounds && dark; ++round_of) {
      [[unroll]] for (uint n = 0u; n < kShadowRound; ++n) {
        vec4 plane = shadows[entry_shadow(entry)].planes[next_plane(planes)];
        dark = dark && dot(plane.xyz, p) <= plane.w;
      }
    }
    if (dark) points |= entry_point(entry);
  }
  return points == kAllPoints;
}
#endif
