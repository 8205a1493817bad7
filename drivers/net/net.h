// Ports on the network: sACN (ANSI E1.31-2018) and Art-Net 4, in and out.
//
// A port is made from options and then belongs to the pump's thread; nothing in here starts a thread or blocks. Time
// comes in with poll() and send(); the only clock asked is the one that the kernel stamps datagrams with, and only for
// how long a datagram had to wait.
//
// Universe numbers on the wire (WireUniverse::wire) count from 1 in both protocols. Art-Net itself counts port
// addresses from 0, so wire universe 1 is Art-Net port address 0 (net 0, sub-net 0, universe 0), and wire universe 17
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
// Far enough for the routers of one site; 239.255.0.0/16 does not leave it (RFC 2365).
inline constexpr int kMulticastTtlDefault = 20;
inline constexpr int kArtnetUniverseMax = 32'768;  // 15 bits of port address, counted from 1

// Component identifier: names one sender on the network for good (E1.31-2018 section 5.6).
using Cid = std::array<std::uint8_t, 16>;

class ArtnetProgram;
class RdmDirectory;
class UnicastExchange;

// The senders of this program. Give one to all network ports of a program and no source takes for input what a sink of
// the same program sent (multicast and broadcast come back to the machine that sent them, which is how several programs
// on one machine hear each other). Safe from any thread, since ports are opened while the pump runs. An entry stays
// after its sink has closed, since last datagrams may still be on their way.
class OwnSenders {
 public:
  OwnSenders();
  ~OwnSenders();
  void add_cid(const Cid& cid);
  [[nodiscard]] bool has_cid(const Cid& cid) const;
  // What Art-Net ports have to know of each other (drivers/net/artnet_nodes.h).
  [[nodiscard]] ArtnetProgram& artnet() { return *artnet_; }
  // Inputs of this program that share a UDP port (drivers/net/unicast_exchange.h).
  [[nodiscard]] UnicastExchange& unicast() { return *unicast_; }

 private:
  mutable std::mutex mutex_;
  std::vector<Cid> cids_;  // guarded by mutex_
  const std::unique_ptr<ArtnetProgram> artnet_;
  const std::unique_ptr<UnicastExchange> unicast_;
};

// What every port of a network is made from. `name` and `universes` are required.
struct NetOptions {
  explicit NetOptions(std::uint16_t udp_port) : port(udp_port) {}

  std::string name;                          // the endpoint as the user wrote it; starts every error message
  std::vector<WireUniverse> universes;       // no number twice on either side
  std::vector<std::string> addresses;        // IPv4; each kind of port says what they are
  std::vector<std::string> interface_names;  // "eth0"; each kind of port says what they are
  std::uint16_t port;                        // UDP, of the receivers
  std::shared_ptr<OwnSenders> own_senders;   // null: echoes of this program's sinks are input like any other
};
// Unicast on a UDP port that several programs of this machine have open goes to one of them (docs/decisions/0092). A
// source that finds the port in another program leaves it unicast, and takes multicast and broadcast as usual. Its
// first notice names that program. An Art-Net sink with addresses takes no unicast; one that searches for devices does.
struct NetSourceOptions : NetOptions {
  using NetOptions::NetOptions;
  // Leaves unicast to every other program with a source, also to those that open the port later: for listeners beside a
  // show, such as a monitor. From a sink that searches for devices it takes unicast where it was there first.
  bool yields = false;
  // Asked while the source opens, which takes seconds with ten thousands of groups; true ends it with kTimeout.
  std::function<bool()> stopping;
  bool kernel_stamps = true;  // stamp frames with their time of arrival in the kernel, else with the time of poll()
};
struct NetSinkOptions : NetOptions {
  using NetOptions::NetOptions;
  double rate_hz_max = 0.0;  // what Sink::rate_hz_max() tells the pump; 0: as frames come
};

// universes: 1 to 63'999 on both sides.
// addresses: local; take only unicast to these, join no group. None: any.
// interface_names: join groups on these only. None: on all that can do multicast.
struct SacnSourceOptions : NetSourceOptions {
  SacnSourceOptions() : NetSourceOptions(kSacnPort) {}
  bool hear_preview = false;  // pass on frames flagged as preview, meant for visualisers and not for the stage
};

