#include "tools/footlight/stop_signal.h"

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <utility>

#include <fcntl.h>
#include <sys/eventfd.h>
#include <unistd.h>

namespace footlight::tools {
namespace {

std::atomic<Pump*> pump_to_stop{nullptr};
std::atomic<std::int64_t> came_ns{0};  // when the first signal came; 0: none did

constexpr std::int64_t kRepeatNs = 1'000'000'000;

std::int64_t monotonic_ns() {
  timespec now = {};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

void on_signal(int number) {
  const int saved_errno = errno;
  const std::int64_t now_ns = monotonic_ns();
  std::int64_t first_ns = 0;
  if (came_ns.compare_exchange_strong(first_ns, now_ns)) {
    if (Pump* const pump = pump_to_stop.load()) pump->request_stop();
  } else if (now_ns - first_ns >= kRepeatNs) {
    std::signal(number, SIG_DFL);
    raise(number);  // takes effect when this handler returns
  }
  errno = saved_errno;
}

void set_one(int signal, void (*handler)(int), int flags) {
  struct sigaction action = {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}
void set_action(void (*handler)(int), int flags) {
  set_one(SIGINT, handler, flags);
  set_one(SIGTERM, handler, flags);
}

bool hangs_up = false;

}  // namespace

// SIGPIPE is ignored because a closed pipe on standard output must not stop the show.
StopSignal::StopSignal() {
  came_ns.store(0);
  std::signal(SIGPIPE, SIG_IGN);
  set_action(on_signal, static_cast<int>(SA_RESTART));
}

StopSignal::~StopSignal() {
  pump_to_stop.store(nullptr);
  if (came()) return;  // repeats are ignored until the program has ended
  set_action(SIG_DFL, 0);
  if (!std::exchange(hangs_up, false)) return;
  set_one(SIGHUP, SIG_DFL, 0);
  set_one(SIGQUIT, SIG_DFL, 0);
}

void StopSignal::stops(Pump* pump) {
  pump_to_stop.store(pump);
  if (pump != nullptr && came()) pump->request_stop();
}

void StopSignal::also_hangup() {
  hangs_up = true;
  set_one(SIGHUP, on_signal, static_cast<int>(SA_RESTART));
  set_one(SIGQUIT, on_signal, static_cast<int>(SA_RESTART));
}

bool StopSignal::came() const { return came_ns.load() != 0; }

namespace {

std::atomic<int> reload_fd{-1};
std::atomic<bool> reload_ended{false};
std::atomic<bool> hangup_came{false};

void wake_reloader() noexcept {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(reload_fd.load(), &one, sizeof one);
}

void on_hangup(int) {
  const int saved_errno = errno;
  hangup_came.store(true);
  wake_reloader();
  errno = saved_errno;
}

bool has_terminal() {
  const int fd = ::open("/dev/tty", O_RDONLY | O_NOCTTY | O_CLOEXEC);
  if (fd >= 0) ::close(fd);
  return fd >= 0;
}

}  // namespace

Status ReloadSignal::opened() const {
  if (reload_fd.load() >= 0) return {};
  return fail(ErrorCode::kIo, "cannot open an eventfd for SIGHUP: {}; raise the limit of open files with 'ulimit -n'",
              std::strerror(open_error_));
}

ReloadSignal::ReloadSignal() : had_terminal_(has_terminal()) {
  reload_ended.store(false);
  hangup_came.store(false);
  reload_fd.store(eventfd(0, EFD_CLOEXEC));
  open_error_ = errno;
  struct sigaction action = {};
  action.sa_handler = on_hangup;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGHUP, &action, nullptr);
}

ReloadSignal::~ReloadSignal() {
  std::signal(SIGHUP, SIG_DFL);
  if (const int fd = reload_fd.exchange(-1); fd >= 0) ::close(fd);
}

ReloadSignal::Request ReloadSignal::wait() {
  std::uint64_t requests = 0;
  while (!reload_ended.load()) {
    if (::read(reload_fd.load(), &requests, sizeof requests) != sizeof requests) {
      if (errno != EINTR) return Request::kNothing;  // no requests can arrive: see opened()
      continue;
    }
    if (reload_ended.load()) break;
    return hangup_came.exchange(false) && had_terminal_ && !has_terminal() ? Request::kStop : Request::kReload;
  }
  return Request::kNothing;
}

void ReloadSignal::request() noexcept { wake_reloader(); }

void ReloadSignal::end() noexcept {
  reload_ended.store(true);
  wake_reloader();
}

}  // namespace footlight::tools
