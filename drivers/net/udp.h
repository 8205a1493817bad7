// Opens sockets, with errors that a user can act on, and sends and receives datagrams in batches. The only part of
// drivers/net that opens sockets. IPv4 addresses are numbers in host byte order here.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/fd.h"
#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::drivers {

inline constexpr std::size_t kDatagramBytesMax = 1280;  // above the largest sACN (1144) and Art-Net packet that is read

[[nodiscard]] Result<std::uint32_t> parse_ipv4(std::string_view port_name, const std::string& text);
// Errors: for the first text that is not an address.
[[nodiscard]] Result<std::vector<std::uint32_t>> parse_ipv4_list(std::string_view port_name,
                                                                 const std::vector<std::string>& texts);
[[nodiscard]] std::string text_of_ipv4(std::uint32_t ipv4);
[[nodiscard]] constexpr bool is_multicast(std::uint32_t ipv4) { return ipv4 >> 28 == 0xE; }

// One IPv4 address of one network interface. Interfaces without an IPv4 address do not appear.
struct Interface {
  std::string name;
  int index = 0;
  std::uint32_t ipv4 = 0;
  std::uint32_t broadcast = 0;  // 0: none
  bool up = false;
  bool multicast = false;
  bool loopback = false;
  std::array<std::uint8_t, 6> mac = {};
};
[[nodiscard]] std::vector<Interface> list_interfaces();
// kNotFound lists the existing interfaces. Interfaces without an IPv4 address are found too (ipv4 = 0).
[[nodiscard]] Result<Interface> find_interface(std::string_view port_name, const std::string& interface_name);

// A message of the form "sacn:1-9: cannot send to 239.255.0.1: no route; run '...'" for an errno.
[[nodiscard]] Error net_error(std::string_view port_name, std::string_view action, int error_number);

struct ReceiverSocket {
  std::string_view port_name;
  std::uint32_t bind_ipv4 = 0;  // 0: any
  std::uint16_t udp_port = 0;
  bool kernel_stamps = true;
  bool packet_info = false;    // fill Datagram::to_ipv4, local_ipv4 and interface_index
  int buffer_bytes = 4 << 20;  // requested; the system may allow less
};
// Non-blocking, shares its port with every other program that shares it. Receives only the groups that it joins itself.
// Linux gives a unicast datagram to one socket of a port only. Of several of our sockets it is the first of their
// group: the oldest at first; when the first one closes, the kernel moves the newest into its place.
[[nodiscard]] Result<Fd> open_receiver(const ReceiverSocket& wanted);
// As above, on any address (bind_ipv4 is not used), but receives no unicast datagram that an IPv4 socket of this
// machine takes; see open_yielding_sender(). Of several yielding sockets, receivers and senders alike, the first of
// their group gets it; see open_receiver().
[[nodiscard]] Result<Fd> open_yielding_receiver(const ReceiverSocket& wanted);
// Makes a receiver receive every group that any program on this machine has joined, on any interface. Returns errno, or
// 0.
[[nodiscard]] int receive_all_groups(const Fd& receiver);
// Receives nothing itself: its memberships make the machine receive the groups, for a receiver of all groups.
[[nodiscard]] Result<Fd> open_member(std::string_view port_name);

struct SenderSocket {
  std::string_view port_name;
  int interface_index = 0;  // through which multicast leaves; 0: the routing table decides
  int multicast_ttl = 1;    // 1 to 255
};
// Non-blocking, bound to a port that the system selects; other sockets of this machine receive its packets too.
[[nodiscard]] Result<Fd> open_sender(const SenderSocket& wanted);
// As open_sender(), bound to `udp_port` beside the port's other sockets, for protocols whose answers come to a fixed
// port. It receives broadcasts, and unicast only if no other socket of this machine takes it, so that other programs
// lose nothing. For that it is an IPv6 socket used for IPv4, since Linux prefers IPv4 sockets (compute_score() in
// net/ipv4/udp.c). Without IPv6, in the kernel or in the sandbox, it gets the port only if it is free, and an IPv4
// socket bound later gets the unicast; otherwise it fails with kIo. Packet information as for ReceiverSocket.
// `op_code_filter`: the kernel drops all datagrams except those with one of these 16-bit numbers, low octet first, at
// octet 8; empty: none are dropped.
[[nodiscard]] Result<Fd> open_yielding_sender(const SenderSocket& wanted, std::uint16_t udp_port,
                                              std::span<const std::uint16_t> op_code_filter);
