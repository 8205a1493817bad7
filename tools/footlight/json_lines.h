// The objects that --json prints, one a line. Keys stay as they are from version to version; new ones may be added.
// Times end in _ns, rates in _hz; bytes of a text that are not UTF-8 are replaced.
#pragma once

#include <string>
#include <string_view>

#include "drivers/registry.h"
#include "sim/dmx_log/dmx_log.h"
#include "sim/dmx_log/ola_show.h"
#include "sim/pump.h"

namespace footlight::tools {

[[nodiscard]] std::string json_of_ready();                           // "event": "ready": every port is open
[[nodiscard]] std::string json_of_notice(std::string_view line);     // "event": "notice"
[[nodiscard]] std::string json_of_status(const PumpStatus& status);  // "event": "status"
[[nodiscard]] std::string json_of_summary(const PumpStatus& status, DurationNs elapsed_ns);  // "event": "summary"
[[nodiscard]] std::string json_of_device(const drivers::FoundDevice& device);
[[nodiscard]] std::string json_of_log(const LogInfo& info);
[[nodiscard]] std::string json_of_conversion(const std::string& in, const std::string& out,
                                             const ConvertReport& report);

}  // namespace footlight::tools
