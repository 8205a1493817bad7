// A private network for a test: a new network namespace with only "lo", which is up, supports multicast (unless
// disabled) and carries 239.255.0.0/16. Nothing that a test sends leaves it, and tests that run in parallel do not
// receive each other's packets.
#pragma once

#include <string>
#include <vector>

namespace footlight::testing {

// Moves the calling thread there. False if the system does not allow it (reported on stderr); the test then returns at
// once.
[[nodiscard]] bool enter_private_network(bool loopback_multicast = true);

// Adds, or removes, an Ethernet-like interface without a network (a veth whose other end is unused), up, with this IPv4
// address and a /24 around it. Only after enter_private_network(). False if the kernel lacks it.
[[nodiscard]] bool add_interface(const char* name, const char* ipv4);
void remove_interface(const char* name);
// Makes an interface send one datagram a second and keep the others, so that the buffers of sockets fill; or sends
// those that it keeps. False if the kernel lacks the means.
[[nodiscard]] bool choke_interface(const char* name);
void free_interface(const char* name);

// A second machine: a network namespace at the other end of a cable. Ours is interface `name` with `ipv4`/24, the other
// is `name`p with all of `peer_ipv4s` and the same broadcast address. Only after enter_private_network(); one at a
// time. False if the kernel lacks it.
[[nodiscard]] bool add_peer(const char* name, const char* ipv4, const std::vector<std::string>& peer_ipv4s);

// While it exists the calling thread is on the second machine. A socket stays on the machine where it was made.
class OnPeer {
 public:
  OnPeer();
  ~OnPeer();
  OnPeer(const OnPeer&) = delete;
  OnPeer& operator=(const OnPeer&) = delete;
};

}  // namespace footlight::testing
