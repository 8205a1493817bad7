// Watches what a bridge sends to a known rig for flashes that harm people with photosensitive epilepsy, and can hold
// them back. sim/photosensitive.h says what counts as harmful, docs/flashes.md what this cannot see.
//
//   FL_ASSIGN(auto guard, OutputGuard::make(rig, FlashMode::kLimit));
//   auto guarded = guard_sink(std::move(sink), guard);
//
// A fixture is a tile of equal area; its light is dimmer x shutter x colour as its definition decodes them, full light
// stands for a screen's white. A fixture that strobes by itself counts with the rate that its channel asks for.
// Holding back lowers dimmer channels, or those of the emitters where a fixture has no dimmer, and nothing else: no
// light is ever brighter than asked, and what a definition does not know passes as it is. Where the levels stand still
// while light is held back, it is let go as soon as the guidance allows.
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

  // Levels that are about to be sent; `held` gets what is to be sent in their place, one for each frame. Frames of
  // universes that the rig does not have, and those that are no levels, are not looked at: their entry is left empty.
  // Where one is not empty, light is held back: call again within 0.1 s, though no level changes, or it stays so.
  void apply(TimeNs now_ns, std::span<const FrameView> frames, std::vector<std::optional<Slots>>& held);

  // What is to be said since the last time; every 10 s at most.
  [[nodiscard]] std::optional<PortNotice> take_notice();

  [[nodiscard]] std::uint64_t count_harmful() const { return harmful_count_.load(); }  // stretches that would have been
  [[nodiscard]] std::uint64_t count_held() const { return held_count_.load(); }        // looks that were held back
  [[nodiscard]] FlashMode mode() const { return mode_; }
  [[nodiscard]] int fixture_count() const { return static_cast<int>(fixtures_.size()); }
  [[nodiscard]] int watched_only_count() const;  // fixtures without a channel by which they could be held back

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
  TileLight snapshot(Fixture& fixture, std::span<const std::uint8_t> levels);
  void dim(const Fixture& fixture, double factor);
  void hold(Fixture& fixture, double gain);
  void say(TimeNs now_ns, const FlashVerdict& asked, double strobe_area);

  fixtures::CompiledRig rig_;
  fixtures::f32::Walker walker_;
  FlashMode mode_;
  FlashLimits limits_;
  std::vector<Fixture> fixtures_;
  std::vector<double> areas_;
  PhotosensitiveGuard asked_;
  PhotosensitiveGuard shown_;
  std::vector<std::uint8_t> levels_;  // as asked, then as sent
  std::vector<std::uint8_t> sent_;
  std::vector<TileLight> tiles_;
  std::vector<double> gains_;
  bool harmful_ = false;
  TimeNs said_ns_ = 0;
  bool said_once_ = false;
  std::optional<PortNotice> notice_;
  std::atomic<std::uint64_t> harmful_count_{0};
  std::atomic<std::uint64_t> held_count_{0};
};

// The sink behind a guard, which several sinks may share.
[[nodiscard]] std::unique_ptr<Sink> guard_sink(std::unique_ptr<Sink> sink, std::shared_ptr<OutputGuard> guard);

}  // namespace footlight::tools
