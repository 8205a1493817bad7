// Which processes there are and which files they have open, as /proc gives it (proc(5)).
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>
#include <vector>

namespace footlight::drivers {

// The process ids below a /proc, ascending.
[[nodiscard]] inline std::vector<std::string> processes(const std::filesystem::path& proc_root) {
  std::vector<std::string> list;
  std::error_code error;
  for (std::filesystem::directory_iterator at(proc_root, error), end; !error && at != end; at.increment(error)) {
    std::string name = at->path().filename().string();
    if (!name.empty() && name.find_first_not_of("0123456789") == std::string::npos) list.push_back(std::move(name));
  }
  std::sort(list.begin(), list.end(), [](const std::string& a, const std::string& b) {
    return a.size() != b.size() ? a.size() < b.size() : a < b;
  });
  return list;
}

// What a process ("self" or its id) has open: "/dev/ttyUSB0", "socket:[4711]". Empty for one of another user.
[[nodiscard]] inline std::vector<std::string> open_files(const std::filesystem::path& proc_root,
                                                         const std::string& process) {
  std::vector<std::string> targets;
  std::error_code error;
  for (std::filesystem::directory_iterator at(proc_root / process / "fd", error), end; !error && at != end;
       at.increment(error)) {
    std::error_code closed;
    const std::filesystem::path target = std::filesystem::read_symlink(at->path(), closed);
    if (!closed) targets.push_back(target.string());
  }
  return targets;
}

// The name that a process has in ps(1).
[[nodiscard]] inline std::string process_name(const std::filesystem::path& proc_root, const std::string& process) {
  std::string name;
  std::getline(std::ifstream(proc_root / process / "comm"), name);
  return name;
}

}  // namespace footlight::drivers
