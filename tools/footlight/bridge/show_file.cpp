#include "tools/footlight/bridge/show_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <optional>

#include "fixtures/files/toml/toml_reader.h"
#include "fixtures/model/rig.h"
#include "sim/file_kind.h"
#include "tools/footlight/duration.h"

namespace footlight::tools {
namespace {

constexpr std::size_t kShowFileBytesMax = 4 << 20;  // 4 MiB; one with 63,999 ports would have less

using fixtures::TomlNode;
using fixtures::TomlReader;

// A duration such as "2.5s", or a number of seconds.
DurationNs read_duration(TomlReader& reader, std::string_view key, DurationNs fallback) {
  if (!reader.has(key)) return fallback;
  const auto duration_ns = parse_duration(reader.text(key));
  if (duration_ns) return *duration_ns;
  reader.trouble(reader.place_of(key), "{}: {}", key, duration_ns.error().message);
  return fallback;
}

std::optional<Endpoint> read_endpoint(TomlReader& reader) {
  const fixtures::SourceAt at = reader.place_of("endpoint");
  const std::string text = reader.text("endpoint");
  if (!reader.has("endpoint")) return std::nullopt;
  auto endpoint = parse_port(text);
  if (endpoint) return std::move(*endpoint);
  reader.trouble(at, "{}", endpoint.error().message);
  return std::nullopt;
}

// The effect of an edge. Keys that do not apply to the mode are not read, and therefore refused.
void read_gpio(TomlReader& reader, InOptions& options) {
  using drivers::StrobeMode;
  drivers::StrobeConfig& strobe = options.gpio_strobe;
  constexpr StrobeMode kModes[] = {StrobeMode::kFollow, StrobeMode::kOneShot, StrobeMode::kToggle, StrobeMode::kRate};
  strobe.mode = kModes[reader.word("mode", {"follow", "one-shot", "toggle", "rate"}, 0)];
  if (strobe.mode == StrobeMode::kFollow) strobe.hold_ns = read_duration(reader, "hold", strobe.hold_ns);
  if (strobe.mode == StrobeMode::kOneShot) {
    strobe.hold_ns = read_duration(reader, "hold", drivers::kOneShotHoldDefaultNs);
    strobe.retrigger = reader.word("retrigger", {"extend", "ignore"}, 0) == 0 ? drivers::Retrigger::kExtend
                                                                              : drivers::Retrigger::kIgnore;
  }
  if (strobe.mode == StrobeMode::kRate && (reader.has("rate_hz") || reader.has("rate_values"))) {
    const auto hz = reader.numbers("rate_hz", 1, 64, 0.01, 1'000.0);
    const auto values = reader.integers("rate_values", 1, 64, 0, 255);
    const bool rising = std::adjacent_find(hz.begin(), hz.end(), std::greater_equal<>()) == hz.end();
    if (hz.size() != values.size() || !rising) {
      reader.trouble(reader.place_of("rate_hz"),
                     "rate_hz: expected rising numbers, as many as in rate_values; example: rate_hz = [1, 25] and "
                     "rate_values = [1, 255]");
    } else {
      strobe.rate_points.clear();
      for (std::size_t i = 0; i < hz.size(); ++i)
        strobe.rate_points.push_back({.hz = hz[i], .value = static_cast<std::uint8_t>(values[i])});
    }
  }
  if (strobe.mode != StrobeMode::kRate) {
    strobe.on = static_cast<std::uint8_t>(reader.integer("on", 0, 255, strobe.on));
  }
  strobe.off = static_cast<std::uint8_t>(reader.integer("off", 0, 255, strobe.off));
  strobe.debounce_ns = read_duration(reader, "debounce", strobe.debounce_ns);
  strobe.flashes_hz_max = reader.number("flashes_hz_max", 0.0, drivers::kFlashesMaxLimitHz, strobe.flashes_hz_max);
  options.gpio_active_low = reader.boolean("active_low", false);
  constexpr drivers::GpioBias kBiases[] = {drivers::GpioBias::kAsIs, drivers::GpioBias::kNone,
                                           drivers::GpioBias::kPullUp, drivers::GpioBias::kPullDown};
  options.gpio_bias = kBiases[reader.word("bias", {"as-is", "none", "pull-up", "pull-down"}, 0)];
  // As a per-address priority, 0 would mean that the input does not claim the slot.
  options.priority = static_cast<int>(reader.integer("priority", 1, kPriorityMax, kPriorityDefault));
  options.wait_for_device = reader.boolean("wait_for_device", false);
}

std::vector<std::uint8_t> read_address_priorities(TomlReader& reader) {
  if (!reader.has("address_priorities")) return {};
  auto priorities = parse_address_priorities(reader.text("address_priorities"));
  if (priorities) return std::move(*priorities);
  reader.trouble(reader.place_of("address_priorities"), "address_priorities: {}", priorities.error().message);
  return {};
}

// cid = "8fd2a1c0-1b7e-4d0a-9a52-0d6f2f3f7c11": a UUID, with or without dashes.
drivers::Cid read_cid(TomlReader& reader) {
  if (!reader.has("cid")) return {};
  std::string digits = reader.text("cid");
  std::erase(digits, '-');
  drivers::Cid cid = {};
  bool is_hex = digits.size() == 2 * cid.size();
  for (std::size_t i = 0; is_hex && i < cid.size(); ++i) {
    const char* const begin = digits.data() + 2 * i;
    is_hex = std::from_chars(begin, begin + 2, cid[i], 16).ptr == begin + 2;
  }
  if (is_hex && cid != drivers::Cid{}) return cid;
  reader.trouble(reader.place_of("cid"),
                 "cid: expected a UUID of 32 hexadecimal digits that are not all 0; uuidgen prints one");
  return {};
}

// second_port = {key = "01020304", send = 0x10, ...}: see drivers::SecondPort.
Result<std::optional<drivers::SecondPort>> read_second_port(TomlReader& reader, const std::string& file) {
  const TomlNode* const table = reader.table("second_port");
  if (table == nullptr) return std::nullopt;
  TomlReader second(*table, file, "second_port");
  drivers::SecondPort port;
  const std::string key = second.text("key");
  constexpr std::size_t kDigits = 2 * std::tuple_size_v<decltype(port.key)>;
  bool is_hex = key.size() == kDigits;
  for (std::size_t i = 0; is_hex && i < port.key.size(); ++i) {
    const char* const begin = key.data() + 2 * i;
    is_hex = std::from_chars(begin, begin + 2, port.key[i], 16).ptr == begin + 2;
  }
  if (!is_hex && second.has("key"))
    second.trouble(second.place_of("key"), "key: expected {} hexadecimal digits, for example \"0A1B2C3D\"", kDigits);
  const auto label = [&](std::string_view name) { return static_cast<std::uint8_t>(second.integer(name, 0, 255, 0)); };
  port.assign = label("assign");
  port.send = label("send");
  port.receive = label("receive");
  port.receive_mode = label("receive_mode");
  port.change_of_state = label("change_of_state");
  FL_TRY(second.finish());
  return port;
}

// "1-24,30"
std::optional<SlotSet> parse_addresses(std::string_view text) {
  SlotSet slots;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    Address first = 0;
    auto read = std::from_chars(at, end, first);
    if (read.ec != std::errc() || !is_address(first)) return std::nullopt;
    Address last = first;
    if (read.ptr != end && *read.ptr == '-') {
      read = std::from_chars(read.ptr + 1, end, last);
      if (read.ec != std::errc() || !is_address(last) || last < first) return std::nullopt;
    }
    for (Address address = first; address <= last; ++address) {
      slots.set(static_cast<std::size_t>(slot_of_address(address)));
    }
    if (read.ptr == end) return slots;
    if (*read.ptr != ',') return std::nullopt;
    at = read.ptr + 1;
  }
}

void read_ltp_slots(const TomlNode& node, TomlReader& merge, Show& show) {
  for (const fixtures::TomlEntry& entry : std::get<fixtures::TomlTable>(node.value)) {
    LtpSlots ltp;
    const char* const end = entry.key.data() + entry.key.size();
    const auto read = std::from_chars(entry.key.data(), end, ltp.universe);
    const auto* const text = std::get_if<std::string>(&entry.node.value);
    const auto slots = text != nullptr ? parse_addresses(*text) : std::nullopt;
    if (read.ec != std::errc() || read.ptr != end || !is_universe(ltp.universe)) {
      merge.trouble(entry.node.at, "ltp_slots: \"{}\" is not a universe; expected one from {} to {}", entry.key,
                    kUniverseMin, kUniverseMax);
    } else if (!slots) {
      merge.trouble(entry.node.at, "ltp_slots: universe {}: expected addresses from 1 to 512, for example \"1-24,30\"",
                    ltp.universe);
    } else if (std::find(show.ltp.begin(), show.ltp.end(), ltp.universe) != show.ltp.end()) {
      merge.trouble(entry.node.at, "ltp_slots: the whole universe {} is in ltp already; remove one of the two",
                    ltp.universe);
    } else {
      ltp.slots = *slots;
      show.ltp_slots.push_back(ltp);
    }
  }
}

Result<InPlan> read_in(const TomlNode& node, const std::string& file) {
  TomlReader reader(node, file, "[[in]]");
  InPlan plan;
  if (auto endpoint = read_endpoint(reader)) {
    plan.endpoint = std::move(*endpoint);
    InOptions& options = plan.options;
    switch (plan.endpoint.kind) {
      case EndpointKind::kNetwork:
        if (plan.endpoint.scheme == "sacn") options.hear_preview = reader.boolean("preview", false);
        if (plan.endpoint.scheme == "artnet") {
          options.priority = static_cast<int>(reader.integer("priority", 0, kPriorityMax, kPriorityDefault));
          options.rdm = reader.boolean("rdm", false);
        }
        break;
      case EndpointKind::kDevice: {
        options.wait_for_device = reader.boolean("wait_for_device", false);
        options.receive_on_change = reader.boolean("receive_on_change", false);
        FL_ASSIGN(options.second_port, read_second_port(reader, file));
        break;
      }
      case EndpointKind::kGpio: read_gpio(reader, options); break;
      case EndpointKind::kControl:
      case EndpointKind::kPicture: break;
      case EndpointKind::kFile:
        if (plan.endpoint.scheme == "audio") options.wait_for_device = reader.boolean("wait_for_device", false);
        options.log_loop = reader.boolean("loop", false);
        options.log_start_ns = read_duration(reader, "start", 0);
        options.log_stop_ns = read_duration(reader, "stop", kTimeNever);
        options.log_speed = reader.number("speed", 0.001, 1'000.0, 1.0);
        break;
    }
  }
  FL_TRY(reader.finish());
  return plan;
}

Result<OutPlan> read_out(const TomlNode& node, const std::string& file) {
  TomlReader reader(node, file, "[[out]]");
  OutPlan plan;
  if (auto endpoint = read_endpoint(reader)) {
    plan.endpoint = std::move(*endpoint);
    OutOptions& options = plan.options;
    switch (plan.endpoint.kind) {
      case EndpointKind::kNetwork:
        options.rate_hz_max = reader.number("rate_hz_max", 0.0, 1'000.0, 0.0);
        if (plan.endpoint.scheme == "artnet") {
          options.sync = reader.boolean("sync", false);
          if (plan.endpoint.addresses.empty()) options.broadcast = reader.boolean("broadcast", true);
        }
        if (plan.endpoint.scheme == "sacn") {
          options.priority = static_cast<int>(reader.integer("priority", 0, kPriorityMax, kPriorityDefault));
          options.preview = reader.boolean("preview", false);
          options.source_name = reader.text("source_name", options.source_name);
          options.address_priorities = read_address_priorities(reader);
          options.sync_universe = static_cast<int>(reader.integer("sync_universe", 0, kUniverseMax, 0));
          options.multicast_ttl = static_cast<int>(reader.integer("multicast_ttl", 0, 255, 0));
          options.announce = reader.boolean("announce", true);
          options.cid = read_cid(reader);
        }
        break;
      case EndpointKind::kDevice: {
        options.wait_for_device = reader.boolean("wait_for_device", false);
        options.blackout_on_exit = reader.boolean("blackout_on_exit", false);
        options.rate_hz_max = reader.number("rate_hz_max", 0.0, 1'000.0, 0.0);
        FL_ASSIGN(options.second_port, read_second_port(reader, file));
        break;
      }
      case EndpointKind::kControl:
      case EndpointKind::kGpio: break;  // refused when it is opened
      case EndpointKind::kPicture:
      case EndpointKind::kFile: options.log_overwrite = reader.boolean("overwrite", false); break;
    }
  }
  plan.standby_for = reader.text("standby_for", "");
  FL_TRY(reader.finish());
  return plan;
}

}  // namespace

Status order_standbys(Show& show) {
  std::vector<OutPlan> ordered;
  std::vector<OutPlan> waiting = std::move(show.outs);
  const auto names = [](const std::vector<OutPlan>& plans, const std::string& text) {
    return std::any_of(plans.begin(), plans.end(), [&](const OutPlan& plan) { return plan.endpoint.text == text; });
  };
  while (!waiting.empty()) {
    const auto ready = std::find_if(waiting.begin(), waiting.end(), [&](const OutPlan& plan) {
      return plan.standby_for.empty() || names(ordered, plan.standby_for);
    });
    if (ready == waiting.end()) {
      const OutPlan& plan = waiting.front();
      const char* const why = plan.standby_for == plan.endpoint.text ? "an output cannot be its own standby"
                              : names(waiting, plan.standby_for)
                                  ? "these outputs are standbys of each other in a circle"
                                  : "expected the endpoint of another output, exactly as written there";
      return fail(ErrorCode::kBadInput, "{}: standby_for = \"{}\": {}", plan.endpoint.text, plan.standby_for, why);
    }
    ordered.push_back(std::move(*ready));
    waiting.erase(ready);
  }
  show.outs = std::move(ordered);
  return {};
}

void add_ltp_slots(Show& show, const fixtures::Rig& rig) {
  const auto is_htp = [](const fixtures::ChannelFunction& function) {
    constexpr std::string_view kHtp[] = {"Dimmer", "ColorAdd_", "ColorSub_", "ColorRGB_"};
    return std::any_of(std::begin(kHtp), std::end(kHtp),
                       [&](std::string_view begin) { return function.attribute.starts_with(begin); });
  };
  const auto does_something = [](const fixtures::ChannelFunction& function) {
    return function.attribute != "NoFeature";
  };
  std::map<Universe, SlotSet> ltp, htp;
  for (const fixtures::PatchedFixture& fixture : rig.fixtures) {
    if (!fixture.patched) continue;
    const auto& type = rig.types[static_cast<std::size_t>(fixture.type)];
    for (const fixtures::Channel& channel : type.modes[static_cast<std::size_t>(fixture.mode)].channels) {
      Universe universe = fixture.universe;
      Address address = fixture.address;
      for (const fixtures::BreakAddress& further : fixture.further_addresses) {
        if (further.dmx_break != channel.dmx_break) continue;
        universe = further.universe;
        address = further.address;
      }
      const bool intensity = std::any_of(channel.functions.begin(), channel.functions.end(), is_htp);
      if (!intensity && std::none_of(channel.functions.begin(), channel.functions.end(), does_something)) continue;
      for (const int offset : channel.slot_offsets) {
        if (is_address(address + offset))
          (intensity ? htp : ltp)[universe].set(static_cast<std::size_t>(slot_of_address(address + offset)));
      }
    }
  }
  for (auto& [universe, slots] : ltp) {
    slots &= ~htp[universe];
    if (slots.none() || std::find(show.ltp.begin(), show.ltp.end(), universe) != show.ltp.end()) continue;
    const auto known = std::find_if(show.ltp_slots.begin(), show.ltp_slots.end(),
                                    [&, number = universe](const LtpSlots& each) { return each.universe == number; });
    if (known != show.ltp_slots.end())
      known->slots |= slots;
    else
      show.ltp_slots.push_back({.universe = universe, .slots = slots, .from_rig = true});
  }
}

Result<Show> parse_show(std::string_view text, const std::string& file) {
  FL_ASSIGN(const TomlNode root, fixtures::parse_toml(text, file));
  TomlReader reader(root, file, "");
  Show show;
  show.universe_count = static_cast<int>(reader.integer("universes", 0, kUniverseMax, 0));
  const TomlNode* const merge = reader.table("merge");
  const auto ins = reader.tables("in");
  const auto outs = reader.tables("out");
  if (merge != nullptr) {
    TomlReader merge_reader(*merge, file, "[merge]");
    show.merge.timeout_ns = read_duration(merge_reader, "timeout", kSenderTimeoutDefaultNs);
    if (show.merge.timeout_ns == 0) {
      merge_reader.trouble(merge_reader.place_of("timeout"), "timeout: expected a time above 0, for example \"2.5s\"");
    }
    if (merge_reader.has("ltp")) {
      for (const std::int64_t universe : merge_reader.integers("ltp", 1, kUniverseMax, kUniverseMin, kUniverseMax)) {
        show.ltp.push_back(static_cast<Universe>(universe));
      }
    }
    if (const TomlNode* const slots = merge_reader.table("ltp_slots")) read_ltp_slots(*slots, merge_reader, show);
    show.ltp_rig = merge_reader.text("ltp_rig", "");
    FL_TRY(merge_reader.finish());
  }
  for (const TomlNode* node : ins) {
    FL_ASSIGN(InPlan plan, read_in(*node, file));
    show.ins.push_back(std::move(plan));
  }
  for (const TomlNode* node : outs) {
    FL_ASSIGN(OutPlan plan, read_out(*node, file));
    show.outs.push_back(std::move(plan));
  }
  FL_TRY(reader.finish());
  if (show.outs.empty()) {
    return fail(ErrorCode::kBadInput,
                "{}: a show needs at least one [[out]], for example\n  [[out]]\n  endpoint = \"enttec-pro\"", file);
  }
  if (const Status ordered = order_standbys(show); !ordered) {
    return fail(ErrorCode::kBadInput, "{}: {}", file, ordered.error().message);
  }
  return show;
}

Result<Show> load_show(const std::string& path) {
  // Paths from the shell (/dev/stdin, /dev/fd/63) have a writer; opening a named pipe would block.
  if (!path.starts_with("/dev/")) {
    FL_TRY(refuse_pipe_input(path));
  }
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    const int number = errno;
    const ErrorCode code = number == ENOENT   ? ErrorCode::kNotFound
                           : number == EACCES ? ErrorCode::kPermission
                                              : ErrorCode::kIo;
    return fail(code, "{}: {}; name a show file, or ports as in 'footlight run --in sacn:1-9 --out enttec-pro'", path,
                std::strerror(number));
  }
  std::string text(kShowFileBytesMax + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  if (text.size() > kShowFileBytesMax) {
    return fail(ErrorCode::kBadInput, "{}: longer than {} bytes, the limit for a show file; name a show file", path,
                kShowFileBytesMax);
  }
  if (file.bad()) return fail(ErrorCode::kIo, "{}: cannot be read; it may be a directory", path);
  FL_ASSIGN(Show show, parse_show(text, path));
  if (!show.ltp_rig.empty()) {
    FL_ASSIGN(const fixtures::Rig rig,
              fixtures::load_rig((std::filesystem::path(path).parent_path() / show.ltp_rig).string()));
    add_ltp_slots(show, rig);
  }
  return show;
}

}  // namespace footlight::tools
