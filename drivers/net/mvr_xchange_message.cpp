#include "drivers/net/mvr_xchange_message.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>

#include <nlohmann/json.hpp>

#include "drivers/net/bytes.h"
#include "drivers/net/mvr_xchange_names.h"

namespace footlight::drivers {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kTextBytesMax = 4096;  // longer ones are cut
constexpr std::size_t kFileNameBytesMax = 1024;
constexpr std::size_t kUuidBytesMax = 64;

struct TypeName {
  MvrMessageType type;
  const char* name;
};
constexpr std::array<TypeName, 10> kTypes = {{
    {MvrMessageType::kJoin, "MVR_JOIN"},
    {MvrMessageType::kJoinAnswer, "MVR_JOIN_RET"},
    {MvrMessageType::kLeave, "MVR_LEAVE"},
    {MvrMessageType::kLeaveAnswer, "MVR_LEAVE_RET"},
    {MvrMessageType::kCommit, "MVR_COMMIT"},
    {MvrMessageType::kCommitAnswer, "MVR_COMMIT_RET"},
    {MvrMessageType::kRequest, "MVR_REQUEST"},
    {MvrMessageType::kRequestAnswer, "MVR_REQUEST_RET"},
    {MvrMessageType::kNewSessionHost, "MVR_NEW_SESSION_HOST"},
    {MvrMessageType::kNewSessionHostAnswer, "MVR_NEW_SESSION_HOST_RET"},
}};

MvrMessageType answer_to(MvrMessageType type) {
  return is_answer(type) ? type : static_cast<MvrMessageType>(static_cast<int>(type) + 1);
}

std::string_view bare_uuid(std::string_view text) {
  return text.size() > 2 && text.front() == '{' && text.back() == '}' ? text.substr(1, text.size() - 2) : text;
}

// Reads the members of one object; the first error stays.
class Members {
 public:
  Members(const Json& object, std::string_view where) : object_(object), where_(where) {}

  [[nodiscard]] bool has(const char* key) const {
    const auto at = object_.find(key);
    return at != object_.end() && !at->is_null();
  }

  std::string text(const char* key, std::size_t bytes_max = kTextBytesMax) {
    if (!has(key)) return {};
    const Json& value = object_[key];
    if (!value.is_string()) {
      refuse(key, "a text", value);
      return {};
    }
    return std::string(cut_utf8(value.get_ref<const std::string&>(), bytes_max));
  }

  std::string uuid(const char* key) {
    const std::string text = this->text(key);
    if (text.size() > kUuidBytesMax) refuse(key, "a UUID", object_[key]);
    return text;
  }

  std::string needed_uuid(const char* key) {
    const std::string text = uuid(key);
    if (text.empty()) refuse_missing(key);
    return text;
  }

  std::uint64_t number(const char* key, std::uint64_t max) {
    if (!has(key)) return 0;
    const Json& value = object_[key];
    std::uint64_t number = 0;
    bool sound = value.is_number_unsigned();
    if (sound) {
      number = value.get<std::uint64_t>();
    } else if (value.is_string()) {
      const auto& text = value.get_ref<const std::string&>();
      const char* const end = text.data() + text.size();
      const auto [next, fault] = std::from_chars(text.data(), end, number);
      sound = text.empty() || (fault == std::errc() && next == end);
    }
    if (!sound || number > max) {
      refuse(key, fmt::format("a number from 0 to {}", max), value);
      return 0;
    }
    return number;
  }

  bool truth(const char* key, bool missing) {
    if (!has(key)) return missing;
    const Json& value = object_[key];
    if (value.is_boolean()) return value.get<bool>();
    const std::string text = value.is_string() ? value.get<std::string>() : "";
    if (same_ascii(text, "true") || same_ascii(text, "false")) return same_ascii(text, "true");
    refuse(key, "true or false", value);
    return missing;
  }

