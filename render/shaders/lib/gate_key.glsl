// The state of a gate, as a number of FL_GATE_WORDS words. After gobo_tables.glsl and beam.h.
//
// Angles and offsets are whole steps, so a state is the same for all heads in step, whatever frame they come in.
#include "render/shaders/lib/gate_steps.glsl"
struct GateKey {
  uint word[FL_GATE_WORDS];
};
uint gate_turn_steps(vec2 turn) {
  return uint(int(round(atan(turn.y, turn.x) / kGateTurnStep))) & uint(FL_GATE_TURN_STEPS - 1);
}
uint gate_offset_steps(float offset) {
  return uint(int(kGateNoOffset) + int(clamp(round(offset / kGateOffsetStep), -32767.0, 32767.0)));
}

// Whether tables of its gate would serve a beam.
bool gate_serves(BeamRow row) {
  return has_several_images(row) && row.focus < 0.0 && !(row.y_axis.w > kWideSpread);
}

GateKey gate_key(BeamRow row) {
  vec2 turn_1 = vec2(row.gobo_cos, row.gobo_sin);
  vec2 turn_2 = vec2(row.gobo_2_cos, row.gobo_2_sin);
  vec2 animation_turn = vec2(row.animation_cos, row.animation_sin);
  if (gate_turns_freely(row)) {
    turn_2 = vec2(turn_1.x * turn_2.x + turn_1.y * turn_2.y, turn_1.x * turn_2.y - turn_1.y * turn_2.x);
    turn_1 = vec2(1.0, 0.0);
  }
  uint next_1 = row.offset_1 != 0.0 ? row.next_1 : 0u;
  uint next_2 = row.offset_2 != 0.0 ? row.next_2 : 0u;
  uint profile = gobo_has_whole(row) ? profile_index(row.eye.w) : uint(FL_GOBO_PROFILES - 1);
  GateKey key;
  key.word[0] = row.gobo | next_1 << 16;
  key.word[1] = row.gobo_2 | next_2 << 16;
  key.word[2] = row.animation | profile << 16;
  key.word[3] = ((row.gobo | next_1) != 0u ? gate_turn_steps(turn_1) : 0u) |
                ((row.gobo_2 | next_2) != 0u ? gate_turn_steps(turn_2) : 0u) << 16;
  key.word[4] = (row.animation != 0u ? gate_turn_steps(animation_turn) : 0u) | gate_offset_steps(row.offset_1) << 16;
  key.word[5] = gate_offset_steps(row.offset_2);
  return key;
}
