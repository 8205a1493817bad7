#include "tools/footlight/bridge/output_guard.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace footlight::tools {
namespace {

constexpr double kFullCdM2 = 200;  // luminance of a fixture at full
constexpr DurationNs kRecheckNs = 100 * kNsPerMs;
constexpr DurationNs kReportPauseNs = 10 * kNsPerS;
constexpr int kHoldSteps = 12;  // of bisection: 1/4096 of the level

// True if the channel only dims, from dark at 0.
bool dims(const fixtures::CompiledRig& rig, const fixtures::ChannelRow& channel, std::uint32_t param) {
  for (std::uint32_t f = 0; f < channel.function_count; ++f) {
    const fixtures::FunctionRow& function = rig.functions[channel.function_first + f];
    const bool dark_at_0 = f > 0 || (function.dmx_from == 0 && !(function.physical_from > 0));
    const bool rises = function.physical_to >= function.physical_from &&
                       (f == 0 || function.physical_from >= rig.functions[channel.function_first + f - 1].physical_to);
    if (function.param != param || function.master_count != 0 || !dark_at_0 || !rises) return false;
  }
  return channel.function_count != 0 && channel.byte_count != 0;
}

class GuardedSink : public Sink {
 public:
  GuardedSink(std::unique_ptr<Sink> sink, std::shared_ptr<OutputGuard> guard)
      : sink_(std::move(sink)), guard_(std::move(guard)) {}

  [[nodiscard]] std::string name() const override { return sink_->name(); }
  [[nodiscard]] int poll_fd() const override { return sink_->poll_fd(); }
  [[nodiscard]] TimeNs next_deadline_ns() const override { return std::min(sink_->next_deadline_ns(), recheck_ns_); }
  [[nodiscard]] PortState state() const override { return sink_->state(); }
  [[nodiscard]] std::string trouble() const override { return sink_->trouble(); }
  [[nodiscard]] PortCounters counters() const override { return sink_->counters(); }
  void take_figures(std::vector<PortFigure>& into) const override { sink_->take_figures(into); }
  [[nodiscard]] std::optional<std::uint64_t> frames_on_line() const override { return sink_->frames_on_line(); }
  [[nodiscard]] std::optional<PortNotice> take_notice() override {
    auto notice = sink_->take_notice();
    return notice ? std::move(notice) : guard_->take_notice();
  }
  [[nodiscard]] std::span<const Universe> universes() const override { return sink_->universes(); }
  [[nodiscard]] double rate_hz_max() const override { return sink_->rate_hz_max(); }
  void close(TimeNs now_ns) override { sink_->close(now_ns); }

  void rest(TimeNs now_ns) override {
    last_.clear();
    recheck_ns_ = kTimeNever;
    sink_->rest(now_ns);
  }

  Status send(TimeNs now_ns, std::span<const FrameView> frames) override {
    for (const FrameView& frame : frames) store(frame);
    return pass(now_ns, frames);
  }

  Status poll(TimeNs now_ns) override {
    FL_TRY(sink_->poll(now_ns));
    if (last_.empty() || now_ns < recheck_ns_) return {};
    // The levels did not change, but the light may be released by now.
    std::vector<FrameView> frames;
    for (Last& last : last_) {
      last.frame.slots = {last.slots.data(), last.count};
      frames.push_back(last.frame);
    }
    return pass(now_ns, frames);
  }

 private:
  struct Last {  // the last input levels of a universe
    FrameView frame;
    Slots slots{};
    std::size_t count = 0;
  };

  void store(const FrameView& frame) {
    if (frame.start_code != kStartCodeLevels) return;
    auto at = std::find_if(last_.begin(), last_.end(),
                           [&](const Last& last) { return last.frame.universe == frame.universe; });
    if (frame.terminated) {
      if (at != last_.end()) last_.erase(at);
      return;
    }
    if (at == last_.end()) at = last_.insert(last_.end(), Last());
    at->frame = frame;
    at->count = std::max(at->count, std::min(frame.slots.size(), at->slots.size()));
    std::copy_n(frame.slots.begin(), std::min(frame.slots.size(), at->slots.size()), at->slots.begin());
  }

  Status pass(TimeNs now_ns, std::span<const FrameView> frames) {
    guard_->apply(now_ns, frames, held_);
    views_.assign(frames.begin(), frames.end());
    recheck_ns_ = kTimeNever;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (!held_[i]) continue;
      views_[i].slots = {held_[i]->data(), std::min(frames[i].slots.size(), held_[i]->size())};
      recheck_ns_ = now_ns + kRecheckNs;
    }
    return sink_->send(now_ns, views_);
  }

  std::unique_ptr<Sink> sink_;
  std::shared_ptr<OutputGuard> guard_;
  std::vector<Last> last_;
  TimeNs recheck_ns_ = kTimeNever;  // while light is held back
  std::vector<std::optional<Slots>> held_;
  std::vector<FrameView> views_;
};

}  // namespace

