#include "drivers/net/sacn_synchroniser.h"

#include <algorithm>

namespace footlight::drivers {

SacnSynchroniser::Address* SacnSynchroniser::find(int universe) {
  const auto at = std::find_if(addresses_.begin(), addresses_.end(),
                               [universe](const Address& a) { return a.universe == universe; });
  return at == addresses_.end() ? nullptr : &*at;
}

bool SacnSynchroniser::waits(std::size_t place, int universe) const {
  return std::any_of(held_[place].begin(), held_[place].end(),
                     [universe](const HeldFrame& frame) { return frame.address == universe; });
}

void SacnSynchroniser::drop_held_of(const Address& address) {
  for (const std::size_t place : address.places) {
    counters_.replaced +=
        std::erase_if(held_[place], [&address](const HeldFrame& frame) { return frame.address == address.universe; });
  }
}

SacnSynchroniser::Address* SacnSynchroniser::find_or_follow(int universe, TimeNs now_ns) {
  if (Address* const known = find(universe); known != nullptr) {
    if (now_ns - known->used_ns >= kSenderTimeoutNs && now_ns - known->synchronised_ns >= kSenderTimeoutNs) {
      drop_held_of(*known);
      known->places.clear();
      known->is_synchronised = false;
    }
    return known;
  }
  // At most one change of groups per datagram: the owner takes it before the next.
  Change change;
  Address* fresh = nullptr;
  if (addresses_.size() < kAddressesMax) {
    fresh = &addresses_.emplace_back();
  } else {
    const auto idlest = std::min_element(addresses_.begin(), addresses_.end(),
                                         [](const Address& a, const Address& b) { return a.used_ns < b.used_ns; });
    if (now_ns - idlest->used_ns < kSenderTimeoutNs) return nullptr;
    drop_held_of(*idlest);
    change.left = idlest->universe;
    *idlest = {};
    fresh = &*idlest;
  }
  fresh->universe = universe;
  change.joined = universe;
  change_ = change;
  return fresh;
}

bool SacnSynchroniser::hold(const SacnData& data, std::size_t place, SenderId sender, TimeNs now_ns) {
  auto& frames = held_[place];
  const auto of_sender = [&](const HeldFrame& frame) { return frame.sender == sender; };
  if (data.sync_universe == 0) {
    if (!frames.empty()) drop(place, sender);
    return false;
  }
  Address* const address = find_or_follow(data.sync_universe, now_ns);
  if (address == nullptr) {
    ++counters_.unfollowed;
    return false;
  }
  address->used_ns = now_ns;
  if (!address->is_synchronised) return false;
  const bool lost = now_ns - address->synchronised_ns >= kSenderTimeoutNs;
  if (lost && data.force_sync) {
    if (!frames.empty()) drop(place, sender);
    return false;
  }
  auto frame = std::find_if(frames.begin(), frames.end(), of_sender);
  if (frame != frames.end() && frame->address != data.sync_universe) {
    drop(place, sender);
    frame = frames.end();
  }
  if (frame == frames.end()) {
    if (frames.size() == kHeldPerUniverseMax) {
      ++counters_.unfollowed;
      return false;
    }
    if (!waits(place, data.sync_universe)) address->places.push_back(place);
    frame = frames.insert(frames.end(), HeldFrame{});
  } else {
    ++counters_.replaced;
  }
  ++counters_.held;
  frame->sender = sender;
  frame->address = data.sync_universe;
  frame->sequence = data.sequence;
  frame->priority = data.priority;
  // A shorter frame keeps the other slots of the frame that it replaces: both are in it.
  std::copy(data.slots.begin(), data.slots.end(), frame->slots.begin());
  frame->slot_count = std::max(frame->slot_count, static_cast<std::uint16_t>(data.slots.size()));
  return true;
}

void SacnSynchroniser::drop(std::size_t place, SenderId sender) {
  auto& frames = held_[place];
  const auto frame =
      std::find_if(frames.begin(), frames.end(), [sender](const HeldFrame& f) { return f.sender == sender; });
  if (frame == frames.end()) return;
  ++counters_.replaced;
  const int universe = frame->address;
  frames.erase(frame);
  if (Address* const address = find(universe); address != nullptr && !waits(place, universe)) {
    std::erase(address->places, place);
  }
}

SacnSynchroniser::Address* SacnSynchroniser::accept(const SacnSync& sync, SenderId sender, TimeNs now_ns) {
  Address* const address = find(sync.sync_universe);
  if (address == nullptr) {
    ++counters_.foreign;
    return nullptr;
  }
  if (address->filter.judge(sender, sync.sequence, false, SequenceRule::kSacn, now_ns) ==
      SequenceFilter::Verdict::kLate) {
    ++counters_.late;
    return nullptr;
  }
  address->is_synchronised = true;
  address->synchronised_ns = now_ns;
  return address;
}

std::optional<SacnSynchroniser::Change> SacnSynchroniser::take_change() { return std::exchange(change_, std::nullopt); }

}  // namespace footlight::drivers
