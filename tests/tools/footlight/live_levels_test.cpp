#include <array>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <sys/eventfd.h>
#include <unistd.h>

#include <doctest/doctest.h>

#include "sim/pattern.h"
#include "sim/system_clock.h"
#include "tools/footlight/preview/live_levels.h"

namespace footlight::tools {
namespace {

// A source that gets its frames from another thread.
class MailSource final : public Source {
 public:
  MailSource() : fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) { REQUIRE(fd_ >= 0); }
  ~MailSource() override { close(fd_); }

  void give(Universe universe, std::uint8_t level) {
    const std::lock_guard lock(mutex_);
    letters_.push_back({universe, level});
    const std::uint64_t one = 1;
    REQUIRE(write(fd_, &one, sizeof(one)) == sizeof(one));
  }

  std::string name() const override { return "mail"; }
  int poll_fd() const override { return fd_; }
  PortState state() const override { return PortState::kWorking; }
  PortCounters counters() const override { return {}; }
  std::span<const Universe> universes() const override { return carried_; }
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override {
    const std::lock_guard lock(mutex_);
    std::uint64_t count = 0;
    if (read(fd_, &count, sizeof(count)) != sizeof(count)) return {};
    for (const Letter& letter : letters_) {
      Slots slots;
      slots.fill(letter.level);
      FrameView frame;
      frame.universe = letter.universe;
      frame.stamp_ns = now_ns;
      frame.sender = 1;
      frame.slots = slots;
      receiver.receive(frame);
    }
    letters_.clear();
    return {};
  }

 private:
  struct Letter {
    Universe universe;
    std::uint8_t level;
  };
  int fd_;
  std::array<Universe, 2> carried_{7, 9};
  std::mutex mutex_;
  std::vector<Letter> letters_;
};

struct Live {
  SystemClock clock;
  MailSource* source = nullptr;
  std::unique_ptr<LiveLevels> levels;

  explicit Live(const std::vector<Universe>& universes) {
    auto mail = std::make_unique<MailSource>();
    source = mail.get();
    std::vector<std::unique_ptr<Source>> sources;
    sources.push_back(std::move(mail));
    levels = LiveLevels::start(universes, std::move(sources), clock).value();
  }

