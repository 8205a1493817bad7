#include "tools/footlight/vrsl/mock_pictures.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <map>
#include <mutex>

namespace footlight::tools {
namespace {

using drivers::Picture;
using drivers::PictureStep;
using drivers::PictureTarget;
using SteadyClock = std::chrono::steady_clock;

// One device.
struct Loop {
  std::mutex mutex;
  std::condition_variable shown;
  Picture picture;
  std::uint64_t count = 0;  // of pictures that were shown
  int outputs = 0;
};

std::shared_ptr<Loop> loop_of(const std::string& name) {
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<Loop>> loops;
  const std::lock_guard lock(mutex);
  std::shared_ptr<Loop> loop = loops[name].lock();
  if (!loop) loops[name] = loop = std::make_shared<Loop>();
  return loop;
}

Status refuse_options(const PictureTarget& target) {
  if (target.options.empty()) return {};
  return drivers::unused_option(target, target.options.front().key);
}

class MockOutput final : public drivers::PictureOutput {
 public:
  explicit MockOutput(std::shared_ptr<Loop> loop) : loop_(std::move(loop)) {
    const std::lock_guard lock(loop_->mutex);
    ++loop_->outputs;
  }
  MockOutput(const MockOutput&) = delete;
  MockOutput& operator=(const MockOutput&) = delete;
  ~MockOutput() override {
    const std::lock_guard lock(loop_->mutex);
    --loop_->outputs;
  }
  Status show(const Picture& picture, DurationNs /*time_ns*/) override {
    {
      const std::lock_guard lock(loop_->mutex);
      loop_->picture = picture;
      ++loop_->count;
    }
    loop_->shown.notify_all();
    return {};
  }

 private:
  std::shared_ptr<Loop> loop_;
};

class MockInput final : public drivers::PictureInput {
 public:
  MockInput(std::shared_ptr<Loop> loop, drivers::GridCodec codec, double pictures_hz)
      : loop_(std::move(loop)), codec_(std::move(codec)), period_(std::llround(1e9 / pictures_hz)) {}

  [[nodiscard]] Result<PictureStep> next(Picture& picture, std::optional<DurationNs>& /*time_ns*/,
                                         DurationNs wait_ns) override {
    std::unique_lock lock(loop_->mutex);
    const auto until = SteadyClock::now() + std::chrono::nanoseconds(wait_ns);
    const SteadyClock::time_point due = loop_->outputs > 0 ? until : std::min(until, pattern_due_);
    loop_->shown.wait_until(lock, due, [this] { return loop_->count != seen_; });
    if (loop_->count != seen_) {
      seen_ = loop_->count;
      picture = loop_->picture;
      return PictureStep::kPicture;
    }
    const auto now = SteadyClock::now();
    if (loop_->outputs > 0 || now < pattern_due_) return PictureStep::kNothing;
    lock.unlock();
    // Patterns of the time in which there was an output, or nobody read, are left out.
    pattern_due_ += period_;
    if (pattern_due_ < now) pattern_due_ = now + period_;
    write_pattern(picture);
    return PictureStep::kPicture;
  }

 private:
  void write_pattern(Picture& picture) {
    std::vector<std::uint8_t> levels(std::size_t{drivers::kGridUniversesMax} * kSlotCountMax);
    for (int universe = 1; universe <= drivers::kGridUniversesMax; ++universe) {
      for (Address address = 1; address <= kSlotCountMax; ++address) {
        levels[static_cast<std::size_t>((universe - 1) * kSlotCountMax + slot_of_address(address))] =
            mock_level(universe, address, patterns_);
      }
    }
    codec_.encode(levels, picture, static_cast<std::uint16_t>(patterns_));
    ++patterns_;
  }

  std::shared_ptr<Loop> loop_;
  drivers::GridCodec codec_;
  const std::chrono::nanoseconds period_;
  SteadyClock::time_point pattern_due_ = SteadyClock::now();
  std::uint64_t patterns_ = 0;
  std::uint64_t seen_ = 0;
};

}  // namespace

bool is_mock_target(std::string_view name) { return name == "mock" || name.starts_with("mock/"); }

Result<std::unique_ptr<drivers::PictureOutput>> open_mock_output(const PictureTarget& target) {
  FL_TRY(refuse_options(target));
  return std::make_unique<MockOutput>(loop_of(target.name));
}

Result<std::unique_ptr<drivers::PictureInput>> open_mock_input(const PictureTarget& target) {
  FL_TRY(refuse_options(target));
  auto codec = drivers::GridCodec::make(target.grid);
  if (!codec) return fail(ErrorCode::kBadInput, "{}: {}", target.endpoint, codec.error().message);
  return std::make_unique<MockInput>(loop_of(target.name), std::move(*codec), target.pictures_hz);
}

}  // namespace footlight::tools
