// Wireshark's dissectors as an independent check of our packets.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace footlight::testing {

// Writes one datagram to UDP `port` into a capture, runs tshark on it and returns the values of the given fields
// (joined by commas if a field occurs several times). nullopt if tshark is not installed, reported on stderr.
[[nodiscard]] std::optional<std::map<std::string, std::string>> dissect(std::span<const std::uint8_t> datagram,
                                                                        std::uint16_t port,
                                                                        const std::vector<std::string>& fields);

}  // namespace footlight::testing
