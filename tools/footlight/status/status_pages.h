// What a running bridge shows to whoever asks, as pages: /status and /levels (JSON, docs/monitor.md) and /metrics
// (docs/metrics.md). POST /reload has it read its show file anew,
// GET /reload says how that went.
//
// Answers come from what the pump has published and from the buffer, so the pump is never waited for.
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
#include "tools/footlight/status/http_server.h"
#include "tools/footlight/status/metrics.h"

namespace footlight::tools {

class StatusPages {
 public:
  // Both outlive the pages.
  StatusPages(const Pump& pump, Clock& clock);

  [[nodiscard]] HttpAnswer answer(const HttpRequest& request) const;
  // Of these, a server for strangers gives /metrics only.
  [[nodiscard]] HttpAnswer answer_metrics(const HttpRequest& request) const;

  std::atomic<bool> real_time{false};
  std::atomic<std::uint64_t> reloads{0};
  std::atomic<std::uint64_t> reload_failures{0};
  std::atomic<bool> reloading{false};
  void set_reload_trouble(const std::string& trouble);  // of the last one; empty: it was taken
  // What POST /reload does: asks for it and returns. Empty: cannot be reloaded. Set before anybody is served.
  std::function<void()> ask_reload;
  // Of the outputs; null: none. Set before anybody is served.
  std::shared_ptr<const OutputGuard> guard;

 private:
  const Pump& pump_;
  Clock& clock_;
  const std::int64_t start_unix_ns_;
  mutable std::mutex mutex_;
  std::string reload_trouble_;  // guarded by mutex_
};

}  // namespace footlight::tools
