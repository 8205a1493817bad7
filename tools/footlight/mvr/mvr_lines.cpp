#include "tools/footlight/mvr/mvr_lines.h"

#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

using Json = nlohmann::json;
using drivers::MvrCommit;
using Kind = drivers::MvrEvent::Kind;

Json json_of(const MvrCommit& commit) {
  return {{"file_uuid", printable_utf8(commit.file_uuid)},
          {"file_name", printable_utf8(commit.file_name)},
          {"comment", printable_utf8(commit.comment)},
          {"bytes", commit.file_bytes},
          {"station_uuid", printable_utf8(commit.station_uuid)},
          {"version", fmt::format("{}.{}", commit.version_major, commit.version_minor)}};
}

// People copy the command into a shell, so that it holds no other signs of a station.
std::string file_hint(const std::string& uuid) {
  constexpr std::string_view kUuidSigns = "0123456789ABCDEFabcdef{}-";
  const bool plain = uuid.find_first_not_of(kUuidSigns) == std::string::npos;
  return fmt::format("{}{}{}", plain ? "footlight mvr get --file " : "file ", printable_line(uuid),
                     plain ? " -o FILE" : "");
}

std::string line_of(const Json& json) { return json.dump() + "\n"; }

}  // namespace

std::string size_text(std::uint64_t bytes) {
  if (bytes < 10'000) return fmt::format("{} bytes", bytes);
  if (bytes < 10'000'000) return fmt::format("{:.0f} kB", static_cast<double>(bytes) / 1e3);
  return fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6);
}

std::string commit_text(const MvrCommit& commit) {
  std::string text = size_text(commit.file_bytes);
  if (!commit.file_name.empty()) text += "  " + printable_line(commit.file_name);
  if (!commit.comment.empty()) text += "  \"" + printable_line(commit.comment) + "\"";
  return text;
}

std::string station_words(const drivers::MvrGroup::Member& member) {
  const auto& station = member.station;
  return fmt::format("'{}'  {}  {}", printable_line(station.name), printable_line(station.uuid),
                     text_of(station.address));
}

std::string station_text(const drivers::MvrGroup::Member& member) {
  const auto& station = member.station;
  std::string text = fmt::format("{}  {}", printable_line(station.name), text_of(station.address));
  if (!member.peer.provider.empty()) text += "  " + printable_line(member.peer.provider);
  if (!station.group.empty()) text += "  group " + printable_line(station.group);
  text += "\n";
  if (!member.trouble.empty()) text += fmt::format("  {}\n", printable_line(member.trouble));
  if (member.joined && member.peer.commits.empty()) text += "  no files\n";
  for (const MvrCommit& commit : member.peer.commits) {
    text += fmt::format("  {}  {}\n", printable_line(commit.file_uuid), commit_text(commit));
  }
  return text;
}

std::string station_json(const drivers::MvrGroup::Member& member, std::string_view event) {
  const auto& station = member.station;
  Json line = {{"name", printable_utf8(station.name)},
               {"uuid", printable_utf8(station.uuid)},
               {"group", printable_utf8(station.group)},
               {"address", text_of(station.address)},
               {"provider", printable_utf8(member.peer.provider)},
               {"joined", member.joined},
               {"files", Json::array()}};
  if (!event.empty()) line["event"] = event;
  if (!member.trouble.empty()) line["trouble"] = printable_utf8(member.trouble);
  for (const MvrCommit& commit : member.peer.commits) line["files"].push_back(json_of(commit));
  return line_of(line);
}

std::string event_text(const drivers::MvrEvent& event) {
  const std::string station = printable_line(event.station_name.empty() ? event.station_uuid : event.station_name);
  switch (event.kind) {
    case Kind::kJoined: return fmt::format("joined: {}\n", station);
    case Kind::kLeft: return fmt::format("left: {}\n", station);
    case Kind::kCommitted:
      return fmt::format("new file of {}: {}\n  {}\n", station.empty() ? "a station" : station,
                         commit_text(event.commit), file_hint(event.commit.file_uuid));
    case Kind::kSent: return fmt::format("sent: {}\n", printable_line(event.commit.file_name));
    case Kind::kRefused: return fmt::format("refused: {}\n", printable_line(event.text));
  }
  return {};
}

std::string event_json(const drivers::MvrEvent& event) {
  constexpr std::array<const char*, 5> kNames = {"joined", "left", "committed", "sent", "refused"};
  Json line = {{"event", kNames.at(static_cast<std::size_t>(event.kind))},
               {"station", printable_utf8(event.station_name)},
               {"station_uuid", printable_utf8(event.station_uuid)}};
  if (event.kind == Kind::kCommitted || event.kind == Kind::kSent) line["file"] = json_of(event.commit);
  if (event.kind == Kind::kRefused) line["reason"] = printable_utf8(event.text);
  return line_of(line);
}

std::string start_json(const drivers::MvrStation& station, const std::string& group, int port) {
  Json line = {{"event", "started"},
               {"station", printable_utf8(station.name())},
               {"station_uuid", station.uuid()},
               {"group", printable_utf8(group)},
               {"port", port}};
  const auto offers = station.offers();
  if (!offers.empty()) line["file"] = json_of(offers.back());
  return line_of(line);
}

}  // namespace footlight::tools
