// Finds MVR-xchange stations and announces this one: multicast DNS through Avahi's daemon
// (docs/decisions/0153-mvr-xchange-by-avahi.md).
//
// One thread. Nothing blocks but open_mvr_discovery(), which opens a connection to the system's message bus.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <poll.h>

#include "drivers/net/mvr_xchange_tcp.h"
#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::drivers {

inline constexpr std::size_t kMvrFoundMax = 64;  // more stations are not listed

struct MvrFound {
  std::string name;  // of its TXT record, else of its instance
  std::string uuid;  // may be empty
  std::string group;
  MvrAddress address;
  std::vector<MvrAddress> others = {};  // further addresses of the same station
  bool operator==(const MvrFound&) const = default;
};

struct MvrAnnouncement {
  std::string name;
  std::string uuid;
  std::string group;
  std::uint16_t port = 0;
  bool operator==(const MvrAnnouncement&) const = default;
};

class MvrDiscovery {
 public:
  virtual ~MvrDiscovery() = default;
  virtual void add_descriptors(std::vector<pollfd>& waiting) const = 0;
  // Does what can be done. Call it when a descriptor is ready, and at least every second.
  virtual void step(TimeNs now_ns) = 0;
  // Stations whose address, port and texts are known; ours is among them once it is announced.
  [[nodiscard]] virtual std::vector<MvrFound> found() const = 0;
  // Announces this station until the object ends. A taken name gets " #2" and so on.
  virtual void announce(const MvrAnnouncement& announcement) = 0;
  // The name that others see; empty: not announced yet.
  [[nodiscard]] virtual std::string announced_name() const = 0;
  // Why the station is not announced, and the next step; empty: it is, or no error has come yet.
  [[nodiscard]] virtual std::string trouble() const = 0;
};

// Errors: kUnsupported (a build without Avahi), kNotFound (its daemon does not run). The message names the next step.
[[nodiscard]] Result<std::unique_ptr<MvrDiscovery>> open_mvr_discovery();

}  // namespace footlight::drivers
