// Shares unicast between the inputs of one program on one UDP port. Linux gives a unicast datagram to one of their
// sockets. The input that reads it passes it on to the others. So each input gets every datagram, as with multicast and
// broadcast.
//
// Threads: that of the inputs, like all state shared by a program's network ports.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "drivers/net/udp.h"
#include "sim/core/clock.h"

namespace footlight::drivers {

class UnicastExchange {
 public:
  // One input reads at most 1,024 datagrams between two polls of another one, or twice that if it is polled first.
  static constexpr std::size_t kParcelsMax = 2'048;

  struct Parcel {
    Datagram datagram;  // without bytes
    std::array<std::uint8_t, kDatagramBytesMax> bytes;
    std::size_t size = 0;
    TimeNs stamp_ns = 0;
  };

  // The inbox of one input. It must not move while it is added.
  struct Inbox {
    std::uint16_t udp_port = 0;
    std::vector<std::uint32_t> ipv4s;  // takes unicast to these addresses; empty: to any
    Fd event;                          // a non-blocking eventfd; readable while parcels wait
    bool shared = false;               // another input has the same port
    std::vector<Parcel> parcels;       // a ring buffer; empty until it is shared for the first time
    std::size_t first = 0;
    std::size_t count = 0;
    std::uint64_t dropped = 0;  // the ring was full
  };

  void add(Inbox& inbox);
  void remove(Inbox& inbox);
  // Passes a datagram that `from` has read to all others of its port that take it.
  void pass_on(const Inbox& from, const Datagram& datagram, TimeNs stamp_ns);

 private:
  void find_shared();
  std::vector<Inbox*> inboxes_;
};

// True if it was sent to an address of this machine: neither multicast nor broadcast. Needs packet information.
[[nodiscard]] inline bool is_unicast(const Datagram& datagram) {
  return datagram.to_ipv4 != 0 && datagram.to_ipv4 == datagram.local_ipv4;
}

}  // namespace footlight::drivers
