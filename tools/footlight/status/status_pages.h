// The HTTP pages of a running bridge: /status and /levels (JSON, docs/monitor.md) and /metrics (docs/metrics.md).
// POST /reload reads the show file again; GET /reload returns the result. POST /hand takes a command of the hand
// (tools/footlight/hand/hand_text.h); GET /hand returns what is set (docs/control.md).
//
// Answers use the pump's published status and the buffer, so they never wait for the pump; those of /hand wait until
// the pump has taken the command, for at most 2 s.
// Threads: answer() any, one at a time for each object; the rest any.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "sim/core/clock.h"
#include "sim/pump.h"
#include "tools/footlight/bridge/output_guard.h"
#include "tools/footlight/hand/hand_desk.h"
#include "tools/footlight/status/http_server.h"
#include "tools/footlight/status/metrics.h"

namespace footlight::tools {

class StatusPages {
 public:
  // Both outlive the pages.
  StatusPages(const Pump& pump, Clock& clock);

  [[nodiscard]] HttpAnswer answer(const HttpRequest& request) const;
  // For a server that strangers can reach: /metrics only.
  [[nodiscard]] HttpAnswer answer_metrics(const HttpRequest& request) const;

  std::atomic<bool> real_time{false};
  std::atomic<std::uint64_t> reloads{0};
  std::atomic<std::uint64_t> reload_failures{0};
  std::atomic<bool> reloading{false};
  void set_reload_trouble(const std::string& trouble);  // of the last one; empty: it was used
  // The action of POST /reload: requests a reload and returns. Empty: no reload. Set before the server starts.
  std::function<void()> request_reload;
  // Takes commands; null: none. And the rig that the outputs drive, for commands with names of fixtures; "": unknown.
  // Set before the server starts.
  HandDesk* hand = nullptr;
  std::string rig;
  // Of the outputs; null: none. Set before the server starts.
  std::shared_ptr<const OutputGuard> guard;

 private:
  [[nodiscard]] HttpAnswer answer_hand(const HttpRequest& request) const;
  const Pump& pump_;
  Clock& clock_;
  const std::int64_t start_unix_ns_;
  mutable std::mutex mutex_;
  std::string reload_trouble_;  // guarded by mutex_
};

}  // namespace footlight::tools
