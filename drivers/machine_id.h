// A text that differs between machines and stays on each.
#pragma once

#include <unistd.h>

#include <fstream>
#include <string>

namespace footlight::drivers {

// /etc/machine-id; the host's name where there is none. It is as good as secret (machine-id(5)): send only its hash.
[[nodiscard]] inline std::string machine_id() {
  std::string text;
  std::ifstream file("/etc/machine-id");
  if (file && std::getline(file, text) && !text.empty()) return text;
  char host[256] = {};
  if (::gethostname(host, sizeof host - 1) == 0) return host;
  return "unknown machine";
}

}  // namespace footlight::drivers
