// Light of one beam in the haze along any ray, by the general path: no tiles, no tables of gobos. After gobo.glsl,
// gauss.h, beam.h, shadow.h, gobo_chord.h, tile_test.glsl, shadow.glsl, surface_light.glsl and kExtinction.

// Nodes of Gauss and samples of a gobo.
struct AirKnobs {
  uint nodes;
  uint taps;
};

// Light of a part of a beam's chord over sigma_s J0.
vec3 light_of_chord(BeamShape beam, BeamRow row, Medium medium, Chord chord, vec3 ray, bool gobo, AirKnobs knobs) {
  const vec2 as_it_is = vec2(1.0, 0.0);  // each wheel turns by itself
  if (gobo) {
    gobo_sample = 0u;
    if (kWide && beam.spread > kWideSpread) {
      return chord_inscatter_gobo(beam, medium, chord, ray, knobs.taps, kExtinction, row.gobo, as_it_is);
    }
    ChordWeight smooth_part = chord_weight(beam, medium, chord, ray, kExtinction);
    return chord_inscatter_taps(beam, chord, smooth_part, ray, knobs.taps, row.gobo, as_it_is);
  }
  if (kMeasured && row.measured != 0u) {
    return vec3(chord_inscatter_measured(beam, medium, chord, ray, knobs.nodes, kExtinction));
  }
  if (kWide && beam.spread > kWideSpread) {
    return vec3(chord_inscatter_wide(beam, medium, chord, ray, 2u, kExtinction));
  }
  return vec3(chord_inscatter_gauss(beam, medium, chord, ray, knobs.nodes, kExtinction));
}

// Of a beam up to t_max_m along a unit ray, over sigma_s J0. eye, ray: in its light space.
vec3 air_light(BeamShape beam, BeamRow row, uint index, Medium medium, vec3 eye, vec3 ray, float t_max_m, bool gobo,
               AirKnobs knobs) {
  Chord chord;
  if (!beam_chord(beam, eye, ray, 0.0, t_max_m, chord)) return vec3(0.0);
  if (kRectangle && row.squeeze > 0.0 && !chord_in_rectangle(chord)) return vec3(0.0);
  if (kBlades && (row.flags & FL_BEAM_BLADES) != 0u) {
    bool seen = true;
    for (int e = 0; e < 4; ++e) seen = chord_cut(chord, blades[index].edge[e].xy, blades[index].edge[e].z) && seen;
    chord_close(chord);
    if (!seen) return vec3(0.0);
  }
  Chord whole = chord;
  vec3 value = vec3(0.0);
  uint bodies = kShadows && !kMaps ? shadow_lists[index].count / kLensPoints : 0u;
  for (uint point = 0u; point < kLensPoints; ++point) {
    ShadowParts parts;
    shadow_parts_clear(parts);
    if (kShadows) {
      ShadowChord ends = shadow_chord(row, beam, whole, ray);
      uint first = shadow_lists[index].first + point * bodies;
      ends.line = kNoRow;  // rows are those of the camera, and of beams with shadows
      if (kMaps) parts = map_parts(index, ends);
      for (uint n = first; n < first + bodies; ++n) shadow_parts_join(parts, shadow_whole(n), ends);
    }
    float from = 0.0;
    bool more = true;
    while (more) {
      float to = 1.0;
      float next = 1.0;
      more = shadow_parts_next(parts, from, to, next);
      to = min(to, 1.0);
      if (kShadows) chord = chord_part(whole, from, to);
      if (to > from) value += point_share(1u << point) * light_of_chord(beam, row, medium, chord, ray, gobo, knobs);
      from = next;
    }
  }
  return value;
}
