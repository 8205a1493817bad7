// Real-time priority for the threads that carry frames: the pump's, and those inside ports that talk to a device.
//
//   want_real_time(kRealTimePriority);            // once, before the ports are opened
//   const Status granted = enter_real_time();     // by each such thread, at its start
//
// A thread that has it runs as soon as it wakes up, whatever else the machine does. It is asked for as SCHED_FIFO
// (sched(7)), at a priority below that of the kernel's interrupt threads (50), which bring the frames.
//
// What keeps it from taking a machine of one core with it:
// - A thread that has run for 200 ms without a rest goes back to normal priority (RLIMIT_RTTIME; SIGXCPU is handled).
//   The others keep theirs. real_time_given_up() says so.
// - What such a thread starts begins at normal priority (SCHED_RESET_ON_FORK).
//
// No privilege is needed where the limits allow it: LimitRTPRIO= of a service, or a line in /etc/security/limits.d.
#pragma once

#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::drivers {

inline constexpr int kRealTimePriority = 40;
inline constexpr DurationNs kRealTimeRunMaxNs = 200 * kNsPerMs;

// For the whole process, before any thread asks. 0, as it is until somebody says otherwise: nobody gets it and nobody
// minds. Takes SIGXCPU; a program that wants real time wants no other use of that signal.
void want_real_time(int priority);

// For the calling thread. Also a success where nobody wants it. A limit that is lower than the priority wanted lowers
// it. Errors: kPermission, with the remedies.
[[nodiscard]] Status enter_real_time();
// Back to normal.
void leave_real_time();
// Whether the calling thread has it.
[[nodiscard]] bool is_real_time();

// How many threads have lost it by running on and on.
[[nodiscard]] int real_time_given_up();

}  // namespace footlight::drivers
