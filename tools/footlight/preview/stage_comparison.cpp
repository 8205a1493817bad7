#include "tools/footlight/preview/stage_comparison.h"

#include <algorithm>
#include <utility>


namespace footlight::tools {
namespace {

// The means of rectangles of a picture.
render::ScreenImage small_of(const HostPicture& picture) {
  render::ScreenImage small{kFlashWidth, kFlashHeight, {}};
  small.rgba.resize(std::size_t{kFlashWidth} * kFlashHeight * 4, 255);
  const auto edge = [](int at, int of, int size) { return std::clamp(at * size / of, 0, size); };
  for (int y = 0; y < kFlashHeight; ++y) {
    const int top = std::min(edge(y, kFlashHeight, picture.height), picture.height - 1);
    const int bottom = std::max(edge(y + 1, kFlashHeight, picture.height), top + 1);
    for (int x = 0; x < kFlashWidth; ++x) {
      const int left = std::min(edge(x, kFlashWidth, picture.width), picture.width - 1);
      const int right = std::max(edge(x + 1, kFlashWidth, picture.width), left + 1);
      std::array<std::uint64_t, 3> sum{};
      for (int row = top; row < bottom; ++row) {
        const std::uint8_t* at = picture.rgba.data() + 4 * (static_cast<std::ptrdiff_t>(row) * picture.width + left);
        for (int column = left; column < right; ++column, at += 4) {
          for (std::size_t i = 0; i < 3; ++i) sum[i] += at[i];
        }
      }
      const auto count = static_cast<std::uint64_t>((bottom - top) * (right - left));
      std::uint8_t* const out = small.rgba.data() + 4 * (std::ptrdiff_t{y} * kFlashWidth + x);
      for (std::size_t i = 0; i < 3; ++i) out[i] = static_cast<std::uint8_t>(sum[i] / count);
    }
  }
  return small;
}

}  // namespace

Result<StageCompare> stage_compare_of(std::string_view word) {
  for (const StageCompare mode : {StageCompare::kOff, StageCompare::kBeside, StageCompare::kDifference}) {
    if (word == word_of(mode)) return mode;
  }
  return fail(ErrorCode::kBadInput, "--compare-stage {}: expected beside, difference or off", word);
}

const char* word_of(StageCompare mode) {
  switch (mode) {
    case StageCompare::kBeside: return "beside";
    case StageCompare::kDifference: return "difference";
    default: return "off";
  }
}

// A log is read for the stage only while that shows it.
void StageComparison::set_mode(StageCompare mode) {
  if (mode_ == mode) return;
  mode_ = mode;
  begin_anew();
  difference_.reset();
  watch_.reset();
  held_back_ = false;
  if (on()) return;
  rgba_b_ = {};
  rgba_ = {};
}

void StageComparison::begin_anew() {
  turn_ = kB;
  camera_.reset();
  width_ = height_ = 0;
}

void StageComparison::hold(std::span<const std::uint8_t> levels, DurationNs dt_ns, bool new_exposure) {
  held_.push_back({{levels.begin(), levels.end()}, dt_ns, new_exposure, std::nullopt});
  held_bytes_ += levels.size();
}

bool StageComparison::is_full() const {
  return held_.size() >= render::kStepsHeldMax || held_bytes_ >= render::kStepBytesHeldMax;
}

Status StageComparison::release(render::Frame& frame) {
  if (!std::exchange(holds_, false)) return {};
  held_bytes_ = 0;
  for (const Held& one : std::exchange(held_, {})) {
    if (!one.keeps) {
      frame.step(one.levels, one.dt_ns, one.new_exposure);
      if (frame.steps_are_due()) FL_TRY(frame.run_steps());
    } else if (AsideStage* const moment = asides_[*one.keeps].get(); moment != nullptr) {
      FL_ASSIGN(render::FrameState state, frame.save_state());
      moment->keep(std::move(state));
    }
  }
  return {};
}

void StageComparison::follow(const LevelComparison& compared, const MakePlayer& log) {
  if (!compared.a) set_mode(StageCompare::kOff);
  for (const std::size_t side : {kA, kB}) {
    const std::optional<KeptLevels>& kept = side == kA ? compared.a : compared.b;
    std::unique_ptr<AsideStage>& aside = asides_[side];
    if (aside && aside->entered()) continue;  // its picture is being drawn
    const bool is_log = kept && !kept->log.empty();
    if (!kept || (is_log && !on())) {
      drop(side);
    } else if (numbers_[side] != kept->number) {
      numbers_[side] = kept->number;
      begin_anew();
      if (is_log) {
        std::unique_ptr<LogPlayer> player = log();
        aside = player ? std::make_unique<AsideStage>(std::move(player)) : nullptr;
        if (!aside) numbers_[side] = 0;  // it is not there yet
        continue;
      }
      aside = std::make_unique<AsideStage>(kept->moment);
      std::erase_if(held_, [side](const Held& one) { return one.keeps == side; });
      held_.push_back({{}, 0, false, side});
      holds_ = true;
    }
  }
}

void StageComparison::drop(std::size_t side) {
  asides_[side].reset();
  numbers_[side] = 0;
}

void StageComparison::change_rig() {
  held_.clear();
  held_bytes_ = 0;
  holds_ = false;
  for (const std::size_t side : {kA, kB}) {
    if (!asides_[side]) continue;
    asides_[side]->forget_states();
    if (asides_[side]->is_log()) drop(side);  // the next one gives levels to the other rig
  }
  begin_anew();
}

void StageComparison::lose_frame() {
  held_.clear();
  held_bytes_ = 0;
  holds_ = false;
  begin_anew();
  if (asides_[kA] && asides_[kA]->is_log()) drop(kA);  // its states may be behind it
  for (const std::size_t side : {kA, kB}) {
    if (asides_[side]) asides_[side]->abandon();
  }
}

AsideStage* StageComparison::inside() const {
  for (const auto& aside : asides_) {
    if (aside && aside->entered()) return aside.get();
  }
  return nullptr;
}

std::optional<Transport::Seeking> StageComparison::seeking() const {
  return on() && asides_[kA] ? asides_[kA]->seeking() : std::nullopt;
}

void StageComparison::begin(const OrbitCamera& camera, TimeNs log_ns, DurationNs exposure_ns) {
  if (turn_ != kB) return;
  camera_ = camera;
  log_ns_ = log_ns;
  exposure_ns_ = exposure_ns;
}

void StageComparison::take_b(const HostPicture& picture) {
  rgba_b_.assign(picture.rgba.begin(), picture.rgba.end());
  width_ = picture.width;
  height_ = picture.height;
}

void StageComparison::follow_flashes(FlashMode mode) {
  const bool limits = mode == FlashMode::kLimit;
  if (mode == FlashMode::kOff) {
    watch_.reset();
  } else if (!watch_) {
    watch_ = std::make_unique<FlashWatch>(false);
  }
  if (watch_ && limits && !std::exchange(limits_, limits)) watch_->hold_from_here();
  limits_ = limits;
}

bool StageComparison::take_a(const HostPicture& picture, FlashMode flashes, DurationNs at_ns) {
  if (picture.width != width_ || picture.height != height_ || rgba_b_.empty()) return false;
  std::vector<std::uint8_t> made;
  const PictureDifference difference = difference_of(picture, {rgba_b_, width_, height_}, made);
  follow_flashes(flashes);
  held_back_ = false;
  if (watch_) {
    render::ScreenImage small = small_of({made, width_, height_});
    if (limits_) {
      held_back_ = watch_->must_wait(at_ns, small);
    } else {
      (void)watch_->check(at_ns, small);
    }
  }
  if (held_back_) return false;
  rgba_ = std::move(made);
  difference_ = difference;
  return true;
}

}  // namespace footlight::tools
