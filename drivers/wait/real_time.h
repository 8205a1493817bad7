// Real-time priority for the threads that carry frames: the pump's, and those inside ports that talk to a device.
//
//   want_real_time(kRealTimePriority);            // once, before the ports are opened
//   const Status granted = enter_real_time();     // by each such thread, at its start
//
// A real-time thread runs as soon as it wakes up, whatever the load of the machine. It uses SCHED_FIFO (sched(7)), at a
// priority below that of the kernel's interrupt threads (50), which deliver the frames.
//
// Protection of a machine with one core:
// - A thread that has run for 200 ms without a pause returns to normal priority (RLIMIT_RTTIME; SIGXCPU is handled).
//   The others keep theirs. real_time_given_up() counts these threads.
// - Threads and processes that such a thread starts have normal priority (SCHED_RESET_ON_FORK).
//
// No privilege is needed if the limits allow it: LimitRTPRIO= of a service, or a line in /etc/security/limits.d.
#pragma once

#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::drivers {

inline constexpr int kRealTimePriority = 40;
inline constexpr DurationNs kRealTimeRunMaxNs = 200 * kNsPerMs;

// For the whole process, before any thread enters. 0, the default: enter_real_time() has no effect and succeeds. Uses
// SIGXCPU; the program must not use that signal otherwise.
void want_real_time(int priority);

// For the calling thread. Succeeds without effect if the priority is 0. A limit below the requested priority lowers it.
// Errors: kPermission, with the remedies.
[[nodiscard]] Status enter_real_time();
// Back to normal priority.
void leave_real_time();
// True if the calling thread has real-time priority.
[[nodiscard]] bool is_real_time();

// How many threads have lost it by running without a pause.
[[nodiscard]] int real_time_given_up();

}  // namespace footlight::drivers
