// The tables that this frame builds: those of whole chords, from `capacity` on the sums along lines, behind them the
// layers of gates that it draws, and blurred copies.
layout(set = 0, binding = FL_BINDING_GOBO_QUEUE, std430) buffer GoboQueueBuffer {
  GoboQueue gobo_queue;
  uint gobo_jobs[];  // 1 + GoboTableRow; of whole chords with profile_index() << 16; of gates a layer
};
