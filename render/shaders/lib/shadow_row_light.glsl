// Light of a chord with the shadows of a map's row. After shadow_map.glsl and kExtinction.

// Whether light at nodes of the whole chord will do: with clouds each part has its own density, wide beams change too
// much along a chord, and where more nodes are asked for each part has as many.
const float kSeriesSpread = 0.6;
const uint kSeriesNodes = kProfile || kNodes > 3u ? 6u : 4u;
uint series_nodes(BeamShape shape) { return shape.spread > 0.35 ? 6u : kSeriesNodes; }
bool has_series(BeamRow row, RowLine line) {
#ifdef FL_HAZE_FIELD
  return false;
#endif
  return has_row(line) && row.squeeze == 0.0 && row.y_axis.w <= kSeriesSpread && kNodes < 6u;
}

// The light of a chord's lit parts, or of its dark ones where those are subtracted; over J0 and sigma_s.
float row_light(uint beam, BeamShape shape, Medium medium, Chord chord, vec3 ray, RowLine line, bool subtracts) {
  RowSpan span = row_span(line, row_bits(beam, line));
  // Most pixels of a tile are on one side of a shadow's edge.
  if ((span.changes.x | span.changes.y) == 0u && span.dark != subtracts) return 0.0;
  ShadowSeries series;
  uint nodes = series_nodes(shape);
  shadow_series(shape, medium, chord, ray, nodes, kExtinction, series);
  float dark = 0.0;
  while ((span.changes.x | span.changes.y) != 0u) {
    float until = shadow_series_until(series, nodes, row_next(span));
    dark += span.dark ? until : -until;
    span.dark = !span.dark;
  }
  if (span.dark) dark += series.whole;
  return clamp(subtracts ? dark : series.whole - dark, 0.0, max(series.whole, 0.0));
}
