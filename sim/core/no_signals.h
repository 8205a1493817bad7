// Threads that no signal is handled on.
//
// A signal to the process goes to any thread that lets it in. The main one waits in calls that a signal ends; another
// would take it in the middle of its work, and the main one would go on waiting.
#pragma once

#include <array>
#include <csignal>

namespace footlight {

// Threads that are begun while one of these lives let no signal in, but those of their own faults and SIGXCPU, which
// the kernel gives to the thread that used up its time only if that thread does not block it. The caller's own signals
// wait until it goes.
class NoSignals {
 public:
  NoSignals() {
    sigset_t signals;
    sigfillset(&signals);
    for (const int fault : std::array{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGSYS, SIGXCPU})
      sigdelset(&signals, fault);
    pthread_sigmask(SIG_BLOCK, &signals, &before_);
  }
  ~NoSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  NoSignals(const NoSignals&) = delete;
  NoSignals& operator=(const NoSignals&) = delete;

 private:
  sigset_t before_ = {};
};

}  // namespace footlight
