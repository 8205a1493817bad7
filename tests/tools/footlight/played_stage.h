// A moving head of a log that plays: a player with the frame that it drives. Needs a Vulkan device.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "render/frame.h"
#include "render/passes/step.h"
#include "render/passes/tonemap.h"
#include "tests/sim/dmx_log/support.h"
#include "tests/support/must.h"
#include "tools/footlight/preview/log_player.h"

namespace footlight::testing {

constexpr DurationNs kPictureNs = 17 * kNsPerMs;

class SetClock final : public Clock {
 public:
  TimeNs now_ns() override { return time_ns; }
  void sleep_until_ns(TimeNs) override {}
  TimeNs time_ns = 0;
};

// A moving head whose levels change every 70 ms, in a random way.
inline std::vector<std::uint8_t> log_of(DurationNs end_ns, std::uint64_t seed = 3) {
  Random random(seed);
  std::vector<OwnedFrame> frames;
  for (TimeNs time_ns = 0; time_ns < end_ns || frames.empty(); time_ns += 70 * kNsPerMs) {
    OwnedFrame frame;
    frame.time_ns = time_ns;
    frame.universe = 1;
    for (std::size_t slot = 0; slot < 40; ++slot) frame.slots.push_back(random.byte());
    frames.push_back(std::move(frame));
  }
  LogWriterOptions options;
  options.block_span_ns = 500 * kNsPerMs;
  return log_bytes(frames, end_ns, options);
}

// A player with the frame that it drives, and what it gave.
struct PlayedStage {
  static constexpr const char* kRig =
      "[rig]\nname = \"r\"\n[[fixture]]\nname = \"A\"\ntype = \"generic/profile\"\nuniverse = 1\naddress = 1\n"
      "position = [0, 0, 5]\n";

  PlayedStage(render::vk::Device& device_in, LogReader log_in)
      : device(device_in), log(std::move(log_in)), frame(make_frame()), player(make_player()) {}
  PlayedStage(render::vk::Device& device_in, DurationNs end_ns) : PlayedStage(device_in, open_log(log_of(end_ns))) {}

  [[nodiscard]] std::unique_ptr<render::Frame> make_frame() const {
    render::FrameSettings settings{.width = 16, .height = 16};
    settings.auto_exposure = true;
    return must(render::Frame::create(device, rig, compiled, settings, {&render::kStepPass, &render::kTonemapPass}));
  }
  [[nodiscard]] std::unique_ptr<tools::LogPlayer> make_player() {
    return std::make_unique<tools::LogPlayer>([this] { return tools::Timeline(log.again(), compiled); }, clock);
  }
  // The first step after a restart takes jump_ns.
  [[nodiscard]] tools::LogPlayer::Driven driven() {
    return {device,
            *frame,
            taken_over,
            [this](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
              ++steps;
              exposed_ns = new_exposure ? dt_ns : exposed_ns + dt_ns;
              frame->step(levels, dt_ns, new_exposure);
            },
            [this] {
              ++restarts;
              clock.time_ns += jump_ns;
            },
            in_flight};
  }
  void turn(DurationNs dt_ns = kPictureNs) { must(player->turn(transport, dt_ns, driven())); }
  void play(TimeNs until_ns) {
    while (player->now_ns() < until_ns) turn();
  }
  void make_index() {
    while (!player->index()->done()) must(player->work_at_index(kNsPerS, driven()));
  }
  [[nodiscard]] render::FrameState state() const { return must(frame->save_state()); }
  // From the start.
  [[nodiscard]] render::FrameState replayed(TimeNs until_ns) const {
    const auto other = make_frame();
    tools::Timeline timeline(log.again(), compiled);
    must(tools::advance_frame(timeline, *other, until_ns, tools::LogPlayer::kExposureNs,
                       [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
                         other->step(levels, dt_ns, new_exposure);
                       }));
    return must(other->save_state());
  }

  render::vk::Device& device;
  LogReader log;
  fixtures::Rig rig = must(fixtures::parse_rig(kRig, "r.toml"));
  fixtures::CompiledRig compiled = must(fixtures::compile(rig));
  SetClock clock;
  std::unique_ptr<render::Frame> frame;
  std::unique_ptr<tools::LogPlayer> player;
  tools::Transport transport;
  bool taken_over = false;
  bool in_flight = false;  // a picture of the frame
  int steps = 0;
  int restarts = 0;
  DurationNs exposed_ns = 0;
  DurationNs jump_ns = 0;
};

}  // namespace footlight::testing
