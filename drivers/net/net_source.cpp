#include "drivers/net/net_source.h"

#include <algorithm>
#include <array>
#include <cerrno>

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "drivers/net/port_holders.h"

namespace footlight::drivers {
namespace {

constexpr std::uint64_t kWatchTag = UINT64_MAX;
constexpr std::uint64_t kOtherTag = UINT64_MAX - 1;  // for watch(): handled by the protocol
constexpr std::uint64_t kInboxTag = UINT64_MAX - 2;
// Per poll() and socket. Remaining datagrams make the descriptor readable again at once, so that a flood on one port
// does not delay the others.
constexpr int kBatchesMax = 16;

bool watch_readable(const Fd& epoll, int fd, std::uint64_t tag) {
  epoll_event event = {};
  event.events = EPOLLIN;
  event.data.u64 = tag;
  return epoll_ctl(epoll.get(), EPOLL_CTL_ADD, fd, &event) == 0;
}

}  // namespace

Status check_universes(const std::string& name, const std::vector<WireUniverse>& universes, int wire_max) {
  if (universes.empty()) {
    return fail(ErrorCode::kBadInput, "{}: no universe is named; name one or more, as in \"1-9\"", name);
  }
  for (const auto& [wire, show] : universes) {
    if (wire < 1 || wire > wire_max) {
      return fail(ErrorCode::kBadInput, "{}: expected wire universes from 1 to {}, got {}", name, wire_max, wire);
    }
    if (!is_universe(show)) {
      return fail(ErrorCode::kBadInput, "{}: expected universes of the show from 1 to {}, got {}", name, kUniverseMax,
                  show);
    }
  }
  for (auto numbers : {wire_numbers(universes), show_numbers(universes)}) {
    std::sort(numbers.begin(), numbers.end());
    const auto twice = std::adjacent_find(numbers.begin(), numbers.end());
    if (twice != numbers.end()) {
      return fail(ErrorCode::kBadInput, "{}: universe {} is named twice; name each universe once on either side", name,
                  *twice);
    }
  }
  return {};
}

std::vector<int> wire_numbers(const std::vector<WireUniverse>& universes) {
  std::vector<int> numbers;
  for (const auto& universe : universes) numbers.push_back(universe.wire);
  return numbers;
}

std::vector<Universe> show_numbers(const std::vector<WireUniverse>& universes) {
  std::vector<Universe> numbers;
  for (const auto& universe : universes) numbers.push_back(universe.show);
  return numbers;
}

NetSource::NetSource(Settings settings)
    : settings_(std::move(settings)),
      show_universes_(show_numbers(settings_.universes)),
      wire_index_(wire_numbers(settings_.universes)) {}

Status NetSource::open() {
  FL_ASSIGN(std::vector<std::uint32_t> bind_ipv4s, parse_ipv4_list(settings_.name, settings_.addresses));
  if (bind_ipv4s.empty()) {
    bind_ipv4s.push_back(0);
  } else if (!is_multicast(bind_ipv4s.front())) {
    settings_.groups.clear();  // unicast only
  }
  FL_TRY(find_named_interfaces());
  epoll_ = Fd(epoll_create1(EPOLL_CLOEXEC));
  if (!epoll_) return tl::unexpected(net_error(settings_.name, "create an epoll descriptor", errno));
  if (watch_.fd() >= 0 && !watch_readable(epoll_, watch_.fd(), kWatchTag)) {
    return tl::unexpected(net_error(settings_.name, "watch the network interfaces", errno));
  }
  if (!is_multicast(bind_ipv4s.front())) {
    find_sharing(bind_ipv4s);
    FL_TRY(open_inbox());
  }
  if (settings_.yields) bind_ipv4s.assign(1, 0);
  for (const std::uint32_t bind_ipv4 : bind_ipv4s) FL_TRY(add_socket(bind_ipv4));
  join_missing();
  settings_.stopping = nullptr;  // needed during the start only
  // At the start, a group that cannot be joined is an error in the options or the system.
  if (joined_interfaces_.empty() && join_refused_) return fail(join_refused_->code, "{}", join_refused_->message);
  return {};
}

NetSource::~NetSource() {
  if (inbox_.event && settings_.own_senders) {
    // Pass on datagrams of this socket that the other inputs have not got yet.
    for (std::size_t i = 0; inbox_.shared && i < sockets_.size(); ++i) {
      for (int count = 0; (count = reader_.read(sockets_[i].fd.get())) > 0;) {
        for (int k = 0; k < count; ++k) {
          const Datagram& datagram = reader_[static_cast<std::size_t>(k)];
          if (!is_unicast(datagram) || datagram.truncated) continue;
          settings_.own_senders->unicast().pass_on(inbox_, datagram, polled_ns_ - datagram.age_ns);
        }
      }
    }
    settings_.own_senders->unicast().remove(inbox_);
  }
  // The kernel finds the group that was joined last first. Closing in the other order would search a list of all groups
  // for each one.
  while (!sockets_.empty()) sockets_.pop_back();
}

void NetSource::find_sharing(std::span<const std::uint32_t> bind_ipv4s) {
  const bool any = bind_ipv4s.front() == 0;
  if (!any) inbox_.ipv4s.assign(bind_ipv4s.begin(), bind_ipv4s.end());
  const auto holders = other_holders(settings_.port);
  const auto other = std::find_if(holders.begin(), holders.end(), [&](const PortHolder& holder) {
    if (!holder.is_ipv4)
      return settings_.yields;  // it leaves unicast to an IPv4 socket, which ours is unless it
                                // yields
    if (holder.ipv4 == 0) return true;
    return std::find(bind_ipv4s.begin(), bind_ipv4s.end(), holder.ipv4) != bind_ipv4s.end();
  });
  if (other == holders.end()) return;
  std::string_view next = "Stop that program to get unicast frames here";
  if (other->is_bridge) next = "'footlight monitor' without an endpoint shows its levels";
  if (other->is_bridge && !other->is_ipv4) {  // an Art-Net output that searches, or inputs that yield
    next =
        "If it has no input on this port, an output that searches for devices drops them: name the addresses of its "
        "devices after @ to get unicast frames here. Else 'footlight monitor' without an endpoint shows its levels";
  }
  sharing_ = PortNotice{.level = settings_.yields ? NoticeLevel::kInfo : NoticeLevel::kWarning,
                        .id = "port-shared",
                        .text = fmt::format("{} has UDP port {} open and gets the unicast frames; multicast and "
                                            "broadcast frames come here too. {}",
                                            other->description, settings_.port, next)};
  settings_.yields = true;
}

Status NetSource::open_inbox() {
  inbox_.udp_port = settings_.port;
  inbox_.event = Fd(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!inbox_.event || !watch_readable(epoll_, inbox_.event.get(), kInboxTag)) {
    return tl::unexpected(net_error(settings_.name, "create an eventfd", errno));
  }
  if (settings_.own_senders) settings_.own_senders->unicast().add(inbox_);
  if (sharing_) {  // makes the first poll() come soon, with the notice
    const std::uint64_t one = 1;
    (void)!::write(inbox_.event.get(), &one, sizeof one);
  }
  return {};
}

void NetSource::read_inbox(FrameReceiver& receiver) {
  std::uint64_t wakes = 0;
  (void)!::read(inbox_.event.get(), &wakes, sizeof wakes);
  while (inbox_.count > 0) {
    const UnicastExchange::Parcel& parcel = inbox_.parcels[inbox_.first];
    Datagram datagram = parcel.datagram;
    datagram.bytes = std::span(parcel.bytes).first(parcel.size);
    take(datagram, parcel.stamp_ns, receiver);
    inbox_.first = (inbox_.first + 1) % inbox_.parcels.size();
    --inbox_.count;
  }
  counters_.dropped += std::exchange(inbox_.dropped, 0);
}

bool NetSource::is_for_us(const Datagram& datagram) const {
  if (!settings_.yields) return true;  // the socket is bound to our addresses
  if (datagram.to_ipv4 == 0) return false;
  const auto& ipv4s = inbox_.ipv4s;
  return ipv4s.empty() || std::find(ipv4s.begin(), ipv4s.end(), datagram.to_ipv4) != ipv4s.end();
}

Status NetSource::add_socket(std::uint32_t bind_ipv4) {
  ReceiverSocket wanted;
  wanted.port_name = settings_.name;
  wanted.bind_ipv4 = bind_ipv4;
  wanted.udp_port = settings_.port;
  wanted.kernel_stamps = settings_.kernel_stamps;
  wanted.packet_info = true;
  // Room for four frames of every universe, with the kernel's memory for a datagram of a full one.
  const std::size_t frames_bytes = settings_.universes.size() * 4 * 2'304;
  wanted.buffer_bytes = static_cast<int>(std::clamp<std::size_t>(frames_bytes, 4 << 20, 64 << 20));
  auto opened = settings_.yields ? open_yielding_receiver(wanted) : open_receiver(wanted);
  if (!opened) {
    // Without IPv6 no socket can leave unicast to others.
    const std::string other = sharing_ ? fmt::format(" ({})", sharing_->text) : "";
    return fail(opened.error().code, "{}{}", opened.error().message, other);
  }
  Fd socket = std::move(*opened);
  if (!watch_readable(epoll_, socket.get(), sockets_.size())) {
    return tl::unexpected(net_error(settings_.name, "watch a socket", errno));
  }
  sockets_.push_back({std::move(socket), 0, 0});
  return {};
}

Status NetSource::find_named_interfaces() {
  Status first;
  only_interfaces_.clear();
  for (const auto& name : settings_.interface_names) {
    const auto found = find_interface(settings_.name, name);
    if (found) {
      only_interfaces_.insert(found->index);
    } else if (first) {
      first = tl::unexpected(found.error());
    }
  }
  return first;
}

Status NetSource::join(std::uint32_t group, int interface_index) {
  // A socket below our limit may still be full if the system's limit is lower; then the next one takes the group.
  for (std::size_t i = first_with_room_;; ++i) {
    if (i == sockets_.size()) {
      if (const int error_number = receive_all_groups(sockets_.front().fd); error_number != 0) {
        return tl::unexpected(net_error(settings_.name, "receive groups of other sockets", error_number));
      }
      FL_ASSIGN(Fd member, open_member(settings_.name));
      sockets_.push_back({std::move(member), 0, 0});
    }
    Socket& socket = sockets_[i];
    if (socket.groups >= kGroupsPerSocketMax) {
      if (i == first_with_room_) ++first_with_room_;
      continue;
    }
    const int error_number = join_group(socket.fd, group, interface_index);
    if (error_number == 0 || error_number == EADDRINUSE) {  // EADDRINUSE: this socket is a member already
      if (error_number == 0) {
        ++socket.groups;
        memberships_.push_back({interface_index, group, i});
      }
      return {};
    }
    if (error_number == ENOBUFS && socket.groups > 0) {
      if (i == first_with_room_) ++first_with_room_;
      continue;
    }
    return tl::unexpected(
        net_error(settings_.name, fmt::format("join multicast group {}", text_of_ipv4(group)), error_number));
  }
}

void NetSource::join_missing() {
  join_trouble_.clear();
  join_refused_.reset();
  const Status named = find_named_interfaces();
  if (settings_.groups.empty()) return;
  // Interfaces listed in the options are tried even if they do not report multicast support, as "lo".
  std::set<int> wanted = only_interfaces_;
  if (settings_.interface_names.empty()) {
    for (const auto& candidate : list_interfaces()) {
      if (candidate.up && candidate.multicast) wanted.insert(candidate.index);
    }
  }
  if (!named) {
    join_trouble_ = named.error().message;
  } else if (wanted.empty()) {
    join_trouble_ = fmt::format(
        "{}: no network interface is up and supports multicast; connect one, or send to this machine "
        "by unicast",
        settings_.name);
  }
  for (const int interface_index : wanted) {
    if (joined_interfaces_.contains(interface_index)) continue;
    Status status;
    for (const std::uint32_t group : settings_.groups) {
      if (status && settings_.stopping && settings_.stopping()) {
        status = fail(ErrorCode::kTimeout, "{}: stopped while it joined its groups", settings_.name);
      }
      if (!status) break;
      status = join(group, interface_index);
    }
    if (status) {
      joined_interfaces_.insert(interface_index);
    } else {
      forget(interface_index);
      join_trouble_ = status.error().message;
      join_refused_ = status.error();
    }
  }
}

Status NetSource::add_group(std::uint32_t group) {
  if (std::find(settings_.groups.begin(), settings_.groups.end(), group) != settings_.groups.end()) return {};
  Status first;
  for (const int interface_index : joined_interfaces_) {
    if (Status status = join(group, interface_index); !status && first) first = status;
  }
  settings_.groups.push_back(group);
  return first;
}

void NetSource::drop_group(std::uint32_t group) {
  leave([group](const Membership& m) { return m.group == group; });
  settings_.groups.erase(std::remove(settings_.groups.begin(), settings_.groups.end(), group), settings_.groups.end());
}

template <class Condition>
void NetSource::leave(Condition condition) {
  for (auto membership = memberships_.rbegin(); membership != memberships_.rend(); ++membership) {  // newest first
    if (!condition(*membership)) continue;
    leave_group(sockets_[membership->socket].fd, membership->group, membership->interface_index);
    --sockets_[membership->socket].groups;
    first_with_room_ = std::min(first_with_room_, membership->socket);
  }
  memberships_.erase(std::remove_if(memberships_.begin(), memberships_.end(), condition), memberships_.end());
}

void NetSource::forget(int interface_index) {
  leave([interface_index](const Membership& m) { return m.interface_index == interface_index; });
  joined_interfaces_.erase(interface_index);
}

PortState NetSource::state() const {
  if (polled_ns_ - settings_.silence_max_ns < received_ns_) return PortState::kWorking;
  // One working interface is enough to wait for frames.
  const bool no_groups = !settings_.groups.empty() && joined_interfaces_.empty();
  return no_groups && !join_trouble_.empty() ? PortState::kGone : PortState::kWaiting;
}

std::string NetSource::trouble() const { return state() == PortState::kGone ? join_trouble_ : std::string(); }

void NetSource::deliver(const FrameView& frame, FrameReceiver& receiver) {
  ++counters_.frames;
  received_ns_ = polled_ns_;
  receiver.receive(frame);
}

void NetSource::read_socket(std::size_t index, TimeNs now_ns, FrameReceiver& receiver) {
  for (int batch = 0; batch < kBatchesMax; ++batch) {
    const int count = reader_.read(sockets_[index].fd.get());
    if (count < 0) {
      // For example ENETDOWN, reported once; the socket works again when the interface is back.
      ++counters_.errors;
      return;
    }
    if (count == 0) return;
    const std::uint32_t drops = reader_.kernel_drops();
    for (int i = 0; i < count; ++i) {
      const Datagram& datagram = reader_[static_cast<std::size_t>(i)];
      if (datagram.truncated) {
        ++counters_.rejected;
        continue;
      }
      // A group that other programs on this machine have joined elsewhere; see Socket.
      if (is_multicast(datagram.to_ipv4) && !joined_interfaces_.contains(datagram.interface_index)) continue;
      const TimeNs stamp_ns = now_ns - datagram.age_ns;
      if (inbox_.shared && is_unicast(datagram)) {
        settings_.own_senders->unicast().pass_on(inbox_, datagram, stamp_ns);
      }
      if (is_for_us(datagram)) take(datagram, stamp_ns, receiver);
    }
    counters_.dropped += static_cast<std::uint32_t>(drops - sockets_[index].kernel_drops);
    sockets_[index].kernel_drops = drops;
    if (static_cast<std::size_t>(count) < DatagramReader::kBatch) return;
  }
}

Status NetSource::watch(int fd) {
  if (watch_readable(epoll_, fd, kOtherTag)) return {};
  return tl::unexpected(net_error(settings_.name, "watch a line", errno));
}

Status NetSource::poll(TimeNs now_ns, FrameReceiver& receiver) {
  polled_ns_ = now_ns;
  std::array<epoll_event, 64> events;
  const int count = epoll_wait(epoll_.get(), events.data(), static_cast<int>(events.size()), 0);
  if (count < 0 && errno != EINTR) {
    return tl::unexpected(net_error(settings_.name, "wait for datagrams", errno));
  }
  bool interfaces_changed = false;
  for (int i = 0; i < count; ++i) {
    const std::uint64_t tag = events[static_cast<std::size_t>(i)].data.u64;
    if (tag == kWatchTag) {
      interfaces_changed = true;
    } else if (tag == kInboxTag) {
      read_inbox(receiver);
    } else if (tag != kOtherTag) {
      read_socket(static_cast<std::size_t>(tag), now_ns, receiver);
    }
  }
  if (interfaces_changed) {
    std::vector<int> lost;
    watch_.read(lost);
    for (const int interface_index : lost) forget(interface_index);
    // Does not end the port: the interface may come back, and unicast may work.
    join_missing();
    if (join_refused_) ++counters_.errors;
  }
  return {};
}

}  // namespace footlight::drivers
