// Options of a frame that `render` and `preview` share. kBadInput names the option and what is expected.
#pragma once

#include <cstdint>
#include <string>

#include "sim/core/result.h"

namespace footlight::tools {

// FrameSettings::edge_samples of "off", "4", "8" or "16".
[[nodiscard]] Result<std::uint32_t> parse_edges(const std::string& text);
// FrameSettings::shadows of "on" or "off".
[[nodiscard]] Result<bool> parse_shadows(const std::string& text);
// FrameSettings::glare of "off", "1%" or "0.01".
[[nodiscard]] Result<double> parse_glare(const std::string& text);

}  // namespace footlight::tools
