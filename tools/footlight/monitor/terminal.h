// A terminal as a screen of lines, without a library: the sequences of ECMA-48 and xterm's for full screens.
//
// The terminal is restored when the object is destroyed, and by a handler if a signal ends the program.
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
  kNone,  // timeout, a new size, or a signal: see Terminal::ended()
  kText,  // a character: Terminal::typed()
  kEnter,
  kEscape,
  kBackspace,
  kUp,
  kDown,
  kLeft,
  kRight,
  kPageUp,
  kPageDown,
};

// Decodes a key press and removes its bytes from the front of `bytes`. kNone: incomplete, or unknown and removed.
// `more_may_come`: a single escape may still be the start of a sequence.
[[nodiscard]] Key take_key(std::string& bytes, std::string& typed, bool more_may_come);

class Terminal {
 public:
  // One at a time in a program. SIGINT, SIGTERM, SIGHUP and SIGQUIT end it (ended()); SIGTSTP works as usual.
  // kUnsupported: standard input or output is not a terminal.
  [[nodiscard]] static Result<std::unique_ptr<Terminal>> take();
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  [[nodiscard]] TerminalSize size() const;
  // Writes the lines that differ from those of the last call.
  void show(const std::vector<std::string>& lines);
  // Waits for a key, at most this long.
  [[nodiscard]] Key wait_for_key(DurationNs patience_ns);
  [[nodiscard]] const std::string& typed() const { return typed_; }  // of the last kText
  [[nodiscard]] bool ended() const;

 private:
  Terminal() = default;

  std::vector<std::string> shown_;
  std::string bytes_;  // read, but not decoded yet
  std::string typed_;
};

// SIGINT and SIGTERM as a stop request, for a program without a screen. True after a signal.
void catch_end_signals();
[[nodiscard]] bool end_signal_came();

}  // namespace footlight::tools
