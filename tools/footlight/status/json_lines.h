// The objects of --json, one a line. Keys stay the same in later versions; new ones may be added. Times end in _ns,
// rates in _hz. Bytes that are not UTF-8 are replaced.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "drivers/capture/captures.h"
#include "drivers/gpio/gpio_list.h"
#include "drivers/rdm/rdm_parameters.h"
#include "drivers/registry.h"
#include "fixtures/files/import/import.h"
#include "fixtures/files/import/import_rig.h"
#include "fixtures/model/color.h"
#include "fixtures/model/diagnostic.h"
#include "sim/dmx_log/dmx_log.h"
#include "sim/dmx_log/log_diff.h"
#include "sim/dmx_log/log_input.h"
#include "sim/pump.h"
#include "sim/universes.h"
#include "tools/footlight/bridge/event_log.h"
#include "tools/footlight/bridge/network_finding.h"
#include "tools/footlight/bridge/rdm_device.h"
#include "tools/footlight/doctor/doctor_checks.h"
#include "tools/footlight/hand/hand_desk.h"

namespace footlight::tools {

[[nodiscard]] std::string json_of_ready();  // "event": "ready": every port is open
// "event": "notice", with the "id" of the event (docs/events.md), "level", "time" and "text"; "port" and "universe" if
// it belongs to one.
[[nodiscard]] std::string json_of_notice(const Event& event);
// The same as a line of a log: "event" is the id.
[[nodiscard]] std::string json_of_event(const Event& event);
[[nodiscard]] std::string json_of_status(const PumpStatus& status);                          // "event": "status"
[[nodiscard]] std::string json_of_summary(const PumpStatus& status, DurationNs elapsed_ns);  // "event": "summary"
// "event": "levels": for each requested universe that exists, 512 levels as 1,024 hexadecimal digits, the stamp of the
// newest frame on the clock of "now_ns", and the number of writes ("revision", 0: none).
[[nodiscard]] std::string json_of_levels(const Universes& universes, std::span<const Universe> requested,
                                         TimeNs now_ns);
// "event": "reload": show files "taken" and "refused" so far, "running" while one is being read, and the "trouble" of
// the last one, empty if it was used.
[[nodiscard]] std::string json_of_reloads(std::uint64_t taken, std::uint64_t refused, bool running,
                                          const std::string& trouble);
// "blackout", "hold", "fades" (number), "rig" (a path), "held": "priority" and "levels" as assignments ("1.17=255").
[[nodiscard]] std::string json_of_hand(const HandReport& report, const std::string& rig);
// "kind": "usb", "serial", "hid", or "unknown" if nothing identifies it as a DMX device. "transport": "libusb", "tty",
// "hidraw": how it would be opened now. "driver": the scheme of its endpoint.
[[nodiscard]] std::string json_of_device(const drivers::FoundDevice& device);
// "kind": "gpio".
[[nodiscard]] std::string json_of_gpio_chip(const drivers::FoundGpioChip& chip);
[[nodiscard]] std::string json_of_check(const Check& check, const Outcome& outcome);  // of doctor
[[nodiscard]] std::string json_of_log(const LogInfo& info, const std::vector<std::string>& notes);
[[nodiscard]] std::string json_of_line_timing(const std::string& path, const drivers::LineCaptureInfo& info);
[[nodiscard]] std::string json_of_finding(const NetworkFinding& found);
[[nodiscard]] std::string json_of_rdm_device(const RdmDevice& device);
// "values": the single value, an array, or an object if the values have names.
[[nodiscard]] std::string json_of_rdm_fields(const std::string& uid, const std::string& parameter,
                                             const std::vector<drivers::RdmField>& fields);
[[nodiscard]] std::string json_of_log_diff(const std::string& a, const std::string& b, const LogDiff& diff);
[[nodiscard]] std::string json_of_conversion(const std::string& in, const std::string& out,
                                             const ConvertReport& report);

// The result of `footlight fixtures check` for one file.
struct FixtureCheck {
  std::string file;
  std::string format;  // empty: not supported
  fixtures::ImportStatus status = fixtures::ImportStatus::kRefused;
  std::string manufacturer, name;  // empty if refused
  std::size_t modes = 0;
  std::vector<fixtures::Diagnostic> diagnostics;
  std::string missing;  // why the path could not be read; empty: it could
};
// "file", "format", "status" (loaded, warnings, refused), "manufacturer", "name", "modes" (number), "diagnostics":
// "severity" (note, warning, error), "code", "file", "line" and "column" (0: unknown), "message", "assumed".
[[nodiscard]] std::string json_of_fixture_check(const FixtureCheck& check);

// Beam `index` of a type as it is drawn: by its angles, as a rectangle, or as measured with its energy check.
[[nodiscard]] std::string json_of_beam(const std::string& name, const fixtures::FixtureType& type, std::size_t index);
// A colour of a type, as drawn and as defined: "type", "what", "reference" and "drawn" (x, y, Y), "delta_e",
// "delta_e_mixing", "by_spectrum".
[[nodiscard]] std::string json_of_color(const std::string& type, const fixtures::ColorError& color);

// The result of `footlight rig check` for one file.
struct RigCheck {
  std::string file;
  std::string format;  // empty: not supported
  fixtures::ImportStatus status = fixtures::ImportStatus::kRefused;
  std::size_t fixtures = 0;
  std::vector<fixtures::Diagnostic> diagnostics;
  std::vector<fixtures::Assumption> assumptions;
};
// "file", "format", "status", "fixtures" (number), "diagnostics" as above, "assumptions": "code", "requested", "used",
// "why", "count".
[[nodiscard]] std::string json_of_rig_check(const RigCheck& check);

}  // namespace footlight::tools
