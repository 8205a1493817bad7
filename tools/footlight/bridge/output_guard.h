// Detects flashes in the levels that a bridge sends to a rig, which can harm people with photosensitive epilepsy, and
// can hold them back. The limits are in sim/photosensitive.h. docs/flashes.md lists what is not detected.
//
//   FL_ASSIGN(auto guard, OutputGuard::make(rig, FlashMode::kLimit));
//   auto guarded = guard_sink(std::move(sink), guard);
//
// A fixture is a tile of equal area. Its light is dimmer x shutter x colour, decoded with its definition; full light
// counts as a screen's white. A fixture with a strobe channel counts with the rate of that channel. Holding back lowers
// only dimmer channels, or those of the emitters if a fixture has no dimmer. No light is ever brighter than the input,
// and other channels are not changed. If the levels do not change while light is held back, it is released as soon as
// the guidance allows. Pixels of displays are not checked.
//
// Threads: the pump's; count_...() any.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fixtures/model/rig.h"
#include "fixtures/simulate/walker.h"
#include "sim/core/ports.h"
#include "sim/photosensitive.h"
#include "tools/footlight/pictures/flash_mode.h"

namespace footlight::tools {

class OutputGuard {
 public:
  // mode: kWarn or kLimit. Errors: those of fixtures::compile(); kBadInput for a rig without a fixture on an address.
  [[nodiscard]] static Result<std::shared_ptr<OutputGuard>> make(const fixtures::Rig& rig, FlashMode mode);

  // `frames` are about to be sent. `held` gets the levels to send instead, one entry for each frame. The entry is empty
  // if the frame may be sent unchanged, is of a universe without fixtures, or has no levels. If an entry is not empty,
  // light is held back: call again within 0.1 s even if no level changes, else the light stays held back.
  void apply(TimeNs now_ns, std::span<const FrameView> frames, std::vector<std::optional<Slots>>& held);

  // The notice since the last call, if any; at most every 10 s.
  [[nodiscard]] std::optional<PortNotice> take_notice();

  [[nodiscard]] std::uint64_t count_harmful() const { return harmful_count_.load(); }  // periods, held back or not
  [[nodiscard]] std::uint64_t count_held() const { return held_count_.load(); }        // snapshots that were held back
  [[nodiscard]] FlashMode mode() const { return mode_; }
  [[nodiscard]] int fixture_count() const { return static_cast<int>(fixtures_.size()); }
  [[nodiscard]] int watched_only_count() const;  // fixtures without a channel that could hold them back

 private:
  struct Handle {                          // a channel that dims
    std::array<std::uint32_t, 4> slots{};  // of all levels, coarse first
    std::uint32_t bytes = 0;
  };
  struct Fixture {
    std::uint32_t head_first = 0;
    std::uint32_t head_end = 0;
    std::vector<Handle> handles;
    double strobe_hz = 0;
    double light = 0;  // 0 to 1
  };

  OutputGuard(fixtures::CompiledRig rig, FlashMode mode);
  void find_handles(Fixture& fixture) const;
  TileLight light_of(Fixture& fixture, std::span<const std::uint8_t> levels);
  void dim(const Fixture& fixture, double factor);
  void hold(Fixture& fixture, double gain);
  void report(TimeNs now_ns, const FlashVerdict& input, double strobe_area);

  fixtures::CompiledRig rig_;
  fixtures::f32::Walker walker_;
  FlashMode mode_;
  FlashLimits limits_;
  std::vector<Fixture> fixtures_;
  std::vector<double> areas_;
  PhotosensitiveGuard input_;
  PhotosensitiveGuard shown_;
  std::vector<std::uint8_t> levels_;  // of the input
  std::vector<std::uint8_t> sent_;
  std::vector<TileLight> tiles_;
  std::vector<double> gains_;
  bool harmful_ = false;
  TimeNs reported_ns_ = 0;
  bool reported_ = false;
  std::optional<PortNotice> notice_;
  std::atomic<std::uint64_t> harmful_count_{0};
  std::atomic<std::uint64_t> held_count_{0};
};

// Puts the sink behind a guard, which several sinks may share.
[[nodiscard]] std::unique_ptr<Sink> guard_sink(std::unique_ptr<Sink> sink, std::shared_ptr<OutputGuard> guard);

}  // namespace footlight::tools
