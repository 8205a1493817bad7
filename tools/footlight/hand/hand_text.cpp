#include "tools/footlight/hand/hand_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>
#include <utility>

namespace footlight::tools {
namespace {

constexpr std::string_view kVersionWord = "footlight-hand ";
constexpr std::string_view kPlaceExample =
    "expected UNIVERSE.ADDRESS as in 1.17, a range as in 1.1-12, 1.* for a universe, or 1.17+18 for 16 bits";

constexpr std::array<std::pair<HandAction, std::string_view>, 8> kActions = {{
    {HandAction::kSet, "set"},
    {HandAction::kRelease, "release"},
    {HandAction::kReleaseAll, "release-all"},
    {HandAction::kBlackout, "blackout"},
    {HandAction::kLift, "blackout-off"},
    {HandAction::kHold, "hold"},
    {HandAction::kRenew, "renew"},
    {HandAction::kTempo, "tempo"},
}};

// The whole text as a number.
template <class Number>
bool read_whole(std::string_view text, Number& number) {
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  return fault == std::errc() && end == text.data() + text.size();
}

// The slots of a place, in their order.
struct Place {
  Universe universe = 0;
  std::vector<std::uint16_t> slots;
  bool one_number = false;  // joined by "+"
  bool one_slot = false;    // a single address, to which a list of levels may add others
};

bool add_address(std::string_view text, Place& place) {
  int address = 0;
  if (!read_whole(text, address) || !is_address(address)) return false;
  const auto slot = static_cast<std::uint16_t>(slot_of_address(address));
  if (place.one_number && std::find(place.slots.begin(), place.slots.end(), slot) != place.slots.end()) return false;
  place.slots.push_back(slot);
  return true;
}

bool read_addresses(std::string_view text, Place& place) {
  if (text == "*") text = "1-512";
  const std::size_t dash = text.find('-');
  if (dash != std::string_view::npos) {
    Place ends;
    if (!add_address(text.substr(0, dash), ends) || !add_address(text.substr(dash + 1), ends)) return false;
    if (ends.slots[0] > ends.slots[1]) return false;
    for (std::uint16_t slot = ends.slots[0]; slot <= ends.slots[1]; ++slot) place.slots.push_back(slot);
    return true;
  }
  place.one_number = text.find('+') != std::string_view::npos;
  place.one_slot = !place.one_number;
  while (true) {
    const std::size_t plus = text.find('+');
    if (!add_address(text.substr(0, plus), place)) return false;
    if (plus == std::string_view::npos) return place.slots.size() <= kHandSlotsMax;
    text.remove_prefix(plus + 1);
  }
}

Result<Place> parse_place(std::string_view text) {
  Place place;
  const std::size_t dot = text.find('.');
  if (dot == std::string_view::npos || !read_whole(text.substr(0, dot), place.universe) ||
      !is_universe(place.universe) || !read_addresses(text.substr(dot + 1), place)) {
    return fail(ErrorCode::kBadInput, "{}: {}; universes are 1 to {}, addresses 1 to {}", text, kPlaceExample,
                kUniverseMax, kSlotCountMax);
  }
  return place;
}

HandLevel level_at(const Place& place, std::size_t first, std::size_t count, std::uint32_t value) {
  HandLevel level;
  level.universe = place.universe;
  level.count = static_cast<int>(count);
  for (std::size_t i = 0; i < count; ++i) level.slots[i] = place.slots[first + i];
  level.value = value;
  return level;
}

Result<std::uint32_t> value_of(std::string_view text, std::uint32_t value_max) {
  const auto number = parse_hand_number(text);
  if (number && number->percent) {
    return static_cast<std::uint32_t>(std::llround(number->number / 100 * value_max));
  }
  std::uint32_t value = 0;
  if (!read_whole(text, value) || value > value_max) {
    return fail(ErrorCode::kBadInput, "{}: expected a whole number from 0 to {}, or a percentage as in 50%", text,
                value_max);
  }
  return value;
}

std::string place_text(const HandLevel& level) {
  std::string text = fmt::format("{}.{}", level.universe, level.slots[0] + 1);
  for (int i = 1; i < level.count; ++i) text += fmt::format("+{}", level.slots[static_cast<std::size_t>(i)] + 1);
  return text;
}

// True if b is a single slot that follows a.
bool follows(const HandLevel& a, const HandLevel& b) {
  return a.universe == b.universe && a.count == 1 && b.count == 1 && a.slots[0] + 1 == b.slots[0];
}

Status parse_part(std::string_view line, HandCommand& command) {
  const auto after = [&line](std::string_view word) {
    if (!line.starts_with(word)) return false;
    line.remove_prefix(word.size());
    return true;
  };
  if (after("priority ")) {
    int priority = 0;
    if (!read_whole(line, priority) || priority < 1 || priority > kPriorityMax) {
      return fail(ErrorCode::kBadInput, "expected a priority from 1 to {}, got {}", kPriorityMax, line);
    }
    command.priority = static_cast<std::uint8_t>(priority);
    return {};
  }
  if (after("over ")) {
    if (!read_whole(line, command.over_ns) || command.over_ns < 0 || command.over_ns > kHandFadeMaxNs) {
      return fail(ErrorCode::kBadInput, "expected a time of at most 24 h in nanoseconds, got {}", line);
    }
    return {};
  }
  if (after("beats ")) {
    const bool read = read_whole(line, command.beats_a_minute) && std::isfinite(command.beats_a_minute);
    if (read && command.action == HandAction::kTempo) return {};
    return fail(ErrorCode::kBadInput, "expected a number of beats a minute, of the action tempo, got {}", line);
  }
  const std::size_t before = command.levels.size();
  const bool jumps = after("jump ");
  const bool valued = command.action != HandAction::kRelease;
  FL_TRY(valued ? parse_slot_assignment(line, command.levels) : parse_slots(line, command.levels));
  for (std::size_t i = before; jumps && i < command.levels.size(); ++i) command.levels[i].jumps = true;
  if (command.levels.size() > kHandLevelsMax) {
    return fail(ErrorCode::kBadInput, "more than {} levels in one command", kHandLevelsMax);
  }
  return {};
}

}  // namespace

bool names_slots(std::string_view text) {
  return !text.empty() && text.front() >= '0' && text.front() <= '9' && text.find(':') == std::string_view::npos;
}

std::string osc_name(std::string_view name) {
  constexpr std::string_view kReserved = " #*,/?[]{}";
  std::string text(name);
  for (char& c : text) {
    if (kReserved.find(c) != std::string_view::npos || static_cast<unsigned char>(c) < 0x20) c = '_';
  }
  return text;
}

Result<HandNumber> parse_hand_number(std::string_view text) {
  HandNumber number;
  number.percent = text.ends_with('%');
  const std::string_view digits = number.percent ? text.substr(0, text.size() - 1) : text;
  const bool read = read_whole(digits, number.number) && std::isfinite(number.number);
  if (!read || (number.percent && (number.number < 0 || number.number > 100))) {
    return fail(ErrorCode::kBadInput, "{}: expected a number, or a percentage from 0% to 100%", text);
  }
  return number;
}

Status parse_slots(std::string_view text, std::vector<HandLevel>& into) {
  FL_ASSIGN(const Place place, parse_place(text));
  for (std::size_t i = 0; i < place.slots.size(); ++i) into.push_back(level_at(place, i, 1, 0));
  return {};
}

Status parse_slot_assignment(std::string_view text, std::vector<HandLevel>& into) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) {
    return fail(ErrorCode::kBadInput, "{}: expected UNIVERSE.ADDRESS=LEVEL, for example 1.17=255 or 1.1-12=50%", text);
  }
  FL_ASSIGN(Place place, parse_place(text.substr(0, equals)));
  const std::size_t count = place.one_number ? place.slots.size() : 1;
  std::vector<std::uint32_t> values;
  std::string_view rest = text.substr(equals + 1);
  while (true) {
    const std::size_t comma = rest.find(',');
    const auto value = value_of(rest.substr(0, comma), hand_value_max(static_cast<int>(count)));
    if (!value) return fail(ErrorCode::kBadInput, "{}: {}", text, value.error().message);
    values.push_back(*value);
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
    if (values.size() > kSlotCountMax) break;
  }
  if (place.one_slot) {
    while (place.slots.size() < values.size())
      place.slots.push_back(static_cast<std::uint16_t>(place.slots.back() + 1));
    if (place.slots.back() >= kSlotCountMax) {
      return fail(ErrorCode::kBadInput, "{}: its levels end past address {}", text, kSlotCountMax);
    }
  }
  const std::size_t numbers = place.slots.size() / count;
  if (values.size() != 1 && values.size() != numbers) {
    return fail(ErrorCode::kBadInput, "{}: {} levels for {} {}; expected one, or one each", text, values.size(),
                numbers, place.one_number ? "number" : "addresses");
  }
  for (std::size_t i = 0; i < numbers; ++i) {
    into.push_back(level_at(place, i * count, count, values[values.size() == 1 ? 0 : i]));
  }
  return {};
}