  // Polls until universe `index` was written `count` times.
  void wait_for(std::size_t index, std::uint32_t count) {
    const TimeNs end_ns = clock.now_ns() + 30 * kNsPerS;
    do {
      levels->take();
      std::this_thread::yield();
    } while (levels->stamps()[index].revision < count && clock.now_ns() < end_ns);
    REQUIRE(levels->stamps()[index].revision >= count);
  }
};

TEST_CASE("a source that is added while levels are received gives its own, and keeps the others") {
  Live live({7, 9, 11});
  live.source->give(7, 50);
  live.wait_for(0, 1);
  CHECK(!live.levels->fed(11));
  live.levels->add(std::make_unique<PatternSource>("mock:full", Pattern::kFull, every_slot({11})));
  CHECK(live.levels->fed(11));
  live.wait_for(2, 1);
  CHECK(live.levels->levels()[0] == 50);
  CHECK(live.levels->levels()[2 * kSlotCountMax] == 255);
}

TEST_CASE("received levels are at the place of their universe in the rig") {
  Live live({2, 7});
  live.source->give(7, 200);
  live.wait_for(1, 1);
  CHECK(live.levels->levels().size() == 2 * kSlotCountMax);
  CHECK(live.levels->levels()[kSlotCountMax] == 200);
  CHECK(live.levels->levels()[2 * kSlotCountMax - 1] == 200);
  CHECK(live.levels->levels()[0] == 0);
  CHECK(live.levels->stamps()[0].revision == 0);
  CHECK(live.levels->stamps()[1].stamp_ns > 0);
  live.source->give(7, 5);
  live.wait_for(1, 2);
  CHECK(live.levels->levels()[kSlotCountMax] == 5);
}

TEST_CASE("a universe of the rig without a source is reported as such, and one that is not in the rig is left out") {
  Live live({2, 7});
  CHECK_FALSE(live.levels->fed(2));
  CHECK(live.levels->fed(7));
  live.source->give(9, 255);
  live.source->give(7, 1);
  live.wait_for(1, 1);
  CHECK(live.levels->levels()[0] == 0);
  CHECK(live.levels->levels()[kSlotCountMax] == 1);
}

TEST_CASE("a universe that arrives and is not in the rig has its levels, its age and its sender") {
  Live live({2, 7});
  live.source->give(9, 33);
  live.source->give(7, 1);
  live.wait_for(1, 1);
  std::vector<UnpatchedUniverse> others;
  live.levels->take_unpatched(others);
  REQUIRE(others.size() == 1);
  CHECK(others[0].universe == 9);
  CHECK(others[0].levels[0] == 33);
  CHECK(others[0].levels[511] == 33);
  CHECK(others[0].sender == "mail");
  CHECK(others[0].priority == kPriorityDefault);
  CHECK(others[0].stamp_ns > 0);
  CHECK(others[0].frames == 1);
}

TEST_CASE("universes that are not in the rig are bounded in number, and leave when their sender ends") {
  UnpatchedLevels levels(std::vector<Universe>{5}, [](const FrameView& frame) { return std::to_string(frame.sender); });
  const auto receive = [&](Universe universe, TimeNs now_ns, std::uint8_t level) {
    const std::array<std::uint8_t, 2> slots{level, level};
    FrameView frame;
    frame.universe = universe;
    frame.stamp_ns = now_ns;
    frame.sender = 4;
    frame.slots = slots;
    levels.receive(frame);
  };
  std::vector<UnpatchedUniverse> all;
  receive(5, kNsPerS, 1);  // of the rig
  levels.take(all);
  CHECK(all.empty());
  for (Universe universe = 200; universe > 100; --universe) receive(universe, kNsPerS, 7);
  levels.take(all);
  REQUIRE(all.size() == UnpatchedLevels::kUniversesMax);
  CHECK(all.front().universe == 137);
  CHECK(all.back().universe == 200);
  CHECK(all.front().sender == "4");
  CHECK(all.front().levels[1] == 7);
  CHECK(all.front().levels[2] == 0);
  // One that came late takes the place of one that is silent for long.
  receive(150, 2 * kNsPerS, 8);
  receive(1, 2 * kNsPerS, 8);
  levels.take(all);
  CHECK(all.front().universe == 137);
  receive(1, kNsPerS + UnpatchedLevels::kForgottenNs, 9);
  levels.take(all);
  CHECK(all.size() == UnpatchedLevels::kUniversesMax);
  CHECK(all.front().universe == 1);
  CHECK(all[1].universe == 138);
  // Priorities of addresses are no levels, and a sender that ends takes its universe along.
  FrameView frame;
  frame.universe = 1;
  frame.start_code = kStartCodePriorities;
  const std::array<std::uint8_t, 1> priorities{200};
  frame.slots = priorities;
  levels.receive(frame);
  levels.take(all);
  CHECK(all.front().levels[0] == 9);
  frame.start_code = kStartCodeLevels;
  frame.terminated = true;
  levels.receive(frame);
  levels.take(all);
  CHECK(all.front().universe == 138);
}

TEST_CASE("taking without a new frame returns at once with unchanged levels") {
  Live live({7});
  live.levels->take();
  CHECK(live.levels->levels()[0] == 0);
  live.source->give(7, 9);
  live.wait_for(0, 1);
  live.levels->take();
  CHECK(live.levels->levels()[0] == 9);
}

TEST_CASE("a pump that waits for frames ends when its object is destroyed") {
  Live live({7});
  live.levels.reset();
  CHECK(live.levels == nullptr);
}

TEST_CASE("a rig without fixtures cannot be driven live") {
  SystemClock clock;
  const auto live = LiveLevels::start({}, {}, clock);
  REQUIRE_FALSE(live.has_value());
  CHECK(live.error().code == ErrorCode::kBadInput);
}

}  // namespace
}  // namespace footlight::tools
