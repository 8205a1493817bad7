// Ports on the network: sACN (ANSI E1.31-2018) and Art-Net 4, in and out.
//
// A port is made from options and then belongs to the pump's thread; nothing here starts a thread or blocks. Time is
// passed to poll() and send(). The only clock read is the one of the kernel's stamps, to compute how long a datagram
// has waited.
//
// Universe numbers on the wire (WireUniverse::wire) count from 1 in both protocols. Art-Net itself counts port
// addresses from 0. So wire universe 1 is Art-Net port address 0 (net 0, sub-net 0, universe 0), and wire universe 17
// is net 0, sub-net 1, universe 0.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/core/endpoint.h"
#include "sim/core/ports.h"

namespace footlight::drivers {

inline constexpr std::uint16_t kSacnPort = 5568;    // E1.31-2018 section 9.3.2
inline constexpr std::uint16_t kArtnetPort = 6454;  // 0x1936
// Enough for the routers of one site; 239.255.0.0/16 does not leave it (RFC 2365).
inline constexpr int kMulticastTtlDefault = 20;
inline constexpr int kArtnetUniverseMax = 32'768;  // 15 bits of port address, counted from 1

// Component identifier: identifies one sender on the network permanently (E1.31-2018 section 5.6).
using Cid = std::array<std::uint8_t, 16>;

class ArtnetProgram;
class RdmDirectory;
class UnicastExchange;

// The senders of this program. Pass the same object to all network ports of a program, so that no source receives what
// a sink of the same program sent. (Multicast and broadcast return to the sending machine, which is how several
// programs on one machine exchange frames.) Safe from any thread, since ports are opened while the pump runs. An entry
// stays after its sink has closed, since its last datagrams may still be under way.
class OwnSenders {
 public:
  OwnSenders();
  ~OwnSenders();
  void add_cid(const Cid& cid);
  [[nodiscard]] bool has_cid(const Cid& cid) const;
  // State shared by Art-Net ports (drivers/net/artnet_nodes.h).
  [[nodiscard]] ArtnetProgram& artnet() { return *artnet_; }
  // Inputs of this program that share a UDP port (drivers/net/unicast_exchange.h).
  [[nodiscard]] UnicastExchange& unicast() { return *unicast_; }

 private:
  mutable std::mutex mutex_;
  std::vector<Cid> cids_;  // guarded by mutex_
  const std::unique_ptr<ArtnetProgram> artnet_;
  const std::unique_ptr<UnicastExchange> unicast_;
};

// Options of every network port. `name` and `universes` are required.
struct NetOptions {
  explicit NetOptions(std::uint16_t udp_port) : port(udp_port) {}

