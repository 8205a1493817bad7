// A part in a group of MVR-xchange: joins the stations that are found or named, informs them of new files, and leaves.
//
// Nothing here blocks; add_descriptors() and step() as for MvrServer. Each message is a connection of its own.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <poll.h>

#include "drivers/net/mvr_xchange_discovery.h"
#include "drivers/net/mvr_xchange_station.h"
#include "drivers/net/mvr_xchange_tcp.h"
#include "sim/core/clock.h"

namespace footlight::drivers {

inline constexpr DurationNs kMvrRejoinNs = 30 * kNsPerS;  // after a station could not be joined

class MvrGroup {
 public:
  struct Member {
    MvrFound station;     // the name and the UUID are those of its answer, once it has answered
    std::string uuid;     // as it was found
    bool named = false;   // by its address, not found
    bool joined = false;  // it has answered, and neither side has left
    bool left = false;    // by its own message; it is not asked again, and may join by itself
    MvrPeer peer;         // its answer, and the files that it announced since
    std::string trouble;  // why it is not joined; empty: it is, or the answer is under way
    TimeNs retry_ns = 0;
    std::size_t failed_addresses = 0;  // one after the other, since the last pause
    std::string informed;              // UUID of our newest file that it was informed of
  };

  // `discovery`: null for none. `group`: empty for all groups that are found. `named`: stations that need not be found.
  // `station` and `discovery` must live as long.
  MvrGroup(MvrStation& station, MvrDiscovery* discovery, std::string group, const std::vector<MvrAddress>& named);

  // A station that need not be found. Nothing happens if it is known.
  void add_named(const MvrAddress& address);
  void add_descriptors(std::vector<pollfd>& waiting) const;
  // Also informs the joined stations of the newest file that the station offers.
  void step(TimeNs now_ns);
  // From now on joins no station; joins that are under way go on, also at further addresses of their stations.
  void stop_joining() { joins_ = false; }
  // Informs the joined stations that this one leaves, and those that answer to a join yet; joins none any more.
  void leave(TimeNs now_ns);
  [[nodiscard]] bool busy() const { return !talks_.empty(); }  // an answer is under way

  [[nodiscard]] const std::vector<Member>& members() const { return members_; }

 private:
  struct Talk {
    std::unique_ptr<MvrClient> client;
    MvrAddress to;
    MvrMessageType type = MvrMessageType::kJoin;
  };
  void find_members();
  void start(Member& member, const MvrMessage& message, TimeNs now_ns);
  void end(const Talk& talk, const Status& status, TimeNs now_ns);
  Status answered(Member& member, const Talk& talk);
  void follow_peers();
  [[nodiscard]] Member* member_at(const MvrAddress& address);
  [[nodiscard]] bool talks_with(const MvrAddress& address) const;

  MvrStation& station_;
  MvrDiscovery* const discovery_;
  const std::string group_;
  std::vector<Member> members_;
  std::vector<Talk> talks_;
  std::uint64_t peer_changes_ = 0;  // of the station, as of the last step
  bool joins_ = true;
  bool leaves_ = false;
};

}  // namespace footlight::drivers
