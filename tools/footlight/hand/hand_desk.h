// The hand of a running bridge (sim/hand.h): takes commands from any thread and keeps the source in the pump.
//
// The source joins the pump with the first command. Before that there is nothing: no port, no thread, no deadline.
//
// A blackout or a hold is remembered in a file beside the bridge's socket, "SOCKET.blackout". A bridge that starts and
// finds the file starts dark, so that a crash during a blackout does not bring the light back. 'footlight blackout off'
// removes the file.
//
// Threads: apply() and report() any but the pump's; the rest as stated.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/result.h"
#include "sim/hand.h"
#include "sim/pump.h"

namespace footlight::tools {

struct HandReport {
  bool blackout = false;
  bool hold = false;
  std::size_t fades = 0;
  std::vector<HandSource::Held> held;
};

class HandDesk {
 public:
  // Both outlive the desk. The desk outlives every run of the pump.
  HandDesk(Pump& pump, Clock& clock) : pump_(pump), clock_(clock) {}

  // Before the pump runs. `path`: of the file that remembers a blackout; "": none. True if the bridge starts dark.
  bool remember_in(std::string path);
  // Returns the number of slots. Errors: those of HandSource::apply(); kTimeout: the pump does not answer; kIo: done,
  // but a blackout cannot be remembered.
  [[nodiscard]] Result<int> apply(const HandCommand& command);
  [[nodiscard]] Result<HandReport> report();

  // The pump's thread, between two ticks: its universes have changed.
  void follow_pump();

 private:
  [[nodiscard]] Status on_pump(std::function<void()> job);
  [[nodiscard]] Status mark(const HandCommand& command) const;
  Result<int> take(const HandCommand& command);

  Pump& pump_;
  Clock& clock_;
  std::string memory_path_;
  std::unique_ptr<HandSource> source_;          // of the pump's thread
  std::shared_ptr<const Universes> universes_;  // of the source
};

}  // namespace footlight::tools
