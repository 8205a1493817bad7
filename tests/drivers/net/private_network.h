// A network of the test's own: a fresh network namespace with nothing in it but "lo", which is up, can do multicast
// (unless told not to) and carries 239.255.0.0/16. Nothing that a test sends can leave it, and tests that run side by
// side do not hear each other.
#pragma once

namespace footlight::testing {

// Moves the calling thread there. False where the system forbids it (it says so on stderr); the test then returns at
// once.
[[nodiscard]] bool enter_private_network(bool loopback_multicast = true);

// Adds an Ethernet-like interface that goes nowhere (a veth whose other end nobody uses), up, with this IPv4 address
// and a /24 around it; and takes it away. Only after enter_private_network(). False where the kernel lacks it.
[[nodiscard]] bool add_interface(const char* name, const char* ipv4);
void remove_interface(const char* name);

}  // namespace footlight::testing
