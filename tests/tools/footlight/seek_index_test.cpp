// Moments of a log with the states of its fixtures: a seek from them equals a replay from the start.
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include "render/frame.h"
#include "render/passes/gather.h"
#include "render/passes/step.h"
#include "tests/sim/dmx_log/support.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/must.h"
#include "tools/demo_show/demo_assets.h"
#include "tools/footlight/pictures/seek_index.h"

namespace footlight::tools {
namespace {

using footlight::testing::HeadlessVulkan;
using footlight::testing::must;

constexpr DurationNs kExposureNs = 20 * kNsPerMs;

// Each look is a millisecond after the one before.
class CountingClock final : public Clock {
 public:
  TimeNs now_ns() override { return now_ns_ += kNsPerMs; }
  void sleep_until_ns(TimeNs) override {}

 private:
  TimeNs now_ns_ = 0;
};

// The demo with its built-in log.
struct Demo {
  fixtures::Rig rig = fixtures::demo_rig();
  fixtures::CompiledRig compiled = must(fixtures::compile(rig));

  [[nodiscard]] Timeline timeline() const {
    const auto bytes = demo::demo_log_bytes();
    return Timeline(must(LogReader::open_bytes({bytes.begin(), bytes.end()}, "the built-in show")), compiled);
  }
  // Only its steps.
  [[nodiscard]] std::unique_ptr<render::Frame> frame(render::vk::Device& device) const {
    return must(render::Frame::create(device, rig, compiled, {.width = 16, .height = 16}, {&render::kStepPass}));
  }
};

void advance(Timeline& timeline, render::Frame& frame, TimeNs until_ns) {
  must(timeline.advance(until_ns, kExposureNs,
                        [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
                          frame.step(levels, dt_ns, new_exposure);
                          if (frame.pending_steps() >= 256) must(frame.run_steps());
                        }));
}

// From the start.
render::FrameState replayed(const Demo& demo, render::vk::Device& device, TimeNs until_ns) {
  const auto frame = demo.frame(device);
  Timeline timeline = demo.timeline();
  advance(timeline, *frame, until_ns);
  return must(frame->save_state());
}

TEST_CASE("a seek from a moment of the index gives the states of a replay from the start, to the bit") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Demo demo;
  const auto frame = demo.frame(vulkan.device());
  Timeline shown = demo.timeline();
  advance(shown, *frame, 7 * kNsPerS);
  const render::FrameState before = must(frame->save_state());
  REQUIRE(std::any_of(before.heads.begin(), before.heads.end(), [](std::byte byte) { return byte != std::byte{0}; }));

