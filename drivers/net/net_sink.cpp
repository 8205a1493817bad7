#include "drivers/net/net_sink.h"

#include <algorithm>
#include <cerrno>

#include "drivers/net/net_source.h"

namespace footlight::drivers {

NetSink::NetSink(Settings settings, std::vector<std::uint32_t> destinations, Fd socket)
    : settings_(std::move(settings)),
      show_universes_(show_numbers(settings_.universes)),
      show_index_(show_universes_),
      destinations_(std::move(destinations)),
      outlets_(show_universes_.size()),
      due_ns_(show_universes_.size(), kTimeNever),
      socket_(std::move(socket)) {}

TimeNs NetSink::next_deadline_ns() const {
  const auto earliest = std::min_element(due_ns_.begin(), due_ns_.end());
  return earliest == due_ns_.end() ? kTimeNever : *earliest;
}

PortState NetSink::state() const {
  if (!socket_) return PortState::kEnded;
  if (!trouble_.empty()) return PortState::kGone;
  return has_sent_ ? PortState::kWorking : PortState::kWaiting;
}

Status NetSink::send(TimeNs now_ns, std::span<const FrameView> frames) {
  if (!socket_) return {};
  for (const FrameView& frame : frames) {
    const int place = show_index_.find(frame.universe);
    if (place < 0 || frame.terminated) continue;
    Outlet& outlet = outlets_[static_cast<std::size_t>(place)];
    const auto slots = frame.slots.first(std::min<std::size_t>(frame.slots.size(), kSlotCountMax));
    const bool changed = !outlet.known || slots.size() > outlet.slot_count ||
                         !std::equal(slots.begin(), slots.end(), outlet.slots.begin());
    if (changed) {
      // Levels that never left are replaced by these; so are those of an earlier frame of this very call.
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
  if (!socket_) return {};
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

void NetSink::find_interface_again() {
  if (settings_.interface_name.empty()) return;
  const auto leaving = find_interface(settings_.name, settings_.interface_name);
  if (leaving && leave_through(socket_, leaving->index) != 0) ++counters_.errors;
}

void NetSink::transmit(TimeNs now_ns) {
  if (pending_.empty()) return;
  if (!trouble_.empty()) find_interface_again();
  for (const std::size_t place : pending_) {
    Outlet& outlet = outlets_[place];
    outlet.pending = false;
    const std::size_t size =
        write_packet({outlet.packet, place, false, std::span(outlet.slots).first(outlet.slot_count)});
    writer_.add(std::span(outlet.packet).first(size), destinations_[place], settings_.udp_port);
  }
  const auto sent = writer_.flush(socket_.get());
  for (std::size_t i = 0; i < sent.count; ++i) {
    Outlet& outlet = outlets_[pending_[i]];
    outlet.unsent = false;
    due_ns_[pending_[i]] = now_ns + (outlet.repeats_left > 0 ? kRepeatIntervalNs : kKeepAliveNs);
  }
  counters_.frames += sent.count;
  const bool full = sent.error_number == EAGAIN || sent.error_number == EWOULDBLOCK || sent.error_number == ENOBUFS;
  for (std::size_t i = sent.count; i < pending_.size(); ++i) {
    outlets_[pending_[i]].unsent = true;
    due_ns_[pending_[i]] = now_ns + (full ? kRetryFullNs : kRetryDownNs);
  }
  if (sent.error_number != 0 && !full) {
    ++counters_.errors;
    trouble_ =
        net_error(settings_.name,
                  fmt::format("send to {}:{}", text_of_ipv4(destinations_[pending_[sent.count]]), settings_.udp_port),
                  sent.error_number)
            .message;
  } else if (sent.count > 0) {
    trouble_.clear();
    has_sent_ = true;
  }
  pending_.clear();
}

void NetSink::close(TimeNs) {
  if (!socket_) return;
  // Three, since any datagram may be lost (E1.31-2018 section 6.2.6).
  for (int round = 0; says_goodbye() && round < 3; ++round) {
    for (std::size_t place = 0; place < outlets_.size(); ++place) {
      Outlet& outlet = outlets_[place];
      if (!outlet.known) continue;
      const std::size_t size =
          write_packet({outlet.packet, place, true, std::span(outlet.slots).first(outlet.slot_count)});
      writer_.add(std::span(outlet.packet).first(size), destinations_[place], settings_.udp_port);
    }
    if (writer_.flush(socket_.get()).error_number != 0) ++counters_.errors;
  }
  std::fill(due_ns_.begin(), due_ns_.end(), kTimeNever);
  socket_.reset();
}

}  // namespace footlight::drivers
