// Which beams plainbeams.comp has in the air. After shadow.glsl.
layout(constant_id = FL_SPEC_PLAIN_BEAMS) const bool kPlainBeams = false;

// Plain ones, and where they have shadows those whose light along a chord is one polynomial: narrow ones, with maps
// seen from where rows can be read. What is compared is stored, so that rounding decides nothing.
bool is_plain_beam(BeamRow row) {
  if (!kPlainBeams) return false;
  if (kMaps) return (row.flags & FL_BEAM_ROWS) != 0u;
  return (row.flags & FL_BEAM_PLAIN) != 0u && (!kShadows || row.y_axis.w <= kSeriesSpread);
}
