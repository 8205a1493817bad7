#include "sim/core/endpoint.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include "sim/core/words.h"

namespace footlight {
namespace {

constexpr int kArtnetWireMax = 32'768;  // 15 bits of port address, counted from 1
constexpr int kVrslWireMax = 9;         // three universes in each colour of its grid, as pictures and over OSC
constexpr int kConnectorMax = 64;
constexpr const char* kFileScheme = "log";
constexpr const char* kGpioScheme = "gpio";
constexpr const char* kPictureScheme = "vrsl";
constexpr const char* kSoundScheme = "audio";
constexpr const char* kOscScheme = "osc";
constexpr const char* kMidiScheme = "midi";
constexpr int kGpioLineMax = 65'535;

struct NetworkScheme {
  std::string_view name;
  int wire_max;
};
constexpr NetworkScheme kNetworkSchemes[] = {
    {"sacn", kUniverseMax}, {"artnet", kArtnetWireMax}, {"vrsl-osc", kVrslWireMax}};

// The whole text as a number from 0; nullopt for anything else.
std::optional<int> number_of(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size() || number < 0) return std::nullopt;
  return number;
}

// True for four numbers from 0 to 255 between dots.
bool is_ipv4(std::string_view text) {
  for (int part = 0; part < 4; ++part) {
    const std::size_t dot = part < 3 ? text.find('.') : text.size();
    if (dot == std::string_view::npos || dot == 0 || dot > 3) return false;
    const auto number = number_of(text.substr(0, dot));
    if (!number || *number > 255) return false;
    text.remove_prefix(part < 3 ? dot + 1 : dot);
  }
  return true;
}

// Removes the text after the last `mark` from `text` and returns it; nullopt if there is no mark.
std::optional<std::string_view> take_suffix(std::string_view& text, char mark) {
  const std::size_t at = text.rfind(mark);
  if (at == std::string_view::npos) return std::nullopt;
  const std::string_view suffix = text.substr(at + 1);
  text = text.substr(0, at);
  return suffix;
}

// "a,b,,c" to "a", "b", "", "c".
std::vector<std::string> split_at_commas(std::string_view text) {
  std::vector<std::string> parts;
  while (true) {
    const std::size_t comma = text.find(',');
    parts.emplace_back(text.substr(0, comma));
    if (comma == std::string_view::npos) return parts;
    text.remove_prefix(comma + 1);
  }
}

// The first part that repeats an earlier one; nullopt if all differ.
std::optional<std::string> named_twice(std::vector<std::string> parts) {
  std::sort(parts.begin(), parts.end());
  const auto twice = std::adjacent_find(parts.begin(), parts.end());
  return twice == parts.end() ? std::nullopt : std::optional(*twice);
}

// "1-3,7" to 1, 2, 3, 7.
Result<std::vector<int>> parse_list(std::string_view text, int number_max) {
  std::vector<int> numbers;
  std::string_view rest = text;
  while (true) {
    const std::size_t comma = rest.find(',');
    const std::string_view part = rest.substr(0, comma);
    const std::size_t dash = part.find('-');
    const auto first = number_of(part.substr(0, dash));
    const auto last = dash == std::string_view::npos ? first : number_of(part.substr(dash + 1));
    if (!first || !last) {
      return fail(ErrorCode::kBadInput, "expected universes as in 1-9 or 1,3,5-7, got \"{}\"", part);
    }
    for (const int number : {*first, *last}) {
      if (number < kUniverseMin || number > number_max) {
        return fail(ErrorCode::kBadInput, "universe {} does not exist; expected {} to {}, as in 1-9", number,
                    kUniverseMin, number_max);
      }
    }
    if (*last < *first) {
      return fail(ErrorCode::kBadInput, "the range {} runs backwards; write {}-{}", part, *last, *first);
    }
    for (int number = *first; number <= *last; ++number) numbers.push_back(number);
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  auto sorted = numbers;
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end()) {
    return fail(ErrorCode::kBadInput, "universe {} is named twice in {}; name each universe once", *twice, text);
  }
  return numbers;
}

Status parse_network(std::string_view text, std::string_view rest, const NetworkScheme& scheme, Endpoint& endpoint) {
  if (const auto names = take_suffix(rest, '%')) {
    endpoint.interface_names = split_at_commas(*names);
    for (const std::string& name : endpoint.interface_names) {
      if (!name.empty() && name.find_first_of("@=: ") == std::string::npos) continue;
      return fail(ErrorCode::kBadInput,
                  "{}: expected the name of an interface at the end after \"%\", as in {}:1-9%eth0 or {}:1-9%eth0,eth1",
                  text, scheme.name, scheme.name);
    }
    if (const auto twice = named_twice(endpoint.interface_names)) {
      return fail(ErrorCode::kBadInput, "{}: interface {} is named twice; name each interface once", text, *twice);
    }
  }
  if (auto address = take_suffix(rest, '@')) {
    std::string_view host = *address;
    if (const auto port = take_suffix(host, ':')) {
      const auto number = port->empty() ? std::nullopt : number_of(*port);
      if (!number || *number < 1 || *number > 65'535) {
        return fail(ErrorCode::kBadInput,
                    "{}: expected a UDP port from 1 to 65535 after \":\", as in {}:1-9@10.0.0.7:5569, got \"{}\"", text,
                    scheme.name, *port);
      }
      endpoint.udp_port = static_cast<std::uint16_t>(*number);
    }
    endpoint.addresses = split_at_commas(host);
    for (const std::string& one : endpoint.addresses) {
      if (is_ipv4(one)) continue;
      return fail(ErrorCode::kBadInput, "{}: expected an IPv4 address after \"@\", as in {}:1-9@10.0.0.7, got \"{}\"",
                  text, scheme.name, one);
    }
    if (const auto twice = named_twice(endpoint.addresses)) {
      return fail(ErrorCode::kBadInput, "{}: address {} is named twice; name each address once", text, *twice);
    }
  }
  if (rest.empty()) {
    return fail(ErrorCode::kBadInput, "{}: expected universes, as in {}:1-9 or {}:1,3,5-7", text, scheme.name,
                scheme.name);
  }
  auto universes = parse_wire_universes(rest, scheme.wire_max);
  if (!universes) return fail(ErrorCode::kBadInput, "{}: {}", text, universes.error().message);
  endpoint.universes = std::move(*universes);
  return {};
}

Status parse_device(std::string_view text, std::string_view rest, Endpoint& endpoint) {
  std::vector<int> shows;
  if (const auto show = take_suffix(rest, '=')) {
    auto numbers = parse_list(*show, kUniverseMax);
    if (!numbers) {
      return fail(ErrorCode::kBadInput,
                  "{}: expected universes from {} to {} after \"=\", one for each connector, as in {}:EN123456=3; {}",
                  text, kUniverseMin, kUniverseMax, endpoint.scheme, numbers.error().message);
    }
    shows = std::move(*numbers);
  }
  std::vector<int> connectors;
  const std::size_t slash = rest.rfind('/');
  if (slash != std::string_view::npos && rest.find_first_not_of("0123456789,", slash + 1) == std::string_view::npos) {
    auto numbers = parse_list(rest.substr(slash + 1), kConnectorMax);
    if (!numbers || (!shows.empty() && shows.size() != numbers->size())) {
      return fail(ErrorCode::kBadInput,
                  "{}: expected connectors from 1 to {} after \"/\", as many as universes, as in {}:EN123456/2=4", text,
                  kConnectorMax, endpoint.scheme);
    }
    connectors = std::move(*numbers);
    endpoint.names_connectors = true;
    rest = rest.substr(0, slash);
  }
  const std::size_t count = std::max<std::size_t>({shows.size(), connectors.size(), 1});
  for (std::size_t i = 0; i < count; ++i) {
    const int first = static_cast<int>(i) + 1;
    endpoint.universes.push_back({connectors.empty() ? first : connectors[i], shows.empty() ? first : shows[i]});
  }
  endpoint.target = rest;
  return {};
}

// "16-18,BLACKOUT" to "16", "17", "18", "BLACKOUT". A part that is not a range of numbers is a name.
Result<std::vector<std::string>> parse_lines(std::string_view text) {
  std::vector<std::string> lines;
  for (const std::string& part : split_at_commas(text)) {
    const std::size_t dash = part.find('-');
    const auto first = dash == std::string::npos ? std::nullopt : number_of(part.substr(0, dash));
    const auto last = dash == std::string::npos ? std::nullopt : number_of(part.substr(dash + 1));
    if (!first || !last) {
      if (part.empty()) return fail(ErrorCode::kBadInput, "a line has no name");
      lines.push_back(part);
      continue;
    }
    if (*last < *first) {
      return fail(ErrorCode::kBadInput, "the range {} runs backwards; write {}-{}", part, *last, *first);
    }
    if (*last > kGpioLineMax) return fail(ErrorCode::kBadInput, "line {} does not exist", *last);
    for (int number = *first; number <= *last; ++number) lines.push_back(std::to_string(number));
  }
  if (const auto twice = named_twice(lines)) {
    return fail(ErrorCode::kBadInput, "line {} is named twice; name each line once", *twice);
  }
  return lines;
}

// "1.25": a universe and an address.
Result<std::pair<Universe, Address>> parse_place(std::string_view text, std::string_view place) {
  const std::size_t dot = place.find('.');
  const auto universe = number_of(place.substr(0, dot));
  const auto address = dot == std::string_view::npos ? std::nullopt : number_of(place.substr(dot + 1));
  if (universe && address && is_universe(*universe) && is_address(*address)) return std::pair(*universe, *address);
  return fail(ErrorCode::kBadInput,
              "{}: expected a universe from {} to {} and an address from 1 to {} after \"=\", as in =1.25, got \"{}\"",
              text, kUniverseMin, kUniverseMax, kSlotCountMax, place);
}

Status parse_gpio(std::string_view text, std::string_view rest, Endpoint& endpoint) {
  constexpr std::string_view kForm = "gpio:CHIP/LINES=UNIVERSE.ADDRESS, as in gpio:gpiochip0/17=1.25, or =tempo";
  const auto place = take_suffix(rest, '=');
  const auto lines = take_suffix(rest, '/');
  if (!place || !lines || rest.empty() || lines->empty()) {
    return fail(ErrorCode::kBadInput, "{}: expected {}", text, kForm);
  }
  const bool taps = *place == "tempo";
  std::pair<Universe, Address> slot{1, 1};
  if (!taps) {
    FL_ASSIGN(slot, parse_place(text, *place));
  }
  const auto [universe, address] = slot;
  auto parsed = parse_lines(*lines);
  if (!parsed) return fail(ErrorCode::kBadInput, "{}: {}; expected {}", text, parsed.error().message, kForm);
  endpoint.lines = std::move(*parsed);
  if (static_cast<int>(endpoint.lines.size()) > kSlotCountMax - slot_of_address(address)) {
    return fail(ErrorCode::kBadInput, "{}: {} lines from address {} on do not fit; a universe has {} addresses", text,
                endpoint.lines.size(), address, kSlotCountMax);
  }
  endpoint.target = rest;
  endpoint.first_address = address;
  if (!taps) endpoint.universes = {{universe, universe}};
  return {};
}

// A map, or a sound with the place of its plain map.
Status parse_sound(std::string_view text, std::string_view rest, Endpoint& endpoint) {
  endpoint.target = rest;
  if (rest.ends_with(".toml")) return {};
  const auto place = take_suffix(rest, '=');
  if (!place || rest.empty()) {
    return fail(ErrorCode::kBadInput,
                "{}: expected a sound map, as in audio:map.toml, or audio:SOUND=UNIVERSE.ADDRESS, as in "
                "audio:track.flac=1.25, audio:alsa:default=1.25 or audio:mock=1.25",
                text);
  }
  FL_ASSIGN(const auto slot, parse_place(text, *place));
  if (slot.second > kSlotCountMax - kPlainSoundSlots + 1) {
    return fail(ErrorCode::kBadInput, "{}: four bands and the beat from address {} on do not fit; use 1 to {}", text,
                slot.second, kSlotCountMax - kPlainSoundSlots + 1);
  }
  endpoint.target = rest;
  endpoint.universes = {{slot.first, slot.first}};
  endpoint.first_address = slot.second;
  return {};
}

// A map, or a UDP port with an address.
Status parse_osc(std::string_view text, std::string_view rest, Endpoint& endpoint) {
  if (rest.ends_with(".toml")) {
    endpoint.target = rest;
    return {};
  }
  const auto address = take_suffix(rest, '@');
  const auto port = number_of(rest);
  if (!port || *port < 1 || *port > 65'535 || (address && !is_ipv4(*address))) {
    return fail(ErrorCode::kBadInput,
                "{}: expected a UDP port, as in osc:8000 or osc:8000@10.0.0.7, or a control map, as in osc:map.toml",
                text);
  }
  endpoint.udp_port = static_cast<std::uint16_t>(*port);
  if (address) endpoint.addresses.emplace_back(*address);
  return {};
}

// A map, or a device with the place of its controllers.
Status parse_midi(std::string_view text, std::string_view rest, Endpoint& endpoint) {
  endpoint.target = rest;
  if (rest.ends_with(".toml")) return {};
  const auto place = take_suffix(rest, '=');
  if (!place || rest.empty()) {
    return fail(ErrorCode::kBadInput,
                "{}: expected a control map, as in midi:map.toml, or midi:DEVICE=UNIVERSE.ADDRESS, as in "
                "midi:nanoKONTROL2=1.1 or midi:mock=1.1",
                text);
  }
  FL_ASSIGN(const auto slot, parse_place(text, *place));
  endpoint.target = rest;
  endpoint.universes = {{slot.first, slot.first}};
  endpoint.first_address = slot.second;
  return {};
}

Result<std::vector<EndpointOption>> parse_options(std::string_view text) {
  std::vector<EndpointOption> options;
  while (!text.empty()) {
    const std::size_t end = text.find('&');
    const std::string_view part = text.substr(0, end);
    const std::size_t equals = part.find('=');
    if (equals == 0 || equals == std::string_view::npos || equals + 1 == part.size()) {
      return fail(ErrorCode::kBadInput,
                  "expected KEY=VALUE after the last \"?\", as in ?layout=vertical-left, got \"{}\"", part);
    }
    EndpointOption option{std::string(part.substr(0, equals)), std::string(part.substr(equals + 1))};
    const auto same = [&](const EndpointOption& other) { return other.key == option.key; };
    if (std::any_of(options.begin(), options.end(), same)) {
      return fail(ErrorCode::kBadInput, "option {} is named twice; name each option once", option.key);
    }
    options.push_back(std::move(option));
    if (end == std::string_view::npos) break;
    text.remove_prefix(end + 1);
  }
  return options;
}

Status parse_picture(std::string_view text, std::string_view rest, Endpoint& endpoint) {
  constexpr std::string_view kForm = "vrsl:UNIVERSES@TARGET, as in vrsl:1-9@frame_%05d.png";
  const std::size_t at = rest.find('@');
  const std::size_t mark = rest.rfind('?');
  const bool has_options = mark != std::string_view::npos && at != std::string_view::npos && mark > at;
  if (has_options) {
    auto options = parse_options(rest.substr(mark + 1));
    if (!options) return fail(ErrorCode::kBadInput, "{}: {}", text, options.error().message);
    endpoint.options = std::move(*options);
    rest = rest.substr(0, mark);
  }
  if (at == std::string_view::npos || at == 0 || at + 1 >= rest.size()) {
    return fail(ErrorCode::kBadInput, "{}: expected {}", text, kForm);
  }
  auto universes = parse_wire_universes(rest.substr(0, at), kVrslWireMax);
  if (!universes) return fail(ErrorCode::kBadInput, "{}: {}", text, universes.error().message);
  endpoint.universes = std::move(*universes);
  endpoint.target = rest.substr(at + 1);
  return {};
}

}  // namespace

