// Which tables of moments (lib/gobo_chord.glsl) a beam reads. After forms.glsl and gobo_chord.h; the including pass
// declares FL_GOBO_TABLES_ACCESS.
layout(set = 0, binding = FL_BINDING_GOBO_TABLES, std430) FL_GOBO_TABLES_ACCESS buffer GoboTablesBuffer {
  GoboTableRow gobo_tables[];
};

// More stands in the gate than one still image.
bool has_several_images(BeamRow row) {
  return (row.gobo != 0u && row.gobo_2 != 0u) || row.offset_1 != 0.0 || row.offset_2 != 0.0 || row.animation != 0u;
}
// Of several: all of it turns as the first image does. What stands beside the middle does not.
bool gate_turns_freely(BeamRow row) { return row.offset_1 == 0.0 && row.offset_2 == 0.0 && row.animation == 0u; }

// The only image in a beam, sharp or not, or that of its gate.
struct GoboImage {
  uint image;  // 1 + its GoboTableRow; 0: there is none, or more than one thing stands in the beam
  vec2 turn;   // cos, sin
};
GoboImage gobo_only_image(BeamRow row) {
  GoboImage only = GoboImage(row.gobo, vec2(row.gobo_cos, row.gobo_sin));
  if (has_several_images(row)) {
    only.image = row.flags >> FL_BEAM_GATE_SHIFT;
    if (!gate_turns_freely(row)) only.turn = vec2(1.0, 0.0);
  } else if (row.gobo == 0u) {
    only = GoboImage(row.gobo_2, vec2(row.gobo_2_cos, row.gobo_2_sin));
  }
  return only;
}

// Its light comes through as it is drawn.
bool gobo_is_sharp(BeamRow row) { return row.gobo_blur <= 1e-4 && row.focus < 0.0; }

// The first layer, plus 1, of its sums along lines; 0: none.
uint gobo_lines_layer(GoboImage only) { return only.image != 0u ? gobo_tables[only.image - 1u].lines : 0u; }

// The first layer, plus 1, of its blurred copies; 0: none.
uint gobo_blurs_layer(GoboImage only) { return only.image != 0u ? gobo_tables[only.image - 1u].blurs : 0u; }

// Whether whole chords serve the beam: they hold the profile, over the whole image.
bool gobo_has_whole(BeamRow row) {
  return gobo_is_sharp(row) && row.gobo_scale == 1.0 && row.j0.w == 0.0 && row.squeeze == 0.0 && row.measured == 0u;
}
// Their first layer, plus 1; 0: none.
uint gobo_whole_layer(BeamRow row, GoboImage only) {
  bool plain = only.image != 0u && gobo_has_whole(row);
  return plain ? gobo_tables[only.image - 1u].whole[profile_index(row.eye.w)] : 0u;
}
