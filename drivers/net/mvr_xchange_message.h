// Messages of MVR-xchange: JSON objects (DIN SPEC 15801, annex on communication), read and written.
//
// Read leniently, since programs and the examples of the specification differ: numbers and truth values also as text,
// the list of files as "Commits" or "Files", stations as one text or a list, and answers with the type of their request
// (drafts before 1.6). Texts that a message needs and values of a wrong type are errors. Written by the tables of 1.6.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/core/result.h"

namespace footlight::drivers {

inline constexpr int kMvrVersionMajor = 1;  // of MVR, of what this program reads and writes
inline constexpr int kMvrVersionMinor = 6;
inline constexpr std::size_t kMvrCommitsMax = 200;  // of one station; the newest are kept

// UUIDs are any text of at most 64 bytes. They keep the spelling of their sender, since some programs compare them
// letter by letter. This function ignores case, and braces around.
[[nodiscard]] bool same_uuid(std::string_view a, std::string_view b);

// One revision of a rig that a station offers. The stations that it is for are not kept: a file is offered to all.
struct MvrCommit {
  std::string file_uuid;
  std::string station_uuid;  // who offers it; empty: not stated
  int version_major = 0;     // of the file; 0.0: not stated
  int version_minor = 0;
  std::uint64_t file_bytes = 0;
  std::string comment;
  std::string file_name;  // a proposal of the sender, which may hold anything
  bool operator==(const MvrCommit&) const = default;
};

enum class MvrMessageType {
  kJoin,
  kJoinAnswer,
  kLeave,
  kLeaveAnswer,
  kCommit,
  kCommitAnswer,
  kRequest,
  kRequestAnswer,  // only of a failure: else the answer is the file
  kNewSessionHost,
  kNewSessionHostAnswer,
};
[[nodiscard]] const char* name_of(MvrMessageType type);  // "MVR_JOIN_RET"
[[nodiscard]] bool is_answer(MvrMessageType type);

struct MvrMessage {
  MvrMessageType type = MvrMessageType::kJoin;
  bool ok = true;       // answers
  std::string message;  // answers: why not
  // Joins and their answers; `station_uuid` also for leaves and commits.
  std::string provider;
  std::string station_name;
  std::string station_uuid;
  int version_major = 0;
  int version_minor = 0;
  bool has_commits = false;        // false: the list is missing, which leaves what is known as it is
  std::vector<MvrCommit> commits;  // in the order of the sender, the last kMvrCommitsMax; of a commit: the one
  // Requests.
  std::string file_uuid;  // empty: the newest
  std::vector<std::string> from_stations;
  // New hosts of a session.
  std::string service_name;
  std::string service_url;
  bool operator==(const MvrMessage&) const = default;
};

// Errors (kProtocol): no JSON object, no known type, a value of a wrong type, a text that is missing.
[[nodiscard]] Result<MvrMessage> parse_mvr_message(std::string_view json);
// Bytes that are no UTF-8 are replaced. Texts are cut to the lengths that are read.
[[nodiscard]] std::string build_mvr_message(const MvrMessage& message);
[[nodiscard]] MvrMessage mvr_answer(MvrMessageType to, bool ok, std::string message = {});

}  // namespace footlight::drivers
