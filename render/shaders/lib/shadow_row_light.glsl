// Light of a chord with the shadows of a map's row. After shadow_map.glsl and kExtinction.

// Whether light at nodes of the whole chord will do: with clouds each part has its own density, wide beams change too
// much along a chord (kSeriesSpread), and where more nodes are asked for each part has as many.
const bool kManyNodes = kProfile || kNodes > 3u;
// FL_SERIES_TWICE: the code for 6 and that for 4 nodes stand beside each other, so that what follows from their number
// is constant. That is quicker in a short shader alone.
void series_of(BeamShape shape, Medium medium, Chord chord, vec3 ray, out ShadowSeries series) {
  bool many = kManyNodes || shape.spread > 0.35;
#ifdef FL_SERIES_TWICE
  if (many) shadow_series(shape, medium, chord, ray, 6u, kExtinction, series);
  else shadow_series(shape, medium, chord, ray, 4u, kExtinction, series);
#else
  shadow_series(shape, medium, chord, ray, many ? 6u : 4u, kExtinction, series);
#endif
}
#ifdef FL_HAZE_FIELD
const bool kSeries = false;
#else
const bool kSeries = kMapRows && kNodes <= uint(FL_ROW_NODES_MAX);
#endif
bool has_series(BeamRow row, RowLine line) {
  return kSeries && has_row(line) && row.squeeze == 0.0 && row.y_axis.w <= kSeriesSpread;
}

// The light of a chord's lit parts, or of its dark ones where those are subtracted; over J0 and sigma_s.
float row_light(uint beam, BeamShape shape, Medium medium, Chord chord, vec3 ray, RowLine line, bool subtracts) {
  RowSpan span = row_span(line, row_bits(beam, line));
  // Most pixels of a tile are on one side of a shadow's edge.
  if ((span.changes.x | span.changes.y) == 0u && span.dark != subtracts) return 0.0;
  ShadowSeries series;
  series_of(shape, medium, chord, ray, series);
  float dark = 0.0;
  while ((span.changes.x | span.changes.y) != 0u) {
    float until = shadow_series_until(series, row_next(span));
    dark += span.dark ? until : -until;
    span.dark = !span.dark;
  }
  if (span.dark) dark += series.whole;
  return clamp(subtracts ? dark : series.whole - dark, 0.0, max(series.whole, 0.0));
}