// addresses: unicast to each of these. None: multicast.
// interface_names: multicast leaves through each of these. None: the routing table decides.
struct SacnSinkOptions : NetSinkOptions {
  SacnSinkOptions() : NetSinkOptions(kSacnPort) {}
  int multicast_ttl = kMulticastTtlDefault;  // 1 to 255: networks that multicast crosses, plus one
  std::string source_name = "Footlight";     // UTF-8; at most 63 bytes go out, cut at a whole character
  std::uint8_t priority = kPriorityDefault;  // 0 to 200
  bool preview = false;                      // flag every frame as preview
  // Start code 0xDD: who wins, address by address, instead of `priority`; the k-th is for address k + 1. 0: this sink
  // has no say there, as for addresses past the end. Empty: not sent. At most 512, 0 to 200 each.
  std::vector<std::uint8_t> address_priorities;
  // Receivers that can hold what they get until the synchronisation packet that follows every batch; those that hear
  // none for 2.5 s go on without (Force_Synchronization). 0: not synchronised.
  int sync_universe = 0;
  bool announce = true;  // tell every 10 s which universes it sends (multicast only)
  Cid cid = {};          // all zero: sacn_cid_of(options)
};

// universes: 1 to 32'768 on the wire, where 1 is port address 0.
// addresses: local; take only datagrams sent to these. None: any, broadcast too.
// interface_names: take only what arrives there. None: anywhere.
struct ArtnetSourceOptions : NetSourceOptions {
  ArtnetSourceOptions() : NetSourceOptions(kArtnetPort) {}
  std::uint8_t priority = kPriorityDefault;  // Art-Net has none; what its frames carry into the merge, 0 to 200
  bool answer_polls = true;                  // answer ArtPoll with ArtPollReply, so that consoles list this program
  bool ask_names = true;                     // ask a new sender once for its name, for Source::sender_text()
  std::string node_name = "Footlight";       // in ArtPollReply; at most 17 and 63 bytes go out as short and long name
  // Where not null: a gateway for RDM to the lines that are in it, under the universes of the show.
  std::shared_ptr<RdmDirectory> rdm_directory;
};

// Where a universe goes that no device has asked for, when devices are searched for.
enum class ArtnetUnsubscribed : std::uint8_t {
  kBroadcast,  // to everybody: reaches devices that do not answer polls
  kSilent,     // nowhere, as Art-Net 4 has it
};

// universes: as of a source.
// addresses: unicast or directed broadcast; all universes go to each of these, and nobody is asked. None: devices are
// searched for by ArtPoll, and each universe goes by unicast to those that take it.
// interface_names: search, and send broadcasts, on these only. None: search on every interface that is up, is not
// loopback and has a broadcast address; broadcast levels on the first of them.
// port: also ours where it can be had.
struct ArtnetSinkOptions : NetSinkOptions {
  ArtnetSinkOptions() : NetSinkOptions(kArtnetPort) {}
  ArtnetUnsubscribed unsubscribed = ArtnetUnsubscribed::kBroadcast;
  bool sync = false;                    // an ArtSync after each batch of frames: devices show all its universes at once
  std::string node_name = "Footlight";  // what other controllers list
};

// Errors: kBadInput (universes, address, priority), kNotFound (interface), kPermission, kIo (port taken, no route).
// Each message begins with options.name and ends with the next step.
[[nodiscard]] Result<std::unique_ptr<Source>> make_sacn_source(const SacnSourceOptions& options);
[[nodiscard]] Result<std::unique_ptr<Sink>> make_sacn_sink(const SacnSinkOptions& options);
[[nodiscard]] Result<std::unique_ptr<Source>> make_artnet_source(const ArtnetSourceOptions& options);
[[nodiscard]] Result<std::unique_ptr<Sink>> make_artnet_sink(const ArtnetSinkOptions& options);

// What an endpoint says, as any of the options above; the rest stays at its default.
template <class Options>
Options options_of(const Endpoint& endpoint, std::shared_ptr<OwnSenders> own_senders) {
  Options options;
  options.name = endpoint.text;
  options.universes = endpoint.universes;
  options.addresses = endpoint.addresses;
  options.interface_names = endpoint.interface_names;
  if (endpoint.udp_port != 0) options.port = endpoint.udp_port;
  options.own_senders = std::move(own_senders);
  return options;
}

// The same from the words of an endpoint whose scheme is sacn or artnet (kBadInput for any other), with the defaults
// above for what an endpoint does not say.
[[nodiscard]] Result<std::unique_ptr<Source>> make_net_source(const Endpoint& endpoint,
                                                              std::shared_ptr<OwnSenders> own_senders);
[[nodiscard]] Result<std::unique_ptr<Sink>> make_net_sink(const Endpoint& endpoint,
                                                          std::shared_ptr<OwnSenders> own_senders);

// The CID that a sink takes by default: the same after every start on this machine, another one on every other machine,
// for every other source name and for every other endpoint. A UUID of version 8 (RFC 9562) over a 64-bit digest of
// /etc/machine-id (the host name where there is none), which is as good as secret and so is not sent itself.
[[nodiscard]] Cid sacn_cid_of(const SacnSinkOptions& options);
[[nodiscard]] Cid sacn_cid(std::string_view machine, std::string_view source_name, std::string_view endpoint);

}  // namespace footlight::drivers
