// How far a job is, on standard error, once it takes longer than half a second; and whether somebody has ended it.
#pragma once

#include <cstddef>
#include <string>

#include "fixtures/files/progress.h"
#include "sim/system_clock.h"

namespace footlight::tools {

// "footlight: 33 of 162 files": one line that a terminal rewrites; elsewhere a line every two seconds.
class Progress {
 public:
  explicit Progress(std::string what);
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void show(std::size_t done, std::size_t all);  // 0 of all: how many there are is not known
  void clear();                                  // before anything else is printed

  // Shows, and says no once a signal to end has come (terminal.h). It refers to this.
  [[nodiscard]] fixtures::GoOn go_on();

 private:
  SystemClock clock_;
  const std::string what_;
  const bool rewrites_;
  const TimeNs begin_ns_;
  bool shown_ = false;
  TimeNs shown_ns_ = 0;
};

}  // namespace footlight::tools
