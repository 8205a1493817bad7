// Sockets: opening them with errors that people can act on, and moving datagrams in batches. The one place of
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

inline constexpr std::size_t kDatagramBytesMax = 1280;  // above the largest sACN (1144) and Art-Net packet that we read

[[nodiscard]] Result<std::uint32_t> parse_ipv4(std::string_view port_name, const std::string& text);
// Errors: of the first text that is no address.
[[nodiscard]] Result<std::vector<std::uint32_t>> parse_ipv4_list(std::string_view port_name,
                                                                 const std::vector<std::string>& texts);
[[nodiscard]] std::string text_of_ipv4(std::uint32_t ipv4);
[[nodiscard]] constexpr bool is_multicast(std::uint32_t ipv4) { return ipv4 >> 28 == 0xE; }

// One IPv4 address of one network interface. Interfaces without an IPv4 address do not appear.
struct Interface {
  std::string name;
  int index = 0;
  std::uint32_t ipv4 = 0;
  std::uint32_t broadcast = 0;  // 0: has none
  bool up = false;
  bool multicast = false;
  bool loopback = false;
  std::array<std::uint8_t, 6> mac = {};
};
[[nodiscard]] std::vector<Interface> list_interfaces();
// kNotFound lists what there is. Interfaces without an IPv4 address are found too (ipv4 = 0).
[[nodiscard]] Result<Interface> find_interface(std::string_view port_name, const std::string& interface_name);

// A message of the form "sacn:1-9: cannot send to 239.255.0.1: no route; run '...'" for what the system said.
[[nodiscard]] Error net_error(std::string_view port_name, std::string_view action, int error_number);

struct ReceiverSocket {
  std::string_view port_name;
  std::uint32_t bind_ipv4 = 0;  // 0: any
  std::uint16_t udp_port = 0;
  bool kernel_stamps = true;
  bool packet_info = false;    // fill Datagram::to_ipv4, local_ipv4 and interface_index
  int buffer_bytes = 4 << 20;  // wanted; the system may allow less
};
// Non-blocking, shares its port with every other program that shares it. Hears only the groups that it joins itself.
// Linux gives a unicast datagram to one socket of a port only. Of several of ours it is the one in the first place of
// their group: the oldest at first; where the first one closes, the kernel moves the newest into its place.
[[nodiscard]] Result<Fd> open_receiver(const ReceiverSocket& wanted);
// The same on any address (bind_ipv4 is not used), but takes no unicast datagram that an IPv4 socket of this machine
// wants; see open_yielding_sender(). Of several yielding sockets, receivers and senders alike, the one in the first
// place of their group gets it; see open_receiver().
[[nodiscard]] Result<Fd> open_yielding_receiver(const ReceiverSocket& wanted);
// Has a receiver hear every group that anybody on this machine has joined, on any interface. errno, or 0.
[[nodiscard]] int hear_all_groups(const Fd& receiver);
// Receives nothing itself: its memberships have the machine take the groups, for such a receiver.
[[nodiscard]] Result<Fd> open_member(std::string_view port_name);

struct SenderSocket {
  std::string_view port_name;
  int interface_index = 0;  // that multicast leaves through; 0: the routing table decides
  int multicast_ttl = 1;    // 1 to 255
};
// Non-blocking, bound to a port that the system picks, heard by other sockets of this machine too.
[[nodiscard]] Result<Fd> open_sender(const SenderSocket& wanted);
// The same, bound to `udp_port` beside whatever listens there, for protocols whose answers come to a fixed port. It
// hears broadcasts, and unicast only where no other socket of this machine wants it, so that it takes nothing away: it
// is an IPv6 socket that speaks IPv4, and Linux prefers IPv4 sockets (compute_score() in net/ipv4/udp.c). Without IPv6,
// in the kernel or in the sandbox, it gets the port only where nobody has it yet, and an IPv4 socket bound later gets
// the unicast; otherwise it fails with kIo. Packet information as there; `op_code_filter` has the kernel drop all
// datagrams but those with one of these 16-bit numbers, low octet first, at octet 8; empty: all.
[[nodiscard]] Result<Fd> open_yielding_sender(const SenderSocket& wanted, std::uint16_t udp_port,
                                              std::span<const std::uint16_t> op_code_filter);
// The same for a sender that takes no answers: receives nothing, so it takes nothing away from anybody. Fails with kIo
// where another program holds the port without sharing it.
[[nodiscard]] Result<Fd> open_deaf_sender(const SenderSocket& wanted, std::uint16_t udp_port);
// Has the multicast of an open sender leave through this interface. errno, or 0.
[[nodiscard]] int leave_through(const Fd& socket, int interface_index);
[[nodiscard]] std::uint16_t local_udp_port(const Fd& socket);

// Asks the routing table without sending anything. 0: there is a way; otherwise errno.
[[nodiscard]] int route_error(std::uint32_t ipv4, int interface_index);

// errno, or 0. Groups of an interface that has gone are forgotten by the kernel, not by the socket: leave them too.
[[nodiscard]] int join_group(const Fd& socket, std::uint32_t group, int interface_index);
void leave_group(const Fd& socket, std::uint32_t group, int interface_index);

struct Datagram {
  std::span<const std::uint8_t> bytes;  // valid until the next read()
  std::uint32_t from_ipv4 = 0;
  std::uint16_t from_udp_port = 0;
  std::uint32_t to_ipv4 = 0;     // where it was sent: a group, a broadcast address or ours; 0 without packet_info
  std::uint32_t local_ipv4 = 0;  // ours, for an answer; 0 without packet_info
  int interface_index = 0;       // where it came in; 0 without packet_info
  DurationNs age_ns = 0;         // how long it has waited in the kernel; 0 where that is not known
  bool truncated = false;        // it was longer than kDatagramBytesMax
};

// Reads batches with recvmmsg.
class DatagramReader {
 public:
  static constexpr std::size_t kBatch = 64;

  DatagramReader();
  ~DatagramReader();
  // Datagrams read, 0 where none waits; -errno where the system refused.
  int read(int fd);
  [[nodiscard]] const Datagram& operator[](std::size_t i) const { return datagrams_[i]; }
  // Datagrams that the kernel has dropped from this socket's full buffer, counted since it was opened, as of the last
  // read(). Counts modulo 2^32.
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
  // `bytes` must stay until flush().
  void add(std::span<const std::uint8_t> bytes, std::uint32_t ipv4, std::uint16_t udp_port);
  struct Sent {
    std::size_t count = 0;  // the first so many of those added have gone
    int error_number = 0;   // why the next one has not; 0: all have gone
  };
  // Empties the batch, sent or not. Stops at the first datagram that the system refuses.
  Sent flush(int fd);
  // The same, and goes on after a datagram that the system refuses, since the next may have another receiver. Writes
  // why each has not gone, 0 where it has; those that were not tried have the error of the last that was: all behind a
  // full buffer, and behind 64 refusals in a row.
  void flush_each(int fd, std::vector<int>& error_numbers);

 private:
  struct Batch;
  void prepare();
  std::unique_ptr<Batch> batch_;
};

// Watches the machine's interfaces and addresses come and go (rtnetlink).
class InterfaceWatch {
 public:
  // Without rtnetlink (a sandbox) there is no descriptor and read() never says anything.
  InterfaceWatch();
  [[nodiscard]] int fd() const { return socket_.get(); }
  // True where anything may have changed since the last call. Interfaces that lost an address or went away are appended
  // to `lost`: the kernel forgets the groups joined there.
  bool read(std::vector<int>& lost);

 private:
  Fd socket_;
};

}  // namespace footlight::drivers
