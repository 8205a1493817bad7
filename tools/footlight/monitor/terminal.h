// A terminal as a screen of lines: no library, the sequences of ECMA-48 and those that xterm added for full screens.
//
// The terminal is given back as it was when the object goes, and by a handler when the program dies of a signal.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::tools {

struct TerminalSize {
  int columns = 80;
  int rows = 24;
};

enum class Key {
  kNone,  // the time is over, the size has changed, or a signal came: see Terminal::ended()
  kText,  // a character: Terminal::typed()
  kEnter,
  kEscape,
  kBackspace,
  kUp,
  kDown,
  kPageUp,
  kPageDown,
};

// What the bytes of a key press mean; takes them off the front of `bytes`. kNone: not complete yet, or nothing known,
// which is taken off as well. `more_may_come`: a lone escape may still be the begin of a sequence.
[[nodiscard]] Key take_key(std::string& bytes, std::string& typed, bool more_may_come);

class Terminal {
 public:
  // One at a time in a program. SIGINT, SIGTERM, SIGHUP and SIGQUIT end it (ended()); SIGTSTP works as usual.
  // kUnsupported: standard input or output is no terminal.
  [[nodiscard]] static Result<std::unique_ptr<Terminal>> take();
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  [[nodiscard]] TerminalSize size() const;
  // Writes the lines that differ from those of the last call.
  void show(const std::vector<std::string>& lines);
  // Waits for a key, at most so long.
  [[nodiscard]] Key wait_for_key(DurationNs patience_ns);
  [[nodiscard]] const std::string& typed() const { return typed_; }  // of the last kText
  [[nodiscard]] bool ended() const;

 private:
  Terminal() = default;

  std::vector<std::string> shown_;
  std::string bytes_;  // read and not understood yet
  std::string typed_;
};

// SIGINT and SIGTERM as a request, for a program without a screen. True once one came.
void catch_end_signals();
[[nodiscard]] bool end_signal_came();

}  // namespace footlight::tools
