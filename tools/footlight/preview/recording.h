// A recording of what the fixtures of the window get, into a log.
//
// Levels are kept when they change, with their time: of live inputs to the time of each frame, else of each picture.
// LogSink writes them on its own thread, and a thread here sees to it that it does so while the window draws a slow
// picture: a program that is killed leaves FILE.part, without at most the last second.
//
// Threads: all calls belong to one thread, the window's.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/result.h"
#include "sim/dmx_log/log_ports.h"

namespace footlight::tools {

// A free name for a log of this rig: FOLDER/show_2026-11-27_14-30-05.dmxlog, else with _2 and so on. rig: the path of
// its file; "": the demo. folder: "": that of the rig's file.
[[nodiscard]] std::string recording_path(const std::string& folder, const std::string& rig, std::int64_t unix_ns);

class Recording {
 public:
  // universes: those that are recorded. The clock must be thread-safe and outlive this. Errors: those of
  // LogSink::create(): there is such a file, no such folder, the disk is full.
  [[nodiscard]] static Result<std::unique_ptr<Recording>> start(const std::string& path,
                                                                std::span<const Universe> universes, Clock& clock,
                                                                std::int64_t unix_ns);
  ~Recording();
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  // levels: 512 for each of `universes`; they hold from at_ns on. Those of other universes are left out and counted.
  void take(TimeNs at_ns, std::span<const Universe> universes, std::span<const std::uint8_t> levels);
  // Why it cannot go on; empty: it does.
  [[nodiscard]] std::string trouble() const;
  [[nodiscard]] DurationNs elapsed_ns() const { return clock_.now_ns() - start_ns_; }
  [[nodiscard]] const std::string& path() const { return path_; }

  // Waits until all is on the disk. Returns what was recorded, for people. Errors: kIo, with what stays readable.
  [[nodiscard]] Result<std::string> end();

 private:
  Recording(std::unique_ptr<LogSink> log, std::string path, Clock& clock);
  void work();

  Clock& clock_;
  const std::string path_;
  const TimeNs start_ns_;
  std::vector<std::uint8_t> last_;  // levels of each universe of the log
  std::vector<bool> known_;         // it has levels
  std::uint32_t sequence_ = 0;
  bool left_out_ = false;
  mutable std::mutex mutex_;
  std::unique_ptr<LogSink> log_;  // guarded by mutex_
  bool ending_ = false;           // likewise
  std::condition_variable wake_;
  std::thread thread_;
};

}  // namespace footlight::tools
