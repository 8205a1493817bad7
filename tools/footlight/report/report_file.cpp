// Files that a report writes.
#include "fixtures/files/export/write_file.h"
#include "tools/footlight/report/report_parts.h"

namespace footlight::tools {

Status unwritable(const std::string& path) {
  return fail(ErrorCode::kIo, "{}: cannot be written; check the folder and the space on its disk", path);
}

Status write_report_file(const std::string& path, const std::string& text) { return fixtures::write_file(path, text); }

std::string with_report_suffix(const std::string& path, const std::string& suffix) {
  const std::size_t dot = path.rfind('.');
  if (dot == std::string::npos || path.find('/', dot) != std::string::npos) return path + "-" + suffix;
  return path.substr(0, dot) + "-" + suffix + path.substr(dot);
}

}  // namespace footlight::tools
