#include "tools/footlight/bridge/bridge_sockets.h"

#include <vector>

#include "tools/footlight/paths.h"
#include "tools/footlight/status/http_server.h"

namespace footlight::tools {

Result<std::string> find_bridge(std::string_view command, std::string_view otherwise) {
  std::vector<std::string> found;
  for (const std::string& socket : sockets()) {
    if (http_request(socket, "GET", "/status")) found.push_back(socket);
  }
  if (found.size() == 1) return found.front();
  if (found.empty()) {
    return fail(ErrorCode::kNotFound, "no 'footlight run' is running on this machine; start one{}", otherwise);
  }
  std::string list;
  for (const std::string& socket : found) list += fmt::format("\n  footlight {} --socket {}", command, socket);
  return fail(ErrorCode::kBadInput, "{} bridges run on this machine; choose one:{}", found.size(), list);
}

}  // namespace footlight::tools
