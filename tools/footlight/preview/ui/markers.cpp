#include "tools/footlight/preview/ui/markers.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fixtures/files/export/write_file.h"
#include "fixtures/files/import/archive.h"
#include "fixtures/files/toml/toml_reader.h"
#include "fixtures/files/toml/toml_text.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr std::size_t kMarkerBytesMax = 1u << 20;
constexpr double kMarkerSecondsMax = 1e7;  // 115 days: a double has their nanoseconds to within one

bool earlier(const Marker& one, const Marker& other) { return one.at_ns < other.at_ns; }

Status check_name(std::string_view name) {
  const bool controls =
      std::any_of(name.begin(), name.end(), [](char c) { return c >= 0 && (c < ' ' || c == '\x7f'); });
  if (!name.empty() && name.size() <= kMarkerNameMax && !controls) return {};
  return fail(ErrorCode::kBadInput, "a marker's name has 1 to {} bytes without control characters", kMarkerNameMax);
}

}  // namespace

Result<Markers> with_marker(const Markers& markers, TimeNs at_ns) {
  for (const Marker& one : markers) {
    if (std::abs(one.at_ns - at_ns) < kMarkerNearNs) {
      return fail(ErrorCode::kBadInput, "there is a marker here already: {}", one.name);
    }
  }
  if (at_ns < 0 || static_cast<double>(at_ns) > kMarkerSecondsMax * 1e9) {
    return fail(ErrorCode::kBadInput, "a marker is between 0 and {:.0f} s of the log", kMarkerSecondsMax);
  }
  if (markers.size() >= kMarkersMax) {
    return fail(ErrorCode::kBadInput, "a log has at most {} markers; delete some", kMarkersMax);
  }
  Marker added{at_ns, ""};
  const auto taken = [&](const Marker& one) { return one.name == added.name; };
  int number = 1;
  do {
    added.name = trf("Marker {}", number++);
  } while (std::any_of(markers.begin(), markers.end(), taken));
  Markers after = markers;
  after.insert(std::upper_bound(after.begin(), after.end(), added, earlier), added);
  return after;
}

Result<Markers> with_name(const Markers& markers, std::size_t index, std::string_view name) {
  FL_TRY(check_name(name));
  Markers after = markers;
  after.at(index).name = name;
  return after;
}

const Marker* marker_after(const Markers& markers, TimeNs now_ns) {
  const auto at = std::upper_bound(markers.begin(), markers.end(), Marker{now_ns, ""}, earlier);
  return at == markers.end() ? nullptr : &*at;
}

const Marker* marker_before(const Markers& markers, TimeNs now_ns) {
  const auto at = std::lower_bound(markers.begin(), markers.end(), Marker{now_ns, ""}, earlier);
  return at == markers.begin() ? nullptr : &*std::prev(at);
}

std::string markers_path(const std::string& log_path) { return log_path + ".markers.toml"; }

std::string markers_text(const Markers& markers) {
  std::string text = "# Named times of the log beside this file, of 'footlight preview'.\n";
  for (const Marker& one : markers) {
    text += fmt::format("\n[[marker]]\nat_s = {:.9f}\nname = {}\n", static_cast<double>(one.at_ns) * 1e-9,
                        fixtures::toml_text(one.name));
  }
  return text;
}

Result<Markers> parse_markers(std::string_view text, const std::string& path) {
  FL_ASSIGN(const fixtures::TomlNode root, fixtures::parse_toml(std::string(text), path));
  fixtures::TomlReader reader(root, path, "");
  Markers markers;
  for (const fixtures::TomlNode* node : reader.tables("marker")) {
    fixtures::TomlReader one(*node, path, "[[marker]]");
    Marker marker;
    marker.at_ns = std::llround(one.number("at_s", 0, kMarkerSecondsMax) * 1e9);
    marker.name = one.text("name");
    FL_TRY(one.finish());
    if (const Status named = check_name(marker.name); !named) {
      return fail(ErrorCode::kBadInput, "{}:{}: name: {}", path, one.place_of("name"), named.error().message);
    }
    markers.push_back(std::move(marker));
  }
  FL_TRY(reader.finish());
  if (markers.size() > kMarkersMax) {
    return fail(ErrorCode::kBadInput, "{}: {} markers; expected at most {}", path, markers.size(), kMarkersMax);
  }
  std::stable_sort(markers.begin(), markers.end(), earlier);
  return markers;
}

Result<Markers> load_markers(const std::string& path) {
  const auto bytes = fixtures::read_whole_file(path, kMarkerBytesMax);
  if (!bytes && bytes.error().code == ErrorCode::kNotFound) return Markers{};
  if (!bytes) return tl::unexpected<Error>(bytes.error());
  return parse_markers(fixtures::text_of(*bytes), path);
}

Status save_markers(const std::string& path, const Markers& markers) {
  return fixtures::write_file(path, markers_text(markers));
}

}  // namespace footlight::tools
