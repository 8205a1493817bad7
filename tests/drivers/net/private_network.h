// A network of the test's own: a fresh network namespace with nothing in it but "lo", which is up, can do multicast
// (unless told not to) and carries 239.255.0.0/16. Nothing that a test sends can leave it, and tests that run side by
// side do not hear each other.
#pragma once

#include <string>
#include <vector>

namespace footlight::testing {

// Moves the calling thread there. False where the system forbids it (it says so on stderr); the test then returns at
// once.
[[nodiscard]] bool enter_private_network(bool loopback_multicast = true);

// Adds an Ethernet-like interface that goes nowhere (a veth whose other end nobody uses), up, with this IPv4 address
// and a /24 around it; and takes it away. Only after enter_private_network(). False where the kernel lacks it.
[[nodiscard]] bool add_interface(const char* name, const char* ipv4);
void remove_interface(const char* name);
// Has an interface take a datagram a second and keep the others, so that the buffers of sockets fill; and lets go of
// what it keeps. False where the kernel lacks the means.
[[nodiscard]] bool choke_interface(const char* name);
void free_interface(const char* name);

// A second machine: a network namespace at the other end of a cable. Ours is interface `name` with `ipv4`/24, its is
// `name`p with all of `peer_ipv4s` and the same broadcast address. Only after enter_private_network(); one at a time.
// False where the kernel lacks it.
[[nodiscard]] bool add_peer(const char* name, const char* ipv4, const std::vector<std::string>& peer_ipv4s);

// While it lives the calling thread is on the second machine. A socket stays on the machine that it was made on.
class OnPeer {
 public:
  OnPeer();
  ~OnPeer();
  OnPeer(const OnPeer&) = delete;
  OnPeer& operator=(const OnPeer&) = delete;
};

}  // namespace footlight::testing