std::string counted_slots(const std::vector<HandLevel>& levels) {
  std::set<std::pair<Universe, std::uint16_t>> slots;
  std::set<Universe> universes;
  for (const HandLevel& level : levels) {
    universes.insert(level.universe);
    for (int i = 0; i < level.count; ++i) slots.emplace(level.universe, level.slots[static_cast<std::size_t>(i)]);
  }
  const std::string count = fmt::format("{} {}", slots.size(), slots.size() == 1 ? "slot" : "slots");
  if (universes.size() == 1) return fmt::format("{} of universe {}", count, *universes.begin());
  return fmt::format("{} of {} universes", count, universes.size());
}

std::vector<std::string> assignments_of(const std::vector<HandLevel>& levels) {
  std::vector<std::string> texts;
  for (std::size_t at = 0; at < levels.size();) {
    const HandLevel& first = levels[at];
    std::size_t run = at + 1;
    while (run < levels.size() && follows(levels[run - 1], levels[run]) && levels[run].jumps == first.jumps) ++run;
    std::size_t equal = at + 1;
    while (equal < run && levels[equal].value == first.value) ++equal;
    std::string text = place_text(first);
    if (equal - at >= 2) {
      text += fmt::format("-{}={}", levels[equal - 1].slots[0] + 1, first.value);
      at = equal;
    } else {
      text += fmt::format("={}", first.value);
      // Up to where three equal levels begin, which are shorter as a range.
      for (++at; at < run; ++at) {
        const bool three =
            at + 2 < run && levels[at].value == levels[at + 1].value && levels[at].value == levels[at + 2].value;
        if (three) break;
        text += fmt::format(",{}", levels[at].value);
      }
    }
    texts.push_back(first.jumps ? "jump " + text : std::move(text));
  }
  return texts;
}

