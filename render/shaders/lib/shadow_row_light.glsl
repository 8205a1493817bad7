// Light of a chord with the shadows of a map's row. After shadow_map.glsl and kExtinction.

// The light of a chord's dark parts, and all of it; over J0 and sigma_s.
struct RowLight {
  float dark;
  float whole;
};
const uint kSeriesNodes = kProfile ? 6u : 4u;
RowLight row_light(uint beam, BeamShape shape, Medium medium, Chord chord, vec3 ray, RowLine line) {
  RowSpan span = row_span(line, row_bits(beam, line));
  ShadowSeries series;
  shadow_series(shape, medium, chord, ray, kSeriesNodes, kExtinction, series);
  float dark = 0.0;
  while ((span.changes.x | span.changes.y) != 0u) {
    float until = shadow_series_until(series, kSeriesNodes, row_next(span));
    dark += span.dark ? until : -until;
    span.dark = !span.dark;
  }
  if (span.dark) dark += series.whole;
  return RowLight(dark, series.whole);
}
