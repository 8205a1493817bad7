// Light of a chord with the shadows of a map's row. After shadow_map.glsl and kExtinction.

// The light of a chord's lit parts, or of its dark ones where those are subtracted; over J0 and sigma_s.
const uint kSeriesNodes = kProfile ? 6u : 4u;
float row_light(uint beam, BeamShape shape, Medium medium, Chord chord, vec3 ray, RowLine line, bool subtracts) {
  RowSpan span = row_span(line, row_bits(beam, line));
  // Most pixels of a tile are on one side of a shadow's edge.
  if ((span.changes.x | span.changes.y) == 0u && span.dark != subtracts) return 0.0;
  ShadowSeries series;
  shadow_series(shape, medium, chord, ray, kSeriesNodes, kExtinction, series);
  float dark = 0.0;
  while ((span.changes.x | span.changes.y) != 0u) {
    float until = shadow_series_until(series, kSeriesNodes, row_next(span));
    dark += span.dark ? until : -until;
    span.dark = !span.dark;
  }
  if (span.dark) dark += series.whole;
  return subtracts ? dark : series.whole - dark;
}
