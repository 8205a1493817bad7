// With real descriptors, without sleeping: every wait here has an event already, or a deadline in the past or within a
// millisecond. The delay of a wake-up is not tested.
#include "drivers/wait/epoll_waiter.h"

#include <doctest/doctest.h>

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <vector>

#include "sim/system_clock.h"

using footlight::ErrorCode;
using footlight::kNsPerMs;
using footlight::kNsPerS;
using footlight::kTimeNever;
using footlight::SystemClock;
using footlight::TimeNs;
using footlight::drivers::EpollWaiter;

namespace {

// A descriptor that the test makes readable or not.
class Bell {
 public:
  Bell() : fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) { REQUIRE(fd_ >= 0); }
  ~Bell() { ::close(fd_); }
  Bell(const Bell&) = delete;
  Bell& operator=(const Bell&) = delete;
  [[nodiscard]] int fd() const { return fd_; }
  void ring() const { REQUIRE(eventfd_write(fd_, 1) == 0); }
  void quiet() const {
    eventfd_t value = 0;
    REQUIRE(eventfd_read(fd_, &value) == 0);
  }

 private:
  int fd_;
};

std::vector<int> wait(EpollWaiter& waiter, TimeNs deadline_ns, std::size_t room = 8) {
  std::vector<int> ready(room);
  ready.resize(static_cast<std::size_t>(waiter.wait_until(deadline_ns, ready)));
  return ready;
}

std::unique_ptr<EpollWaiter> make() {
  auto waiter = EpollWaiter::make();
  REQUIRE(waiter);
  return std::move(*waiter);
}

EpollWaiter* signalled_waiter = nullptr;
void on_signal(int) { signalled_waiter->interrupt(); }

}  // namespace

TEST_CASE("a wait returns exactly the readable descriptors") {
  const auto waiter = make();
  const Bell a, b;
  REQUIRE(waiter->watch(a.fd()));
  REQUIRE(waiter->watch(b.fd()));
  b.ring();
  CHECK(wait(*waiter, kTimeNever) == std::vector<int>{b.fd()});
  CHECK(wait(*waiter, kTimeNever) == std::vector<int>{b.fd()});  // until it is read
  b.quiet();
  CHECK(wait(*waiter, 1).empty());
}

TEST_CASE("descriptors that do not fit into the result come with the next call") {
  const auto waiter = make();
  const std::array<Bell, 5> bells;
  for (const Bell& bell : bells) {
    REQUIRE(waiter->watch(bell.fd()));
    bell.ring();
  }
  std::vector<int> seen;
  for (int i = 0; i < 20 && seen.size() < bells.size(); ++i)
    for (const int fd : wait(*waiter, kTimeNever, 2)) {
      seen.push_back(fd);
      for (const Bell& bell : bells)
        if (bell.fd() == fd) bell.quiet();
    }
  CHECK(seen.size() == bells.size());
}

TEST_CASE("a deadline in the past, also 0 and below, ends the wait at once") {
  const auto waiter = make();
  for (const TimeNs past_ns : {TimeNs{-5}, TimeNs{0}, TimeNs{1}, TimeNs{1}, TimeNs{2}})
    CHECK(wait(*waiter, past_ns).empty());
}

TEST_CASE("a wait ended by its deadline does not end before it") {
  const auto waiter = make();
  SystemClock clock;
  for (const TimeNs in_ns : {kNsPerMs, kNsPerMs / 2, kNsPerMs}) {
    const TimeNs deadline_ns = clock.now_ns() + in_ns;
    CHECK(wait(*waiter, deadline_ns).empty());
    CHECK(clock.now_ns() >= deadline_ns);
  }
}

TEST_CASE("an interrupt before the wait ends it, once") {
  const auto waiter = make();
  waiter->interrupt();
  waiter->interrupt();
  CHECK(wait(*waiter, kTimeNever).empty());
  const Bell bell;
  REQUIRE(waiter->watch(bell.fd()));
  bell.ring();
  CHECK(wait(*waiter, kTimeNever).size() == 1);  // no interrupt is left
}

TEST_CASE("an interrupt from a signal handler ends a wait without deadline") {
  const auto waiter = make();
  signalled_waiter = waiter.get();
  struct sigaction action {};
  struct sigaction before {};
  action.sa_handler = on_signal;
  REQUIRE(sigaction(SIGUSR1, &action, &before) == 0);
  REQUIRE(raise(SIGUSR1) == 0);
  CHECK(wait(*waiter, kTimeNever).empty());
  REQUIRE(sigaction(SIGUSR1, &before, nullptr) == 0);
}

TEST_CASE("a descriptor number that was closed and reused is reported after watching it again") {
  const auto waiter = make();
  int number = -1;
  {
    const Bell old;
    number = old.fd();
    REQUIRE(waiter->watch(old.fd()));
  }
  const Bell fresh;
  REQUIRE(fresh.fd() == number);  // the lowest free number is used
  fresh.ring();
  CHECK(wait(*waiter, 1).empty());
  REQUIRE(waiter->watch(fresh.fd()));
  CHECK(wait(*waiter, kTimeNever) == std::vector<int>{fresh.fd()});
}

TEST_CASE("an unwatched descriptor is not reported, and unwatching a closed one is harmless") {
  const auto waiter = make();
  const Bell bell;
  REQUIRE(waiter->watch(bell.fd()));
  REQUIRE(waiter->watch(bell.fd()));  // watching twice counts once
  bell.ring();
  waiter->unwatch(bell.fd());
  CHECK(wait(*waiter, 1).empty());
  waiter->unwatch(12345);
}

TEST_CASE("a plain file is refused with a message that names the next step") {
  const auto waiter = make();
  std::FILE* file = std::tmpfile();
  REQUIRE(file != nullptr);
  const auto watched = waiter->watch(fileno(file));
  REQUIRE_FALSE(watched);
  CHECK(watched.error().code == ErrorCode::kUnsupported);
  CHECK(watched.error().message.find("deadline") != std::string::npos);
  CHECK(waiter->watch(-1).error().code == ErrorCode::kIo);
  std::fclose(file);
}
