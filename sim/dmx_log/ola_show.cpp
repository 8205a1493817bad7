#include "sim/dmx_log/ola_show.h"

#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <sstream>
#include <string_view>
#include <utility>

#include "sim/core/check.h"
#include "sim/dmx_log/log_output.h"
#include "sim/file_kind.h"

namespace footlight {
namespace {

constexpr std::string_view kFirstLine = "OLA Show";
constexpr std::size_t kLineCharsMax = 16u << 10;  // 512 levels of three digits take 2,100
constexpr std::int64_t kDelayMaxMs = 1'000LL * 60 * 60 * 24 * 365;
constexpr DurationNs kTimeMaxNs = DurationNs{1} << 61;

// The part of a line that a message quotes.
std::string quote(std::string_view text) {
  constexpr std::size_t kCharsMax = 40;
  std::string out = "'";
  for (const char c : text.substr(0, kCharsMax)) out += std::isprint(static_cast<unsigned char>(c)) != 0 ? c : '?';
  return out + (text.size() > kCharsMax ? "...'" : "'");
}

template <class T>
bool parse_whole(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() && !text.empty();
}

}  // namespace

OlaShowReader::OlaShowReader(std::string path, std::unique_ptr<std::istream> stream, int universe_offset)
    : path_(std::move(path)), stream_(std::move(stream)), universe_offset_(universe_offset) {}

Result<OlaShowReader> OlaShowReader::open(const std::string& path, int universe_offset) {
  FL_TRY(refuse_pipe_input(path));
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    return fail(ErrorCode::kBadInput, "{}: is a directory; name a file", path);
  }
  errno = 0;
  auto stream = std::make_unique<std::ifstream>(path, std::ios::binary);
  if (!*stream) return dmx_log::fail_open(errno, path);
  return begin(path, std::move(stream), universe_offset);
}

Result<OlaShowReader> OlaShowReader::open_text(std::string text, const std::string& name, int universe_offset) {
  return begin(name, std::make_unique<std::istringstream>(std::move(text)), universe_offset);
}

Result<OlaShowReader> OlaShowReader::begin(std::string path, std::unique_ptr<std::istream> stream,
                                           int universe_offset) {
  OlaShowReader reader(path, std::move(stream), universe_offset);
  std::string line;
  FL_ASSIGN(const bool any, reader.read_line(line));
  if (!any) return fail(ErrorCode::kBadInput, "{}: is empty; expected the line '{}'", path, kFirstLine);
  if (line != kFirstLine) {
    return fail(ErrorCode::kBadInput, "{}:{}: expected the line '{}', got {}", path, reader.line_, kFirstLine,
                quote(line));
  }
  return reader;
}

Result<bool> OlaShowReader::read_line(std::string& line) {
  while (true) {
    line.clear();
    ++line_;
    bool any = false;
    while (true) {
      const int c = stream_->get();
      if (c == std::ifstream::traits_type::eof()) {
        if (any) open_line_ = line_;
        break;
      }
      any = true;
      if (c == '\n') break;
      if (line.size() == kLineCharsMax) {
        return fail(ErrorCode::kBadInput, "{}:{}: the line is longer than {} characters; expected at most 512 levels",
                    path_, line_, kLineCharsMax);
      }
      line.push_back(static_cast<char>(c));
    }
    if (stream_->bad()) return fail(ErrorCode::kIo, "{}: cannot read after line {}", path_, line_ - 1);
    if (!any) return false;
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t')) line.pop_back();
    if (!line.empty()) return true;
  }
}

