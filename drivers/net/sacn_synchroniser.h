// Universe synchronisation on the receiving side (E1.31-2018 sections 6.2.4.1, 6.2.6 and 11): data packets with a
// synchronisation address wait for the synchronisation packet of that address. No socket, no clock.
//
// - Before the first synchronisation packet of an address, its data is used at once (6.2.4.1).
// - After that a frame is held until the next one. A newer frame of the same universe and sender replaces a held one,
//   which is counted.
// - Synchronisation is lost 2.5 s after the last synchronisation packet (11.1.2). Then the Force_Synchronization bit of
//   each data packet decides (6.2.6): set, it is used at once; clear, it is held until synchronisation resumes. If the
//   data is silent for 2.5 s as well, the state is dropped, so that frames of a restarted desk are used at once.
// - A data packet without address is used at once, and held frames of its universe and sender are dropped (6.2.4.1).
// - Any sender may synchronise any address: the standard connects them by the address alone.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "drivers/net/sacn_packet.h"
#include "drivers/net/sequence.h"
#include "sim/core/dmx.h"

namespace footlight::drivers {

struct HeldFrame {
  SenderId sender = 0;
  int address = 0;  // the synchronisation address that it waits for
  std::uint8_t sequence = 0;
  std::uint8_t priority = kPriorityDefault;
  std::uint16_t slot_count = 0;
  Slots slots = {};
};

class SacnSynchroniser {
 public:
  // Beyond these limits data is used at once.
  static constexpr std::size_t kAddressesMax = 32;       // active at a time; one idle for 2.5 s is replaced
  static constexpr std::size_t kHeldPerUniverseMax = 4;  // senders whose frames can wait

  struct Counters {
    std::uint64_t held = 0;        // frames that had to wait
    std::uint64_t replaced = 0;    // of those, never used: a newer one came before the synchronisation packet
    std::uint64_t unfollowed = 0;  // frames used at once because of the limits above
    std::uint64_t late = 0;        // synchronisation packets out of sequence
    std::uint64_t foreign = 0;     // synchronisation packets for an address that no data uses
  };

  explicit SacnSynchroniser(std::size_t place_count) : held_(place_count) {}

  // For a data packet with levels that passed all other rules. True: it is held; false: use it now.
  bool hold(const SacnData& data, std::size_t place, SenderId sender, TimeNs now_ns);
  // Drops held frames of a sender that ends.
  void drop(std::size_t place, SenderId sender);

  // For a synchronisation packet: calls use(place, held) for each frame that it releases, in the order in which the
  // universes were first held.
  template <class Use>
  void synchronise(const SacnSync& sync, SenderId sender, TimeNs now_ns, Use use) {
    Address* const address = accept(sync, sender, now_ns);
    if (address == nullptr) return;
    std::swap(address->places, places_spare_);
    for (const std::size_t place : places_spare_) {
      auto& frames = held_[place];
      for (std::size_t i = 0; i < frames.size();) {
        if (frames[i].address != sync.sync_universe) {
          ++i;
        } else {
          use(place, frames[i]);
          frames.erase(frames.begin() + static_cast<std::ptrdiff_t>(i));
        }
      }
    }
    places_spare_.clear();
  }

  // The addresses whose groups must be joined or left since the last call.
  struct Change {
    int joined = 0;  // 0: none
    int left = 0;
  };
  [[nodiscard]] std::optional<Change> take_change();

  [[nodiscard]] const Counters& counters() const { return counters_; }

 private:
  struct Address {
    int universe = 0;
    TimeNs used_ns = 0;            // last data packet
    TimeNs synchronised_ns = 0;    // last synchronisation packet
    bool is_synchronised = false;  // one was received; synchronisation may be lost now
    SequenceFilter filter;
    std::vector<std::size_t> places;  // with frames that wait for it, each once
  };

  [[nodiscard]] Address* find(int universe);
  Address* find_or_follow(int universe, TimeNs now_ns);
  Address* accept(const SacnSync& sync, SenderId sender, TimeNs now_ns);
  [[nodiscard]] bool waits(std::size_t place, int universe) const;
  void drop_held_of(const Address& address);

  std::vector<Address> addresses_;
  std::vector<std::vector<HeldFrame>> held_;  // per place
  std::vector<std::size_t> places_spare_;
  std::optional<Change> change_;
  Counters counters_;
};

}  // namespace footlight::drivers