  // One text or a list of texts; empty ones are left out.
  std::vector<std::string> uuids(const char* key) {
    std::vector<std::string> found;
    if (!has(key)) return found;
    const Json& value = object_[key];
    if (value.is_string()) {
      found.push_back(uuid(key));
    } else if (value.is_array()) {
      for (const Json& one : value) {
        if (!one.is_string() || one.get_ref<const std::string&>().size() > kUuidBytesMax) {
          refuse(key, "UUIDs", one);
          return {};
        }
        found.push_back(one.get<std::string>());
      }
    } else {
      refuse(key, "a UUID or a list of UUIDs", value);
    }
    std::erase(found, "");
    return found;
  }

  void refuse_missing(const char* key) {
    if (status_) status_ = fail(ErrorCode::kProtocol, "{}: \"{}\" is missing", where_, key);
  }
  void refuse(const char* key, std::string_view expected, const Json& value) {
    if (!status_) return;
    // Values within values are not shown: to write them takes a call for each level, of which there may be a million.
    const std::string shown = value.is_array()    ? "a list"
                              : value.is_object() ? "an object"
                                                  : value.dump(-1, ' ', true, Json::error_handler_t::replace);
    status_ = fail(ErrorCode::kProtocol, "{}: \"{}\" is {}; expected {}", where_, key, cut_utf8(shown, 60), expected);
  }
  [[nodiscard]] const Status& status() const { return status_; }

 private:
  const Json& object_;
  std::string_view where_;
  Status status_;
};

Result<MvrCommit> commit_of(const Json& object, std::string_view where) {
  if (!object.is_object()) return fail(ErrorCode::kProtocol, "{}: a commit that is no object", where);
  Members members(object, where);
  MvrCommit commit;
  commit.file_uuid = members.needed_uuid("FileUUID");
  commit.station_uuid = members.uuid("StationUUID");
  commit.version_major = static_cast<int>(members.number("verMajor", 1000));
  commit.version_minor = static_cast<int>(members.number("verMinor", 1000));
  commit.file_bytes = members.number("FileSize", std::numeric_limits<std::int64_t>::max());
  commit.comment = members.text("Comment");
  commit.file_name = members.text("FileName", kFileNameBytesMax);
  FL_TRY(members.status());
  return commit;
}

Status read_join(Members& members, const Json& object, MvrMessage& message) {
  message.provider = members.text("Provider");
  message.station_name = members.text("StationName");
  message.station_uuid = members.uuid("StationUUID");
  message.version_major = static_cast<int>(members.number("verMajor", 1000));
  message.version_minor = static_cast<int>(members.number("verMinor", 1000));
  const char* const key = members.has("Commits") ? "Commits" : "Files";
  message.has_commits = members.has(key);
  if (!message.has_commits) return {};
  const Json& list = object[key];
  if (!list.is_array()) {
    members.refuse(key, "a list", list);
    return members.status();
  }
  const std::size_t count = std::min(list.size(), kMvrCommitsMax);
  message.commits.reserve(count);
  for (std::size_t i = list.size() - count; i < list.size(); ++i) {
    FL_ASSIGN(MvrCommit commit, commit_of(list[i], name_of(message.type)));
    if (commit.station_uuid.empty()) commit.station_uuid = message.station_uuid;
    message.commits.push_back(std::move(commit));
  }
  return {};
}

Json json_of(const MvrCommit& commit) {
  Json json = {{"Type", "MVR_COMMIT"},
               {"verMajor", commit.version_major},
               {"verMinor", commit.version_minor},
               {"FileSize", commit.file_bytes},
               {"FileUUID", commit.file_uuid},
               {"StationUUID", commit.station_uuid},
               {"ForStationsUUID", Json::array()},
               {"Comment", cut_utf8(commit.comment, kTextBytesMax)}};
  if (!commit.file_name.empty()) json["FileName"] = cut_utf8(commit.file_name, kFileNameBytesMax);
  return json;
}

}  // namespace

bool same_uuid(std::string_view a, std::string_view b) { return same_ascii(bare_uuid(a), bare_uuid(b)); }

