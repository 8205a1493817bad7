#include "drivers/gpio/gpio_model.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include <sys/eventfd.h>
#include <unistd.h>

#include "sim/core/check.h"

namespace footlight::drivers::mock {
namespace {

constexpr int kMockLineCount = 61;  // the highest number is the highest rate in Hz
constexpr DurationNs kBounceSpacingNs = 200 * kNsPerUs;
constexpr int kBounceEdges = 5;  // closes, opens, closes, opens, closes

std::optional<int> line_of(const std::string& text, std::size_t line_count) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  if (number < 0 || static_cast<std::size_t>(number) >= line_count) return std::nullopt;
  return number;
}

tl::unexpected<Error> no_line(const GpioLineRequest& request, std::size_t line_count) {
  return fail(ErrorCode::kNotFound, "gpio:{}/{}: no such line; the model has {}, 0 to {}", request.chip, request.line,
              line_count, line_count - 1);
}

// A contact that closes and opens periodically; its edges depend on the time alone.
class BeatLine final : public GpioLine {
 public:
  BeatLine(Clock& clock, int rate_hz) : clock_(clock), period_ns_(rate_hz == 0 ? 0 : kNsPerS / rate_hz) {
    if (period_ns_ != 0) next_ns_ = clock_.now_ns() + period_ns_ / 2;
  }

  [[nodiscard]] int fd() const override { return -1; }
  [[nodiscard]] TimeNs next_edge_ns() const override { return next_ns_; }

  Result<std::size_t> read_edges(std::span<GpioEdge> edges) override {
    const TimeNs now_ns = clock_.now_ns();
    std::size_t count = 0;
    while (count < edges.size() && next_ns_ <= now_ns) {
      edges[count++] = {.stamp_ns = next_ns_, .level = step_ % 2 == 0};
      // Steps 0 to 4 close with bounces, step 5 opens; then the cycle repeats.
      if (step_ == 0) closed_ns_ = next_ns_;
      if (step_ < kBounceEdges - 1) {
        next_ns_ += kBounceSpacingNs;
      } else {
        next_ns_ = closed_ns_ + (step_ == kBounceEdges - 1 ? period_ns_ / 2 : period_ns_);
      }
      step_ = (step_ + 1) % (kBounceEdges + 1);
    }
    return count;
  }
  Result<bool> read_level() override { return step_ % 2 == 1; }

 private:
  Clock& clock_;
  const DurationNs period_ns_;
  TimeNs next_ns_ = kTimeNever;
  TimeNs closed_ns_ = 0;
  int step_ = 0;
};

class MockChips final : public GpioChips {
 public:
  explicit MockChips(Clock& clock) : clock_(clock) {}
  Result<std::unique_ptr<GpioLine>> request(const GpioLineRequest& request) override {
    const auto line = line_of(request.line, kMockLineCount);
    if (!line) return no_line(request, kMockLineCount);
    return std::unique_ptr<GpioLine>(std::make_unique<BeatLine>(clock_, *line));
  }

 private:
  Clock& clock_;
};

}  // namespace

GpioModel::GpioModel(int line_count, std::string name)
    : name_(std::move(name)), lines_(static_cast<std::size_t>(line_count)) {
  for (Line& line : lines_) {
    line.event_fd = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    FL_CHECK(line.event_fd >= 0);
  }
}

GpioModel::~GpioModel() {
  for (const Line& line : lines_) ::close(line.event_fd);
}

void GpioModel::drive(int line, bool level, TimeNs stamp_ns) {
  const std::lock_guard lock(mutex_);
  Line& driven = lines_.at(static_cast<std::size_t>(line));
  if (driven.level == level || driven.stuck) return;
  driven.level = level;
  push(driven, {.stamp_ns = stamp_ns, .level = level});
}

void GpioModel::bounce(int line, bool level, TimeNs stamp_ns, int edge_count, DurationNs spacing_ns) {
  for (int i = 0; i < edge_count; ++i) drive(line, (i % 2 == 0) == level, stamp_ns + i * spacing_ns);
}

void GpioModel::push(Line& line, GpioEdge edge) {
  if (!line.requested || !plugged_ || line.drops_edges) return;
  if (line.queue.size() >= kGpioQueueEdges) {
    ++line.lost;
    return;
  }
  line.queue.push_back(edge);
  set_readable(line);
}

void GpioModel::set_readable(Line& line) const {
  std::uint64_t count = 1;
  if (!line.queue.empty() || !plugged_ || line.failing) {
    FL_CHECK(::write(line.event_fd, &count, sizeof count) == sizeof count);
  } else {
    (void)!::read(line.event_fd, &count, sizeof count);  // fails if it was not readable
  }
}

void GpioModel::unplug() {
  const std::lock_guard lock(mutex_);
  plugged_ = false;
  for (Line& line : lines_) {
    line.queue.clear();
    set_readable(line);
  }
}

void GpioModel::plug() {
  const std::lock_guard lock(mutex_);
  plugged_ = true;
  ++plug_count_;
  for (Line& line : lines_) {
    line.requested = false;
    set_readable(line);
  }
}

