// MVR-xchange over TCP: the sockets of MvrAnswering and MvrAsking (mvr_xchange_station.h). IPv4 only.
//
// Nothing here blocks or starts a thread. Add the descriptors to those that poll() waits for, then call step() with the
// time: it does what can be done, and costs a system call a connection if that is nothing. Call it at least every
// second, for the timeouts.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <poll.h>

#include "drivers/fd.h"
#include "drivers/net/mvr_xchange_station.h"
#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::drivers {

inline constexpr std::size_t kMvrConnectionsMax = 32;     // accepted; the one that is silent longest makes room
inline constexpr DurationNs kMvrConnectNs = 5 * kNsPerS;  // to a station that does not answer
// For a whole message, or an answer that is no file: bytes that drip do not prolong it. For each kMvrSlowestBytes of a
// file, and the rest of it.
inline constexpr DurationNs kMvrSilenceNs = 15 * kNsPerS;
inline constexpr std::uint64_t kMvrSlowestBytes = 64u << 10;
inline constexpr DurationNs kMvrFileNs = 1'800 * kNsPerS;  // from its first byte to its last

// IPv4 in host byte order.
struct MvrAddress {
  std::uint32_t ipv4 = 0;
  std::uint16_t port = 0;
  bool operator==(const MvrAddress&) const = default;
};
[[nodiscard]] std::string text_of(const MvrAddress& address);  // "10.0.0.7:42424"
// "10.0.0.7:42424" or "console.local:42424". Asks the system's resolver for a name, which may block for seconds.
// Errors: kBadInput (the form), kNotFound (no such name).
[[nodiscard]] Result<MvrAddress> find_mvr_address(std::string_view text);

// The connections that others open.
class MvrServer {
 public:
  // `listen`: address 0 for all of this machine, port 0 for one that the system selects. `station` must live as long.
  // Errors: kIo (the port is taken), kNotFound (an address of another machine), kPermission.
  [[nodiscard]] static Result<std::unique_ptr<MvrServer>> open(const MvrAddress& listen, MvrStation& station);
  [[nodiscard]] std::uint16_t port() const { return port_; }

  void add_descriptors(std::vector<pollfd>& waiting) const;
  void step(TimeNs now_ns);
  [[nodiscard]] std::size_t connection_count() const { return connections_.size(); }
  // Connections that were closed since the last call for what they sent, or for what they did not: one line each.
  [[nodiscard]] std::vector<std::string> take_faults();

 private:
  struct Connection {
    Fd socket;
    MvrAddress peer;
    MvrAnswering answering;
    TimeNs moved_ns = 0;  // when a message began or ended, or bytes went, the last time
  };
  MvrServer(Fd listener, std::uint16_t port, MvrStation& station);
  void accept_all(TimeNs now_ns);
  // False: close it.
  bool step(Connection& connection, TimeNs now_ns);
  void add_fault(const Connection& connection, std::string_view text);

  MvrStation& station_;
  const Fd listener_;
  const std::uint16_t port_;
  TimeNs accept_ns_ = 0;  // not before, after the system refused a connection
  bool accept_rests_ = false;
  std::list<Connection> connections_;
  std::vector<std::string> faults_;
};

// One message to another station, and its answer.
class MvrClient {
 public:
  // `name`: of the station, at the beginning of messages. `sink`: as for MvrAsking.
  [[nodiscard]] static Result<std::unique_ptr<MvrClient>> open(std::string name, const MvrAddress& to,
                                                               const MvrMessage& request, TimeNs now_ns,
                                                               MvrFileSink* sink = nullptr);
  void add_descriptors(std::vector<pollfd>& waiting) const;
  // True: done, and the connection is closed. Errors: kDisconnected, kTimeout, kProtocol, of the sink; then the
  // connection is closed too.
  [[nodiscard]] Result<bool> step(TimeNs now_ns);
  [[nodiscard]] const MvrAsking& asking() const { return asking_; }
  [[nodiscard]] const MvrAddress& to() const { return to_; }
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  MvrClient(std::string name, const MvrAddress& to, Fd socket, const MvrMessage& request, TimeNs now_ns,
            MvrFileSink* sink);
  [[nodiscard]] Result<bool> move_bytes(TimeNs now_ns);
  [[nodiscard]] tl::unexpected<Error> failed(const Error& error);

  const std::string name_;
  const MvrAddress to_;
  Fd socket_;
  MvrAsking asking_;
  bool connected_ = false;
  TimeNs moved_ns_;  // when the connection was opened, the file began, or kMvrSlowestBytes of it came the last time
  std::uint64_t moved_bytes_ = 0;  // of the file, then
  TimeNs file_ns_ = 0;             // when the file began
};

}  // namespace footlight::drivers
