#include "tools/footlight/preview/ui/report_view.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr double kLeastError = 1e-7;  // an error of 0 is drawn there
constexpr double kLeastMs = 1e-3;

// Decades, from a lower to a higher power of 10.
class LogAxis {
 public:
  void take(double value) {
    if (!std::isfinite(value)) return;
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }
  void settle() {
    from_ = static_cast<int>(std::floor(std::log10(low_)));
    to_ = std::max(static_cast<int>(std::ceil(std::log10(high_))), from_ + 1);
  }
  [[nodiscard]] float at(double value) const {
    const double share = (std::log10(value) - from_) / (to_ - from_);
    return static_cast<float>(std::clamp(share, 0.0, 1.0));
  }
  [[nodiscard]] std::vector<ErrorPlot::Tick> ticks(std::string (*text)(double)) const {
    std::vector<ErrorPlot::Tick> ticks;
    for (int power = from_; power <= to_; ++power) {
      const double value = std::pow(10.0, power);
      ticks.push_back({at(value), text(value)});
    }
    return ticks;
  }

 private:
  double low_ = HUGE_VAL;
  double high_ = 0;
  int from_ = 0;
  int to_ = 1;
};

double error_in_plot(double error) { return std::max(error, kLeastError); }
double ms_in_plot(double ms) { return std::max(ms, kLeastMs); }

}  // namespace

double PassHistory::Row::median_ms() const {
  if (ms.empty()) return 0;
  std::vector<float> sorted = ms;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return static_cast<double>(*middle);
}

double PassHistory::Row::most_ms() const {
  return ms.empty() ? 0 : static_cast<double>(*std::max_element(ms.begin(), ms.end()));
}

void PassHistory::add(std::span<const render::PassTime> passes) {
  std::vector<Row> next;
  const auto push = [](Row& row, double ms) {
    row.ms.push_back(static_cast<float>(ms));
    if (row.ms.size() > kPicturesMax) row.ms.erase(row.ms.begin());
  };
  for (const render::PassTime& pass : passes) {
    const auto known = std::find_if(rows_.begin(), rows_.end(), [&](const Row& row) { return row.name == pass.name; });
    if (known != rows_.end()) {
      next.push_back(std::move(*known));
      rows_.erase(known);
    } else {
      next.push_back({pass.name, std::vector<float>(pictures_)});
    }
    push(next.back(), pass.gpu_ms);
  }
  // Those that this picture has not: at the end, until they are out of sight.
  for (Row& row : rows_) {
    push(row, 0);
    if (row.most_ms() > 0) next.push_back(std::move(row));
  }
  rows_ = std::move(next);
  pictures_ = std::min(pictures_ + 1, kPicturesMax);
}

PassHistory::Row PassHistory::total() const {
  Row all{tr("all"), std::vector<float>(pictures_)};
  for (const Row& row : rows_) {
    for (std::size_t i = 0; i < row.ms.size(); ++i) all.ms[i] += row.ms[i];
  }
  return all;
}

std::optional<ErrorPlot> plot_of(const ReportView& view) {
  if (view.ladder.empty()) return std::nullopt;
  ErrorPlot plot;
  const bool timed = view.present && view.present->ms > 0 && view.picture_ms > 0;
  if (timed) plot.scale = view.picture_ms / view.present->ms;
  const bool measured = view.error.samples > 0 && view.picture_ms > 0;
  LogAxis times;
  LogAxis errors;
  for (const render::KnobPoint& point : view.ladder) {
    times.take(ms_in_plot(point.ms * plot.scale));
    errors.take(error_in_plot(point.error));
  }
  if (view.present) times.take(ms_in_plot(view.present->ms * plot.scale));
  if (view.present) errors.take(error_in_plot(view.present->error));
  if (measured) times.take(ms_in_plot(view.picture_ms));
  if (measured) errors.take(error_in_plot(view.error.rel_l2));
  if (view.target.ms > 0) times.take(ms_in_plot(view.target.ms));
  if (view.target.error > 0) errors.take(error_in_plot(view.target.error));
  times.settle();
  errors.settle();
  const auto place = [&](double ms, double error) {
    return ErrorPlot::Point{times.at(ms_in_plot(ms)), errors.at(error_in_plot(error))};
  };
  for (render::KnobPoint point : view.ladder) {
    point.ms *= plot.scale;
    plot.curve.push_back({place(point.ms, point.error), point});
  }
  if (view.present) plot.present = place(view.present->ms * plot.scale, view.present->error);
  if (measured) {
    plot.measured = place(view.picture_ms, view.error.rel_l2);
    plot.measured_low = errors.at(error_in_plot(view.error.low));
    plot.measured_high = errors.at(error_in_plot(view.error.high));
  }
  if (view.target.ms > 0) plot.target_x = times.at(ms_in_plot(view.target.ms));
  if (view.target.error > 0) plot.target_y = errors.at(error_in_plot(view.target.error));
  plot.ticks_x = times.ticks([](double ms) { return fmt::format("{:g} ms", ms); });
  plot.ticks_y = errors.ticks([](double error) { return fmt::format("{:g} %", 100 * error); });
  return plot;
}

std::string share_text(double share) {
  const double percent = 100 * share;
  return fmt::format("{:.{}f} %", percent, percent < 0.01 ? 4 : percent < 0.1 ? 3 : percent < 10 ? 2 : 0);
}

std::string ms_text(double ms) { return fmt::format("{:.{}f} ms", ms, ms < 10 ? 2 : ms < 100 ? 1 : 0); }

}  // namespace footlight::tools