bool is_sound_device(std::string_view sound) {
  return sound == "alsa" || sound.starts_with("alsa:") || sound == kMockSound;
}

std::vector<Universe> Endpoint::show_universes() const {
  std::vector<Universe> numbers;
  for (const WireUniverse& universe : universes) numbers.push_back(universe.show);
  return numbers;
}

Result<std::vector<WireUniverse>> parse_wire_universes(std::string_view text, int wire_max) {
  const std::size_t equals = text.find('=');
  FL_ASSIGN(const auto wire, parse_list(text.substr(0, equals), wire_max));
  auto show = wire;
  if (equals != std::string_view::npos) {
    FL_ASSIGN(show, parse_list(text.substr(equals + 1), kUniverseMax));
  }
  if (show.size() != wire.size()) {
    return fail(ErrorCode::kBadInput,
                "{} names {} universes on the wire and {} in the show; name equally many, as in 101-109=1-9", text,
                wire.size(), show.size());
  }
  std::vector<WireUniverse> universes;
  for (std::size_t i = 0; i < wire.size(); ++i) universes.push_back({wire[i], show[i]});
  return universes;
}

Result<std::vector<std::uint8_t>> parse_address_priorities(std::string_view text) {
  std::vector<std::uint8_t> priorities(kSlotCountMax);
  std::vector<bool> named(kSlotCountMax);
  for (const std::string& part : split_at_commas(text)) {
    const std::string_view rest = trimmed(part);
    const std::size_t colon = rest.find(':');
    const std::string_view range = rest.substr(0, colon);
    const std::size_t dash = range.find('-');
    // Text that is not a number becomes 0, which is out of range.
    const auto first = number_of(range.substr(0, dash)).value_or(0);
    const auto last = dash == std::string_view::npos ? first : number_of(range.substr(dash + 1)).value_or(0);
    const auto priority = colon == std::string_view::npos ? -1 : number_of(rest.substr(colon + 1)).value_or(-1);
    if (!is_address(first) || !is_address(last) || last < first || priority < 0 || priority > kPriorityMax) {
      return fail(ErrorCode::kBadInput,
                  "expected addresses from 1 to {} and a priority from 0 to {}, as in 1-100:150, got \"{}\"",
                  kSlotCountMax, kPriorityMax, rest);
    }
    for (Address address = first; address <= last; ++address) {
      const auto slot = static_cast<std::size_t>(slot_of_address(address));
      if (named[slot]) {
        return fail(ErrorCode::kBadInput, "address {} is named twice; name each address once", address);
      }
      named[slot] = true;
      priorities[slot] = static_cast<std::uint8_t>(priority);
    }
  }
  return priorities;
}

