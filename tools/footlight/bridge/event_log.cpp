#include "tools/footlight/bridge/event_log.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include <sys/stat.h>
#include <syslog.h>
#include <unistd.h>

#ifdef FOOTLIGHT_HAVE_SYSTEMD
#include <systemd/sd-journal.h>
#endif

#include "sim/core/clock.h"
#include "tools/footlight/status/json_lines.h"

namespace footlight::tools {
namespace {

// JOURNAL_STREAM has device and inode of the stream from the service manager; after a redirection they differ.
bool stderr_is_journal() {
  const char* const stream = std::getenv("JOURNAL_STREAM");
  struct stat status = {};
  if (stream == nullptr || fstat(STDERR_FILENO, &status) != 0) return false;
  return fmt::format("{}:{}", status.st_dev, status.st_ino) == stream;
}

#ifdef FOOTLIGHT_HAVE_SYSTEMD
constexpr bool kHaveJournal = true;

int syslog_priority(NoticeLevel level) {
  switch (level) {
    case NoticeLevel::kInfo: return LOG_INFO;
    case NoticeLevel::kWarning: return LOG_WARNING;
    case NoticeLevel::kError: return LOG_ERR;
  }
  return LOG_ERR;
}

bool write_to_journal(const Event& event) {
  std::array<std::string, 6> fields = {
      "MESSAGE=" + event.text,        fmt::format("PRIORITY={}", syslog_priority(event.level)),
      "SYSLOG_IDENTIFIER=footlight",  "FOOTLIGHT_EVENT=" + event.id,
      "FOOTLIGHT_PORT=" + event.port, fmt::format("FOOTLIGHT_UNIVERSE={}", event.universe),
  };
  std::array<iovec, fields.size()> parts = {};
  int count = 0;
  for (std::string& field : fields) {
    const bool empty = (&field == &fields[4] && event.port.empty()) || (&field == &fields[5] && event.universe == 0);
    if (!empty) parts[static_cast<std::size_t>(count++)] = {.iov_base = field.data(), .iov_len = field.size()};
  }
  return sd_journal_sendv(parts.data(), count) == 0;
}
#else
constexpr bool kHaveJournal = false;
bool write_to_journal(const Event&) { return false; }
#endif

}  // namespace

Event::Event(const Notice& notice, std::int64_t now_unix_ns)
    : unix_ns(now_unix_ns),
      level(notice.level),
      id(notice.id),
      text(notice.text),
      port(notice.port),
      universe(notice.universe) {}

Result<EventFormat> event_format_of(const std::string& word) {
  if (word.empty()) return kHaveJournal && stderr_is_journal() ? EventFormat::kJournal : EventFormat::kText;
  if (word == "text") return EventFormat::kText;
  if (word == "json") return EventFormat::kJson;
  if (word != "journal") {
    return fail(ErrorCode::kBadInput, "--log-format: expected text, json or journal, got \"{}\"", word);
  }
  if (kHaveJournal) return EventFormat::kJournal;
  return fail(ErrorCode::kUnsupported,
              "--log-format: this build has no libsystemd; use text or json, or build with libsystemd-dev");
}

Result<NoticeLevel> notice_level_of(const std::string& word) {
  for (const NoticeLevel level : {NoticeLevel::kInfo, NoticeLevel::kWarning, NoticeLevel::kError}) {
    if (word == name_of(level)) return level;
  }
  return fail(ErrorCode::kBadInput, "--log-level: expected info, warning or error, got \"{}\"", word);
}

const char* name_of(NoticeLevel level) {
  switch (level) {
    case NoticeLevel::kInfo: return "info";
    case NoticeLevel::kWarning: return "warning";
    case NoticeLevel::kError: return "error";
  }
  return "?";
}

std::string utc_text(std::int64_t unix_ns, int digits) {
  std::int64_t seconds = unix_ns / kNsPerS;
  std::int64_t rest_ns = unix_ns % kNsPerS;
  if (rest_ns < 0) {
    rest_ns += kNsPerS;
    --seconds;
  }
  const auto time = static_cast<std::time_t>(seconds);
  std::tm utc = {};
  gmtime_r(&time, &utc);
  std::string text = fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday,
                                 utc.tm_hour, utc.tm_min, utc.tm_sec);
  if (digits > 0) text += "." + fmt::format("{:09}", rest_ns).substr(0, static_cast<std::size_t>(digits));
  return text + "Z";
}

std::string event_text(const Event& event) {
  std::string line =
      fmt::format("{} {} {}: {}", utc_text(event.unix_ns, 3), name_of(event.level), event.id, event.text);
  std::replace(line.begin(), line.end(), '\n', ' ');
  return line;
}

void write_event(const Event& event, EventFormat format) {
  switch (format) {
    case EventFormat::kNone: return;
    case EventFormat::kJournal:
      if (write_to_journal(event)) return;
      break;  // no journal: write text instead
    case EventFormat::kText: break;
    case EventFormat::kJson: std::fputs((json_of_event(event) + "\n").c_str(), stderr); return;
  }
  std::fputs((event_text(event) + "\n").c_str(), stderr);
}

}  // namespace footlight::tools
