#include "sim/dmx_log/log_input.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "sim/dmx_log/format.h"
#include "sim/dmx_log/log_output.h"
#include "sim/dmx_log/ola_show.h"
#include "sim/file_kind.h"

namespace footlight {
namespace {

class DmxLogInput final : public LogInput {
 public:
  explicit DmxLogInput(LogReader reader) : reader_(std::move(reader)) {}
  [[nodiscard]] LogFormat format() const override { return LogFormat::kDmxLog; }
  [[nodiscard]] const std::string& path() const override { return reader_.info().path; }
  [[nodiscard]] TimeNs origin_ns() const override { return reader_.info().origin_ns; }
  [[nodiscard]] std::int64_t wall_start_unix_ns() const override { return reader_.info().wall_start_unix_ns; }
  [[nodiscard]] std::vector<Universe> universes() const override {
    std::vector<Universe> universes;
    for (const LogUniverseInfo& universe : reader_.info().universes) universes.push_back(universe.universe);
    return universes;
  }
  Result<bool> next(FrameView& view) override {
    LogFrame frame;
    FL_ASSIGN(const bool any, reader_.next(frame));
    if (!any) return false;
    last_ns_ = frame.time_ns;
    view = {};
    view.universe = frame.universe;
    view.stamp_ns = frame.stamp_ns;
    view.sender = frame.sender;
    view.sequence = frame.sequence;
    view.priority = frame.priority;
    view.terminated = frame.terminated;
    // A frame restored after damage carries the whole universe, possibly more slots than the frame itself.
    view.slots = frame.restored ? frame.levels : frame.slots();
    return true;
  }
  [[nodiscard]] TimeNs end_ns() const override {
    const LogInfo& info = reader_.info();
    return info.origin_ns + (info.finished ? std::max(info.duration_ns, last_ns_) : last_ns_);
  }
  [[nodiscard]] bool finished() const override { return reader_.info().finished; }
  [[nodiscard]] std::uint64_t damage_count() const override { return reader_.info().damage_count; }

 private:
  LogReader reader_;
  DurationNs last_ns_ = 0;
};

class OlaShowInput final : public LogInput {
 public:
  OlaShowInput(OlaShowReader reader, std::string path) : reader_(std::move(reader)), path_(std::move(path)) {}
  [[nodiscard]] LogFormat format() const override { return LogFormat::kOlaShow; }
  [[nodiscard]] const std::string& path() const override { return path_; }
  Result<bool> next(FrameView& view) override {
    FL_ASSIGN(const bool any, reader_.next(frame_));
    if (!any) return false;
    view = {};
    view.universe = frame_.universe;
    view.stamp_ns = frame_.time_ns;
    view.slots = frame_.slots;
    return true;
  }
  [[nodiscard]] TimeNs end_ns() const override { return reader_.time_ns(); }
  [[nodiscard]] bool finished() const override { return reader_.open_line() == 0; }
  [[nodiscard]] std::vector<std::string> notes() const override {
    if (finished()) return {};
    return {
        fmt::format("{}:{}: the last line has no line end: the file may be cut off there. If it is complete, add a "
                    "line end",
                    path_, reader_.open_line())};
  }

 private:
  OlaShowReader reader_;
  std::string path_;
  OlaShowFrame frame_;
};

}  // namespace

Result<LogFormat> detect_log_format(const std::string& path) {
  FL_TRY(refuse_pipe_input(path));
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    return fail(ErrorCode::kBadInput, "{}: is a directory; name a file", path);
  }
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return dmx_log::fail_open(errno, path);
  std::array<char, 8> head = {};
  stream.read(head.data(), head.size());
  const std::string_view read(head.data(), static_cast<std::size_t>(stream.gcount()));
  if (read.starts_with("OLA Show")) return LogFormat::kOlaShow;
  const std::string_view magic(reinterpret_cast<const char*>(dmx_log::kFileMagic), sizeof dmx_log::kFileMagic);
  if (!read.empty() && magic.starts_with(read)) return LogFormat::kDmxLog;
  // pcap in either byte order, with microseconds or nanoseconds; pcapng.
  for (const std::string_view start :
       {"\xA1\xB2\xC3\xD4", "\xD4\xC3\xB2\xA1", "\xA1\xB2\x3C\x4D", "\x4D\x3C\xB2\xA1", "\x0A\x0D\x0D\x0A"}) {
    if (read.starts_with(start)) return LogFormat::kPacketCapture;
  }
  if (read.starts_with("PK\x03\x04")) return LogFormat::kLineCapture;
  // A DMX log whose first bytes are damaged is recognised by its blocks.
  if (LogReader::open(path)) return LogFormat::kDmxLog;
  return fail(ErrorCode::kBadInput,
              "{}: expected a DMX log, an OLA Show, a packet capture (pcap, pcapng) or a sigrok capture (.sr); {}",
              path, read.empty() ? "it is empty" : "its first bytes match none of them");
}

Result<std::unique_ptr<LogInput>> open_log_input(const std::string& path, int universe_offset) {
  FL_ASSIGN(const LogFormat format, detect_log_format(path));
  switch (format) {
    case LogFormat::kDmxLog: {
      FL_ASSIGN(LogReader reader, LogReader::open(path));
      return std::make_unique<DmxLogInput>(std::move(reader));
    }
    case LogFormat::kOlaShow: {
      FL_ASSIGN(OlaShowReader reader, OlaShowReader::open(path, universe_offset));
      return std::make_unique<OlaShowInput>(std::move(reader), path);
    }
    case LogFormat::kPacketCapture:
    case LogFormat::kLineCapture:
    case LogFormat::kSound: break;
    case LogFormat::kVideo: break;
  }
  return fail(ErrorCode::kUnsupported, "{}: is a capture, expected a DMX log or an OLA Show", path);
}

Result<LogReader> read_into_memory(LogInput& input) {
  dmx_log::Bytes bytes;
  LogWriterOptions options;
  options.origin_ns = input.origin_ns();
  options.wall_start_unix_ns = input.wall_start_unix_ns();
  options.universes = input.universes();
  FL_ASSIGN(LogWriter writer, dmx_log::make_writer(dmx_log::memory_output(bytes, input.path()), options));
  FrameView frame;
  while (true) {
    FL_ASSIGN(const bool any, input.next(frame));
    if (!any) break;
    FL_TRY(writer.append(frame));
  }
  FL_TRY(writer.close(input.end_ns()));
  return LogReader::open_bytes(std::move(bytes), input.path());
}

Result<LogInfo> describe(LogInput& input) {
  FL_ASSIGN(const LogReader reader, read_into_memory(input));
  LogInfo info = reader.info();
  info.path = input.path();
  info.format = input.format();
  std::error_code error;
  const auto size = std::filesystem::file_size(input.path(), error);
  info.file_bytes = error ? 0 : size;
  info.finished = input.finished();
  info.damage_count = input.damage_count();
  info.checked = true;
  return info;
}

}  // namespace footlight
