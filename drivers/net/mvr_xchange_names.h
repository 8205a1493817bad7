// Names and records of MVR-xchange in multicast DNS (RFC 1035, RFC 6763): pure functions on bytes.
//
// A station is found by PTR records of "_mvrxchange._tcp.local" and, for its group, of "GROUP._mvrxchange._tcp.local".
// Both name an instance. "STATION.GROUP._mvrxchange._tcp.local" is what consoles announce, and what this program does;
// some programs announce "GROUP._mvrxchange._tcp.local". Its SRV record holds host and port, its TXT record the
// station's name and UUID.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace footlight::drivers {

inline constexpr std::string_view kMvrService = "_mvrxchange";
inline constexpr std::string_view kMvrGroupDefault = "Default";  // of consoles, too

// Ignores the case of the letters A to Z.
[[nodiscard]] bool same_ascii(std::string_view a, std::string_view b);

// The labels of a name, as bytes: {"Desk", "Default", "_mvrxchange", "_tcp", "local"}.
using DnsLabels = std::vector<std::string>;

// A name without compression that fills `bytes`; nothing: damaged.
[[nodiscard]] std::optional<DnsLabels> parse_dns_name(std::span<const std::uint8_t> bytes);
// Labels that are empty or longer than 63 bytes are left out.
[[nodiscard]] std::vector<std::uint8_t> build_dns_name(const DnsLabels& labels);
[[nodiscard]] bool same_dns_name(const DnsLabels& a, const DnsLabels& b);  // ASCII case is ignored

struct DnsService {
  std::uint16_t port = 0;
  DnsLabels host;
};
[[nodiscard]] std::optional<DnsService> parse_dns_srv(std::span<const std::uint8_t> bytes);
[[nodiscard]] std::vector<std::uint8_t> build_dns_srv(const DnsService& service);

struct MvrText {
  std::string station_name;
  std::string station_uuid;
};
// Keys in any case. What is missing is empty; bytes after damage are ignored.
[[nodiscard]] MvrText parse_mvr_text(std::span<const std::uint8_t> bytes);
[[nodiscard]] std::vector<std::uint8_t> build_mvr_text(const MvrText& text);

struct MvrInstance {
  std::string station;  // empty: only a group is named
  std::string group;
};
// Nothing: no instance of this service.
[[nodiscard]] std::optional<MvrInstance> mvr_instance_of(const DnsLabels& name);
[[nodiscard]] DnsLabels mvr_group_name(std::string_view group);
[[nodiscard]] DnsLabels mvr_instance_name(const MvrInstance& instance);
// A name of people as a label: at most 63 bytes of UTF-8, without dots, which programs read as ends of labels.
[[nodiscard]] std::string dns_label(std::string_view name);

}  // namespace footlight::drivers
