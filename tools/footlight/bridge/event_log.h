// Events, one line each: as text, as JSON, or for systemd's journal.
//
//   text     2026-07-27T18:03:11.412Z warning port-lost: enttec-pro:EN1: lost: unplugged
//   json     {"time":"2026-07-27T18:03:11.412345Z","level":"warning","event":"port-lost",...}
//   journal  native fields: MESSAGE, PRIORITY, FOOTLIGHT_EVENT, FOOTLIGHT_PORT, FOOTLIGHT_UNIVERSE (sd_journal_send(3))
//
// docs/events.md lists the events.
#pragma once

#include <cstdint>
#include <string>

#include "sim/core/notice.h"
#include "sim/core/result.h"

namespace footlight::tools {

// A copy of a notice.
struct Event {
  std::int64_t unix_ns = 0;  // since 1970-01-01 UTC
  NoticeLevel level = NoticeLevel::kInfo;
  std::string id;
  std::string text;
  std::string port;
  Universe universe = 0;

  Event() = default;
  Event(const Notice& notice, std::int64_t now_unix_ns);
};

enum class EventFormat {
  kNone,
  kText,
  kJson,
  kJournal,
};
// "text", "json" or "journal". Empty: kJournal if standard error is connected to the journal (systemd.exec(5), variable
// JOURNAL_STREAM), else kText. kBadInput for other words, kUnsupported for "journal" in a build without libsystemd.
[[nodiscard]] Result<EventFormat> event_format_of(const std::string& word);
// "info", "warning" or "error".
[[nodiscard]] Result<NoticeLevel> notice_level_of(const std::string& word);

[[nodiscard]] const char* name_of(NoticeLevel level);
// "2026-07-27T18:03:11.412345Z", with this number of `digits` of the second (0 to 9).
[[nodiscard]] std::string utc_text(std::int64_t unix_ns, int digits);
// Without a line end. Line ends in the text become spaces, so that one event is one line.
[[nodiscard]] std::string event_text(const Event& event);
// Writes to standard error or to the journal. kNone: does nothing. One thread at a time.
void write_event(const Event& event, EventFormat format);

}  // namespace footlight::tools
