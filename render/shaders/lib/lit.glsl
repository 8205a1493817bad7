// Dark culling: a beam whose flux is below the threshold of the frame is not drawn.
bool is_lit(HeadState state, TypeRow type) {
  float flux_lm = type.flux_lm * max(state.red, max(state.green, state.blue));
  return flux_lm > params.dark_lm;
}
