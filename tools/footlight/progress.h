// Prints the progress of a job on standard error if it takes longer than half a second, and reports a stop request.
#pragma once

#include <cstddef>
#include <string>

#include "fixtures/files/progress.h"
#include "sim/system_clock.h"

namespace footlight::tools {

// "footlight: 33 of 162 files, 4 s left": one line that is rewritten on a terminal; elsewhere a line every two seconds.
class Progress {
 public:
  explicit Progress(std::string what);
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void show(std::size_t done, std::size_t all);  // all = 0: the total is unknown, and so is the time left
  void clear();                                  // call before printing anything else

  // Prints the progress; returns false after a stop signal (terminal.h). Refers to this object.
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
