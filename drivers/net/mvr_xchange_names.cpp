#include "drivers/net/mvr_xchange_names.h"

#include <algorithm>

#include "drivers/net/bytes.h"

namespace footlight::drivers {
namespace {

constexpr std::size_t kLabelBytesMax = 63;
constexpr std::size_t kNameBytesMax = 255;
constexpr std::size_t kServiceLabels = 3;  // _mvrxchange, _tcp, local

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

DnsLabels with_service(DnsLabels labels) {
  labels.insert(labels.end(), {std::string(kMvrService), "_tcp", "local"});
  return labels;
}

void add_text(std::vector<std::uint8_t>& bytes, std::string_view key, std::string_view value) {
  const std::string_view cut = cut_utf8(value, 254 - key.size());
  bytes.push_back(static_cast<std::uint8_t>(key.size() + 1 + cut.size()));
  bytes.insert(bytes.end(), key.begin(), key.end());
  bytes.push_back('=');
  bytes.insert(bytes.end(), cut.begin(), cut.end());
}

}  // namespace

bool same_ascii(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return lower(x) == lower(y); });
}

std::optional<DnsLabels> parse_dns_name(std::span<const std::uint8_t> bytes) {
  if (bytes.size() > kNameBytesMax) return std::nullopt;
  DnsLabels labels;
  while (!bytes.empty()) {
    const std::size_t size = bytes[0];
    if (size == 0) return bytes.size() == 1 ? std::optional(labels) : std::nullopt;
    if (size > kLabelBytesMax || size >= bytes.size()) return std::nullopt;
    const auto label = bytes.subspan(1, size);
    labels.emplace_back(label.begin(), label.end());
    bytes = bytes.subspan(1 + size);
  }
  return std::nullopt;  // no end
}

std::vector<std::uint8_t> build_dns_name(const DnsLabels& labels) {
  std::vector<std::uint8_t> bytes;
  for (const std::string& label : labels) {
    if (label.empty() || label.size() > kLabelBytesMax) continue;
    bytes.push_back(static_cast<std::uint8_t>(label.size()));
    bytes.insert(bytes.end(), label.begin(), label.end());
  }
  bytes.push_back(0);
  return bytes;
}

bool same_dns_name(const DnsLabels& a, const DnsLabels& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same_ascii);
}

std::optional<DnsService> parse_dns_srv(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kHead = 6;  // priority, weight, port
  if (bytes.size() < kHead) return std::nullopt;
  const auto host = parse_dns_name(bytes.subspan(kHead));
  if (!host || host->empty()) return std::nullopt;
  return DnsService{read_u16_be(bytes, 4), *host};
}

std::vector<std::uint8_t> build_dns_srv(const DnsService& service) {
  std::vector<std::uint8_t> bytes(6);
  write_u16_be(bytes, 4, service.port);
  const auto host = build_dns_name(service.host);
  bytes.insert(bytes.end(), host.begin(), host.end());
  return bytes;
}

MvrText parse_mvr_text(std::span<const std::uint8_t> bytes) {
  MvrText text;
  while (!bytes.empty()) {
    const std::size_t size = bytes[0];
    if (size >= bytes.size()) break;
    const std::string entry(bytes.begin() + 1, bytes.begin() + 1 + static_cast<std::ptrdiff_t>(size));
    bytes = bytes.subspan(1 + size);
    const std::size_t equals = entry.find('=');
    if (equals == std::string::npos) continue;
    const std::string_view key = std::string_view(entry).substr(0, equals);
    // The first one counts (RFC 6763 section 6.4).
    if (same_ascii(key, "StationName") && text.station_name.empty()) text.station_name = entry.substr(equals + 1);
    if (same_ascii(key, "StationUUID") && text.station_uuid.empty()) text.station_uuid = entry.substr(equals + 1);
  }
  return text;
}

std::vector<std::uint8_t> build_mvr_text(const MvrText& text) {
  std::vector<std::uint8_t> bytes;
  add_text(bytes, "StationName", text.station_name);
  add_text(bytes, "StationUUID", text.station_uuid);
  return bytes;
}

std::optional<MvrInstance> mvr_instance_of(const DnsLabels& name) {
  if (name.size() <= kServiceLabels) return std::nullopt;
  const std::size_t own = name.size() - kServiceLabels;
  if (!same_dns_name({name.begin() + static_cast<std::ptrdiff_t>(own), name.end()}, with_service({}))) {
    return std::nullopt;
  }
  MvrInstance instance;
  instance.group = name[own - 1];
  for (std::size_t i = 0; i + 1 < own; ++i) instance.station += (i == 0 ? "" : ".") + name[i];
  return instance;
}

DnsLabels mvr_group_name(std::string_view group) {
  return with_service(group.empty() ? DnsLabels() : DnsLabels{dns_label(group)});
}

DnsLabels mvr_instance_name(const MvrInstance& instance) {
  return with_service({dns_label(instance.station), dns_label(instance.group)});
}

std::string dns_label(std::string_view name) {
  std::string label(cut_utf8(name, kLabelBytesMax));
  std::replace(label.begin(), label.end(), '.', '-');
  return label.empty() ? "-" : label;
}

}  // namespace footlight::drivers
