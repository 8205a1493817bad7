// The DMX log: every frame received, with its time in nanoseconds. Layout of the file: docs/formats/dmxlog.md.
//
// Every frame is kept, also a repeat of the levels before it, so that the timing of the line is preserved. Levels are
// stored only where they changed. Times are integer nanoseconds from the start of the recording. The end is stored too,
// so a recording of 60 s has a duration of 60 s even if the last frame came earlier.
//
// Damage stays local: blocks decode independently and carry checksums. A log whose writer died is read up to its last
// whole block. A damaged block is skipped and reported with its offset in the file.
//
// Related: log_input.h (other formats, conversion), log_diff.h (comparison of two logs), log_ports.h (the log as a
// source and as a sink of the pump). Threads: none of its own; one thread at a time may use a reader or a writer.
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
  // Time 0 of the log, on the clock of FrameView::stamp_ns.
  TimeNs origin_ns = 0;
  // The wall clock at that moment, nanoseconds since 1970-01-01 UTC; 0: unknown.
  std::int64_t wall_start_unix_ns = 0;
  // The universes to record, stored in the header. Frames of others are accepted too.
  std::vector<Universe> universes;
  // Replace a finished log of the same name. Otherwise that is an error.
  bool overwrite = false;
  // Also keep frames that change nothing. Without them the log contains no frame rates.
  bool keep_repeats = true;
  // A block is written when it spans this much time, > 0 (up to a quarter longer if there is no pause of 2 ms between
  // frames) ... A recorder writes earlier, see LogSinkOptions::flush_after_ns.
  DurationNs block_span_ns = 4 * kNsPerS;
  // ... or holds this many bytes of levels; raised to four times the size of one snapshot of all universes if there are
  // many.
  std::size_t block_bytes = 1u << 20;
  // zstd's level, 1 to 19.
  int compression_level = 6;
  // Wait for the disk after each block, so that a power cut loses no more than the open block.
  bool sync_blocks = false;
};

struct LogWriterStats {
  std::uint64_t frames = 0;
  std::uint64_t changes = 0;  // frames that changed a level
  std::uint64_t repeats_dropped = 0;
  std::uint64_t not_levels = 0;   // frames of per-address priorities, which the format cannot store; left out
  std::uint64_t late_stamps = 0;  // frames stamped before the previous one (or before the origin); raised to its time
  std::uint64_t blocks = 0;
  std::uint64_t bytes = 0;  // in the file so far
};

// Writes `path`.part and renames it to `path` in close(). A process that dies leaves the .part file, which LogReader
// reads. A .part file of an earlier recording is never touched (the next one is called .part2 and so on).
//
// Memory: one snapshot of all universes, one block (about block_bytes, twice while it is written), an index of at most
// 1 MiB. Errors: kIo (the message names the file; on a full disk the file ends after its last whole block and stays
// readable), kPermission, kNotFound (no such directory), kBadInput. After an error every call returns it again.
class LogWriter {
 public:
  [[nodiscard]] static Result<LogWriter> create(const std::string& path, const LogWriterOptions& options);
  LogWriter(LogWriter&&) noexcept;
  LogWriter& operator=(LogWriter&&) noexcept;
  // Without close(): writes the open block; the file keeps its .part name.
  ~LogWriter();

  // Adds one frame. Its universe must be valid, its slots at most 512.
  Status append(const FrameView& frame);
  // Writes the open block if it is block_span_ns old or older; call it while no frames come.
  Status tick(TimeNs now_ns);
  // Writes the open block now.
  Status flush();
  // Ends the recording at this time (on the clock of the frames; not before the last frame) and gives the file its
  // name.
  Status close(TimeNs end_stamp_ns);
  // Instead of close(): removes the .part file. A file named `path` is not touched.
  void discard();