  CountingClock clock;
  SeekIndex index(demo.timeline());
  int calls = 0;
  for (; !index.done(); ++calls) {
    REQUIRE(calls < 10'000);
    const TimeNs known_ns = index.known_ns();
    must(index.work(*frame, clock, 3 * kNsPerMs));
    CHECK((index.done() || index.known_ns() > known_ns));
    // What is shown stays.
    const render::FrameState after = must(frame->save_state());
    REQUIRE(after.heads == before.heads);
    REQUIRE(after.time_ns == before.time_ns);
  }
  CHECK(calls > 5);
  CHECK(index.known_ns() == shown.duration_ns());
  CHECK(index.moments().size() >= 20);
  CHECK(index.before(0) == nullptr);

  for (const double seconds : {2.5, 11.0, 30.0, 30.013, 47.77, 59.9}) {
    CAPTURE(seconds);
    const auto until_ns = static_cast<TimeNs>(seconds * 1e9);
    const SeekIndex::Moment* moment = index.before(until_ns - kExposureNs);
    REQUIRE(moment != nullptr);
    CHECK(until_ns - moment->position.now_ns < 3 * kNsPerS);
    Timeline timeline = demo.timeline();
    must(timeline.go_to(moment->position));
    must(frame->load_state(moment->state));
    advance(timeline, *frame, until_ns);
    const render::FrameState sought = must(frame->save_state());
    const render::FrameState played = replayed(demo, vulkan.device(), until_ns);
    CHECK(sought.heads == played.heads);
    CHECK(sought.time_ns == played.time_ns);
    CHECK(sought.air.haze.total == played.air.haze.total);
  }
}

TEST_CASE("the beams of a picture stay while the index is made, also those of more than one workgroup of heads") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  constexpr std::size_t kPars = 100;  // of 5 slots: dimmer, strobe, red, green, blue
  static_assert(kPars > FL_GROUP_HEADS);
  const fixtures::Rig rig = must(fixtures::parse_rig(
      "[rig]\nname = \"r\"\n[[fixture]]\nname = \"A {}\"\ntype = \"generic/par\"\nuniverse = 1\naddress = 1\n"
      "position = [0, 0, 5]\nposition_step = [0.2, 0, 0]\ncount = 100\n",
      "r.toml"));
  const fixtures::CompiledRig compiled = must(fixtures::compile(rig));
  std::vector<testing::OwnedFrame> frames;
  for (std::size_t i = 0; i < 60; ++i) {  // one more is dark each tenth of a second
    testing::OwnedFrame frame;
    frame.time_ns = static_cast<DurationNs>(i) * 100 * kNsPerMs;
    frame.universe = 1;
    frame.slots.assign(kSlotCountMax, 255);
    for (std::size_t par = 0; par < kPars; ++par) {
      frame.slots[5 * par] = par < i ? 0 : 255;
      frame.slots[5 * par + 1] = 0;
    }
    frames.push_back(std::move(frame));
  }
  const auto log = testing::log_bytes(frames, 6 * kNsPerS);
  const auto frame = must(render::Frame::create(vulkan.device(), rig, compiled, {.width = 16, .height = 16},
                                                {&render::kStepPass, &render::kGatherPass}));
  Timeline shown(testing::open_log(log), compiled);
  advance(shown, *frame, kNsPerS - kNsPerMs);
  must(frame->draw(render::View{}, 0));
  const auto before = must(frame->read_beams());
  REQUIRE(before.size() == kPars - 9);
  const auto same = [&](const std::vector<render::BeamRow>& beams) {
    return beams.size() == before.size() &&
           std::memcmp(beams.data(), before.data(), beams.size() * sizeof(render::BeamRow)) == 0;
  };

  CountingClock clock;
  SeekIndex index(Timeline(testing::open_log(log), compiled));
  while (!index.done()) {
    must(index.work(*frame, clock, 20 * kNsPerMs));
    must(frame->draw(render::View{}, 0));
    CHECK(must(frame->read_counts()).live_count == before.size());
    CHECK(same(must(frame->read_beams())));
  }
}

TEST_CASE("an index goes on after the loss of a device as if nothing had happened") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Demo demo;
  CountingClock clock;
  const auto whole_frame = demo.frame(vulkan.device());
  SeekIndex whole(demo.timeline());
  for (int i = 0; i < 3; ++i) must(whole.work(*whole_frame, clock, 3 * kNsPerMs));
  REQUIRE(!whole.moments().empty());

  const auto device = must(render::vk::Device::create({.validation = true, .name_contains = vulkan.device().name()}));
  const auto lost_frame = demo.frame(*device);
  SeekIndex index(demo.timeline(), SeekIndex::kBytesMax);
  device->lose_after(3);  // states out and in, steps; then the states after them are not read
  REQUIRE(!index.work(*lost_frame, clock, kNsPerMs));
  CHECK(device->lost());
  CHECK(index.known_ns() == 0);
  while (index.moments().size() < whole.moments().size()) must(index.work(*whole_frame, clock, 3 * kNsPerMs));
  for (std::size_t i = 0; i < whole.moments().size(); ++i) {
    CHECK(index.moments()[i].position.now_ns == whole.moments()[i].position.now_ns);
    CHECK(index.moments()[i].state.heads == whole.moments()[i].state.heads);
  }
}

TEST_CASE("an index that would take too much memory drops every other moment, and stays below its limit") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Demo demo;
  const auto frame = demo.frame(vulkan.device());
  CountingClock clock;
  SeekIndex whole(demo.timeline());
  while (!whole.done()) must(whole.work(*frame, clock, kNsPerS));
  const std::uint64_t limit = whole.bytes() / 3;
  SeekIndex index(demo.timeline(), limit);
  while (!index.done()) must(index.work(*frame, clock, kNsPerS));
  CHECK(index.bytes() <= limit);
  REQUIRE(index.moments().size() >= 3);
  for (std::size_t i = 1; i < index.moments().size(); ++i) {
    const DurationNs apart_ns = index.moments()[i].position.now_ns - index.moments()[i - 1].position.now_ns;
    CHECK(apart_ns >= 2 * SeekIndex::kSpacingNs);
  }
}

}  // namespace
}  // namespace footlight::tools