void GpioModel::hold(int line, std::string consumer) {
  const std::lock_guard lock(mutex_);
  lines_.at(static_cast<std::size_t>(line)).consumer = std::move(consumer);
}

void GpioModel::stick(int line, bool stuck) {
  const std::lock_guard lock(mutex_);
  lines_.at(static_cast<std::size_t>(line)).stuck = stuck;
}

void GpioModel::lose_edges(int line, bool losing) {
  const std::lock_guard lock(mutex_);
  lines_.at(static_cast<std::size_t>(line)).drops_edges = losing;
}

void GpioModel::fail_reads(int line, bool failing) {
  const std::lock_guard lock(mutex_);
  Line& failed = lines_.at(static_cast<std::size_t>(line));
  failed.failing = failing;
  set_readable(failed);
}

void GpioModel::forbid(bool forbidden) {
  const std::lock_guard lock(mutex_);
  forbidden_ = forbidden;
}

bool GpioModel::is_requested(int line) const {
  const std::lock_guard lock(mutex_);
  return lines_.at(static_cast<std::size_t>(line)).requested;
}

std::uint64_t GpioModel::lost(int line) const {
  const std::lock_guard lock(mutex_);
  return lines_.at(static_cast<std::size_t>(line)).lost;
}

GpioLineRequest GpioModel::last_request() const {
  const std::lock_guard lock(mutex_);
  return last_request_;
}

class ModelLine final : public GpioLine {
 public:
  ModelLine(std::shared_ptr<GpioModel> model, std::size_t line, std::uint64_t plug_count)
      : model_(std::move(model)), line_(line), plug_count_(plug_count) {}
  ~ModelLine() override {
    const std::lock_guard lock(model_->mutex_);
    if (is_gone()) return;
    mine().requested = false;
    mine().queue.clear();
    model_->set_readable(mine());
  }
  ModelLine(const ModelLine&) = delete;
  ModelLine& operator=(const ModelLine&) = delete;

  [[nodiscard]] int fd() const override { return model_->lines_[line_].event_fd; }

  Result<std::size_t> read_edges(std::span<GpioEdge> edges) override {
    const std::lock_guard lock(model_->mutex_);
    FL_TRY(check());
    auto& queue = mine().queue;
    const std::size_t count = std::min({edges.size(), queue.size(), kGpioQueueEdges});
    std::copy_n(queue.begin(), count, edges.begin());
    queue.erase(queue.begin(), queue.begin() + static_cast<std::ptrdiff_t>(count));
    model_->set_readable(mine());
    return count;
  }

  Result<bool> read_level() override {
    const std::lock_guard lock(model_->mutex_);
    FL_TRY(check());
    return mine().level;
  }

 private:
  [[nodiscard]] GpioModel::Line& mine() const { return model_->lines_[line_]; }
  [[nodiscard]] bool is_gone() const { return !model_->plugged_ || model_->plug_count_ != plug_count_; }
  [[nodiscard]] Status check() const {
    if (is_gone()) return fail(ErrorCode::kDisconnected, "{} line {}: the chip is gone", model_->name_, line_);
    if (mine().failing) return fail(ErrorCode::kIo, "{} line {}: reading edges: I/O error", model_->name_, line_);
    return {};
  }

  std::shared_ptr<GpioModel> model_;
  const std::size_t line_;
  const std::uint64_t plug_count_;
};

class ModelChips final : public GpioChips {
 public:
  explicit ModelChips(std::shared_ptr<GpioModel> model) : model_(std::move(model)) {}

  Result<std::unique_ptr<GpioLine>> request(const GpioLineRequest& request) override {
    const std::lock_guard lock(model_->mutex_);
    if (!model_->plugged_ || request.chip != model_->name_)
      return fail(ErrorCode::kNotFound, "{}: no such GPIO chip", request.chip);
    if (model_->forbidden_) return fail(ErrorCode::kPermission, "{}: Permission denied", request.chip);
    const auto line = line_of(request.line, model_->lines_.size());
    if (!line) return no_line(request, model_->lines_.size());
    GpioModel::Line& wanted = model_->lines_[static_cast<std::size_t>(*line)];
    if (wanted.requested || !wanted.consumer.empty())
      return fail(ErrorCode::kIo, "{} line {}: in use by \"{}\"", request.chip, *line,
                  wanted.requested ? "footlight" : wanted.consumer);
    model_->last_request_ = request;
    wanted.requested = true;
    wanted.queue.clear();
    model_->set_readable(wanted);
    return std::unique_ptr<GpioLine>(
        std::make_unique<ModelLine>(model_, static_cast<std::size_t>(*line), model_->plug_count_));
  }

 private:
  std::shared_ptr<GpioModel> model_;
};

std::shared_ptr<GpioChips> make_model_chips(std::shared_ptr<GpioModel> model) {
  return std::make_shared<ModelChips>(std::move(model));
}

std::shared_ptr<GpioChips> make_mock_chips(Clock& clock) { return std::make_shared<MockChips>(clock); }

}  // namespace footlight::drivers::mock
