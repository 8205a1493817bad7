#include "drivers/wait/real_time.h"

#include <sched.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>

namespace footlight::drivers {
namespace {

std::atomic<int> wanted_priority{0};
std::atomic<int> given_up{0};
std::atomic<rlim_t> run_max_us{0};  // soft limit of RLIMIT_RTTIME, set by want_real_time()
static_assert(std::atomic<rlim_t>::is_always_lock_free, "read in a signal handler");

bool set_normal() {
  const sched_param none = {};
  return sched_setscheduler(0, SCHED_OTHER, &none) == 0;
}

// Runs on the thread that used up its time: the kernel sends SIGXCPU to it unless it blocks the signal (NoSignals does
// not). The kernel has then raised the soft limit of the process by 1 s. This restores the first limit for the other
// threads.
void on_no_rest(int) {
  const int saved_errno = errno;
  if (is_real_time() && set_normal()) given_up.fetch_add(1);
  rlimit limit = {};
  if (getrlimit(RLIMIT_RTTIME, &limit) == 0) {
    limit.rlim_cur = run_max_us.load();
    setrlimit(RLIMIT_RTTIME, &limit);
  }
  errno = saved_errno;
}

// Sets the soft limit of a resource to `value`, or as near below it as the hard limit allows.
rlim_t set_soft_limit(__rlimit_resource resource, rlim_t value) {
  rlimit limit = {};
  if (getrlimit(resource, &limit) != 0) return 0;
  limit.rlim_cur = std::min(value, limit.rlim_max);
  return setrlimit(resource, &limit) == 0 ? limit.rlim_cur : 0;
}

}  // namespace

void want_real_time(int priority) {
  wanted_priority.store(priority);
  if (priority == 0) return;
  struct sigaction action = {};
  action.sa_handler = on_no_rest;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGXCPU, &action, nullptr);
  // At the hard limit the kernel kills the process: stay well below it if there is one.
  rlimit run_time = {};
  if (getrlimit(RLIMIT_RTTIME, &run_time) != 0) return;
  const auto wanted_us = static_cast<rlim_t>(kRealTimeRunMaxNs / kNsPerUs);
  const bool bounded = run_time.rlim_max != RLIM_INFINITY;
  run_time.rlim_cur = bounded ? std::min(wanted_us, run_time.rlim_max / 2) : wanted_us;
  run_max_us.store(run_time.rlim_cur);
  setrlimit(RLIMIT_RTTIME, &run_time);
}

Status enter_real_time() {
  const int wanted = wanted_priority.load();
  if (wanted == 0) return {};
  const auto set = [](int priority) {
    sched_param param = {};
    param.sched_priority = priority;
    return sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &param) == 0;
  };
  if (set(wanted)) return {};  // the limits allow it, or the process has the privilege
  const int number = errno;
  const auto allowed = static_cast<int>(set_soft_limit(RLIMIT_RTPRIO, static_cast<rlim_t>(wanted)));
  if (allowed > 0 && set(allowed)) return {};
  return fail(ErrorCode::kPermission,
              "real-time priority refused ({}), so that a busy machine may delay frames; allow it with LimitRTPRIO={} "
              "in the service, or with the line 'USER - rtprio {}' in /etc/security/limits.d/footlight.conf and a new "
              "login; or do without it: --no-realtime",
              std::strerror(number), wanted, wanted);
}

void leave_real_time() {
  if (wanted_priority.load() != 0) set_normal();
}

bool is_real_time() { return (sched_getscheduler(0) & ~SCHED_RESET_ON_FORK) == SCHED_FIFO; }

int real_time_given_up() { return given_up.load(); }

}  // namespace footlight::drivers
