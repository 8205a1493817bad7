// Flash limit on the outputs of a bridge, with the fixtures of a rig file.
#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/must.h"
#include "tools/footlight/bridge/output_guard.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kFrameNs = 25 * kNsPerMs;

using footlight::testing::must;

// Four lamps of one channel, on slots 0 to 3.
fixtures::Rig rig_of_four() {
  std::string text = "[rig]\nname = \"four\"\n";
  for (int i = 0; i < 4; ++i) {
    text += "[[fixture]]\nname = \"P" + std::to_string(i + 1) + "\"\ntype = \"vrsl/flasher\"\nuniverse = 1\n" +
            "address = " + std::to_string(1 + i) + "\nposition = [" + std::to_string(i) + ", 0, 4]\n";
  }
  return must(fixtures::parse_rig(text, "four.toml"));
}

// Stores the sent frames.
class RecordingSink : public Sink {
 public:
  [[nodiscard]] std::string name() const override { return "recording sink"; }
  [[nodiscard]] PortState state() const override { return PortState::kWorking; }
  [[nodiscard]] PortCounters counters() const override { return {}; }
  Status send(TimeNs /*now_ns*/, std::span<const FrameView> frames) override {
    for (const FrameView& frame : frames) sent.emplace_back(frame.slots.begin(), frame.slots.end());
    return {};
  }
  Status poll(TimeNs /*now_ns*/) override { return {}; }
  [[nodiscard]] std::span<const Universe> universes() const override { return carried; }
  void close(TimeNs /*now_ns*/) override {}
  std::vector<std::vector<std::uint8_t>> sent;
  std::vector<Universe> carried{1};
};

struct Run {
  std::shared_ptr<OutputGuard> guard;
  RecordingSink* recording = nullptr;
  std::unique_ptr<Sink> sink;

  explicit Run(FlashMode mode) : guard(must(OutputGuard::make(rig_of_four(), mode))) {
    auto inner = std::make_unique<RecordingSink>();
    recording = inner.get();
    sink = guard_sink(std::move(inner), guard);
  }
  // The levels that are sent instead.
  std::vector<std::uint8_t> send(TimeNs now_ns, const std::vector<std::uint8_t>& levels) {
    FrameView frame;
    frame.universe = 1;
    frame.stamp_ns = now_ns;
    frame.slots = levels;
    must(sink->send(now_ns, {&frame, 1}));
    return recording->sent.back();
  }
};

std::vector<std::uint8_t> all(std::uint8_t level) {
  std::vector<std::uint8_t> levels(512);
  std::fill_n(levels.begin(), 4, level);
  levels[100] = 77;  // of no fixture
  return levels;
}

// Changes of a tenth of full light and more, one by one.
int swings(const std::vector<std::vector<std::uint8_t>>& sent, std::size_t from, std::size_t to) {
  int count = 0;
  int last = 0;
  double low = sent[from][0], high = low;
  for (std::size_t i = from; i < to; ++i) {
    const double light = sent[i][0];
    low = std::min(low, light);
    high = std::max(high, light);
    if (last != 1 && light - low >= 25.5) {
      ++count;
      last = 1;
      low = high = light;
    } else if (last != -1 && high - light >= 25.5) {
      ++count;
      last = -1;
      low = high = light;
    }
  }
  return count;
}

TEST_CASE("a rig whose dimmers blink ten times a second gets a warning, and its levels are not changed") {
  Run run(FlashMode::kWarn);
  TimeNs now_ns = 0;
  for (int i = 0; i < 80; ++i, now_ns += kFrameNs) {
    const auto levels = all(i / 2 % 2 == 0 ? 255 : 0);
    CHECK(run.send(now_ns, levels) == levels);
  }
  CHECK(run.guard->count_harmful() >= 1);
  CHECK(run.guard->count_held() == 0);
  const auto notice = run.sink->take_notice();
  REQUIRE(notice.has_value());
  CHECK(notice->id == "flashes-harmful");
  CHECK_FALSE(run.sink->take_notice().has_value());  // not each frame
}

TEST_CASE(
    "limited, no second has more than three flashes, nothing is brighter than the input, other slots are unchanged") {
  Run run(FlashMode::kLimit);
  TimeNs now_ns = 0;
  for (int i = 0; i < 200; ++i, now_ns += kFrameNs) {
    const auto levels = all(i / 2 % 2 == 0 ? 255 : 0);
    const auto sent = run.send(now_ns, levels);
    for (std::size_t slot = 0; slot < 512; ++slot) REQUIRE(sent[slot] <= levels[slot]);
    REQUIRE(sent[100] == 77);
  }
  for (std::size_t from = 0; from + 40 <= run.recording->sent.size(); ++from) {
    CHECK(swings(run.recording->sent, from, from + 40) <= 6);
  }
  CHECK(run.guard->count_held() > 10);
  const auto notice = run.sink->take_notice();
  REQUIRE(notice.has_value());
  CHECK(notice->id == "flashes-limited");
}

TEST_CASE("light that was held back is released when allowed, even if the console sends nothing more") {
  Run run(FlashMode::kLimit);
  TimeNs now_ns = 0;
  std::vector<std::uint8_t> sent;
  for (int i = 0; i < 61; ++i, now_ns += kFrameNs) sent = run.send(now_ns, all(i / 2 % 2 == 0 ? 255 : 0));
  REQUIRE(sent[0] < 255);  // the console stays at full, and light is held back
  REQUIRE(run.sink->next_deadline_ns() < kTimeNever);
  for (int i = 0; i < 30 && run.sink->next_deadline_ns() < kTimeNever; ++i) {
    now_ns = run.sink->next_deadline_ns();
    must(run.sink->poll(now_ns));
  }
  CHECK(run.sink->next_deadline_ns() == kTimeNever);
  CHECK(run.recording->sent.back()[0] == 255);
}

TEST_CASE("a slow chase, a fade and a single cue are not changed") {
  Run run(FlashMode::kLimit);
  TimeNs now_ns = 0;
  for (int i = 0; i < 400; ++i, now_ns += kFrameNs) {
    auto levels = all(static_cast<std::uint8_t>(i % 256));
    if (i % 40 < 20) levels[0] = 255;  // one of four at one flash a second
    REQUIRE(run.send(now_ns, levels) == levels);
  }
  CHECK(run.guard->count_harmful() == 0);
}

TEST_CASE("frames of another universe, other start codes and the end of a stream are not changed") {
  Run run(FlashMode::kLimit);
  std::vector<std::optional<Slots>> held;
  std::vector<std::uint8_t> levels(512, 255);
  FrameView other;
  other.universe = 2;
  other.slots = levels;
  FrameView priorities;
  priorities.universe = 1;
  priorities.start_code = kStartCodePriorities;
  priorities.slots = levels;
  FrameView end;
  end.universe = 1;
  end.terminated = true;
  const std::vector<FrameView> frames{other, priorities, end};
  run.guard->apply(0, frames, held);
  REQUIRE(held.size() == 3);
  for (const auto& one : held) CHECK_FALSE(one.has_value());
}

TEST_CASE("--flashes accepts off, warn and limit only") {
  CHECK(must(flash_mode_of("off")) == FlashMode::kOff);
  CHECK(must(flash_mode_of("warn")) == FlashMode::kWarn);
  CHECK(must(flash_mode_of("limit")) == FlashMode::kLimit);
  CHECK_FALSE(flash_mode_of("yes").has_value());
}

}  // namespace
}  // namespace footlight::tools
