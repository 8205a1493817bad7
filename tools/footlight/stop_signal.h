// SIGINT and SIGTERM as a stop request, so that sinks can end their streams. One that comes a second after the first,
// or later, ends the program at once. Those before are ignored: `timeout` sends two, and so do a shell and the kernel
// when a terminal closes. SIGPIPE is ignored.
#pragma once

#include "sim/core/result.h"
#include "sim/pump.h"

namespace footlight::tools {

// Signals are stored from construction on; from stops(pump) on, they stop that pump. One object at a time in a program.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  // nullptr: no pump any more. A stored signal stops the pump at once.
  void stops(Pump* pump);
  // SIGHUP and SIGQUIT stop as SIGTERM does, for a program whose lamps would stay lit when its terminal closes.
  void also_hangup();
  [[nodiscard]] bool came() const;
};

// SIGHUP as a request to read the show file again. If the terminal of the program has gone, SIGHUP means stop, as for
// other programs. One object at a time in a program.
class ReloadSignal {
 public:
  ReloadSignal();
  ~ReloadSignal();
  ReloadSignal(const ReloadSignal&) = delete;
  ReloadSignal& operator=(const ReloadSignal&) = delete;

  // kIo if the system had no descriptor left; then wait() returns kNothing at once.
  [[nodiscard]] Status opened() const;
  enum class Request { kReload, kStop, kNothing };
  // Waits for a signal, or for request() or end() of another thread. kNothing: end() was called.
  [[nodiscard]] Request wait();
  void request() noexcept;  // any thread, and signal handlers
  void end() noexcept;      // any thread

 private:
  const bool had_terminal_;
  int open_error_ = 0;
};

}  // namespace footlight::tools
