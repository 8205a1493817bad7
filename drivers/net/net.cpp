#include "drivers/net/net.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <fstream>

#include <unistd.h>

#include "drivers/net/hash.h"

namespace footlight::drivers {
namespace {

// "1-3,7" to 1, 2, 3, 7.
Result<std::vector<int>> parse_list(std::string_view text, std::string_view whole) {
  std::vector<int> numbers;
  while (true) {
    const std::size_t comma = text.find(',');
    const std::string_view part = text.substr(0, comma);
    const char* const end = part.data() + part.size();
    int first = 0;
    auto [after_first, error] = std::from_chars(part.data(), end, first);
    int last = first;
    bool good = error == std::errc{};
    if (good && after_first != end) {
      good = *after_first == '-';
      if (good) {
        const auto [after_last, last_error] = std::from_chars(after_first + 1, end, last);
        good = last_error == std::errc{} && after_last == end;
      }
    }
    if (!good || !is_universe(first) || !is_universe(last) || last < first) {
      return fail(ErrorCode::kBadInput,
                  "universes \"{}\": expected numbers from 1 to {} as in \"1-9\" or \"1,3\" before and after one \"=\", "
                  "got \"{}\"", whole, kUniverseMax, part);
    }
    for (int number = first; number <= last; ++number) numbers.push_back(number);
    if (comma == std::string_view::npos) break;
    text.remove_prefix(comma + 1);
  }
  auto sorted = numbers;
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end()) {
    return fail(ErrorCode::kBadInput, "universes \"{}\": {} is named twice; name each universe once", whole, *twice);
  }
  return numbers;
}

std::string machine_text() {
  std::string text;
  std::ifstream file("/etc/machine-id");
  if (file && std::getline(file, text) && !text.empty()) return text;
  char host[256] = {};
  if (gethostname(host, sizeof host - 1) == 0) return host;
  return "unknown machine";
}

}  // namespace

Result<std::vector<WireUniverse>> parse_wire_universes(std::string_view text) {
  const std::size_t equals = text.find('=');
  FL_ASSIGN(const auto wire, parse_list(text.substr(0, equals), text));
  auto show = wire;
  if (equals != std::string_view::npos) {
    FL_ASSIGN(show, parse_list(text.substr(equals + 1), text));
  }
  if (show.size() != wire.size()) {
    return fail(ErrorCode::kBadInput, "universes \"{}\": {} on the wire and {} in the show; name equally many on both sides",
                text, wire.size(), show.size());
  }
  std::vector<WireUniverse> universes;
  for (std::size_t i = 0; i < wire.size(); ++i) universes.push_back({wire[i], show[i]});
  return universes;
}

bool OwnSenders::has_cid(const Cid& cid) const { return std::find(cids_.begin(), cids_.end(), cid) != cids_.end(); }

bool OwnSenders::has_udp_port(std::uint16_t port) const {
  return std::find(udp_ports_.begin(), udp_ports_.end(), port) != udp_ports_.end();
}

Cid sacn_cid(std::string_view machine, std::string_view source_name, std::string_view endpoint) {
  const std::uint64_t machine_digest = mix64(fnv1a64(machine));
  std::uint64_t halves[2];
  for (std::uint64_t i = 0; i < 2; ++i) {
    const std::uint64_t seed = mix64(machine_digest + i);
    halves[i] = mix64(fnv1a64(endpoint, mix64(fnv1a64(source_name, seed))));
  }
  Cid cid;
  for (std::size_t i = 0; i < cid.size(); ++i) cid[i] = static_cast<std::uint8_t>(halves[i / 8] >> (8 * (i % 8)));
  cid[6] = static_cast<std::uint8_t>((cid[6] & 0x0F) | 0x80);  // version 8: made by a rule of our own
  cid[8] = static_cast<std::uint8_t>((cid[8] & 0x3F) | 0x80);  // variant of RFC 9562
  return cid;
}

Cid sacn_cid_of(const SacnSinkOptions& options) {
  if (options.cid != Cid{}) return options.cid;
  return sacn_cid(machine_text(), options.source_name, options.name);
}

}  // namespace footlight::drivers