const char* name_of(MvrMessageType type) { return kTypes.at(static_cast<std::size_t>(type)).name; }
bool is_answer(MvrMessageType type) { return static_cast<int>(type) % 2 == 1; }

MvrMessage mvr_answer(MvrMessageType to, bool ok, std::string message) {
  MvrMessage answer;
  answer.type = answer_to(to);
  answer.ok = ok;
  answer.message = std::move(message);
  return answer;
}

Result<MvrMessage> parse_mvr_message(std::string_view json) {
  const Json object = Json::parse(json, nullptr, /*allow_exceptions=*/false);
  if (!object.is_object()) return fail(ErrorCode::kProtocol, "a message that is no JSON object");
  Members head(object, "a message");
  const std::string type = head.text("Type", 64);
  FL_TRY(head.status());
  const auto known = std::find_if(kTypes.begin(), kTypes.end(), [&](const TypeName& one) { return one.name == type; });
  if (known == kTypes.end()) return fail(ErrorCode::kProtocol, "a message of the unknown type \"{}\"", type);
  MvrMessage message;
  message.type = known->type;
  Members members(object, known->name);
  // Drafts before 1.6 answer with the type of the request.
  if (members.has("OK") && !is_answer(message.type)) message.type = answer_to(message.type);
  message.ok = members.truth("OK", true);
  message.message = members.text("Message");
  switch (message.type) {
    case MvrMessageType::kJoin:
    case MvrMessageType::kJoinAnswer:
      FL_TRY(read_join(members, object, message));
      if (message.type == MvrMessageType::kJoin && message.station_uuid.empty()) members.refuse_missing("StationUUID");
      break;
    case MvrMessageType::kLeave:
      message.station_uuid = members.uuid("FromStationUUID");
      if (message.station_uuid.empty()) message.station_uuid = members.needed_uuid("StationUUID");
      break;
    case MvrMessageType::kCommit: {
      FL_ASSIGN(MvrCommit commit, commit_of(object, known->name));
      message.station_uuid = commit.station_uuid;
      message.has_commits = true;
      message.commits.push_back(std::move(commit));
      break;
    }
    case MvrMessageType::kRequest:
      message.file_uuid = members.uuid("FileUUID");
      message.from_stations = members.uuids("FromStationUUID");
      break;
    case MvrMessageType::kNewSessionHost:
      message.service_name = members.text("ServiceName");
      message.service_url = members.text("ServiceURL");
      break;
    default: break;
  }
  FL_TRY(members.status());
  return message;
}

std::string build_mvr_message(const MvrMessage& message) {
  Json json = {{"Type", name_of(message.type)}};
  if (is_answer(message.type)) {
    json["OK"] = message.ok;
    json["Message"] = cut_utf8(message.message, kTextBytesMax);
  }
  switch (message.type) {
    case MvrMessageType::kJoin:
    case MvrMessageType::kJoinAnswer:
      json["Provider"] = message.provider;
      json["StationName"] = cut_utf8(message.station_name, kTextBytesMax);
      json["StationUUID"] = message.station_uuid;
      json["verMajor"] = message.version_major;
      json["verMinor"] = message.version_minor;
      if (message.has_commits) {
        json["Commits"] = Json::array();
        for (const MvrCommit& commit : message.commits) json["Commits"].push_back(json_of(commit));
      }
      break;
    case MvrMessageType::kLeave: json["FromStationUUID"] = message.station_uuid; break;
    case MvrMessageType::kCommit:
      if (!message.commits.empty()) json = json_of(message.commits.front());
      break;
    case MvrMessageType::kRequest:
      json["FileUUID"] = message.file_uuid;
      json["FromStationUUID"] = message.from_stations;
      break;
    case MvrMessageType::kNewSessionHost:
      json["ServiceName"] = message.service_name;
      json["ServiceURL"] = message.service_url;
      break;
    default: break;
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace footlight::drivers
