// A sound device as a port, with a device that a test controls.
#include "tools/footlight/sound/live_sound.h"

#include <condition_variable>
#include <mutex>

#include <doctest/doctest.h>
#include <poll.h>

#include "drivers/sound/mock_sound.h"
#include "tests/sim/sound/tones.h"
#include "tests/support/must.h"

namespace footlight::tools {
namespace {

using testing::must;

// What the test and the devices share.
struct Stage {
  std::mutex mutex;
  std::condition_variable changed;
  bool plugged = true;
  int opened = 0;
};

// Endless sound at 8 kHz, in pieces of 10 ms; gone when it is unplugged.
class FakeDevice final : public drivers::SoundDevice {
 public:
  explicit FakeDevice(Stage& stage) : stage_(stage) {}
  [[nodiscard]] const drivers::SoundInfo& info() const override { return info_; }
  [[nodiscard]] std::uint64_t overruns() const override { return 0; }
  Status read(std::vector<float>& interleaved, DurationNs /*timeout_ns*/) override {
    const std::lock_guard lock(stage_.mutex);
    if (!stage_.plugged) return fail(ErrorCode::kDisconnected, "fake: no such device");
    interleaved = sine(100, 0.01, 8'000, 0.8);
    return {};
  }

 private:
  Stage& stage_;
  drivers::SoundInfo info_{8'000, 1, "fake", "fake"};
};

OpenSoundDevice opener(Stage& stage) {
  return [&stage]() -> Result<std::unique_ptr<drivers::SoundDevice>> {
    const std::lock_guard lock(stage.mutex);
    if (!stage.plugged) return fail(ErrorCode::kNotFound, "fake: not plugged in");
    ++stage.opened;
    return std::make_unique<FakeDevice>(stage);
  };
}

void plug(Stage& stage, bool plugged) {
  const std::lock_guard lock(stage.mutex);
  stage.plugged = plugged;
}

struct Received final : FrameReceiver {
  void receive(const FrameView& frame) override {
    ++frames;
    universe = frame.universe;
    bass = frame.slots[0];
    size = frame.slots.size();
  }
  int frames = 0;
  Universe universe = 0;
  int bass = 0;
  std::size_t size = 0;
};

fixtures::SoundLevels levels() {
  return must(fixtures::SoundLevels::create(fixtures::plain_sound_map("alsa", 7, 1), fixtures::Rig{}));
}

// Polls whenever the port has work, until the condition is true; at most 20 s.
template <class Condition>
bool poll_until(Source& source, Received& received, Condition condition) {
  for (int i = 0; i < 4'000 && !condition(); ++i) {
    pollfd ready{source.poll_fd(), POLLIN, 0};
    if (::poll(&ready, 1, 5'000) != 1) return false;
    must(source.poll(i, received));
  }
  return condition();
}

TEST_CASE("a device's sound arrives as levels of its universe") {
  Stage stage;
  auto source = must(make_live_sound(levels(), opener(stage), {.name = "audio:fake=7.1"}));
  Received received;
  CHECK(poll_until(*source, received, [&] { return received.bass > 0; }));
  CHECK(received.universe == 7);
  CHECK(received.size == 512);
  CHECK(source->state() == PortState::kWorking);
  CHECK(source->name() == "audio:fake=7.1");
}

TEST_CASE("a device that vanishes is reported with the reason, and its levels come back with it") {
  Stage stage;
  auto source = must(make_live_sound(levels(), opener(stage), {.name = "audio:fake=7.1"}));
  Received received;
  REQUIRE(poll_until(*source, received, [&] { return received.frames > 0; }));
  plug(stage, false);
  REQUIRE(poll_until(*source, received, [&] { return source->state() == PortState::kGone; }));
  CHECK(source->trouble().find("fake") != std::string::npos);
  plug(stage, true);
  const int before = received.frames;
  CHECK(poll_until(*source, received, [&] { return received.frames > before + 2; }));
  CHECK(source->state() == PortState::kWorking);
  CHECK(source->trouble().empty());
  const std::lock_guard lock(stage.mutex);
  CHECK(stage.opened == 2);
}

TEST_CASE("a device that is absent at the start is an error, unless the port may wait for it") {
  Stage stage;
  stage.plugged = false;
  const auto refused = make_live_sound(levels(), opener(stage), {.name = "audio:fake=7.1"});
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().message.find("audio:fake=7.1: fake") == 0);
  auto source = must(make_live_sound(levels(), opener(stage), {.name = "audio:fake=7.1", .wait_for_device = true}));
  CHECK(source->state() == PortState::kGone);
  plug(stage, true);
  Received received;
  CHECK(poll_until(*source, received, [&] { return received.frames > 0; }));
}

TEST_CASE("a build or machine without sound devices is an error, also for a port that waits for its device") {
  const OpenSoundDevice open = []() -> Result<std::unique_ptr<drivers::SoundDevice>> {
    return fail(ErrorCode::kUnsupported, "built without ALSA");
  };
  const auto refused = make_live_sound(levels(), open, {.name = "audio:fake=7.1", .wait_for_device = true});
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().message == "audio:fake=7.1: built without ALSA");
}

TEST_CASE("a device without a clock is read at its rate, and a fast card without pauses, for 30 days") {
  for (const int rate_hz : {8'000, 44'100, 48'000, 192'000}) {
    for (const DurationNs elapsed_s : {1, 600, 86'400, 30 * 86'400}) {
      const DurationNs elapsed_ns = elapsed_s * kNsPerS;
      const auto frames = static_cast<std::uint64_t>(elapsed_s) * static_cast<std::uint64_t>(rate_hz);
      CHECK(read_pause_ns(frames + frames / 2'000, rate_hz, elapsed_ns) == 0);  // 500 ppm fast
      CHECK(read_pause_ns(frames / 2, rate_hz, elapsed_ns) == 0);
      // Twice its rate: the time that is left, less the share of fast cards.
      CHECK(read_pause_ns(2 * frames, rate_hz, elapsed_ns) == elapsed_ns - elapsed_ns / 1'000);
    }
  }
}

TEST_CASE("the model of a device has a beat of 120 a minute, moves every band, and plays as a port") {
  std::vector<DurationNs> waits;
  const auto device = drivers::make_mock_sound([&](DurationNs time_ns) { waits.push_back(time_ns); });
  AudioLink link({}, device->info().rate_hz, device->info().channels);
  std::vector<float> samples;
  std::array<float, kSoundBands> most{};
  float least_bass = 1;
  while (link.frames() < 12U * 48'000) {
    REQUIRE(device->read(samples, 0));
    link.push(samples, [&](const AudioLinkState& state) {
      for (std::size_t band = 0; band < most.size(); ++band) most[band] = std::max(most[band], state.bands[band][0]);
      if (state.step > 200) least_bass = std::min(least_bass, state.bands[0][0]);
    });
  }
  // Each read waits until its 10 ms are over.
  REQUIRE(waits.size() == 1 + 12U * 100);
  for (std::size_t i = 0; i < waits.size(); ++i) REQUIRE(waits[i] == static_cast<DurationNs>(i) * 10 * kNsPerMs);
  for (const float one : most) CHECK(one > 0.5F);
  CHECK(least_bass < 0.2F);
  CHECK(link.state().beat.bpm == doctest::Approx(120).epsilon(0.01));

  const auto port = must(open_live_sound(fixtures::plain_sound_map("mock", 7, 1), {"audio:mock=7.1"}));
  Received received;
  CHECK(poll_until(*port, received, [&] { return received.bass > 100; }));
  CHECK(received.universe == 7);
  CHECK(port->state() == PortState::kWorking);
}

}  // namespace
}  // namespace footlight::tools
