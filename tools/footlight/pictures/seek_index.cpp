#include "tools/footlight/pictures/seek_index.h"

#include <algorithm>
#include <utility>

#include "sim/core/check.h"

namespace footlight::tools {
namespace {

constexpr std::size_t kStepsTogether = 64;  // for which the GPU is called once

std::uint64_t bytes_of(const SeekIndex::Moment& moment) {
  return sizeof(moment) + moment.position.levels.size() + moment.state.bytes();
}

}  // namespace

SeekIndex::SeekIndex(Timeline timeline, std::uint64_t bytes_max, DurationNs spacing_ns)
    : timeline_(std::move(timeline)), bytes_max_(bytes_max), spacing_ns_(spacing_ns) {
  FL_CHECK(timeline_.can_go());
  at_.position = timeline_.position();
}

Status SeekIndex::work(render::Frame& frame, Clock& clock, DurationNs budget_ns) {
  if (done_) return {};
  const TimeNs until_ns = clock.now_ns() + budget_ns;
  FL_ASSIGN(const render::FrameState shown, frame.save_state());
  at_.state.heads.resize(shown.heads.size());  // at first of zeros: no step yet
  const Status made = make_moments(frame, clock, until_ns);
  const Status back = frame.load_state(shown);
  return made ? back : made;
}

Status SeekIndex::make_moments(render::Frame& frame, Clock& clock, TimeNs until_ns) {
  if (interrupted_) FL_TRY(timeline_.go_to(at_.position));
  interrupted_ = true;
  FL_TRY(frame.load_state(at_.state));
  const Timeline::Step step = [&frame](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
    frame.step(levels, dt_ns, new_exposure);
  };
  bool ended = false;
  while (!ended) {
    const TimeNs next_ns = moments_.empty() ? spacing_ns_ : moments_.back().position.now_ns + spacing_ns_;
    FL_ASSIGN(const bool more, timeline_.advance_to_change(timeline_.now_ns() + 1, timeline_.duration_ns(), step));
    const bool due = more && timeline_.now_ns() >= next_ns;
    const bool fits = frame.pending_steps() < kStepsTogether && !frame.steps_are_due();
    if (!due && more && fits) continue;
    FL_TRY(frame.run_steps());
    ended = !more || clock.now_ns() >= until_ns;
    if (!due && !ended) continue;
    FL_ASSIGN(render::FrameState state, frame.save_state());
    at_ = {timeline_.position(), std::move(state)};
    if (due) keep();
    done_ = !more;
  }
  interrupted_ = false;
  return {};
}

void SeekIndex::keep() {
  moments_.push_back(at_);
  bytes_ += bytes_of(at_);
  if (bytes_ <= bytes_max_) return;
  std::size_t kept = 0;
  for (std::size_t i = 1; i < moments_.size(); i += 2) moments_[kept++] = std::move(moments_[i]);
  moments_.resize(kept);
  moments_.shrink_to_fit();
  spacing_ns_ *= 2;
  bytes_ = 0;
  for (const Moment& moment : moments_) bytes_ += bytes_of(moment);
}

std::span<const SeekIndex::Moment> SeekIndex::after(TimeNs time_ns) const {
  const auto first = std::upper_bound(moments_.begin(), moments_.end(), time_ns,
                                      [](TimeNs time, const Moment& moment) { return time < moment.position.now_ns; });
  return {first, moments_.end()};
}

const SeekIndex::Moment* SeekIndex::before(TimeNs time_ns) const {
  const std::size_t count = moments_.size() - after(time_ns).size();
  return count == 0 ? nullptr : &moments_[count - 1];
}

}  // namespace footlight::tools
