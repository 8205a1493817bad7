#include "tools/footlight/monitor/monitor_state.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

using Json = nlohmann::ordered_json;

// The value, or the fallback if it is missing or of another type.
template <class Value>
Value get(const Json& json, const char* key, Value fallback) {
  const auto at = json.find(key);
  if (at == json.end()) return fallback;
  if constexpr (std::is_same_v<Value, bool>) {
    if (at->is_boolean()) return at->template get<bool>();
  } else if constexpr (std::is_arithmetic_v<Value>) {
    if (at->is_number()) return at->template get<Value>();
  } else {
    if (at->is_string()) return printable_utf8(at->template get_ref<const std::string&>());
  }
  return fallback;
}

const Json& list(const Json& json, const char* key) {
  static const Json kNone = Json::array();
  const auto at = json.find(key);
  return at != json.end() && at->is_array() ? *at : kNone;
}

Result<Json> parse_page(const std::string& text, const char* event) {
  Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || get<std::string>(json, "event", "") != event) {
    return fail(ErrorCode::kProtocol,
                "expected the page \"{}\" of a bridge; both programs may be of different versions", event);
  }
  return json;
}

int digit_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}

MonitorPort port_of(const Json& json) {
  MonitorPort port;
  port.name = get<std::string>(json, "name", "");
  port.is_out = get<std::string>(json, "direction", "") == "out";
  port.state = get<std::string>(json, "state", "");
  port.standby = get(json, "standby", false);
  port.trouble = get<std::string>(json, "trouble", "");
  port.rate_hz = get(json, "rate_hz", 0.0);
  port.frames = get<std::uint64_t>(json, "frames", 0);
  port.rejected = get<std::uint64_t>(json, "rejected", 0);
  for (const char* key : {"dropped", "refused", "errors", "failures"}) port.lost += get<std::uint64_t>(json, key, 0);
  if (const auto latency = json.find("latency"); latency != json.end()) {
    port.latency_p99_ns = get<DurationNs>(*latency, "p99_ns", 0);
  }
  return port;
}

MonitorSender sender_of(const Json& json) {
  MonitorSender sender;
  sender.name = get<std::string>(json, "name", "");
  sender.priority = get(json, "priority", 0);
  sender.age_ns = get<DurationNs>(json, "age_ns", 0);
  sender.rate_hz = get(json, "rate_hz", 0.0);
  sender.wins = get(json, "wins", false);
  sender.per_address = get(json, "per_address", false);
  sender.lost = get<std::uint64_t>(json, "lost", 0);
  sender.late = get<std::uint64_t>(json, "late", 0);
  return sender;
}

}  // namespace

MonitorUniverse* MonitorState::find(Universe universe) {
  const auto at =
      std::lower_bound(universes.begin(), universes.end(), universe,
                       [](const MonitorUniverse& entry, Universe number) { return entry.universe < number; });
  return at != universes.end() && at->universe == universe ? &*at : nullptr;
}

Status take_status(MonitorState& state, const std::string& text) {
  FL_ASSIGN(const Json json, parse_page(text, "status"));
  state.json = text;
  state.ports.clear();
  for (const Json& port : list(json, "ports")) {
    if (port.is_object()) state.ports.push_back(port_of(port));
  }
  std::vector<MonitorUniverse> universes;
  for (const Json& entry : list(json, "universes")) {
    if (!entry.is_object()) continue;
    const auto number = get<Universe>(entry, "universe", 0);
    MonitorUniverse universe;
    if (const MonitorUniverse* known = state.find(number)) universe = *known;  // keeps its levels
    universe.universe = number;
    universe.rate_hz = get(entry, "rate_hz", 0.0);
    universe.priority = get(entry, "priority", 0);
    universe.frames_refused =
        get<std::uint64_t>(entry, "refused_priority", 0) + get<std::uint64_t>(entry, "refused_full", 0);
    universe.senders.clear();
    for (const Json& sender : list(entry, "senders")) {
      if (sender.is_object()) universe.senders.push_back(sender_of(sender));
    }
    universe.sender_count = get(entry, "senders", static_cast<int>(universe.senders.size()));
    universes.push_back(std::move(universe));
  }
  std::sort(universes.begin(), universes.end(), [](const auto& a, const auto& b) { return a.universe < b.universe; });
  state.universes = std::move(universes);
  return {};
}

Status take_levels(MonitorState& state, const std::string& text) {
  FL_ASSIGN(const Json json, parse_page(text, "levels"));
  state.now_ns = get<TimeNs>(json, "now_ns", 0);
  for (const Json& entry : list(json, "universes")) {
    if (!entry.is_object()) continue;
    MonitorUniverse* const universe = state.find(get<Universe>(entry, "universe", 0));
    const auto digits = get<std::string>(entry, "levels", "");
    if (universe == nullptr || digits.size() != 2 * universe->levels.size()) continue;
    const bool first = universe->revision == 0;
    universe->stamp_ns = get<TimeNs>(entry, "stamp_ns", 0);
    universe->revision = get<std::uint64_t>(entry, "revision", 0);
    Slots levels{};
    for (std::size_t i = 0; i < levels.size(); ++i) {
      const int high = digit_of(digits[2 * i]);
      const int low = digit_of(digits[2 * i + 1]);
      if (high < 0 || low < 0) return fail(ErrorCode::kProtocol, "levels: expected hexadecimal digits");
      levels[i] = static_cast<std::uint8_t>(high * 16 + low);
    }
    universe->take(levels, state.now_ns, first);
  }
  return {};
}

std::string json_of_monitor(const MonitorState& state, const std::string& time) {
  Json json = Json::parse(state.json, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) json = Json::object();
  json["event"] = "monitor";
  json["time"] = time;
  if (json.contains("universes") && json["universes"].is_array()) {
    for (Json& entry : json["universes"]) {
      const auto number = get<Universe>(entry, "universe", 0);
      const auto at = std::find_if(state.universes.begin(), state.universes.end(),
                                   [&](const MonitorUniverse& universe) { return universe.universe == number; });
      if (at == state.universes.end() || at->revision == 0) continue;
      entry["age_ns"] = std::max<DurationNs>(state.now_ns - at->stamp_ns, 0);
      entry["levels"] = at->levels;
    }
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace footlight::tools