Result<bool> OlaShowReader::next(OlaShowFrame& frame) {
  while (true) {
    FL_ASSIGN(const bool any, read_line(text_));
    if (!any) return false;
    const std::string_view line = text_;
    if (delay_next_) {
      std::int64_t delay_ms = 0;
      if (!parse_whole(line, delay_ms) || delay_ms < 0 || delay_ms > kDelayMaxMs) {
        return fail(ErrorCode::kBadInput, "{}:{}: expected a delay in whole milliseconds, got {}", path_, line_,
                    quote(line));
      }
      time_ns_ += delay_ms * kNsPerMs;
      if (time_ns_ > kTimeMaxNs) return fail(ErrorCode::kBadInput, "{}:{}: the show is too long", path_, line_);
      delay_next_ = false;
      continue;
    }
    const std::size_t space = line.find(' ');
    int universe = 0;
    if (!parse_whole(line.substr(0, space), universe)) {
      return fail(ErrorCode::kBadInput, "{}:{}: expected '<universe> <level>,<level>,...', got {}", path_, line_,
                  quote(line));
    }
    const std::int64_t number = std::int64_t{universe} + universe_offset_;
    if (!is_universe(number)) {
      return fail(ErrorCode::kBadInput, "{}:{}: expected a universe from 1 to {}, got {}{}", path_, line_, kUniverseMax,
                  number, number == 0 ? "; for a show that counts from 0 give a universe offset of 1" : "");
    }
    frame.universe = static_cast<Universe>(number);
    frame.time_ns = time_ns_;
    frame.slots.clear();
    const std::string_view levels = space == std::string_view::npos ? std::string_view{} : line.substr(space + 1);
    FL_TRY(read_levels(levels, frame.slots));
    delay_next_ = true;
    return true;
  }
}

Status OlaShowReader::read_levels(std::string_view levels, std::vector<std::uint8_t>& slots) const {
  if (levels.empty()) return {};
  while (true) {
    const std::size_t comma = levels.find(',');
    const std::string_view word = levels.substr(0, comma);
    const bool last = comma == std::string_view::npos;
    // A comma after address 512 does not start another level.
    if (last && word.empty() && slots.size() == kSlotCountMax) return {};
    int level = 0;
    if (!word.empty() && (!parse_whole(word, level) || level < 0 || level > 255)) {
      return fail(ErrorCode::kBadInput, "{}:{}: expected a level from 0 to 255 for address {}, got {}", path_, line_,
                  slots.size() + 1, quote(word));
    }
    if (slots.size() == kSlotCountMax) {
      return fail(ErrorCode::kBadInput, "{}:{}: expected at most 512 levels", path_, line_);
    }
    slots.push_back(static_cast<std::uint8_t>(level));
    if (last) return {};
    levels.remove_prefix(comma + 1);
  }
}

// ---- Writing -------------------------------------------------------------------------------------------------------

OlaShowWriter::OlaShowWriter(std::string path, std::ofstream stream)
    : path_(std::move(path)), stream_(std::move(stream)) {}

Result<OlaShowWriter> OlaShowWriter::create(const std::string& path, bool overwrite) {
  FL_TRY(refuse_pipe_output(path));
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    return fail(ErrorCode::kBadInput, "{}: is a directory; name a file", path);
  }
  FL_TRY(refuse_existing(path, overwrite));
  errno = 0;
  std::ofstream stream(path + ".part", std::ios::binary | std::ios::trunc);
  if (!stream) return dmx_log::fail_errno(errno, path, "cannot create");
  stream << kFirstLine << '\n';
  return OlaShowWriter(path, std::move(stream));
}

Status OlaShowWriter::check_stream() {
  if (!stream_) return fail(ErrorCode::kIo, "{}.part: cannot write; is the disk full?", path_);
  return {};
}

void OlaShowWriter::write_delay(DurationNs time_ns) {
  // Computed from the start, not from the last frame, so that rounding errors do not add up.
  const std::int64_t total_ms = (time_ns - lead_ns_ + kNsPerMs / 2) / kNsPerMs;
  text_ += std::to_string(total_ms - written_ms_);
  text_ += '\n';
  written_ms_ = total_ms;
}

Status OlaShowWriter::append(DurationNs time_ns, Universe universe, std::span<const std::uint8_t> slots) {
  text_.clear();
  if (any_) {
    write_delay(time_ns);
  } else {
    lead_ns_ = time_ns;
    any_ = true;
  }
  text_ += std::to_string(universe);
  text_ += ' ';
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (i > 0) text_ += ',';
    text_ += std::to_string(slots[i]);
  }
  text_ += '\n';
  stream_ << text_;
  return check_stream();
}

Status OlaShowWriter::close(DurationNs end_ns) {
  text_.clear();
  if (any_) write_delay(end_ns);
  stream_ << text_;
  stream_.close();
  FL_TRY(check_stream());
  if (std::rename((path_ + ".part").c_str(), path_.c_str()) != 0) {
    return dmx_log::fail_errno(errno, path_, "cannot give the show its name");
  }
  return {};
}

}  // namespace footlight
