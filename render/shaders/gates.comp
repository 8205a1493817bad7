#version 460
// Numbers the states of gates in the order of the beams, and gives them layers: those that have one keep it, others get
// the one that was out of use for longest and are queued to be drawn. One workgroup walks all beams, so that the same
// frames give the same layers.
#extension GL_GOOGLE_include_directive : require
#define FL_USE_BEAMS
#define FL_BEAMS_ACCESS
#define FL_USE_COUNTS
#define FL_COUNTS_ACCESS readonly
#define FL_GOBO_TABLES_ACCESS
#define FL_GATES_ACCESS
#include "render/shaders/lib/frame.glsl"
#include "render/shaders/lib/forms.glsl"
#include "render/shaders/shared/gauss.h"
#include "render/shaders/shared/beam.h"
#include "render/shaders/lib/profile_index.glsl"
#include "render/shaders/lib/gobo_tables.glsl"
#include "render/shaders/lib/gobo_queue.glsl"
#include "render/shaders/lib/gates.glsl"
#include "render/shaders/lib/gate_key.glsl"

layout(local_size_x = FL_GROUP_GATES) in;

const uint kNobody = 0xffffffffu;
shared GateKey keys[FL_GATES_MAX];     // of the states
shared uint beams_of[FL_GATES_MAX];    // of a state
shared bool waited[FL_GATES_MAX];      // the frame before had this state
shared uint layer_of[FL_GATES_MAX];    // of a state, plus 1
shared bool in_use[FL_GATES_MAX];      // a layer
shared uint last_frame[FL_GATES_MAX];  // of a layer
shared bool is_new[FL_GATES_MAX];      // a layer that has to be drawn
shared uint states;
shared uint unlisted;
shared uint first;

bool same(GateKey a, GateKey b) {
  bool equal = true;
  for (int i = 0; i < FL_GATE_WORDS; ++i) equal = equal && a.word[i] == b.word[i];
  return equal;
}
GateKey key_of(GateRow row) {
  GateKey key;
  for (int i = 0; i < FL_GATE_WORDS; ++i) key.word[i] = row.key[i];
  return key;
}
GateRow row_of(GateKey key, uint planes) {
  GateRow row;
  for (int i = 0; i < FL_GATE_WORDS; ++i) row.key[i] = key.word[i];
  row.last_frame = gates_head.frame + 1u;
  row.planes = planes;
  return row;
}

uint planes_of(uint image) { return image == 0u ? 1u : gobo_tables[image - 1u].planes; }
uint planes_of(GateKey key) {
  uint planes = planes_of(key.word[2] & 0xffffu);
  for (int wheel = 0; wheel < 2; ++wheel) {
    planes = max(planes, max(planes_of(key.word[wheel] & 0xffffu), planes_of(key.word[wheel] >> 16)));
  }
  return planes;
}

// Numbers the states of beams base + lane, and marks these beams.
void number_states(uint base) {
  uint lane = gl_LocalInvocationIndex;
  uint index = base + lane;
  bool open = index < counts.live_count && gate_serves(beams[index]);
  GateKey key;
  uint known = 0u;  // states that this thread has compared
  if (open) key = gate_key(beams[index]);
  for (;;) {
    for (; open && known < states; ++known) {
      if (!same(key, keys[known])) continue;
      open = false;
      atomicAdd(beams_of[known], 1u);
      beams[index].flags |= (gobo_queue.gate_row + known + 1u) << FL_BEAM_GATE_SHIFT;
    }
    if (lane == 0u) first = kNobody;
    barrier();
    if (open) atomicMin(first, lane);
    barrier();
    uint next = first;
    bool full = states == gobo_queue.gates;
    barrier();
    if (next == kNobody) return;
    if (full) break;
    if (lane == next) {
      keys[states] = key;
      ++states;
    }
    barrier();
  }
  if (open) atomicAdd(unlisted, 1u);
}

void main() {
  uint lane = gl_LocalInvocationIndex;
  uint layers = gobo_queue.gates;
  if (lane == 0u) {
    states = 0u;
    unlisted = 0u;
  }
  if (lane < layers) {
    beams_of[lane] = 0u;
    layer_of[lane] = 0u;
    waited[lane] = false;
    in_use[lane] = false;
    is_new[lane] = false;
    last_frame[lane] = gates[lane].last_frame;
  }
  barrier();
  for (uint base = 0u; base < counts.live_count; base += uint(FL_GROUP_GATES)) number_states(base);
  barrier();
  if (lane < states) {
    for (uint layer = 0u; layer < layers; ++layer) {
      if (same(keys[lane], key_of(gates[layer]))) {
        layer_of[lane] = layer + 1u;
        in_use[layer] = true;
      }
      if (same(keys[lane], key_of(gates[layers + layer]))) waited[lane] = true;
    }
  }
  barrier();
  if (lane == 0u) {
    // First the states that stand still: they stay, and what moves needs a new image in each frame anyway.
    uint builds = 0u;
    for (int moving = 0; moving < 2; ++moving) {
      for (uint state = 0u; state < states && builds < gobo_queue.gate_builds; ++state) {
        if (layer_of[state] != 0u || waited[state] != (moving == 0)) continue;
        uint layer = 0u;
        uint oldest = kNobody;
        for (uint other = 0u; other < layers; ++other) {
          if (in_use[other] || last_frame[other] >= oldest) continue;
          oldest = last_frame[other];
          layer = other;
        }
        layer_of[state] = layer + 1u;
        in_use[layer] = true;
        is_new[layer] = true;
        uint row = gobo_queue.gate_row + state + 1u;
        uint profile = keys[state].word[2] >> 16;
        gobo_jobs[2u * gobo_queue.capacity + builds] = layer;
        gobo_jobs[gobo_queue.capacity + builds] = row;
        if (profile < uint(FL_GOBO_PROFILES - 1)) {
          gobo_jobs[gobo_queue.whole_groups[2]] = row | profile << 16;
          ++gobo_queue.whole_groups[2];
        }
        ++builds;
      }
    }
    gobo_queue.gate_groups[2] = builds;
    gobo_queue.lines_groups[2] = builds;
    uint sampled = unlisted;
    for (uint state = 0u; state < states; ++state) sampled += layer_of[state] == 0u ? beams_of[state] : 0u;
    gates_head.states = states;
    gates_head.builds = builds;
    gates_head.sampled_beams = sampled;
  }
  barrier();
  if (lane < layers) {
    GoboTableRow table;
    table.planes = 1u;
    table.lines = 0u;
    table.blurs = 0u;
    table.built = 0u;
    table.gate = 0u;
    for (int p = 0; p < FL_GOBO_PROFILES; ++p) table.whole[p] = 0u;
    GateRow state;
    for (int i = 0; i < FL_GATE_WORDS; ++i) state.key[i] = 0u;
    if (lane < states) {
      table.planes = planes_of(keys[lane]);
      state = row_of(keys[lane], table.planes);
      if (layer_of[lane] != 0u) {
        uint layer = layer_of[lane] - 1u;
        gates[layer] = state;
        uint plane = layer * gobo_queue.gate_planes;
        table.gate = plane + 1u;
        table.lines = gobo_queue.gate_lines_layer + plane + 1u;
        uint profile = keys[lane].word[2] >> 16;
        if (profile < uint(FL_GOBO_PROFILES - 1)) table.whole[profile] = gobo_queue.gate_whole_layer + plane + 1u;
      }
    }
    gobo_tables[gobo_queue.gate_row + lane] = table;
    gates[layers + lane] = state;
  }
  barrier();
  if (lane == 0u) ++gates_head.frame;
}
