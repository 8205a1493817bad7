// The log as ports of the pump: LogSource plays one, LogSink records one.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sim/core/ports.h"
#include "sim/dmx_log/dmx_log.h"

namespace footlight {

struct LogSourceOptions {
  DurationNs start_ns = 0;                              // start time in the log, >= 0
  DurationNs stop_ns = kTimeNever;                      // end time in the log; kTimeNever: the end of the recording
  bool loop = false;                                    // from stop_ns back to start_ns, without a gap
  double speed = 1.0;                                   // 0.001 to 1000
  std::vector<std::pair<Universe, Universe>> renumber;  // from (in the log) to (in the pump)
  bool only_renumbered = false;                         // leave out universes that `renumber` does not list
};

// Plays a log. Time 0 is the `now_ns` of the first poll() or start(). Each frame is due at start + (time in the log -
// start_ns) / speed, computed from the start for each frame, so delays never add up. It is delivered in the first
// poll() at or after that, stamped with its due time. With start_ns > 0 the snapshot of all universes at that time
// comes first.
//
// Threads: all calls on the pump's thread. Blocks are read and decompressed there, between frames rather than when one
// is due. Errors of poll(): the file cannot be read any more. Damage in the log is skipped and counted in
// counters().rejected.
class LogSource final : public Source {
 public:
  [[nodiscard]] static Result<std::unique_ptr<LogSource>> from_reader(LogReader reader, const std::string& name,
                                                                      const LogSourceOptions& options = {});
  ~LogSource() override;

  // Sets time 0 before the first poll(), to start several ports together.
  void start(TimeNs now_ns);

  [[nodiscard]] std::string name() const override;
  [[nodiscard]] TimeNs next_deadline_ns() const override;
  [[nodiscard]] PortState state() const override;
  [[nodiscard]] std::string trouble() const override;
  [[nodiscard]] PortCounters counters() const override;
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override;
  [[nodiscard]] std::span<const Universe> universes() const override;

  [[nodiscard]] const LogInfo& info() const;
  // How many times it has reached the end and started again.
  [[nodiscard]] std::uint64_t passes() const;

 private:
  struct Impl;
  explicit LogSource(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

struct LogSinkOptions {
  std::vector<Universe> universes;  // to record; must not be empty
  bool keep_empty = true;           // false: without a frame no file is left, and none is replaced
  LogWriterOptions writer;          // origin_ns and universes are set by the sink
  TimeNs start_ns = 0;              // time 0 of the log, on the pump's clock
  // The open block is written this long after its first frame, > 0. If the process dies, the frames of this time are
  // lost.
  DurationNs flush_after_ns = 800 * kNsPerMs;
  std::size_t waiting_bytes_max = 16u << 20;  // frames that wait for a slow disk; further ones are lost and counted
};

// Records every frame with its stamp. send() copies the frame; the sink's own thread compresses and writes, so that a
// slow disk never delays the pump. If the process is killed, frames older than 1 s are in the .part file: 0.8 s until
// their block is due, and 0.2 s to compress and write it. Lost frames are counted in counters().dropped. A disk error
// makes the state kGone, with the reason in trouble(); what was written stays readable.
class LogSink final : public Sink {
 public:
  [[nodiscard]] static Result<std::unique_ptr<LogSink>> create(const std::string& path, const LogSinkOptions& options);
  ~LogSink() override;

  [[nodiscard]] std::string name() const override;
  [[nodiscard]] TimeNs next_deadline_ns() const override;
  [[nodiscard]] PortState state() const override;
  [[nodiscard]] std::string trouble() const override;
  [[nodiscard]] PortCounters counters() const override;
  Status send(TimeNs now_ns, std::span<const FrameView> frames) override;
  Status poll(TimeNs now_ns) override;
  [[nodiscard]] std::span<const Universe> universes() const override;
  // Ends the recording at now_ns: waits until everything is on the disk. The result is in state() and trouble().
  void close(TimeNs now_ns) override;

  // For the part written so far; complete after close().
  [[nodiscard]] LogWriterStats stats() const;

 private:
  struct Impl;
  explicit LogSink(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace footlight
