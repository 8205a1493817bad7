#include "tools/footlight/preview/dropped_file.h"

#include <filesystem>
#include <system_error>

#include "fixtures/files/definition_list.h"
#include "fixtures/files/import/import_rig.h"
#include "sim/dmx_log/log_input.h"

namespace footlight::tools {

Result<DroppedKind> kind_of_dropped(const std::string& path) {
  std::error_code trouble;
  if (!std::filesystem::exists(path, trouble)) return fail(ErrorCode::kNotFound, "{}: there is no such file", path);
  const std::string format = fixtures::rig_format(path);
  if (format == "gdtf" || format == "qxf" || format == "ofl" || format == "photometry") return DroppedKind::kDefinition;
  if (format == "mvr" || format == "qxw" || format == "vrsl") return DroppedKind::kRig;
  if (format == "toml" && path.ends_with(".toml")) {
    return fixtures::open_definition(path) ? DroppedKind::kDefinition : DroppedKind::kRig;
  }
  if (detect_log_format(path)) return DroppedKind::kLog;
  return fail(ErrorCode::kUnsupported,
              "{}: is no definition (GDTF, QXF, Open Fixture Library), no rig (MVR, TOML, QXW) and no log (.dmxlog)",
              path);
}

DroppedFiles sort_dropped(const std::vector<std::string>& paths) {
  DroppedFiles dropped;
  const auto replace = [&](std::string& with, const std::string& path) {
    if (!with.empty()) {
      dropped.refused.push_back(
          fail(ErrorCode::kBadInput, "{}: is not opened, since {} was dropped with it", with, path).value());
    }
    with = path;
  };
  for (const std::string& path : paths) {
    auto kind = kind_of_dropped(path);
    if (!kind) {
      dropped.refused.push_back(std::move(kind).error());
    } else if (*kind == DroppedKind::kDefinition) {
      dropped.definitions.push_back(path);
    } else {
      replace(*kind == DroppedKind::kRig ? dropped.rig : dropped.log, path);
    }
  }
  return dropped;
}

}  // namespace footlight::tools
