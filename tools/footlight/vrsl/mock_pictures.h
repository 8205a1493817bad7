// A model of a video loopback device inside this process: what one port shows on it, others read.
//
// A device that no port shows anything on gives a moving pattern to its readers, so that an input can be tried alone.
// Names: "mock", and "mock/NAME" for more than one. Threads: any; each port is used by one.
#pragma once

#include <memory>
#include <string_view>

#include "drivers/vrsl/picture_port.h"

namespace footlight::tools {

[[nodiscard]] bool is_mock_target(std::string_view name);

// Options: none.
[[nodiscard]] Result<std::unique_ptr<drivers::PictureOutput>> open_mock_output(const drivers::PictureTarget& target);
[[nodiscard]] Result<std::unique_ptr<drivers::PictureInput>> open_mock_input(const drivers::PictureTarget& target);

// The level of the pattern: it rises by one with each picture.
[[nodiscard]] constexpr std::uint8_t mock_level(int universe, Address address, std::uint64_t picture) {
  return static_cast<std::uint8_t>(7U * static_cast<unsigned>(address) + 31U * static_cast<unsigned>(universe) +
                                   static_cast<unsigned>(picture));
}

}  // namespace footlight::tools
