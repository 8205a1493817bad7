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
  DurationNs start_ns = 0;                              // where in the log to begin, >= 0
  DurationNs stop_ns = kTimeNever;                      // where to end; kTimeNever: at the end of the recording
  bool loop = false;                                    // from stop_ns back to start_ns, without a gap
  double speed = 1.0;                                   // 0.001 to 1000
  std::vector<std::pair<Universe, Universe>> renumber;  // from (in the log) to (in the pump)
  bool only_renumbered = false;                         // leave out universes that `renumber` does not name
};

// Plays a log. Time 0 is the `now_ns` of the first poll() or start(). Each frame is due at
// start + (time in the log - start_ns) / speed, reckoned anew from the start for each frame, so lateness never adds up;
// it is handed over in the first poll() at or after that, stamped with the time it was due. With start_ns > 0 the whole
// look at that time comes first.
//
// Threads: all calls on the pump's thread. Reads and decompresses blocks there, between frames rather than when one is
// due. Errors of poll(): the file cannot be read any more. Damage in the log is skipped and counted in
// counters().rejected.
class LogSource final : public Source {
 public:
  [[nodiscard]] static Result<std::unique_ptr<LogSource>> from_reader(LogReader reader, const std::string& name,
                                                                      const LogSourceOptions& options = {});
  ~LogSource() override;

  // Sets time 0 ahead of the first poll(), to start several ports together.
  void start(TimeNs now_ns);

  [[nodiscard]] std::string name() const override;
  [[nodiscard]] TimeNs next_deadline_ns() const override;
  [[nodiscard]] PortState state() const override;
  [[nodiscard]] std::string trouble() const override;
  [[nodiscard]] PortCounters counters() const override;
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override;
  [[nodiscard]] std::span<const Universe> universes() const override;

  [[nodiscard]] const LogInfo& info() const;
  // How many times it has gone through the log and begun again.
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
  // The open block goes to the file this long after its first frame came, > 0: what the death of the process loses.
  DurationNs flush_after_ns = 800 * kNsPerMs;
  std::size_t waiting_bytes_max = 16u << 20;  // frames that wait for a slow disk; what comes on top is lost and counted
};

// Records every frame with the stamp that it carries. send() copies the frame; a thread of the sink's own compresses
// and writes, so that a slow disk never holds up the pump. When the process is killed, frames that are older than 1 s
// are in the .part file: 0.8 s until their block is due, and 0.2 s for compressing and writing it. Lost frames are in
// counters().dropped, trouble of the disk makes the state kGone with trouble() saying why; what was written stays
// readable.
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
  // Ends the recording at now_ns: waits until everything is on the disk. The outcome is in state(), trouble().
  void close(TimeNs now_ns) override;

  // Of the finished part; complete after close().
  [[nodiscard]] LogWriterStats stats() const;

 private:
  struct Impl;
  explicit LogSink(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace footlight
