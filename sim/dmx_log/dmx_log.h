// The DMX log: what came over the wire, when, to the nanosecond. Layout of the file: docs/formats/dmxlog.md.
//
// Every frame is kept, also one that repeats the levels before it, so that the timing of the line survives; levels are
// kept only where they changed. Times are integer nanoseconds from the start of the recording; the end is stored too,
// so a recording of 60 s says 60 s whatever came last.
//
// Whole from the damage of others: blocks decode alone and carry checksums. A log whose writer died is read up to its
// last whole block, a damaged block is skipped and reported with its offset in the file.
//
// Related: log_input.h (other formats, conversion), log_diff.h (two logs compared), log_ports.h (the log as a source
// and as a sink of the pump). Threads: none of its own; one thread at a time may use a reader or a writer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/dmx.h"
#include "sim/core/result.h"

namespace footlight {

// ---- Writing -------------------------------------------------------------------------------------------------------

struct LogWriterOptions {
  // What time 0 of the log is, on the clock of FrameView::stamp_ns.
  TimeNs origin_ns = 0;
  // The wall clock at that moment, nanoseconds since 1970-01-01 UTC; 0: unknown.
  std::int64_t wall_start_unix_ns = 0;
  // The universes that are asked for; goes into the header. Others may come, too.
  std::vector<Universe> universes;
  // Replace a finished log of the same name. Otherwise that is an error.
  bool overwrite = false;
  // Also keep frames that change nothing. Without them a log holds no word on rates.
  bool keep_repeats = true;
  // A block is written when it spans this much time, > 0 (up to a quarter longer where no pause of 2 ms comes between
  // frames) ... A recorder writes sooner, see LogSinkOptions::flush_after_ns.
  DurationNs block_span_ns = 4 * kNsPerS;
  // ... or holds this many bytes of levels; raised to four times the size of one look where there are many universes.
  std::size_t block_bytes = 1u << 20;
  // zstd's level, 1 to 19.
  int compression_level = 6;
  // Wait for the disk after each block (power cuts, not only crashes, lose no more than the open block).
  bool sync_blocks = false;
};

struct LogWriterStats {
  std::uint64_t frames = 0;
  std::uint64_t changes = 0;  // frames that changed a level
  std::uint64_t repeats_dropped = 0;
  std::uint64_t not_levels = 0;   // per-address priorities, which the format has no place for; left out
  std::uint64_t late_stamps = 0;  // frames stamped before the one before them (or before the origin); raised to it
  std::uint64_t blocks = 0;
  std::uint64_t bytes = 0;  // in the file so far
};

// Writes `path`.part and gives it the name `path` in close(). A process that dies leaves the .part file, which
// LogReader reads; a .part file of an earlier recording is never touched (the next one is called .part2 and so on).
//
// Memory: one look, one block (about block_bytes, twice while it is written), an index of at most 1 MiB.
// Errors: kIo (the message names the file; on a full disk the file ends after its last whole block and stays readable),
// kPermission, kNotFound (no such directory), kBadInput. After an error every call returns it again.
class LogWriter {
 public:
  [[nodiscard]] static Result<LogWriter> create(const std::string& path, const LogWriterOptions& options);
  LogWriter(LogWriter&&) noexcept;
  LogWriter& operator=(LogWriter&&) noexcept;
  // Without close(): the open block is written, the file keeps its .part name.
  ~LogWriter();

  // Takes one frame. Its universe must be valid, its slots at most 512.
  Status append(const FrameView& frame);
  // Writes the open block if it has waited for block_span_ns or longer; for times in which no frame comes.
  Status tick(TimeNs now_ns);
  // Writes the open block now.
  Status flush();
  // Ends the recording at this time (on the clock of the frames; not before the last frame) and gives the file its
  // name.
  Status close(TimeNs end_stamp_ns);
  // Instead of close(): removes the .part file. A file called `path` stays as it is.
  void discard();

  [[nodiscard]] LogWriterStats stats() const;
  // Where the bytes are now: `path` after close(), the .part file before.
  [[nodiscard]] const std::string& written_path() const;

