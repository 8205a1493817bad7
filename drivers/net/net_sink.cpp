#include "drivers/net/net_sink.h"

#include <algorithm>
#include <cerrno>

#include "drivers/net/net_source.h"

namespace footlight::drivers {
namespace {

bool is_buffer_full(int error_number) {
  return error_number == EAGAIN || error_number == EWOULDBLOCK || error_number == ENOBUFS;
}

}  // namespace

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

void NetSink::send_again(std::size_t place, TimeNs now_ns) {
  if (socket_ && outlets_[place].known) due_ns_[place] = now_ns;
}

void NetSink::transmit(TimeNs now_ns) {
  if (pending_.empty()) return;
  if (!trouble_.empty()) find_interface_again();
  ends_.clear();
  std::size_t datagram_count = 0;
  for (const std::size_t place : pending_) {
    Outlet& outlet = outlets_[place];
    outlet.pending = false;
    const std::size_t size =
        write_packet({outlet.packet, place, false, std::span(outlet.slots).first(outlet.slot_count)});
    for (const std::uint32_t ipv4 : destinations_of(place)) {
      writer_.add(std::span(outlet.packet).first(size), ipv4, settings_.udp_port);
      ++datagram_count;
    }
    ends_.push_back(datagram_count);
  }
  if (datagram_count > 0) end_batch(writer_);
  writer_.flush_each(socket_.get(), error_numbers_);

  bool any_sent = false;
  std::string trouble;
  for (std::size_t i = 0, at = 0; i < pending_.size(); ++i) {
    const std::size_t place = pending_[i];
    Outlet& outlet = outlets_[place];
    std::size_t sent = 0;
    bool full = false;
    const std::size_t first = at;
    for (; at < ends_[i]; ++at) {
      const int error_number = error_numbers_[at];
      sent += error_number == 0;
      full |= is_buffer_full(error_number);
      if (error_number == 0 || is_buffer_full(error_number)) continue;
      ++counters_.errors;
    }
    // Nobody to send to is no failure. One of several receivers out of reach is none for the others.
    outlet.unsent = full || (sent == 0 && at > first);
    if (outlet.unsent) {
      due_ns_[place] = now_ns + (full ? kRetryFullNs : kRetryDownNs);
      if (!full && trouble.empty()) {
        const std::uint32_t ipv4 = destinations_of(place).front();
        trouble = net_error(settings_.name, fmt::format("send to {}:{}", text_of_ipv4(ipv4), settings_.udp_port),
                            error_numbers_[first])
                      .message;
      }
      continue;
    }
    due_ns_[place] = now_ns + (outlet.repeats_left > 0 ? kRepeatIntervalNs : kKeepAliveNs);
    if (sent == 0) continue;
    ++counters_.frames;
    any_sent = true;
  }
  if (!trouble.empty() || any_sent) trouble_ = std::move(trouble);
  has_sent_ |= any_sent;
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
      for (const std::uint32_t ipv4 : destinations_of(place)) {
        writer_.add(std::span(outlet.packet).first(size), ipv4, settings_.udp_port);
      }
    }
    if (writer_.flush(socket_.get()).error_number != 0) ++counters_.errors;
  }
  std::fill(due_ns_.begin(), due_ns_.end(), kTimeNever);
  socket_.reset();
}

}  // namespace footlight::drivers
