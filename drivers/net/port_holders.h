// Which other programs of this machine have a UDP port open. Linux gives a unicast datagram to one socket only, so a
// port that shares must know who gets it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace footlight::drivers {

struct PortHolder {
  bool is_ipv4 = false;     // false: an IPv6 socket, which gets IPv4 unicast only where no IPv4 socket wants it
  std::uint32_t ipv4 = 0;   // that an IPv4 socket is bound to; 0: any
  int pid = 0;              // 0: this user may not see it
  bool is_bridge = false;   // a 'footlight run'
  std::string description;  // for people: "footlight run (process 812)", or "a program of user 104"
};

// Sockets of this process, and those that get no unicast, are left out. IPv4 sockets first. Reads /proc, of all
// processes only where there is one.
[[nodiscard]] std::vector<PortHolder> other_holders(std::uint16_t udp_port);

}  // namespace footlight::drivers
