#include "tools/footlight/preview/output_feed.h"

#include <algorithm>
#include <utility>

namespace footlight::tools {
namespace {

constexpr int kDarkFrames = 4;
constexpr DurationNs kPeriodNs = kNsPerS / OutputFeed::kOutputRateHz;

constexpr Slots kZeros{};

class DarkEnd final : public Sink {
 public:
  DarkEnd(std::unique_ptr<Sink> sink, std::string name) : sink_(std::move(sink)), name_(std::move(name)) {}

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] int poll_fd() const override { return sink_->poll_fd(); }
  [[nodiscard]] TimeNs next_deadline_ns() const override { return sink_->next_deadline_ns(); }
  [[nodiscard]] PortState state() const override { return sink_->state(); }
  [[nodiscard]] std::string trouble() const override { return sink_->trouble(); }
  [[nodiscard]] PortCounters counters() const override { return sink_->counters(); }
  void take_figures(std::vector<PortFigure>& into) const override { sink_->take_figures(into); }
  [[nodiscard]] std::optional<PortNotice> take_notice() override { return sink_->take_notice(); }
  [[nodiscard]] std::optional<std::uint64_t> frames_on_line() const override { return sink_->frames_on_line(); }
  [[nodiscard]] std::span<const Universe> universes() const override { return sink_->universes(); }
  [[nodiscard]] double rate_hz_max() const override { return sink_->rate_hz_max(); }
  Status poll(TimeNs now_ns) override { return sink_->poll(now_ns); }
  void rest(TimeNs now_ns) override { sink_->rest(now_ns); }

  Status send(TimeNs now_ns, std::span<const FrameView> frames) override {
    for (const FrameView& frame : frames) {
      const auto at = std::lower_bound(sent_.begin(), sent_.end(), frame.universe);
      if (at == sent_.end() || *at != frame.universe) sent_.insert(at, frame.universe);
    }
    return sink_->send(now_ns, frames);
  }

  void close(TimeNs now_ns) override {
    std::vector<FrameView> dark;
    for (const Universe universe : sent_) {
      FrameView& frame = dark.emplace_back();
      frame.universe = universe;
      frame.stamp_ns = now_ns;
      frame.slots = kZeros;
    }
    // A sink that is lost cannot send them. Its lamps are then those of an output that was cut off.
    for (int i = 0; i < kDarkFrames && !dark.empty(); ++i) (void)sink_->send(now_ns, dark);
    sink_->close(now_ns);
  }

 private:
  std::unique_ptr<Sink> sink_;
  std::string name_;
  std::vector<Universe> sent_;  // ascending
};

}  // namespace

void OutputFeed::give(TimeNs now_ns, std::span<const Universe> universes, std::span<const std::uint8_t> levels,
                      std::span<const Universe> sendable) {
  const auto numbers = given_.numbers();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const int index = static_cast<int>(i);
    FrameView frame;
    frame.universe = numbers[i];
    frame.stamp_ns = now_ns;
    if (std::binary_search(sendable.begin(), sendable.end(), numbers[i])) {
      const auto at = std::lower_bound(universes.begin(), universes.end(), numbers[i]);
      const auto from = static_cast<std::size_t>(at - universes.begin()) * kSlotCountMax;
      if (at == universes.end() || *at != numbers[i] || from + kSlotCountMax > levels.size()) continue;
      frame.slots = levels.subspan(from, kSlotCountMax);
    } else {
      Slots before;
      FrameStamp stamp;
      given_.snapshot(index, before, stamp);
      if (stamp.revision == 0) continue;  // never sent
      frame.slots = kZeros;
    }
    given_.write(index, frame);
  }
  given_ns_.store(now_ns);
}

void OutputFeed::lift(TimeNs now_ns) {
  given_ns_.store(now_ns);
  darkness_.store(Darkness::kNone);
}

Darkness OutputFeed::darkness() const {
  const Darkness latched = darkness_.load();
  if (latched != Darkness::kNone) return latched;
  const Hold hold = hold_.load();
  return hold == Hold::kNotNeeded || hold == Hold::kDown ? Darkness::kNone : Darkness::kNotHeld;
}

void OutputFeed::need_hold(bool on) {
  const Hold before = hold_.load();
  if (on == (before != Hold::kNotNeeded)) return;
  if (!on && before != Hold::kDown) {  // lamps do not light up because nobody holds the key any more
    Darkness none = Darkness::kNone;
    darkness_.compare_exchange_strong(none, Darkness::kAsked);
  }
  hold_.store(on ? Hold::kWaits : Hold::kNotNeeded);
}

void OutputFeed::end_old_hold(TimeNs now_ns) {
  Hold down = Hold::kDown;
  if (now_ns - held_ns_.load() > kHeldMaxNs) hold_.compare_exchange_strong(down, Hold::kWaits);
}

void OutputFeed::hold(TimeNs now_ns, bool held) {
  if (hold_.load() == Hold::kNotNeeded) return;
  if (!held) return hold_.store(Hold::kUp);
  end_old_hold(now_ns);
  held_ns_.store(now_ns);
  Hold up = Hold::kUp;
  hold_.compare_exchange_strong(up, Hold::kDown);
}

void OutputFeed::count_armed(int change) {
  armed_ += change;
  hurry();
}

Status OutputFeed::poll(TimeNs now_ns, FrameReceiver& receiver) {
  if (armed_ == 0) return {};
  due_ns_ = (due_ns_ > now_ns - kPeriodNs ? due_ns_ : now_ns) + kPeriodNs;
  if (now_ns - given_ns_.load() > kSilenceMaxNs) {
    Darkness none = Darkness::kNone;
    darkness_.compare_exchange_strong(none, Darkness::kSilence);
  }
  end_old_hold(now_ns);
  const bool dark = darkness() != Darkness::kNone;
  const auto numbers = given_.numbers();
  ++sequence_;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    Slots slots;
    FrameStamp stamp;
    given_.snapshot(static_cast<int>(i), slots, stamp);
    if (stamp.revision == 0) continue;
    if (dark) slots.fill(0);
    FrameView frame;
    frame.universe = numbers[i];
    frame.stamp_ns = now_ns;
    frame.sender = 1;
    frame.sequence = sequence_;
    frame.slots = slots;
    receiver.receive(frame);
  }
  return {};
}

std::unique_ptr<Sink> ending_dark(std::unique_ptr<Sink> sink, std::string name) {
  return std::make_unique<DarkEnd>(std::move(sink), std::move(name));
}

}  // namespace footlight::tools
