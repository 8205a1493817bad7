#include "tools/footlight/progress.h"

#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include "tools/footlight/monitor/terminal.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kAfterNs = 500 * kNsPerMs;
constexpr DurationNs kEveryNs = 200 * kNsPerMs;
constexpr DurationNs kLineEveryNs = 2'000 * kNsPerMs;  // without a terminal

}  // namespace

Progress::Progress(std::string what)
    : what_(std::move(what)), rewrites_(isatty(STDERR_FILENO) != 0), begin_ns_(clock_.now_ns()) {}

void Progress::show(std::size_t done, std::size_t all) {
  const TimeNs now_ns = clock_.now_ns();
  const DurationNs pause_ns = rewrites_ ? kEveryNs : kLineEveryNs;
  if (now_ns - begin_ns_ < kAfterNs || (shown_ && now_ns - shown_ns_ < pause_ns)) return;
  const std::string of_all = all > 0 ? fmt::format(" of {}", all) : "";
  std::string left;
  if (done > 0 && done < all) {
    const double left_ns =
        static_cast<double>(now_ns - begin_ns_) / static_cast<double>(done) * static_cast<double>(all - done);
    left = fmt::format(", {:.0f} s left", std::ceil(left_ns * 1e-9));
  }
  fmt::print(stderr, "{}footlight: {}{} {}{}{}", rewrites_ ? "\r" : "", done, of_all, what_, left,
             rewrites_ ? "\033[K" : "\n");
  shown_ = true;
  shown_ns_ = now_ns;
}

void Progress::clear() {
  if (rewrites_ && shown_) fmt::print(stderr, "\r\033[K");
  shown_ = shown_ && !rewrites_;
}

fixtures::GoOn Progress::go_on() {
  return [this](std::size_t done, std::size_t all) {
    show(done, all);
    return !end_signal_came();
  };
}

}  // namespace footlight::tools
