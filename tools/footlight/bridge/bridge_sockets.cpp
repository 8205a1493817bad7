#include "tools/footlight/bridge/bridge_sockets.h"

#include <vector>

#include "tools/footlight/paths.h"
#include "tools/footlight/status/http_server.h"

namespace footlight::tools {

Result<std::string> find_bridge(std::string_view command, std::string_view otherwise, bool with_windows) {
  std::vector<std::string> found;
  std::string silent;  // one that does not answer
  const auto look = [&](std::string_view kind) {
    for (const std::string& socket : sockets(kind)) {
      const auto answer = http_request(socket, "GET", "/status");
      if (answer) {
        found.push_back(socket);
      } else if (answer.error().code == ErrorCode::kTimeout) {
        silent = socket;
      }
    }
  };
  look("run");
  const bool windows = found.empty() && with_windows;
  if (windows) look("preview");
  if (found.size() == 1) return found.front();
  if (found.empty() && !silent.empty()) {
    return fail(
        ErrorCode::kTimeout,
        "{}: the program that has this socket does not answer; it may be stopped ('fg' or 'kill -CONT' goes on) "
        "or hang (end it before you start another one)",
        silent);
  }
  if (found.empty()) {
    return fail(ErrorCode::kNotFound, "no 'footlight run' is running on this machine{}; start one{}",
                with_windows ? ", and no 'footlight preview'" : "", otherwise);
  }
  std::string list;
  for (const std::string& socket : found) list += fmt::format("\n  footlight {} --socket {}", command, socket);
  return fail(ErrorCode::kBadInput, "{} {} run on this machine; choose one:{}", found.size(),
              windows ? "windows" : "bridges", list);
}

}  // namespace footlight::tools