Result<Endpoint> parse_endpoint(std::string_view text, std::span<const std::string_view> device_schemes) {
  Endpoint endpoint;
  endpoint.text = text;
  // "enttec-pro=3" and "enttec-pro/2" have no target, so the scheme may end there too.
  const std::size_t scheme_end = std::min(text.find_first_of(":=/"), text.size());
  endpoint.scheme = text.substr(0, scheme_end);
  const bool has_colon = scheme_end < text.size() && text[scheme_end] == ':';
  const std::string_view rest = text.substr(scheme_end + (has_colon ? 1 : 0));

  if (endpoint.scheme == kFileScheme) {
    if (!has_colon || rest.empty()) {
      return fail(ErrorCode::kBadInput, "{}: expected the name of a file, as in log:show.dmxlog", text);
    }
    endpoint.kind = EndpointKind::kFile;
    endpoint.target = rest;
    return endpoint;
  }
  for (const NetworkScheme& scheme : kNetworkSchemes) {
    if (endpoint.scheme != scheme.name) continue;
    endpoint.kind = EndpointKind::kNetwork;
    FL_TRY(parse_network(text, has_colon ? rest : std::string_view{}, scheme, endpoint));
    return endpoint;
  }
  if (endpoint.scheme == kGpioScheme) {
    endpoint.kind = EndpointKind::kGpio;
    FL_TRY(parse_gpio(text, has_colon ? rest : std::string_view{}, endpoint));
    return endpoint;
  }
  if (endpoint.scheme == kPictureScheme) {
    endpoint.kind = EndpointKind::kPicture;
    FL_TRY(parse_picture(text, has_colon ? rest : std::string_view{}, endpoint));
    return endpoint;
  }
  if (endpoint.scheme == kSoundScheme) {
    endpoint.kind = EndpointKind::kFile;
    FL_TRY(parse_sound(text, has_colon ? rest : std::string_view{}, endpoint));
    return endpoint;
  }
  if (endpoint.scheme == kOscScheme || endpoint.scheme == kMidiScheme) {
    endpoint.kind = EndpointKind::kControl;
    const std::string_view after = has_colon ? rest : std::string_view{};
    FL_TRY(endpoint.scheme == kOscScheme ? parse_osc(text, after, endpoint) : parse_midi(text, after, endpoint));
    return endpoint;
  }
  for (const std::string_view scheme : device_schemes) {
    if (endpoint.scheme != scheme) continue;
    endpoint.kind = EndpointKind::kDevice;
    FL_TRY(parse_device(text, rest, endpoint));
    return endpoint;
  }

  std::string known;
  for (const NetworkScheme& scheme : kNetworkSchemes) known += fmt::format("{}, ", scheme.name);
  for (const std::string_view scheme : device_schemes) known += fmt::format("{}, ", scheme);
  known += fmt::format("{}, {}, {}, {}, {}, {}", kGpioScheme, kPictureScheme, kFileScheme, kSoundScheme, kOscScheme,
                       kMidiScheme);
  return fail(ErrorCode::kBadInput, "{}: unknown scheme \"{}\"; expected one of {}, as in sacn:1-9",
              text.empty() ? "\"\"" : text, endpoint.scheme, known);
}

}  // namespace footlight
