// Angles and offsets in the number of a gate's state.
const float kGateTurnStep = 6.283185307179586 / float(FL_GATE_TURN_STEPS);
const float kGateOffsetStep = 1.0 / float(FL_GATE_OFFSET_STEPS);
const uint kGateNoOffset = 0x8000u;
vec2 gate_turn(uint steps) {
  float angle = float(steps & 0xffffu) * kGateTurnStep;
  return vec2(cos(angle), sin(angle));
}
float gate_offset(uint steps) { return float(int(steps & 0xffffu) - int(kGateNoOffset)) * kGateOffsetStep; }
