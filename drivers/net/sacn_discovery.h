// Universe discovery (E1.31-2018 sections 4.3, 8 and 12): senders announce their universes every 10 s. The list of
// senders, and a port that fills it from the network.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/net/net.h"
#include "drivers/net/net_source.h"
#include "drivers/net/sacn_packet.h"

namespace footlight::drivers {

inline constexpr DurationNs kSacnAnnounceNs = 10 * kNsPerS;  // E131_UNIVERSE_DISCOVERY_INTERVAL
inline constexpr DurationNs kSacnForgetNs = 20 * kNsPerS;

struct SacnAnnouncement {
  Cid cid = {};
  std::string name;  // as received; may hold any octet but 0
  std::uint32_t ipv4 = 0;
  std::vector<int> universes;  // ascending, each once; of the pages received
  int pages = 0;               // number of pages received; see pages_wanted
  int pages_wanted = 0;
  TimeNs received_ns = 0;
};

class SacnDirectory {
 public:
  // A further sender replaces the one silent for longest. Memory: at most 256 KiB per sender, for 256 pages.
  static constexpr std::size_t kSendersMax = 128;

  void take(const SacnDiscovery& packet, std::uint32_t from_ipv4, TimeNs now_ns);
  // Removes senders that have been silent for 20 s.
  void expire(TimeNs now_ns);
  // In the order of their first packets.
  [[nodiscard]] std::vector<SacnAnnouncement> list() const;

 private:
  struct Page {
    std::vector<std::uint16_t> universes;
    bool known = false;
  };
  struct Sender {
    Cid cid = {};
    std::string name;
    std::uint32_t ipv4 = 0;
    TimeNs received_ns = 0;
    std::vector<Page> pages;
  };
  std::vector<Sender> senders_;
};

struct SacnDiscoveryOptions {
  std::string name = "sacn discovery";       // starts its messages
  std::vector<std::string> interface_names;  // none: all that are up and support multicast
  std::uint16_t port = kSacnPort;
};

// Receives the discovery group only, on a socket that takes no unicast from other programs. poll() delivers no frames.
class SacnDiscoverySource final : public NetSource {
 public:
  [[nodiscard]] static Result<std::unique_ptr<SacnDiscoverySource>> create(const SacnDiscoveryOptions& options);
  [[nodiscard]] SacnDirectory& directory() { return directory_; }

 private:
  explicit SacnDiscoverySource(const SacnDiscoveryOptions& options);
  void take(const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& receiver) override;

  SacnDirectory directory_;
};

}  // namespace footlight::drivers
