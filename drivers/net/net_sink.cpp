#include "drivers/net/net_sink.h"

#include <algorithm>
#include <cerrno>

#include "drivers/net/net_source.h"

namespace footlight::drivers {

NetSink::NetSink(const NetSinkOptions& options, std::vector<Link> links)
    : settings_(options),
      show_universes_(show_numbers(settings_.universes)),
      show_index_(show_universes_),
      outlets_(show_universes_.size()),
      due_ns_(show_universes_.size(), kTimeNever),
      links_(std::move(links)),
      entries_(links_.size()) {}

Result<std::vector<NetSink::Link>> NetSink::open_links(const std::string& port_name,
                                                       const std::vector<std::string>& interface_names,
                                                       int multicast_ttl) {
  std::vector<Link> links;
  SenderSocket wanted;
  wanted.port_name = port_name;
  wanted.multicast_ttl = multicast_ttl;
  for (const auto& interface_name : interface_names) {
    FL_ASSIGN(const Interface leaving, find_interface(port_name, interface_name));
    wanted.interface_index = leaving.index;
    FL_ASSIGN(Fd socket, open_sender(wanted));
    links.push_back({std::move(socket), interface_name});
  }
  if (links.empty()) {
    FL_ASSIGN(Fd socket, open_sender(wanted));
    links.push_back({std::move(socket), {}});
  }
  return links;
}

Status NetSink::check_routes(const std::string& port_name, std::span<const Link> links,
                             std::span<const Destination> destinations) {
  for (const Destination& destination : destinations) {
    int interface_index = 0;
    if (const auto& interface_name = links[destination.link].interface_name; !interface_name.empty()) {
      FL_ASSIGN(const Interface leaving, find_interface(port_name, interface_name));
      interface_index = leaving.index;
    }
    if (const int error_number = route_error(destination.ipv4, interface_index); error_number != 0) {
      return tl::unexpected(
          net_error(port_name, fmt::format("send to {}", text_of_ipv4(destination.ipv4)), error_number));
    }
  }
  return {};
}

void NetSink::set_destinations(std::size_t place, std::vector<Destination> destinations) {
  outlets_[place].destinations = std::move(destinations);
}

TimeNs NetSink::next_deadline_ns() const {
  const auto earliest = std::min_element(due_ns_.begin(), due_ns_.end());
  return earliest == due_ns_.end() ? kTimeNever : *earliest;
}

PortState NetSink::state() const {
  if (!is_open()) return PortState::kEnded;
  if (!trouble_.empty()) return PortState::kGone;
  return has_sent_ ? PortState::kWorking : PortState::kWaiting;
}

Status NetSink::send(TimeNs now_ns, std::span<const FrameView> frames) {
  if (!is_open()) return {};
  for (const FrameView& frame : frames) {
    const int place = show_index_.find(frame.universe);
    if (place < 0 || frame.terminated || frame.start_code != kStartCodeLevels) continue;
    Outlet& outlet = outlets_[static_cast<std::size_t>(place)];
    const auto slots = frame.slots.first(std::min<std::size_t>(frame.slots.size(), kSlotCountMax));
    const bool changed = !outlet.known || slots.size() > outlet.slot_count ||
                         !std::equal(slots.begin(), slots.end(), outlet.slots.begin());
    if (changed) {
      // These replace levels that were never sent, including those of an earlier frame in this call.
      if (outlet.unsent || outlet.pending) ++counters_.dropped;
      std::copy(slots.begin(), slots.end(), outlet.slots.begin());
      outlet.slot_count = std::max(outlet.slot_count, slots.size());
      outlet.known = true;
      outlet.repeats_left = kRepeats;
    } else if (!outlet.unsent) {
      if (outlet.pending || outlet.repeats_left == 0) continue;
      --outlet.repeats_left;
    }
    add_pending(static_cast<std::size_t>(place));
  }
  transmit(now_ns);
  return {};
}

Status NetSink::poll(TimeNs now_ns) {
  if (!is_open()) return {};
  for (std::size_t place = 0; place < outlets_.size(); ++place) {
    if (due_ns_[place] > now_ns) continue;
    Outlet& outlet = outlets_[place];
    if (!outlet.unsent && outlet.repeats_left > 0) --outlet.repeats_left;
    add_pending(place);
  }
  transmit(now_ns);
  return {};
}

void NetSink::add_pending(std::size_t place) {
  if (outlets_[place].pending) return;
  outlets_[place].pending = true;
  pending_.push_back(place);
}

void NetSink::find_interface_again(Link& link) {
  if (link.interface_name.empty()) return;
  const auto leaving = find_interface(settings_.name, link.interface_name);
  if (leaving && leave_through(link.socket, leaving->index) != 0) ++counters_.errors;
}

void NetSink::add_entry(std::span<const std::uint8_t> bytes, std::span<const Destination> destinations,
                        std::size_t place) {
  for (const Destination& to : destinations) entries_[to.link].push_back({bytes, to.ipv4, place});
}

void NetSink::add(std::span<const std::uint8_t> bytes, std::span<const Destination> destinations) {
  add_entry(bytes, destinations, kNoPlace);
}

void NetSink::send_added() { flush_entries(); }

void NetSink::send_again(std::size_t place, TimeNs now_ns) {
  if (is_open() && outlets_[place].known) due_ns_[place] = now_ns;
}

bool NetSink::flush_entries() {
  bool any = false;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    if (entries_[i].empty()) continue;
    if (links_[i].failed) find_interface_again(links_[i]);
    any |= flush_link(links_[i], entries_[i]);
    entries_[i].clear();
  }
  return any;
}