Result<std::shared_ptr<OutputGuard>> OutputGuard::make(const fixtures::Rig& rig, FlashMode mode) {
  FL_ASSIGN(fixtures::CompiledRig compiled, fixtures::compile(rig));
  if (compiled.heads.empty() || compiled.universes.empty()) {
    return fail(ErrorCode::kBadInput,
                "{}: has no fixture with an address, so there is nothing to check; pixels of displays are not checked",
                rig.name);
  }
  return std::shared_ptr<OutputGuard>(new OutputGuard(std::move(compiled), mode));
}

OutputGuard::OutputGuard(fixtures::CompiledRig rig, FlashMode mode)
    : rig_(std::move(rig)),
      walker_(rig_),
      mode_(mode),
      areas_(rig_.head_first.size() - 1, 1.0 / static_cast<double>(rig_.head_first.size() - 1)),
      input_(limits_, areas_),
      shown_(limits_, areas_),
      levels_(rig_.universes.size() * kSlotCountMax),
      sent_(levels_.size()),
      tiles_(areas_.size()) {
  for (std::size_t i = 0; i + 1 < rig_.head_first.size(); ++i) {
    Fixture fixture;
    fixture.head_first = rig_.head_first[i];
    fixture.head_end = rig_.head_first[i + 1];
    find_handles(fixture);
    tiles_[i] = light_of(fixture, levels_);
    fixtures_.push_back(std::move(fixture));
  }
}

void OutputGuard::find_handles(Fixture& fixture) const {
  for (const std::uint32_t param : {fixtures::kParamDimmer, fixtures::kParamEmitter}) {
    for (std::uint32_t h = fixture.head_first; h < fixture.head_end; ++h) {
      const fixtures::HeadRow& row = rig_.heads[h];
      const fixtures::TypeRow& type = rig_.types[row.type];
      const std::uint32_t firsts[] = {row.slot_first_1, row.slot_first_2, row.slot_first_3, row.slot_first_4};
      for (std::uint32_t c = 0; c < type.channel_count; ++c) {
        const fixtures::ChannelRow& channel = rig_.channels[type.channel_first + c];
        const std::uint32_t first = firsts[std::min<std::uint32_t>(channel.dmx_break, 3)];
        if (first == fixtures::kNoAddress || !dims(rig_, channel, param)) continue;
        Handle handle;
        handle.bytes = std::min<std::uint32_t>(channel.byte_count, 4);
        for (std::uint32_t b = 0; b < handle.bytes; ++b) {
          const std::uint32_t packed = b < 2 ? channel.slots_01 : channel.slots_23;
          handle.slots[b] = first + (b % 2 == 0 ? packed & 0xffffu : packed >> 16u);
        }
        // Several heads may share a dimmer.
        const bool known = std::any_of(fixture.handles.begin(), fixture.handles.end(),
                                       [&](const Handle& other) { return other.slots == handle.slots; });
        if (!known && handle.slots[handle.bytes - 1] < levels_.size()) fixture.handles.push_back(handle);
      }
    }
    if (!fixture.handles.empty()) return;
  }
}

int OutputGuard::watched_only_count() const {
  return static_cast<int>(std::count_if(fixtures_.begin(), fixtures_.end(),
                                        [](const Fixture& fixture) { return fixture.handles.empty(); }));
}

TileLight OutputGuard::light_of(Fixture& fixture, std::span<const std::uint8_t> levels) {
  TileLight tile;
  fixture.strobe_hz = 0;
  const double share = 1.0 / std::max<std::uint32_t>(fixture.head_end - fixture.head_first, 1);
  for (std::uint32_t h = fixture.head_first; h < fixture.head_end; ++h) {
    const fixtures::TypeRow& type = rig_.types[rig_.heads[h].type];
    const auto decoded = walker_.decoded(levels, h);
    const double level = std::clamp(static_cast<double>(decoded.value[fixtures::kParamDimmer]), 0.0, 1.0);
    const double open = std::clamp(static_cast<double>(decoded.value[fixtures::kParamShutter]), 0.0, 1.0);
    const auto law = static_cast<std::uint32_t>(decoded.value[fixtures::kParamDimmerLaw]);
    const double light =
        share * open * static_cast<double>(walker_.dimmer_light(law, type.law_first, static_cast<float>(level)));
    const bool mixes = type.emitter_count > 0;
    using fixtures::f32::Vec3;
    Vec3 color = mixes ? decoded.emitted : Vec3(type.white_red, type.white_green, type.white_blue);
    if (Vec3 macro = color; walker_.macro_color(macro, decoded, type)) color = mixes ? macro : color * macro;
    tile.red += light * std::clamp(static_cast<double>(color.x), 0.0, 1.0);
    tile.green += light * std::clamp(static_cast<double>(color.y), 0.0, 1.0);
    tile.blue += light * std::clamp(static_cast<double>(color.z), 0.0, 1.0);
    const auto strobe_hz = static_cast<double>(decoded.value[fixtures::kParamStrobeHz]);
    if (light > 0) fixture.strobe_hz = std::max(fixture.strobe_hz, strobe_hz);
  }
  const double luminance = 0.2126 * tile.red + 0.7152 * tile.green + 0.0722 * tile.blue;  // Rec. 709
  fixture.light = luminance;
  tile.luminance_cd_m2 = kFullCdM2 * luminance;
  return tile;
}

