#include "tools/footlight/stop_signal.h"

#include <atomic>
#include <cerrno>
#include <csignal>

namespace footlight::tools {
namespace {

std::atomic<Pump*> pump_to_stop{nullptr};
std::atomic<bool> signal_came{false};

void on_signal(int) {
  const int saved_errno = errno;
  signal_came.store(true);
  if (Pump* const pump = pump_to_stop.load()) pump->request_stop();
  errno = saved_errno;
}

void set_action(void (*handler)(int), int flags) {
  struct sigaction action = {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

}  // namespace

// SA_RESETHAND: the next one has its usual effect. A reader of our output that goes away must not take the show with
// it.
StopSignal::StopSignal() {
  signal_came.store(false);
  std::signal(SIGPIPE, SIG_IGN);
  set_action(on_signal, static_cast<int>(SA_RESETHAND | SA_RESTART));
}

StopSignal::~StopSignal() {
  pump_to_stop.store(nullptr);
  set_action(SIG_DFL, 0);
}

void StopSignal::stops(Pump* pump) {
  pump_to_stop.store(pump);
  if (pump != nullptr && came()) pump->request_stop();
}

bool StopSignal::came() const { return signal_came.load(); }

}  // namespace footlight::tools