 private:
  friend struct LogWriterMaker;  // log_writer.cpp
  struct Impl;
  explicit LogWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// ---- Reading -------------------------------------------------------------------------------------------------------

// A part of the file that could not be used.
struct LogDamage {
  std::uint64_t offset = 0;  // of its first byte in the file
  std::uint64_t size_bytes = 0;
  std::string what;  // "checksum of the block is wrong", ...
};

struct LogUniverseInfo {
  Universe universe = 0;
  std::uint64_t frames = 0;
  std::uint64_t changes = 0;  // frames that changed a level
  int slot_count = 0;         // of the longest frame
  DurationNs first_ns = 0;    // time of the first and of the last frame
  DurationNs last_ns = 0;
  // Mean over the time in which it was heard; 0 with fewer than two frames.
  [[nodiscard]] double rate_hz() const {
    return frames > 1 && last_ns > first_ns
               ? static_cast<double>(frames - 1) * 1e9 / static_cast<double>(last_ns - first_ns)
               : 0.0;
  }
};

enum class LogFormat {
  kDmxLog,
  kOlaShow,
  kPacketCapture,  // pcap or pcapng holding sACN or Art-Net
  kLineCapture,    // sigrok's samples of a DMX line
};

struct LogInfo {
  std::string path;
  LogFormat format = LogFormat::kDmxLog;
  int version_major = 0;
  int version_minor = 0;
  TimeNs origin_ns = 0;                    // what time 0 was on the recorder's clock
  std::int64_t wall_start_unix_ns = 0;     // 0: unknown
  DurationNs duration_ns = 0;              // of the recording; of an unfinished one the time of the last frame
  std::vector<LogUniverseInfo> universes;  // ascending; those of the header that were never heard have 0 frames
  std::uint64_t frames = 0;
  std::uint64_t changes = 0;
  std::uint64_t late_stamps = 0;
  std::uint64_t blocks = 0;
  std::uint64_t file_bytes = 0;
  bool finished = false;          // its writer closed it; if not, it was read up to its last whole block
  bool checked = false;           // every block was read, not only the index
  std::vector<LogDamage> damage;  // the first 64
  std::uint64_t damage_count = 0;
  [[nodiscard]] bool recovered() const { return !finished || damage_count > 0; }
};

// A run of slots that changed: slots first to first + count - 1, counted from 0.
struct SlotRun {
  std::uint16_t first = 0;
  std::uint16_t count = 0;
};

// One frame. The spans belong to the reader and are valid until its next call.
struct LogFrame {
  DurationNs time_ns = 0;  // since the start of the recording
  TimeNs stamp_ns = 0;     // time_ns + origin: as the recorder stamped it
  Universe universe = 0;
  SenderId sender = 0;  // as recorded: tells senders apart within this log only
  std::uint32_t sequence = 0;
  std::uint8_t priority = kPriorityDefault;
  bool terminated = false;
  // Nobody sent it: it carries what changed inside damage, at the first time after the damage at which it is known.
  bool restored = false;
  int slot_count = 0;                    // of this frame, 0 to 512
  std::span<const std::uint8_t> levels;  // all 512, after this frame; slots that were never heard are 0
  std::span<const SlotRun> changes;      // against this universe's frame before; empty for a repeat
  [[nodiscard]] std::span<const std::uint8_t> slots() const {
    return levels.first(static_cast<std::size_t>(slot_count));
  }
};

// How one universe stood at a moment. The span belongs to the reader and is valid until its next call.
struct LogSnapshot {
  Universe universe = 0;
  DurationNs time_ns = 0;  // of the newest frame that it had
  SenderId sender = 0;
  std::uint32_t sequence = 0;
  std::uint8_t priority = kPriorityDefault;
  bool terminated = false;
  int slot_count = 0;
  std::span<const std::uint8_t> levels;  // all 512
};

struct LogReaderOptions {
  // Without: blocks with wrong checksums are read as far as their structure holds. For salvage and for fuzzing.
  bool check_checksums = true;
};

// Reads a log, finished or not. Holds one block in memory, at most kLogBlockBytesMax.
// Errors: kNotFound, kPermission, kIo; kBadInput where the file is no log ("show.dmxlog: not a DMX log: ..."),
// kUnsupported where it is of a later version. Damage inside is no error: see info().damage.
class LogReader {
 public:
  [[nodiscard]] static Result<LogReader> open(const std::string& path, const LogReaderOptions& options = {});
  // A log in memory; `name` stands for the path in messages.
  [[nodiscard]] static Result<LogReader> open_bytes(std::vector<std::uint8_t> bytes, const std::string& name,
                                                    const LogReaderOptions& options = {});
  LogReader(LogReader&&) noexcept;
  LogReader& operator=(LogReader&&) noexcept;
  ~LogReader();

  // What the index says, with the damage met so far. Of an unfinished log: what scanning the block headers gave; counts
  // per universe then need read_log_info().
  [[nodiscard]] const LogInfo& info() const;

  // The next frame in order of time; false at the end.
  [[nodiscard]] Result<bool> next(LogFrame& frame);
  // Goes to a time: look() then holds every frame at or before time_ns, next() gives the first one after it.
  // Binary search over the index and one block; any time is allowed.
  Status seek(DurationNs time_ns);
  // Back to the start: next() gives the first frame, look() is empty.
  Status rewind();
  // Every universe heard up to here, ascending, after the frame that next() gave last or at the time of seek().
  [[nodiscard]] std::span<const LogSnapshot> snapshot();

 private:
  struct Impl;
  explicit LogReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

inline constexpr std::size_t kLogBlockBytesMax = 128u << 20;  // of a block when decompressed

// All about a log. `check` reads every block even if the index is sound; an unfinished or damaged log is always read
// whole. Other formats: describe() in log_input.h.
[[nodiscard]] Result<LogInfo> read_log_info(const std::string& path, bool check = false);

}  // namespace footlight
