// Named times of a log, and the file beside it that keeps them: show.dmxlog.markers.toml.
//
//   [[marker]]
//   at_s = 83.2
//   name = "Chorus"
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::tools {

inline constexpr std::size_t kMarkersMax = 1000;
inline constexpr std::size_t kMarkerNameMax = 60;              // bytes
inline constexpr DurationNs kMarkerNearNs = 100 * kNsPerMs;    // markers are at least so far apart
inline constexpr DurationNs kMarkerPassedNs = 500 * kNsPerMs;  // back from a playing log: beyond the one just passed

struct Marker {
  TimeNs at_ns = 0;
  std::string name;
  bool operator==(const Marker&) const = default;
};
using Markers = std::vector<Marker>;  // ascending

// With one more, named "Marker N" by the first number that is free. kBadInput: there is one within kMarkerNearNs, or
// there are kMarkersMax.
[[nodiscard]] Result<Markers> with_marker(const Markers& markers, TimeNs at_ns);
// kBadInput: the name is empty, longer than kMarkerNameMax or has control characters.
[[nodiscard]] Result<Markers> with_name(const Markers& markers, std::size_t index, std::string_view name);

// The next one after, or before, a time; nullptr: there is none.
[[nodiscard]] const Marker* marker_after(const Markers& markers, TimeNs now_ns);
[[nodiscard]] const Marker* marker_before(const Markers& markers, TimeNs now_ns);

[[nodiscard]] std::string markers_path(const std::string& log_path);
[[nodiscard]] std::string markers_text(const Markers& markers);
// Times are sorted; `path` is for messages. Errors: kBadInput.
[[nodiscard]] Result<Markers> parse_markers(std::string_view text, const std::string& path);
// None if there is no file. Errors: those of parse_markers(); kPermission, kIo.
[[nodiscard]] Result<Markers> load_markers(const std::string& path);
// Replaces the file in one step. Without a marker an existing file is left empty of them.
[[nodiscard]] Status save_markers(const std::string& path, const Markers& markers);

}  // namespace footlight::tools