bool NetSink::flush_link(Link& link, const std::vector<Entry>& entries) {
  for (const Entry& entry : entries) writer_.add(entry.bytes, entry.ipv4, settings_.port);
  writer_.flush_each(link.socket.get(), error_numbers_);
  bool any = false;
  link.failed = false;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const int error_number = error_numbers_[i];
    const bool full = error_number == EAGAIN || error_number == EWOULDBLOCK || error_number == ENOBUFS;
    any |= error_number == 0;
    if (entries[i].place != kNoPlace) {
      outlets_[entries[i].place].reached |= error_number == 0;
      outlets_[entries[i].place].refused |= full;
    }
    if (error_number == 0 || full) continue;
    ++counters_.errors;
    link.failed = true;
    if (!refusal_.empty()) continue;
    refusal_ = net_error(settings_.name, fmt::format("send to {}:{}", text_of_ipv4(entries[i].ipv4), settings_.port),
                         error_number)
                   .message;
  }
  return any;
}

void NetSink::transmit(TimeNs now_ns) {
  if (pending_.empty()) return;
  refusal_.clear();
  add_before(now_ns, pending_);
  for (const std::size_t place : pending_) {
    Outlet& outlet = outlets_[place];
    outlet.pending = false;
    outlet.reached = outlet.destinations.empty();
    outlet.refused = false;
    if (outlet.reached) continue;
    const std::size_t size =
        write_packet({outlet.packet, place, false, std::span(outlet.slots).first(outlet.slot_count)});
    add_entry(std::span(outlet.packet).first(size), outlet.destinations, place);
  }
  add_after(now_ns, pending_);
  if (flush_entries()) {
    trouble_.clear();
    has_sent_ = true;
  } else if (!refusal_.empty()) {
    trouble_ = refusal_;
  }
  for (const std::size_t place : pending_) {
    Outlet& outlet = outlets_[place];
    outlet.unsent = outlet.refused || !outlet.reached;
    DurationNs pause_ns = outlet.repeats_left > 0 ? kRepeatIntervalNs : kKeepAliveNs;
    if (outlet.unsent) pause_ns = outlet.refused ? kRetryFullNs : kRetryDownNs;
    due_ns_[place] = now_ns + pause_ns;
    if (!outlet.unsent && !outlet.destinations.empty()) ++counters_.frames;
  }
  pending_.clear();
}

void NetSink::end_streams() {
  // Three times, since any datagram may be lost (E1.31-2018 section 6.2.6).
  for (int round = 0; round < 3; ++round) {
    for (std::size_t place = 0; place < outlets_.size(); ++place) {
      Outlet& outlet = outlets_[place];
      if (!outlet.known) continue;
      const std::size_t size =
          write_packet({outlet.packet, place, true, std::span(outlet.slots).first(outlet.slot_count)});
      add_entry(std::span(outlet.packet).first(size), outlet.destinations, place);
    }
    flush_entries();
  }
}

void NetSink::rest(TimeNs) {
  if (!is_open()) return;
  if (ends_streams_at_rest()) end_streams();
  for (Outlet& outlet : outlets_) {
    outlet.known = outlet.unsent = false;
    outlet.repeats_left = 0;
  }
  std::fill(due_ns_.begin(), due_ns_.end(), kTimeNever);
}

void NetSink::close(TimeNs) {
  if (!is_open()) return;
  if (ends_streams()) end_streams();
  std::fill(due_ns_.begin(), due_ns_.end(), kTimeNever);
  links_.clear();
}

}  // namespace footlight::drivers
