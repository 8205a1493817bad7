// Dark culling: a beam with no more flux than the threshold of the frame is not drawn. The threshold is 0 unless the
// settings say otherwise, so that only beams without any light are left out.
bool is_lit(HeadState state, TypeRow type) {
  float flux_lm = type.flux_lm * max(state.red, max(state.green, state.blue));
  return flux_lm > params.dark_lm;
}
