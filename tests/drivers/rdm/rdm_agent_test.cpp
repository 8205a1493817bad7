#include "drivers/rdm/rdm_agent.h"

#include <doctest/doctest.h>

#include <condition_variable>
#include <mutex>

#include <poll.h>

#include "drivers/rdm/rdm_directory.h"

namespace footlight::drivers {
namespace {

// A line that does not answer until it is opened.
class Gate {
 public:
  void open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }
  void pass() {
    std::unique_lock lock(mutex_);
    ++entered_;
    changed_.notify_all();
    changed_.wait(lock, [this] { return open_; });
  }
  void wait_until_entered(int count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return entered_ >= count; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = false;
  int entered_ = 0;
};

class GatedWire final : public RdmWire {
 public:
  explicit GatedWire(Gate& gate) : RdmWire({0x7FF0, 1}), gate_(gate) {}

 private:
  Result<Octets> exchange(std::span<const std::uint8_t>) override {
    gate_.pass();
    return Octets{0xFE};  // like several answers at once: discovery continues without end
  }
  Gate& gate_;
};

}  // namespace

TEST_CASE("an agent accepts sixteen requests while its line is busy, refuses more, and answers each with its ticket") {
  Gate gate;
  auto agent = RdmAgent::create(std::make_unique<GatedWire>(gate));
  REQUIRE(agent.has_value());
  RdmMessage request;
  request.to = {1, 2};
  REQUIRE((*agent)->submit(0, request));
  gate.wait_until_entered(1);
  for (std::uint64_t ticket = 1; ticket <= RdmAgent::kRequestsMax; ++ticket) REQUIRE((*agent)->submit(ticket, request));
  CHECK_FALSE((*agent)->submit(99, request));
  gate.open();
  std::vector<std::uint64_t> tickets;
  while (tickets.size() < 1 + RdmAgent::kRequestsMax) {
    pollfd waiting = {(*agent)->fd(), POLLIN, 0};
    REQUIRE(::poll(&waiting, 1, 10'000) == 1);
    for (const auto& answer : (*agent)->take().answers) {
      CHECK_FALSE(answer.message.has_value());  // the received bytes were not a message
      tickets.push_back(answer.ticket);
    }
  }
  for (std::uint64_t i = 0; i < tickets.size(); ++i) CHECK(tickets[i] == i);
  pollfd quiet = {(*agent)->fd(), POLLIN, 0};
  CHECK(::poll(&quiet, 1, 0) == 0);
}

TEST_CASE("an agent stopped in the middle of a search waits for one request and no more") {
  Gate gate;
  auto agent = RdmAgent::create(std::make_unique<GatedWire>(gate));
  REQUIRE(agent.has_value());
  (*agent)->search();
  gate.wait_until_entered(1);
  std::jthread opener([&gate] { gate.open(); });
  agent->reset();
  gate.wait_until_entered(1);  // the test proves itself by ending
}

TEST_CASE("a directory returns the last entry, and nothing of a closed device") {
  RdmDirectory directory;
  CHECK_FALSE(directory.find(1).has_value());
  bool gone = false;
  Gate gate;
  directory.put(
      1, [&] { return std::make_unique<GatedWire>(gate); }, [&] { return gone; });
  const auto first = directory.find(1);
  REQUIRE(first.has_value());
  CHECK(first->make_line() != nullptr);
  CHECK_FALSE(directory.find(2).has_value());
  directory.put(
      1, [&] { return std::make_unique<GatedWire>(gate); }, [&] { return gone; });
  CHECK(directory.find(1)->generation != first->generation);
  gone = true;
  CHECK_FALSE(directory.find(1).has_value());
}

}  // namespace footlight::drivers
