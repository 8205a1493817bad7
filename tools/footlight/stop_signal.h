// SIGINT and SIGTERM as a request, so that sinks can say their last words. A second signal ends the program at once.
// SIGPIPE is ignored.
#pragma once

#include "sim/core/result.h"
#include "sim/pump.h"

namespace footlight::tools {

// From construction on, signals are remembered; from stop(pump) on, they stop that pump. One at a time in a program.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  // nullptr: no pump any more. A signal that came before stops it at once.
  void stops(Pump* pump);
  [[nodiscard]] bool came() const;
};

// SIGHUP as the wish to read the show file anew; but when the terminal that the program was started in has gone, it
// means the end, as it does for every other program. One at a time in a program.
class ReloadSignal {
 public:
  ReloadSignal();
  ~ReloadSignal();
  ReloadSignal(const ReloadSignal&) = delete;
  ReloadSignal& operator=(const ReloadSignal&) = delete;

  // kIo where the system had no descriptor to spare: then wait() returns kNothing at once.
  [[nodiscard]] Status opened() const;
  enum class Decoded { kReload, kStop, kNothing };
  // Waits for a signal, or for wish() or end() of another thread; kNothing: it is over.
  [[nodiscard]] Decoded wait();
  void decoded() noexcept;  // any thread, and signal handlers
  void end() noexcept;      // any thread

 private:
  const bool had_terminal_;
  int open_error_ = 0;
};

}  // namespace footlight::tools
