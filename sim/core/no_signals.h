// Keeps signals away from worker threads.
//
// The kernel delivers a signal of the process to any thread that does not block it. The main thread waits in calls that
// a signal interrupts. If another thread took the signal, the main thread would go on waiting.
#pragma once

#include <array>
#include <csignal>

namespace footlight {

// Threads started while a NoSignals exists block all signals except those of their own faults and SIGXCPU. The kernel
// sends SIGXCPU to the thread that used up its time only if that thread does not block it. Signals to the calling
// thread stay pending until the destructor runs.
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