// As above, for a sender without answers: it receives nothing, so other programs lose nothing. Fails with kIo if
// another program holds the port without sharing it.
[[nodiscard]] Result<Fd> open_send_only(const SenderSocket& wanted, std::uint16_t udp_port);
// Sends the multicast of an open sender through this interface. Returns errno, or 0.
[[nodiscard]] int leave_through(const Fd& socket, int interface_index);
[[nodiscard]] std::uint16_t local_udp_port(const Fd& socket);

// Queries the routing table without sending anything. 0: there is a route; otherwise errno.
[[nodiscard]] int route_error(std::uint32_t ipv4, int interface_index);

// Returns errno, or 0. When an interface is removed, the kernel drops its groups but the socket does not: leave them
// too.
[[nodiscard]] int join_group(const Fd& socket, std::uint32_t group, int interface_index);
void leave_group(const Fd& socket, std::uint32_t group, int interface_index);

struct Datagram {
  std::span<const std::uint8_t> bytes;  // valid until the next read()
  std::uint32_t from_ipv4 = 0;
  std::uint16_t from_udp_port = 0;
  std::uint32_t to_ipv4 = 0;     // its destination: a group, a broadcast address or ours; 0 without packet_info
  std::uint32_t local_ipv4 = 0;  // ours, for an answer; 0 without packet_info
  int interface_index = 0;       // where it arrived; 0 without packet_info
  DurationNs age_ns = 0;         // how long it has waited in the kernel; 0 if unknown
  bool truncated = false;        // it was longer than kDatagramBytesMax
};

// Reads batches with recvmmsg.
class DatagramReader {
 public:
  static constexpr std::size_t kBatch = 64;

  DatagramReader();
  ~DatagramReader();
  // Returns the number of datagrams read, 0 if none waits, -errno if the system refused.
  int read(int fd);
  [[nodiscard]] const Datagram& operator[](std::size_t i) const { return datagrams_[i]; }
  // Datagrams that the kernel has dropped from this socket's full buffer since it was opened, as of the last read().
  // Modulo 2^32.
  [[nodiscard]] std::uint32_t kernel_drops() const { return kernel_drops_; }

 private:
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
  std::array<Datagram, kBatch> datagrams_ = {};
  std::uint32_t kernel_drops_ = 0;
};

// Sends batches with sendmmsg.
class DatagramWriter {
 public:
  DatagramWriter();
  ~DatagramWriter();
  // `bytes` must stay valid until flush().
  void add(std::span<const std::uint8_t> bytes, std::uint32_t ipv4, std::uint16_t udp_port);
  struct Sent {
    std::size_t count = 0;  // how many were sent, from the first on
    int error_number = 0;   // why the next one was not; 0: all were sent
  };
  // Empties the batch, sent or not. Stops at the first datagram that the system refuses.
  Sent flush(int fd);
  // As flush(), but continues after a refused datagram, since the next may have another receiver. Writes the error of
  // each datagram, 0 if it was sent. Datagrams that were not tried get the last error: all after a full buffer, and all
  // after 64 refusals in a row.
  void flush_each(int fd, std::vector<int>& error_numbers);

 private:
  struct Batch;
  void prepare();
  std::unique_ptr<Batch> batch_;
};

// Watches the machine's interfaces and addresses for changes (rtnetlink).
class InterfaceWatch {
 public:
  // Without rtnetlink (a sandbox) there is no descriptor and read() always returns false.
  InterfaceWatch();
  [[nodiscard]] int fd() const { return socket_.get(); }
  // True if anything may have changed since the last call. Interfaces that lost an address or were removed are appended
  // to `lost`: the kernel drops the groups joined there.
  bool read(std::vector<int>& lost);

 private:
  Fd socket_;
};

}  // namespace footlight::drivers
