#include "drivers/net/port_holders.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include <arpa/inet.h>

#include <fmt/format.h>

#include "drivers/net/udp.h"
#include "drivers/open_files.h"

namespace footlight::drivers {
namespace {

namespace fs = std::filesystem;

struct OpenSocket {
  PortHolder holder;
  std::uint64_t inode = 0;
  unsigned uid = 0;
};

// Lines of /proc/net/udp: "sl local_address rem_address st queues tr uid-related..." (proc(5)). Addresses are
// hexadecimal, in the byte order of the machine.
void read_table(const char* path, bool is_ipv4, std::uint16_t udp_port, std::vector<OpenSocket>& sockets) {
  std::ifstream table(path);
  std::string line;
  std::getline(table, line);
  while (std::getline(table, line)) {
    std::istringstream words(line);
    std::string slot, local, remote, state, queues, timer, retries, timeout;
    OpenSocket found;
    words >> slot >> local >> remote >> state >> queues >> timer >> retries >> found.uid >> timeout >> found.inode;
    const std::size_t colon = local.find(':');
    if (!words || colon == std::string::npos) continue;
    if (std::strtoul(local.c_str() + colon + 1, nullptr, 16) != udp_port) continue;
    if (remote.find_first_not_of("0:") != std::string::npos) continue;  // connected: receives from one sender only
    found.holder.is_ipv4 = is_ipv4;
    if (is_ipv4) found.holder.ipv4 = ntohl(static_cast<std::uint32_t>(std::strtoul(local.c_str(), nullptr, 16)));
    if (is_multicast(found.holder.ipv4)) continue;  // bound to a group: gets no unicast
    sockets.push_back(std::move(found));
  }
}

std::set<std::uint64_t> inodes_of(const std::string& process) {
  std::set<std::uint64_t> inodes;
  for (const std::string& target : open_files("/proc", process)) {
    unsigned long long inode = 0;
    if (std::sscanf(target.c_str(), "socket:[%llu]", &inode) == 1) inodes.insert(inode);
  }
  return inodes;
}

// Describes the holder: its name, and its subcommand if it is a footlight.
void describe(PortHolder& holder) {
  const fs::path process = fs::path("/proc") / std::to_string(holder.pid);
  const std::string name = process_name("/proc", std::to_string(holder.pid));
  std::string printable;
  for (const char c : name) printable += std::isprint(static_cast<unsigned char>(c)) != 0 ? c : '?';
  if (name == "footlight") {
    std::ifstream arguments(process / "cmdline");
    std::string program, command;
    std::getline(arguments, program, '\0');
    std::getline(arguments, command, '\0');
    holder.is_bridge = command == "run";
    const bool is_word = !command.empty() && std::all_of(command.begin(), command.end(),
                                                         [](unsigned char c) { return std::islower(c) != 0; });
    if (is_word) printable += " " + command;
  }
  holder.description = fmt::format("{} (process {})", printable.empty() ? "a program" : printable, holder.pid);
}

}  // namespace

std::vector<PortHolder> other_holders(std::uint16_t udp_port) {
  std::vector<OpenSocket> sockets;
  read_table("/proc/thread-self/net/udp", true, udp_port, sockets);
  read_table("/proc/thread-self/net/udp6", false, udp_port, sockets);
  if (!sockets.empty()) {
    const auto own = inodes_of("self");
    std::erase_if(sockets, [&](const OpenSocket& one) { return own.contains(one.inode); });
  }
  std::vector<PortHolder> holders;
  if (sockets.empty()) return holders;
  for (const std::string& process : processes("/proc")) {
    const auto inodes = inodes_of(process);
    for (OpenSocket& one : sockets) {
      if (!inodes.contains(one.inode)) continue;
      one.holder.pid = std::atoi(process.c_str());
      describe(one.holder);
    }
  }
  for (OpenSocket& one : sockets) {
    if (one.holder.pid == 0) {
      one.holder.description =
          fmt::format("a program of user {} (find it with 'sudo ss -ulpn sport = :{}')", one.uid, udp_port);
    }
    holders.push_back(std::move(one.holder));
  }
  return holders;
}

}  // namespace footlight::drivers
