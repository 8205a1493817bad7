// What `footlight mvr` prints, for people and as JSON. Texts of other stations are made printable.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "drivers/net/mvr_xchange_group.h"

namespace footlight::tools {

[[nodiscard]] std::string size_text(std::uint64_t bytes);                          // "1.2 MB"
[[nodiscard]] std::string commit_text(const drivers::MvrCommit& commit);           // size, file name, comment
[[nodiscard]] std::string station_words(const drivers::MvrGroup::Member& member);  // name, UUID and address
// Lines with line ends: the station, then its files.
[[nodiscard]] std::string station_text(const drivers::MvrGroup::Member& member);
[[nodiscard]] std::string event_text(const drivers::MvrEvent& event);
// One JSON object and a line end. `event`: a member of that name is added; empty: none.
[[nodiscard]] std::string station_json(const drivers::MvrGroup::Member& member, std::string_view event = {});
[[nodiscard]] std::string event_json(const drivers::MvrEvent& event);
[[nodiscard]] std::string start_json(const drivers::MvrStation& station, const std::string& group, int port);

}  // namespace footlight::tools
