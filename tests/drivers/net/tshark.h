// Wireshark's dissectors as an independent judge of our packets.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace footlight::testing {

// Packs one datagram to UDP `port` into a capture, has tshark take it apart and returns the named fields' values
// (joined by a comma where a field occurs several times). nullopt where tshark is not installed; it says so on stderr.
[[nodiscard]] std::optional<std::map<std::string, std::string>> dissect(std::span<const std::uint8_t> datagram,
                                                                        std::uint16_t port,
                                                                        const std::vector<std::string>& fields);

}  // namespace footlight::testing