  std::string name;                          // the endpoint as the user wrote it; starts every error message
  std::vector<WireUniverse> universes;       // no number twice on either side
  std::vector<std::string> addresses;        // IPv4; the meaning depends on the kind of port, see below
  std::vector<std::string> interface_names;  // "eth0"; the meaning depends on the kind of port, see below
  std::uint16_t port;                        // UDP, of the receivers
  std::shared_ptr<OwnSenders> own_senders;   // null: frames of this program's sinks are received like any other
};
// If several programs of this machine have a UDP port open, unicast to it reaches one of them (docs/decisions/0092). A
// source that finds the port open in another program leaves unicast to that program, and receives multicast and
// broadcast as usual. Its first notice names the program. An Art-Net sink with addresses receives no unicast; one that
// searches for devices does.
struct NetSourceOptions : NetOptions {
  using NetOptions::NetOptions;
  // Leaves unicast to every other program with a source, also to those that open the port later: for listeners beside a
  // show, such as a monitor. A sink that searches for devices gets no unicast if this source was there first.
  bool yields = false;
  // Called while the source opens, which takes seconds with tens of thousands of groups; returning true ends it with
  // kTimeout.
  std::function<bool()> stopping;
  bool kernel_stamps = true;  // stamp frames with their arrival time in the kernel, else with the time of poll()
};
struct NetSinkOptions : NetOptions {
  using NetOptions::NetOptions;
  double rate_hz_max = 0.0;  // the result of Sink::rate_hz_max(); 0: no cap
};

// universes: 1 to 63'999 on both sides.
// addresses: local; receive only unicast to these, join no group. None: any.
// interface_names: join groups on these only. None: on all that support multicast.
struct SacnSourceOptions : NetSourceOptions {
  SacnSourceOptions() : NetSourceOptions(kSacnPort) {}
  bool hear_preview = false;  // deliver frames flagged as preview, meant for visualisers and not for the stage
};

// addresses: unicast to each of these. None: multicast.
// interface_names: send multicast through each of these. None: the routing table decides.
struct SacnSinkOptions : NetSinkOptions {
  SacnSinkOptions() : NetSinkOptions(kSacnPort) {}
  int multicast_ttl = kMulticastTtlDefault;  // 1 to 255: number of networks that multicast crosses, plus one
  std::string source_name = "Footlight";     // UTF-8; at most 63 bytes are sent, cut at a whole character
  std::uint8_t priority = kPriorityDefault;  // 0 to 200
  bool preview = false;                      // flag every frame as preview
  // Start code 0xDD: the priority of each address, instead of `priority`; the k-th is for address k + 1. 0, and
  // addresses past the end: not claimed by this sink. Empty: not sent. At most 512, 0 to 200 each.
  std::vector<std::uint8_t> address_priorities;
  // Receivers that support it hold frames until the synchronisation packet that follows every batch. Those that receive
  // none for 2.5 s continue without (Force_Synchronization). 0: not synchronised.
  int sync_universe = 0;
  bool announce = true;  // announce its universes every 10 s (multicast only)
  Cid cid = {};          // all zero: sacn_cid_of(options)
};

// universes: 1 to 32'768 on the wire, where 1 is port address 0.
// addresses: local; receive only datagrams sent to these. None: any, broadcast included.
// interface_names: receive only what arrives there. None: anywhere.
struct ArtnetSourceOptions : NetSourceOptions {
  ArtnetSourceOptions() : NetSourceOptions(kArtnetPort) {}
  std::uint8_t priority = kPriorityDefault;  // Art-Net has none; the priority of its frames in the merge, 0 to 200
  bool answer_polls = true;                  // answer ArtPoll with ArtPollReply, so that consoles list this program
  bool request_names = true;                 // request the name of a new sender once, for Source::sender_text()
  std::string node_name = "Footlight";       // in ArtPollReply; at most 17 and 63 bytes are sent as short and long name
  // If not null: acts as an RDM gateway to the lines in it, under the universes of the show.
  std::shared_ptr<RdmDirectory> rdm_directory;
};

// The destination of a universe that no device subscribes to, when devices are searched for.
enum class ArtnetUnsubscribed : std::uint8_t {
  kBroadcast,  // to all: reaches devices that do not answer polls
  kSilent,     // nowhere, as Art-Net 4 specifies
};

// universes: as for a source.
// addresses: unicast or directed broadcast; all universes go to each of these, without a search. None: devices are
// searched for by ArtPoll, and each universe goes by unicast to those that take it.
// interface_names: search, and send broadcasts, on these only. None: search on every interface that is up, is not
// loopback and has a broadcast address; broadcast levels on the first of them.
// port: also used for our socket if available.
struct ArtnetSinkOptions : NetSinkOptions {
  ArtnetSinkOptions() : NetSinkOptions(kArtnetPort) {}
  ArtnetUnsubscribed unsubscribed = ArtnetUnsubscribed::kBroadcast;
  bool sync = false;                    // an ArtSync after each batch of frames: devices show all its universes at once
  std::string node_name = "Footlight";  // shown in other controllers' lists
};

// Errors: kBadInput (universes, address, priority), kNotFound (interface), kPermission, kIo (port taken, no route).
// Each message starts with options.name and ends with the next step.
[[nodiscard]] Result<std::unique_ptr<Source>> make_sacn_source(const SacnSourceOptions& options);
[[nodiscard]] Result<std::unique_ptr<Sink>> make_sacn_sink(const SacnSinkOptions& options);
[[nodiscard]] Result<std::unique_ptr<Source>> make_artnet_source(const ArtnetSourceOptions& options);
[[nodiscard]] Result<std::unique_ptr<Sink>> make_artnet_sink(const ArtnetSinkOptions& options);

// Options from an endpoint; all other fields keep their defaults.
template <class Options>
Options options_of(const Endpoint& endpoint, const std::shared_ptr<OwnSenders>& own_senders) {
  Options options;
  options.name = endpoint.text;
  options.universes = endpoint.universes;
  options.addresses = endpoint.addresses;
  options.interface_names = endpoint.interface_names;
  if (endpoint.udp_port != 0) options.port = endpoint.udp_port;
  options.own_senders = own_senders;
  return options;
}

// As above, from an endpoint whose scheme is sacn or artnet (kBadInput for any other), with default options.
[[nodiscard]] Result<std::unique_ptr<Source>> make_net_source(const Endpoint& endpoint,
                                                              const std::shared_ptr<OwnSenders>& own_senders);
[[nodiscard]] Result<std::unique_ptr<Sink>> make_net_sink(const Endpoint& endpoint,
                                                          const std::shared_ptr<OwnSenders>& own_senders);

// The default CID of a sink: the same after every start on this machine; different on every other machine, for every
// other source name and for every other endpoint. A UUID of version 8 (RFC 9562) over a 64-bit digest of
// /etc/machine-id (the host name if there is none). That file counts as a secret, so it is not sent itself.
[[nodiscard]] Cid sacn_cid_of(const SacnSinkOptions& options);
[[nodiscard]] Cid sacn_cid(std::string_view machine, std::string_view source_name, std::string_view endpoint);

}  // namespace footlight::drivers