void OutputGuard::dim(const Fixture& fixture, double factor) {
  for (const Handle& handle : fixture.handles) {
    std::uint64_t value = 0;
    for (std::uint32_t b = 0; b < handle.bytes; ++b) value = value << 8u | levels_[handle.slots[b]];
    value = static_cast<std::uint64_t>(std::floor(static_cast<double>(value) * factor));
    for (std::uint32_t b = handle.bytes; b > 0; --b) {
      sent_[handle.slots[b - 1]] = static_cast<std::uint8_t>(value & 0xffu);
      value >>= 8u;
    }
  }
}

// The largest level whose light is at most gain times that of the input.
void OutputGuard::hold(Fixture& fixture, double gain) {
  const double input = fixture.light;
  double low = 0, high = 1;
  for (int i = 0; i < kHoldSteps; ++i) {
    const double middle = 0.5 * (low + high);
    dim(fixture, middle);
    light_of(fixture, sent_);
    (fixture.light <= gain * input ? low : high) = middle;
  }
  dim(fixture, low);
  fixture.light = input;
}

void OutputGuard::apply(TimeNs now_ns, std::span<const FrameView> frames, std::vector<std::optional<Slots>>& held) {
  held.assign(frames.size(), std::nullopt);
  std::vector<std::size_t> places(frames.size(), rig_.universes.size());
  bool any = false;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FrameView& frame = frames[i];
    if (frame.start_code != kStartCodeLevels || frame.terminated) continue;
    const auto at = std::lower_bound(rig_.universes.begin(), rig_.universes.end(), frame.universe);
    if (at == rig_.universes.end() || *at != frame.universe) continue;
    places[i] = static_cast<std::size_t>(at - rig_.universes.begin());
    const std::size_t count = std::min<std::size_t>(frame.slots.size(), kSlotCountMax);
    std::copy_n(frame.slots.begin(), count, levels_.begin() + static_cast<std::ptrdiff_t>(places[i] * kSlotCountMax));
    any = true;
  }
  if (!any) return;

  double strobe_area = 0;
  for (std::size_t i = 0; i < fixtures_.size(); ++i) {
    tiles_[i] = light_of(fixtures_[i], levels_);
    if (fixtures_[i].strobe_hz > limits_.flashes && tiles_[i].luminance_cd_m2 >= limits_.change_cd_m2)
      strobe_area += areas_[i];
  }
  const FlashVerdict input = input_.measure(now_ns, tiles_);
  report(now_ns, input, strobe_area);
  if (mode_ != FlashMode::kLimit) return;

  // Strobing fixtures are dark while there are too many; the others keep their light within the limits.
  const bool strobes_held = strobe_area > limits_.area;
  for (std::size_t i = 0; i < fixtures_.size(); ++i) {
    if (strobes_held && fixtures_[i].strobe_hz > limits_.flashes) tiles_[i] = TileLight();
  }
  shown_.limit(now_ns, tiles_, gains_);
  sent_ = levels_;
  bool holds = false;
  for (std::size_t i = 0; i < fixtures_.size(); ++i) {
    const double gain = strobes_held && fixtures_[i].strobe_hz > limits_.flashes ? 0.0 : gains_[i];
    if (!(gain < 1) || fixtures_[i].handles.empty()) continue;
    hold(fixtures_[i], gain);
    holds = true;
  }
  if (!holds) return;
  ++held_count_;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (places[i] == rig_.universes.size()) continue;
    held[i].emplace();
    std::copy_n(sent_.begin() + static_cast<std::ptrdiff_t>(places[i] * kSlotCountMax), kSlotCountMax,
                held[i]->begin());
  }
}

void OutputGuard::report(TimeNs now_ns, const FlashVerdict& input, double strobe_area) {
  const bool harmful = input.harmful || strobe_area > limits_.area;
  if (harmful && !harmful_) ++harmful_count_;
  harmful_ = harmful;
  if (!harmful || (reported_ && now_ns - reported_ns_ < kReportPauseNs)) return;
  reported_ = true;
  reported_ns_ = now_ns;
  const double area = std::max({input.area, input.red_area, strobe_area});
  const std::string what = fmt::format(
      "more than {} flashes a second from {:.0f} % of the rig{}, which can harm people with photosensitive "
      "epilepsy",
      limits_.flashes, 100 * area, input.red_area > input.area ? " in saturated red" : "");
  if (mode_ == FlashMode::kLimit) {
    notice_ = PortNotice{.level = NoticeLevel::kWarning, .id = "flashes-limited", .text = what + "; held back"};
  } else {
    notice_ = PortNotice{
        .level = NoticeLevel::kWarning, .id = "flashes-harmful", .text = what + "; --flashes limit holds them back"};
  }
}

std::optional<PortNotice> OutputGuard::take_notice() { return std::exchange(notice_, std::nullopt); }

std::unique_ptr<Sink> guard_sink(std::unique_ptr<Sink> sink, std::shared_ptr<OutputGuard> guard) {
  return std::make_unique<GuardedSink>(std::move(sink), std::move(guard));
}

}  // namespace footlight::tools
