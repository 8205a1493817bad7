#include "drivers/net/sacn_discovery.h"

#include <algorithm>
#include <variant>

namespace footlight::drivers {

void SacnDirectory::take(const SacnDiscovery& packet, std::uint32_t from_ipv4, TimeNs now_ns) {
  auto sender = std::find_if(senders_.begin(), senders_.end(), [&](const Sender& s) { return s.cid == packet.cid; });
  if (sender == senders_.end()) {
    if (senders_.size() == kSendersMax) {
      senders_.erase(std::min_element(senders_.begin(), senders_.end(),
                                      [](const Sender& a, const Sender& b) { return a.received_ns < b.received_ns; }));
    }
    sender = senders_.insert(senders_.end(), Sender{});
    sender->cid = packet.cid;
  }
  sender->name = packet.source_name;
  sender->ipv4 = from_ipv4;
  sender->received_ns = now_ns;
  sender->pages.resize(static_cast<std::size_t>(packet.last_page) + 1);
  Page& page = sender->pages[static_cast<std::size_t>(packet.page)];
  page.known = true;
  page.universes.clear();
  for (std::size_t i = 0; i < packet.universe_count(); ++i) {
    page.universes.push_back(static_cast<std::uint16_t>(packet.universe(i)));
  }
}

void SacnDirectory::expire(TimeNs now_ns) {
  std::erase_if(senders_, [now_ns](const Sender& sender) { return now_ns - sender.received_ns >= kSacnForgetNs; });
}

std::vector<SacnAnnouncement> SacnDirectory::list() const {
  std::vector<SacnAnnouncement> announcements;
  for (const Sender& sender : senders_) {
    SacnAnnouncement one;
    one.cid = sender.cid;
    one.name = sender.name;
    one.ipv4 = sender.ipv4;
    one.received_ns = sender.received_ns;
    one.pages_wanted = static_cast<int>(sender.pages.size());
    for (const Page& page : sender.pages) {
      one.pages += page.known ? 1 : 0;
      one.universes.insert(one.universes.end(), page.universes.begin(), page.universes.end());
    }
    // The standard requires ascending lists; some senders' are not.
    std::sort(one.universes.begin(), one.universes.end());
    one.universes.erase(std::unique(one.universes.begin(), one.universes.end()), one.universes.end());
    announcements.push_back(std::move(one));
  }
  return announcements;
}

Result<std::unique_ptr<SacnDiscoverySource>> SacnDiscoverySource::create(const SacnDiscoveryOptions& options) {
  std::unique_ptr<SacnDiscoverySource> source(new SacnDiscoverySource(options));
  FL_TRY(source->open());
  return source;
}

SacnDiscoverySource::SacnDiscoverySource(const SacnDiscoveryOptions& options)
    : NetSource([&] {
        const std::uint32_t group = sacn_group_ipv4(kSacnDiscoveryUniverse);
        Settings settings{NetSourceOptions(options.port)};
        settings.name = options.name;
        // Bound to the group: a socket bound to every address would receive some of the unicast for a bridge on this
        // machine.
        settings.addresses = {text_of_ipv4(group)};
        settings.interface_names = options.interface_names;
        settings.kernel_stamps = false;
        settings.groups = {group};
        return settings;
      }()) {}

void SacnDiscoverySource::take(const Datagram& datagram, TimeNs stamp_ns, FrameReceiver&) {
  const auto packet = parse_sacn_packet(datagram.bytes);
  if (!packet) {
    count_rejected();
  } else if (const auto* discovery = std::get_if<SacnDiscovery>(&*packet)) {
    directory_.take(*discovery, datagram.from_ipv4, stamp_ns);
  }
}

}  // namespace footlight::drivers
