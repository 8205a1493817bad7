// The tables that this frame builds: those of whole chords, and from `capacity` on the sums along lines.
layout(set = 0, binding = FL_BINDING_GOBO_QUEUE, std430) buffer GoboQueueBuffer {
  GoboQueue gobo_queue;
  uint gobo_jobs[];  // image; of whole chords with profile_index() << 16
};
