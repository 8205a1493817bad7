// Finds other programs of this machine that have a UDP port open. Linux gives a unicast datagram to one socket only, so
// a port that shares must know which program gets it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace footlight::drivers {

struct PortHolder {
  bool is_ipv4 = false;     // false: an IPv6 socket, which gets IPv4 unicast only if no IPv4 socket takes it
  std::uint32_t ipv4 = 0;   // the address that an IPv4 socket is bound to; 0: any
  int pid = 0;              // 0: not visible to this user
  bool is_bridge = false;   // a 'footlight run'
  std::string description;  // "footlight run (process 812)", or "a program of user 104"
};

// Leaves out sockets of this process and sockets that get no unicast. IPv4 sockets first. Reads /proc; it reads all
// processes only if there is another holder.
[[nodiscard]] std::vector<PortHolder> other_holders(std::uint16_t udp_port);

}  // namespace footlight::drivers
