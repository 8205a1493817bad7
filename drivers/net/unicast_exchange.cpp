#include "drivers/net/unicast_exchange.h"

#include <algorithm>

#include <unistd.h>

namespace footlight::drivers {

void UnicastExchange::add(Inbox& inbox) {
  inboxes_.push_back(&inbox);
  find_shared();
}

void UnicastExchange::remove(Inbox& inbox) {
  std::erase(inboxes_, &inbox);
  find_shared();
}

void UnicastExchange::find_shared() {
  for (Inbox* const inbox : inboxes_) {
    inbox->shared = std::any_of(inboxes_.begin(), inboxes_.end(), [&](const Inbox* other) {
      return other != inbox && other->udp_port == inbox->udp_port;
    });
    if (inbox->shared && inbox->parcels.empty()) inbox->parcels.resize(kParcelsMax);
  }
}

void UnicastExchange::pass_on(const Inbox& from, const Datagram& datagram, TimeNs stamp_ns) {
  for (Inbox* const to : inboxes_) {
    if (to == &from || to->udp_port != from.udp_port) continue;
    const auto& ipv4s = to->ipv4s;
    if (!ipv4s.empty() && std::find(ipv4s.begin(), ipv4s.end(), datagram.to_ipv4) == ipv4s.end()) continue;
    if (to->count == to->parcels.size()) {
      ++to->dropped;
      continue;
    }
    Parcel& parcel = to->parcels[(to->first + to->count) % to->parcels.size()];
    ++to->count;
    parcel.datagram = datagram;
    parcel.datagram.bytes = {};
    parcel.size = std::min(datagram.bytes.size(), parcel.bytes.size());
    std::copy_n(datagram.bytes.begin(), parcel.size, parcel.bytes.begin());
    parcel.stamp_ns = stamp_ns;
    if (to->count > 1) continue;  // readable already
    const std::uint64_t one = 1;
    (void)!::write(to->event.get(), &one, sizeof one);
  }
}

}  // namespace footlight::drivers
