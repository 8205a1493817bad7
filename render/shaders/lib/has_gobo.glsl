// Whether images stand in a beam.
layout(constant_id = FL_SPEC_GOBO) const bool kGobo = false;
bool has_gobo(BeamRow row) {
  return kGobo && ((row.gobo | row.gobo_2 | row.animation) != 0u || row.offset_1 != 0.0 || row.offset_2 != 0.0);
}
