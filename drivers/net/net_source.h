// Common part of the sACN and Art-Net sources: shared sockets, batched reading, groups joined on interfaces as they
// appear and disappear. A protocol derives from it and decodes the datagrams.
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "drivers/net/net.h"
#include "drivers/net/sequence.h"
#include "drivers/net/udp.h"
#include "drivers/net/unicast_exchange.h"
#include "drivers/net/universe_index.h"
#include "sim/core/ports.h"

namespace footlight::drivers {

// Linux allows one socket this many groups by default (net.ipv4.igmp_max_memberships).
inline constexpr std::size_t kGroupsPerSocketMax = 20;

class NetSource : public Source {
 public:
  ~NetSource() override;
  NetSource(const NetSource&) = delete;
  NetSource& operator=(const NetSource&) = delete;
  [[nodiscard]] std::string name() const override { return settings_.name; }
  [[nodiscard]] int poll_fd() const override { return epoll_.get(); }
  [[nodiscard]] PortState state() const override;
  [[nodiscard]] std::string trouble() const override;
  [[nodiscard]] PortCounters counters() const override { return counters_; }
  [[nodiscard]] std::span<const Universe> universes() const override { return show_universes_; }
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override;
  [[nodiscard]] std::optional<PortNotice> take_notice() override { return std::exchange(sharing_, std::nullopt); }

  // Open sockets, one for each kGroupsPerSocketMax groups. For tests.
  [[nodiscard]] std::size_t socket_count() const { return sockets_.size(); }

 protected:
  // addresses: local ones to bind to, then no group is joined; or one multicast group, to receive nothing else. None:
  // any. interface_names: to join groups on; none: all that are up and support multicast.
  struct Settings : NetSourceOptions {
    explicit Settings(const NetSourceOptions& options) : NetSourceOptions(options) {}
    DurationNs silence_max_ns = kSenderTimeoutNs;  // kWorking until nothing was received for this long
    std::vector<std::uint32_t> groups;             // to join; empty: none
  };
  explicit NetSource(Settings settings);

  // Opens the sockets and joins the groups. Call once, before anything else.
  Status open();

  // Takes one datagram of at most kDatagramBytesMax octets. `stamp_ns`: when it arrived.
  virtual void take(const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& receiver) = 0;

  // Place in settings.universes of a wire universe; -1: not carried.
  [[nodiscard]] int place_of(int wire_universe) const { return wire_index_.find(wire_universe); }
  [[nodiscard]] Universe show_universe(int place) const { return show_universes_[static_cast<std::size_t>(place)]; }
  void deliver(const FrameView& frame, FrameReceiver& receiver);
  void count_rejected() { ++counters_.rejected; }
  void count_error() { ++counters_.errors; }
  void count_dropped() { ++counters_.dropped; }
  // Socket for answers to a datagram.
  [[nodiscard]] const Fd& first_socket() const { return sockets_.front().fd; }
  [[nodiscard]] const Settings& settings() const { return settings_; }
  // True if settings().interface_names lists this interface, or is empty.
  [[nodiscard]] bool receives_on(int interface_index) const {
    return settings_.interface_names.empty() || only_interfaces_.contains(interface_index);
  }
  // Joins one more group on every interface with groups; does nothing if it is joined already.
  Status add_group(std::uint32_t group);
  void drop_group(std::uint32_t group);
  // Makes poll_fd() readable with this descriptor too, until it is closed.
  Status watch(int fd);

 private:
  // Only the first socket is read (with addresses: one for each). While it has room for all groups, it receives only
  // those. Otherwise further sockets, which are not read, hold the other groups, and the first receives every group
  // that this machine has joined. The reason: the kernel checks a datagram against the groups of every socket of its
  // port, so hundreds of reading sockets would cost more than the reading.
  struct Socket {
    Fd fd;
    std::size_t groups = 0;
    std::uint32_t kernel_drops = 0;
  };
  struct Membership {
    int interface_index = 0;
    std::uint32_t group = 0;
    std::size_t socket = 0;
  };

  Status add_socket(std::uint32_t bind_ipv4);
  // Decides whether to leave unicast to other programs, and prepares the notice about it.
  void find_sharing(std::span<const std::uint32_t> bind_ipv4s);
  Status open_inbox();
  void read_inbox(FrameReceiver& receiver);
  // False: it is addressed to another address, or came over IPv6.
  [[nodiscard]] bool is_for_us(const Datagram& datagram) const;
  // Joins the groups on interfaces that have none yet. A failure is recorded in join_trouble_ and does not affect other
  // interfaces.
  void join_missing();
  Status find_named_interfaces();
  Status join(std::uint32_t group, int interface_index);
  template <class Condition>
  void leave(Condition condition);
  void forget(int interface_index);
  void read_socket(std::size_t index, TimeNs now_ns, FrameReceiver& receiver);

  Settings settings_;
  std::vector<Universe> show_universes_;
  UniverseIndex wire_index_;
  std::set<int> only_interfaces_;  // those of settings_.interface_names that exist
  Fd epoll_;
  std::vector<Socket> sockets_;
  std::size_t first_with_room_ = 0;  // the sockets before it are full
  std::vector<Membership> memberships_;
  std::set<int> joined_interfaces_;
  InterfaceWatch watch_;
  DatagramReader reader_;
  UnicastExchange::Inbox inbox_;  // in the exchange of settings_.own_senders, if there is one
  std::optional<PortNotice> sharing_;
  PortCounters counters_;
  std::string join_trouble_;           // why groups could not be joined on an interface; empty: all were
  std::optional<Error> join_refused_;  // the system's error for it; nullopt if it was not tried
  TimeNs received_ns_ = -kTimeNever;   // newest frame
  TimeNs polled_ns_ = 0;
};

// Checks the common options of every port; kBadInput names the number. `wire_max`: 63'999 or 32'768.
[[nodiscard]] Status check_universes(const std::string& name, const std::vector<WireUniverse>& universes, int wire_max);
[[nodiscard]] std::vector<int> wire_numbers(const std::vector<WireUniverse>& universes);
[[nodiscard]] std::vector<Universe> show_numbers(const std::vector<WireUniverse>& universes);

}  // namespace footlight::drivers
