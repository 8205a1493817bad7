// Each case runs in its own process, since priorities and limits belong to processes.
#include "drivers/wait/real_time.h"

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include <sched.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <doctest/doctest.h>

#include "sim/core/no_signals.h"

namespace footlight::drivers {
namespace {

constexpr int kSkipped = 77;
constexpr uid_t kNobody = 65'534;

// The result of `body` in a child process: 0 on success, else the failed step. -1: it was killed.
int in_child(const std::function<int()>& body) {
  const pid_t pid = fork();
  REQUIRE(pid >= 0);
  if (pid == 0) _exit(body());
  int status = 0;
  REQUIRE(waitpid(pid, &status, 0) == pid);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

void check_child(int code) {
  if (code == kSkipped) {
    MESSAGE("skipped: this user may not choose its limits, its user or its priority");
    return;
  }
  CHECK(code == 0);
}

// Gives this process the right to real time: by limit, or by privilege if limits cannot be raised here.
bool may_have_real_time() {
  const rlimit limit = {.rlim_cur = 95, .rlim_max = 95};
  const sched_param one = {.sched_priority = 1};
  const sched_param none = {};
  setrlimit(RLIMIT_RTPRIO, &limit);
  return sched_setscheduler(0, SCHED_FIFO, &one) == 0 && sched_setscheduler(0, SCHED_OTHER, &none) == 0;
}

// Changes to an ordinary user with this limit.
bool become_user(rlim_t rtprio_max) {
  const rlimit limit = {.rlim_cur = 0, .rlim_max = rtprio_max};
  return setrlimit(RLIMIT_RTPRIO, &limit) == 0 && setuid(kNobody) == 0;
}

int policy() { return sched_getscheduler(0); }

int priority() {
  sched_param param = {};
  return sched_getparam(0, &param) == 0 ? param.sched_priority : -1;
}

TEST_CASE("no thread gets real time unless it was requested for the process") {
  check_child(in_child([] {
    if (!enter_real_time()) return 1;
    return policy() == SCHED_OTHER ? 0 : 2;
  }));
}

TEST_CASE("a thread gets real time if it may, and threads that it starts do not") {
  check_child(in_child([] {
    if (!may_have_real_time()) return kSkipped;
    want_real_time(kRealTimePriority);
    if (!enter_real_time()) return 1;
    if (policy() != (SCHED_FIFO | SCHED_RESET_ON_FORK) || priority() != kRealTimePriority) return 2;
    int policy_of_other = -1;
    std::thread([&] { policy_of_other = policy(); }).join();
    if (policy_of_other != SCHED_OTHER) return 3;
    leave_real_time();
    return policy() == SCHED_OTHER ? 0 : 4;
  }));
}

TEST_CASE("a limit below the requested priority lowers it") {
  check_child(in_child([] {
    if (!become_user(7)) return kSkipped;
    want_real_time(kRealTimePriority);
    if (!enter_real_time()) return 1;
    return priority() == 7 ? 0 : 2;
  }));
}

TEST_CASE("a refusal names both places where it can be allowed, and the option to run without") {
  check_child(in_child([] {
    if (!become_user(0)) return kSkipped;
    want_real_time(kRealTimePriority);
    const Status refused = enter_real_time();
    if (refused || refused.error().code != ErrorCode::kPermission) return 1;
    for (const char* part : {"LimitRTPRIO=40", "/etc/security/limits.d", "--no-realtime"})
      if (refused.error().message.find(part) == std::string::npos) return 2;
    return policy() == SCHED_OTHER ? 0 : 3;
  }));
}

// ThreadSanitizer delays a signal until the thread calls something that waits, which this one never does.
#if !defined(FOOTLIGHT_THREAD_SANITIZER)
TEST_CASE("a thread that never pauses loses real time and continues at normal priority") {
  check_child(in_child([] {
    if (!may_have_real_time()) return kSkipped;
    want_real_time(kRealTimePriority);
    if (!enter_real_time()) return 1;
    while (policy() != SCHED_OTHER) {
    }
    return real_time_given_up() == 1 ? 0 : 2;
  }));
}

TEST_CASE("of several real-time threads the one that never pauses is demoted, also if it blocks signals") {
  check_child(in_child([] {
    if (!may_have_real_time()) return kSkipped;
    want_real_time(kRealTimePriority);
    if (!enter_real_time()) return 1;
    for (int turn = 1; turn <= 2; ++turn) {  // the first thread that spins does not lengthen the time of the second
      const auto begin = std::chrono::steady_clock::now();
      int lost = 0;
      {
        const NoSignals for_the_thread;
        std::thread([&] {
          if (!enter_real_time()) return;
          while (policy() != SCHED_OTHER && std::chrono::steady_clock::now() - begin < std::chrono::seconds(20)) {
          }
          lost = policy() == SCHED_OTHER ? 1 : 0;
        }).join();
      }
      if (!is_real_time()) return 10 * turn + 2;  // the wrong thread was demoted
      if (lost == 0) return 10 * turn + 3;
      if (real_time_given_up() != turn) return 10 * turn + 4;
      rlimit limit = {};
      getrlimit(RLIMIT_RTTIME, &limit);
      if (limit.rlim_cur != kRealTimeRunMaxNs / kNsPerUs) return 10 * turn + 5;
    }
    return 0;
  }));
}
#endif

TEST_CASE("a hard limit on the time of real-time threads is never reached") {
  check_child(in_child([] {
    const rlimit limit = {.rlim_cur = 100'000, .rlim_max = 100'000};  // us
    if (setrlimit(RLIMIT_RTTIME, &limit) != 0) return kSkipped;
    want_real_time(kRealTimePriority);
    rlimit now = {};
    getrlimit(RLIMIT_RTTIME, &now);
    return now.rlim_cur <= 50'000 ? 0 : 1;
  }));
}

}  // namespace
}  // namespace footlight::drivers