  [[nodiscard]] LogWriterStats stats() const;
  // The current file: `path` after close(), the .part file before.
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

inline constexpr std::size_t kLogDamageListedMax = 64;       // of the damaged parts of a log
inline constexpr std::size_t kLogDamageCountedMax = 65'536;  // bounds the memory on a broken disk

struct LogUniverseInfo {
  Universe universe = 0;
  std::uint64_t frames = 0;
  std::uint64_t changes = 0;  // frames that changed a level
  int slot_count = 0;         // of the longest frame
  DurationNs first_ns = 0;    // times of the first and the last frame
  DurationNs last_ns = 0;
  // Mean rate between its first and last frame; 0 with fewer than two frames.
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
  kSound,          // a sound file through a sound map
  kVideo,          // pictures of VRSL's grid
};

struct LogInfo {
  std::string path;
  LogFormat format = LogFormat::kDmxLog;
  int version_major = 0;
  int version_minor = 0;
  TimeNs origin_ns = 0;                    // time 0 on the recorder's clock
  std::int64_t wall_start_unix_ns = 0;     // 0: unknown
  DurationNs duration_ns = 0;              // of the recording; if unfinished, the time of the last frame
  std::vector<LogUniverseInfo> universes;  // ascending; universes of the header without frames are included
  std::uint64_t frames = 0;
  std::uint64_t changes = 0;
  std::uint64_t late_stamps = 0;
  std::uint64_t blocks = 0;
  std::uint64_t file_bytes = 0;
  bool finished = false;          // its writer closed it; if not, it was read up to its last whole block
  bool checked = false;           // every block was read, not only the index
  std::vector<LogDamage> damage;  // the first kLogDamageListedMax
  std::uint64_t damage_count = 0;  // of all; kLogDamageCountedMax: so many or more
  std::uint64_t damage_bytes = 0;  // of all that are counted
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
  TimeNs stamp_ns = 0;     // time_ns + origin: the recorder's stamp
  Universe universe = 0;
  SenderId sender = 0;  // as recorded: distinguishes senders within this log only
  std::uint32_t sequence = 0;
  std::uint8_t priority = kPriorityDefault;
  bool terminated = false;
  // No sender sent it: it carries what changed inside damage, at the first time after the damage at which that is
  // known.
  bool restored = false;
  int slot_count = 0;                    // of this frame, 0 to 512
  std::span<const std::uint8_t> levels;  // all 512, after this frame; slots never received are 0
  std::span<const SlotRun> changes;      // against this universe's previous frame; empty for a repeat
  [[nodiscard]] std::span<const std::uint8_t> slots() const {
    return levels.first(static_cast<std::size_t>(slot_count));
  }
};

// The state of one universe at a time. The span belongs to the reader and is valid until its next call.
struct LogSnapshot {
  Universe universe = 0;
  DurationNs time_ns = 0;  // of its newest frame
  SenderId sender = 0;
  std::uint32_t sequence = 0;
  std::uint8_t priority = kPriorityDefault;
  bool terminated = false;
  int slot_count = 0;
  std::span<const std::uint8_t> levels;  // all 512
};

struct LogReaderOptions {
  // If false, blocks with wrong checksums are read as far as their structure is valid. For salvage and fuzzing.
  bool check_checksums = true;
};

// Reads a log, finished or not. Holds one block in memory, at most kLogBlockBytesMax. Errors: kNotFound, kPermission,
// kIo; kBadInput if the file is not a log ("show.dmxlog: not a DMX log: ..."), kUnsupported if it has a later version.
// Damage inside the file is not an error: see info().damage.
class LogReader {
 public:
  [[nodiscard]] static Result<LogReader> open(const std::string& path, const LogReaderOptions& options = {});
  // A log in memory; `name` replaces the path in messages.
  [[nodiscard]] static Result<LogReader> open_bytes(std::vector<std::uint8_t> bytes, const std::string& name,
                                                    const LogReaderOptions& options = {});
  LogReader(LogReader&&) noexcept;
  LogReader& operator=(LogReader&&) noexcept;
  ~LogReader();
  // Another reader of the same log, at its start. It shares the open file or the bytes in memory, so it needs nothing
  // from the path: the file may have been renamed since. Readers of one log may be used in different threads.
  [[nodiscard]] LogReader again() const;

  // The contents of the index, and the damage found so far. For an unfinished log: from a scan of the block headers;
  // counts per universe then need read_log_info().
  [[nodiscard]] const LogInfo& info() const;

  // All damage that this reader and every other one of the same log (again()) has met so far; the first parts,
  // how many there are and their bytes. Any thread may call it while others read.
  struct DamageMet {
    std::uint64_t count = 0;  // kLogDamageCountedMax: so many or more
    std::uint64_t bytes = 0;
    std::vector<LogDamage> first;  // at most kLogDamageListedMax
  };
  [[nodiscard]] DamageMet damage_met() const;

  // The next frame in order of time; false at the end.
  [[nodiscard]] Result<bool> next(LogFrame& frame);
  // Moves to a time: snapshot() then includes every frame at or before time_ns, and next() returns the first one after
  // it. Binary search over the index and one block; any time is allowed.
  Status seek(DurationNs time_ns);
  // Back to the start: next() returns the first frame, snapshot() is empty.
  Status rewind();
  // Every universe with a frame so far, ascending: after the last frame from next(), or at the time of seek().
  [[nodiscard]] std::span<const LogSnapshot> snapshot();

 private:
  struct Impl;
  explicit LogReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

inline constexpr std::size_t kLogBlockBytesMax = 128u << 20;  // of a decompressed block

// All information about a log. `check` reads every block even if the index is valid; an unfinished or damaged log is
// always read completely. Other formats: describe() in log_input.h.
[[nodiscard]] Result<LogInfo> read_log_info(const std::string& path, bool check = false);

}  // namespace footlight
