#include "tools/footlight/preview/live_levels.h"

#include <algorithm>

#include "drivers/wait/epoll_waiter.h"
#include "sim/core/no_signals.h"

namespace footlight::tools {
namespace {

constexpr std::size_t kNoticesMax = 64;

}  // namespace

Result<std::unique_ptr<LiveLevels>> LiveLevels::start(std::span<const Universe> universes,
                                                      std::vector<std::unique_ptr<Source>> sources, Clock& clock) {
  if (universes.empty()) {
    return fail(ErrorCode::kBadInput,
                "this rig has no fixture and no display with an address; remove the inputs, patch a fixture, or give a "
                "display a universe");
  }
  std::unique_ptr<LiveLevels> live(new LiveLevels());
  FL_ASSIGN(live->universes_, Universes::make(universes));
  FL_ASSIGN(live->waiter_, drivers::EpollWaiter::make());
  PumpOptions options;
  options.on_notice = [self = live.get()](const Notice& notice) {
    const std::lock_guard lock(self->mutex_);
    if (self->notices_.size() == kNoticesMax) self->notices_.erase(self->notices_.begin());
    self->notices_.emplace_back(notice.text);
  };
  live->pump_ = std::make_unique<Pump>(*live->universes_, clock, *live->waiter_, options);
  const auto name_of = [self = live.get()](const FrameView& frame) -> std::string {
    std::string name;
    for (const Source* source : self->named_) {
      const auto carried = source->universes();
      if (std::find(carried.begin(), carried.end(), frame.universe) == carried.end()) continue;
      if (std::string sender = source->sender_text(frame.sender); !sender.empty()) return sender;
      if (name.empty()) name = source->name();
    }
    return name;
  };
  live->unpatched_ = std::make_unique<UnpatchedLevels>(universes, name_of);
  live->pump_->add_tap(*live->unpatched_);
  for (auto& source : sources) {
    live->pump_->add_source(*source);
    live->named_.push_back(source.get());
    live->keep(std::move(source));
  }
  live->trail_ = std::make_unique<SnapshotTrail>(*live->universes_);
  live->pump_->add_sink(*live->trail_);
  const auto count = static_cast<std::size_t>(live->universes_->count());
  live->levels_.resize(count * kSlotCountMax);
  live->stamps_.resize(count);
  (void)live->pump_->latest_status();  // requests the first one
  const NoSignals for_the_thread;
  live->thread_ = std::jthread([self = live.get()](const std::stop_token& stop) {
    const std::stop_callback stop_pump(stop, [self] { self->pump_->request_stop(); });
    self->pump_->run();
  });
  return live;
}

LiveLevels::~LiveLevels() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

void LiveLevels::add(std::unique_ptr<Source> source) {
  pump_->call([this, added = source.get()] {
    pump_->add_source(*added);
    named_.push_back(added);
  });
  keep(std::move(source));
}

void LiveLevels::keep(std::unique_ptr<Source> source) {
  const auto carried = source->universes();
  fed_.insert(fed_.end(), carried.begin(), carried.end());
  std::sort(fed_.begin(), fed_.end());
  sources_.push_back(std::move(source));
}

void LiveLevels::take() { universes_->snapshot_changed(levels_, stamps_); }

bool LiveLevels::fed(Universe universe) const { return std::binary_search(fed_.begin(), fed_.end(), universe); }

std::vector<std::string> LiveLevels::notices() {
  const std::lock_guard lock(mutex_);
  return std::exchange(notices_, {});
}

}  // namespace footlight::tools