std::string hand_message(const HandCommand& command) {
  const auto action =
      std::find_if(kActions.begin(), kActions.end(), [&](const auto& each) { return each.first == command.action; });
  std::string text = fmt::format("{}{}\n{}\npriority {}\nover {}\n", kVersionWord, kHandVersion, action->second,
                                 command.priority, command.over_ns);
  if (command.action == HandAction::kTempo && command.beats_a_minute != 0) {
    text += fmt::format("beats {}\n", command.beats_a_minute);
  }
  if (command.action != HandAction::kRelease) {
    for (const std::string& line : assignments_of(command.levels)) text += line + "\n";
    return text;
  }
  std::vector<HandLevel> places = command.levels;
  for (HandLevel& place : places) place.value = 0;  // equal levels become ranges
  for (HandLevel& place : places) place.jumps = false;
  for (const std::string& line : assignments_of(places)) text += line.substr(0, line.find('=')) + "\n";
  return text;
}

std::vector<HandCommand> hand_parts(HandCommand command) {
  constexpr std::size_t kPartLevels = kHandMessageBytesMax / 48;  // more bytes than the line of a level has
  std::vector<HandCommand> parts;
  const std::vector<HandLevel> levels = std::exchange(command.levels, {});
  for (std::size_t at = 0; at < levels.size() || parts.empty(); at += kPartLevels) {
    parts.push_back(command);
    const auto first = levels.begin() + static_cast<std::ptrdiff_t>(at);
    const auto count = static_cast<std::ptrdiff_t>(std::min(kPartLevels, levels.size() - at));
    parts.back().levels.assign(first, first + count);
  }
  return parts;
}

Result<HandCommand> parse_hand_message(std::string_view text) {
  HandCommand command;
  for (int number = 1; number <= 2 || !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (number == 1) {
      int version = 0;
      if (!line.starts_with(kVersionWord) || !read_whole(line.substr(kVersionWord.size()), version)) {
        return fail(ErrorCode::kBadInput, "line 1: expected '{}{}'", kVersionWord, kHandVersion);
      }
      if (version != kHandVersion) {
        return fail(ErrorCode::kUnsupported,
                    "the command has version {}, this bridge reads {}; use one version of both", version, kHandVersion);
      }
    } else if (number == 2) {
      const auto action =
          std::find_if(kActions.begin(), kActions.end(), [&](const auto& each) { return each.second == line; });
      if (action == kActions.end()) return fail(ErrorCode::kBadInput, "line 2: expected set, release, blackout ...");
      command.action = action->first;
    } else if (const Status part = parse_part(line, command); !part) {
      return fail(ErrorCode::kBadInput, "line {}: {}", number, part.error().message);
    }
  }
  return command;
}

}  // namespace footlight::tools
