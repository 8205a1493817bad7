// Files that a report writes.
#include <filesystem>
#include <fstream>
#include <system_error>

#include "sim/file_kind.h"
#include "tools/footlight/report/report_parts.h"

namespace footlight::tools {

Status unwritable(const std::string& path) {
  return fail(ErrorCode::kIo, "{}: cannot be written; choose a folder that exists and is yours", path);
}

Status write_report_file(const std::string& path, const std::string& text) {
  FL_TRY(refuse_pipe_output(path));
  const std::string part = path + ".part";
  std::ofstream stream(part, std::ios::binary | std::ios::trunc);
  stream << text;
  stream.close();
  std::error_code trouble;
  if (stream) std::filesystem::rename(part, path, trouble);
  if (stream && !trouble) return {};
  std::error_code ignored;
  std::filesystem::remove(part, ignored);
  return unwritable(path);
}

std::string with_report_suffix(const std::string& path, const std::string& suffix) {
  const std::size_t dot = path.rfind('.');
  if (dot == std::string::npos || path.find('/', dot) != std::string::npos) return path + "-" + suffix;
  return path.substr(0, dot) + "-" + suffix + path.substr(dot);
}

}  // namespace footlight::tools
