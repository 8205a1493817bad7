#include "drivers/net/artnet_source.h"

#include <algorithm>
#include <variant>

#include "drivers/net/bytes.h"
#include "drivers/net/hash.h"

namespace footlight::drivers {
namespace {

constexpr std::size_t kBindIndexMax = 255;
// How often the state of ports is checked while there are subscribers to changes.
constexpr DurationNs kWatchIntervalNs = 250 * kNsPerMs;
constexpr DurationNs kNameRetryNs = 30 * kNsPerS;

}  // namespace

Result<std::unique_ptr<ArtnetSource>> ArtnetSource::create(const ArtnetSourceOptions& options) {
  FL_TRY(check_universes(options.name, options.universes, kArtnetUniverseMax));
  if (options.priority > kPriorityMax) {
    return fail(ErrorCode::kBadInput, "{}: expected a priority from 0 to {}, got {}", options.name, kPriorityMax,
                options.priority);
  }
  std::unique_ptr<ArtnetSource> source(new ArtnetSource(options));
  FL_TRY(source->open());
  return source;
}

ArtnetSource::ArtnetSource(const ArtnetSourceOptions& options)
    : NetSource([&] {
        Settings settings(options);
        settings.silence_max_ns = kArtnetSilenceMaxNs;
        return settings;
      }()),
      options_(options),
      program_(options.own_senders ? options.own_senders : std::make_shared<OwnSenders>()),
      states_(options.universes.size()),
      seed_(artnet_machine_seed()) {
  std::map<int, std::vector<std::size_t>> by_net_and_subnet;
  for (std::size_t place = 0; place < options.universes.size(); ++place) {
    port_addresses_.push_back(artnet_port_address(options.universes[place].wire));
    by_net_and_subnet[port_addresses_.back() >> 4].push_back(place);
  }
  // Art-Net 4 recommends one port per reply, and the bind index counts to 255.
  const std::size_t at_once = options.universes.size() <= kBindIndexMax ? 1 : kArtnetReplyPortsMax;
  for (const auto& [upper, places] : by_net_and_subnet) {
    for (std::size_t first = 0; first < places.size(); first += at_once) {
      const std::size_t last = std::min(first + at_once, places.size());
      groups_.emplace_back(places.begin() + static_cast<std::ptrdiff_t>(first),
                           places.begin() + static_cast<std::ptrdiff_t>(last));
    }
  }
  groups_.resize(std::min(groups_.size(), kBindIndexMax));
  if (options.rdm_directory) {
    gateway_ = std::make_unique<ArtnetGateway>(options.rdm_directory);
    gateway_->on_new_descriptor = [this](int fd) {
      if (!watch(fd)) count_error();
    };
    for (std::size_t group = 0; group < groups_.size(); ++group) {
      for (std::size_t i = 0; i < groups_[group].size(); ++i) {
        const std::size_t place = groups_[group][i];
        gateway_->add_universe(port_addresses_[place], show_universe(static_cast<int>(place)),
                               static_cast<std::uint8_t>(group + 1), static_cast<std::uint8_t>(i + 1));
      }
    }
  }
  program_->artnet().add_source(port_addresses_);
}

ArtnetSource::~ArtnetSource() { program_->artnet().remove_source(port_addresses_); }

TimeNs ArtnetSource::next_deadline_ns() const {
  TimeNs next_ns = std::min(answers_.next_due_ns(), next_watch_ns_);
  if (!held_places_.empty()) {
    for (const Sync& sync : syncs_) next_ns = std::min(next_ns, sync.until_ns);
  }
  return next_ns;
}

Status ArtnetSource::poll(TimeNs now_ns, FrameReceiver& receiver) {
  FL_TRY(NetSource::poll(now_ns, receiver));
  if (std::erase_if(syncs_, [&](const Sync& sync) { return sync.until_ns <= now_ns; }) > 0) {
    const auto places = held_places_;
    for (const std::size_t place : places) {
      if (!is_synchronous(states_[place].held->ipv4, now_ns)) release(place, now_ns, receiver);
    }
  }
  answers_.answer_due(now_ns, [&](ArtnetAnswers::Requester& requester) { return answer(requester, now_ns); });
  if (next_watch_ns_ <= now_ns) report_changes(now_ns);
  if (gateway_) {
    gateway_->take_news(rdm_replies_);
    send_rdm();
  }
  return {};
}

void ArtnetSource::send_rdm() {
  for (const auto& reply : rdm_replies_) add_artnet_reply(writer_, reply.bytes, reply.to, options_.port);
  if (!rdm_replies_.empty() && writer_.flush(first_socket().get()).error_number != 0) count_error();
  rdm_replies_.clear();
}

std::string ArtnetSource::sender_text(SenderId sender) const {
  const auto found = ipv4_of_sender_.find(sender);
  if (found == ipv4_of_sender_.end()) return {};
  const std::string name = program_->artnet().nodes.name_of(found->second);
  const std::string address = text_of_ipv4(found->second);
  return name.empty() ? address : fmt::format("{} ({})", name, address);
}

void ArtnetSource::take(const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& receiver) {
  const auto packet = parse_artnet_packet(datagram.bytes);
  if (!packet) {
    count_rejected();
    return;
  }
  // Replies first: they may be for a sink of this program that uses another interface.
  if (const auto* reply = std::get_if<ArtnetPollReply>(&*packet)) {
    ++details_.replies;
    program_->artnet().receive(*reply, datagram, stamp_ns);
    return;
  }
  if (!receives_on(datagram.interface_index)) {
    ++details_.other_interface;
    return;
  }
  if (const auto* dmx = std::get_if<ArtnetDmx>(&*packet)) {
    take_dmx(*dmx, datagram, stamp_ns, receiver);
  } else if (const auto* poll = std::get_if<ArtnetPoll>(&*packet)) {
    take_poll(*poll, datagram, stamp_ns);
  } else if (std::holds_alternative<ArtnetSync>(*packet)) {
    take_sync(datagram, stamp_ns, receiver);
  } else if (const auto* other = std::get_if<ArtnetOther>(&*packet);
             gateway_ && other != nullptr && is_artnet_rdm(other->op_code)) {
    ++details_.rdm;
    if (const auto rdm = parse_artnet_rdm_packet(datagram.bytes)) {
      gateway_->take(*rdm, datagram, rdm_replies_);
      send_rdm();
    } else {
      count_rejected();
    }
  } else {
    ++details_.other_op_code;
  }
}

std::size_t ArtnetSource::live_senders(std::size_t place, TimeNs now_ns) const {
  const auto& senders = states_[place].senders;
  return static_cast<std::size_t>(std::count_if(senders.begin(), senders.end(), [&](const Sender& sender) {
    return now_ns - kArtnetSilenceMaxNs < sender.received_ns;
  }));
}

bool ArtnetSource::is_synchronous(std::uint32_t ipv4, TimeNs now_ns) const {
  return std::any_of(syncs_.begin(), syncs_.end(),
                     [&](const Sync& sync) { return sync.ipv4 == ipv4 && now_ns < sync.until_ns; });
}

void ArtnetSource::take_dmx(const ArtnetDmx& dmx, const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& receiver) {
  const int found = place_of(artnet_wire_universe(dmx.port_address));
  if (found < 0) {
    ++details_.other_universe;
    return;
  }
  // Other programs here may send from the same UDP port as sinks of this program.
  if (options_.own_senders && is_from_here(datagram) && program_->artnet().is_own_frame(dmx)) {
    ++details_.own;
    return;
  }
  const auto place = static_cast<std::size_t>(found);
  UniverseState& state = states_[place];
  const SenderId sender = sender_hash(octets_of(datagram.from_ipv4));
  if (dmx.sequence != 0 && state.filter.judge(sender, dmx.sequence, false, SequenceRule::kArtnet, stamp_ns) ==
                               SequenceFilter::Verdict::kLate) {
    ++details_.late;
    return;
  }
  auto known = std::find_if(state.senders.begin(), state.senders.end(),
                            [&](const Sender& each) { return each.ipv4 == datagram.from_ipv4; });
  if (known == state.senders.end()) {
    known = std::min_element(state.senders.begin(), state.senders.end(),
                             [](const Sender& a, const Sender& b) { return a.received_ns < b.received_ns; });
    known->ipv4 = datagram.from_ipv4;
    if (options_.request_names) request_name(datagram, stamp_ns);
    if (ipv4_of_sender_.size() < kNameRequestsMax) ipv4_of_sender_[sender] = datagram.from_ipv4;
  }
  known->received_ns = stamp_ns;

  if (!is_synchronous(datagram.from_ipv4, stamp_ns) || live_senders(place, stamp_ns) > 1) {
    release(place, stamp_ns, receiver);
    deliver_frame(place, datagram.from_ipv4, dmx.sequence, stamp_ns, dmx.slots, receiver);
    return;
  }
  if (!state.held) state.held = std::make_unique<Held>();
  Held& held = *state.held;
  ++details_.held;
  if (held.full) {
    count_dropped();
  } else {
    held.slot_count = 0;
    held.full = true;
    held_places_.push_back(place);
  }
  std::copy(dmx.slots.begin(), dmx.slots.end(), held.slots.begin());
  held.slot_count = std::max(held.slot_count, dmx.slots.size());
  held.ipv4 = datagram.from_ipv4;
  held.sequence = dmx.sequence;
}

void ArtnetSource::deliver_frame(std::size_t place, std::uint32_t ipv4, std::uint8_t sequence, TimeNs stamp_ns,
                                 std::span<const std::uint8_t> slots, FrameReceiver& receiver) {
  FrameView frame;
  frame.universe = show_universe(static_cast<int>(place));
  frame.stamp_ns = stamp_ns;
  frame.sender = sender_hash(octets_of(ipv4));
  frame.sequence = sequence;
  frame.priority = options_.priority;
  frame.silence_max_ns = kArtnetSilenceMaxNs;
  frame.slots = slots;
  deliver(frame, receiver);
}

void ArtnetSource::release(std::size_t place, TimeNs stamp_ns, FrameReceiver& receiver) {
  const auto& held = states_[place].held;
  if (!held || !held->full) return;
  held->full = false;
  std::erase(held_places_, place);
  deliver_frame(place, held->ipv4, held->sequence, stamp_ns, std::span(held->slots).first(held->slot_count), receiver);
}

void ArtnetSource::take_sync(const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& receiver) {
  if (options_.own_senders && is_from_here(datagram) && program_->artnet().is_own_sync(stamp_ns)) {
    ++details_.own;
    return;
  }
  const bool sends_to_us = std::any_of(states_.begin(), states_.end(), [&](const UniverseState& state) {
    return std::any_of(state.senders.begin(), state.senders.end(), [&](const Sender& sender) {
      return sender.ipv4 == datagram.from_ipv4 && stamp_ns - kArtnetSilenceMaxNs < sender.received_ns;
    });
  });
  if (!sends_to_us) {
    ++details_.sync_ignored;
    return;
  }
  ++details_.sync;
  auto known =
      std::find_if(syncs_.begin(), syncs_.end(), [&](const Sync& sync) { return sync.ipv4 == datagram.from_ipv4; });
  if (known == syncs_.end()) {
    if (syncs_.size() >= kSyncSendersMax) return;
    known = syncs_.insert(syncs_.end(), Sync{datagram.from_ipv4});
  }
  known->until_ns = stamp_ns + kArtnetSyncTimeoutNs;
  const auto places = held_places_;
  for (const std::size_t place : places) {
    if (states_[place].held->ipv4 == datagram.from_ipv4) release(place, stamp_ns, receiver);
  }
}

void ArtnetSource::request_name(const Datagram& datagram, TimeNs now_ns) {
  const auto last = requested_ns_.find(datagram.from_ipv4);
  if (last == requested_ns_.end() ? requested_ns_.size() >= kNameRequestsMax : now_ns - last->second < kNameRetryNs)
    return;
  if (!program_->artnet().nodes.name_of(datagram.from_ipv4).empty()) return;
  requested_ns_[datagram.from_ipv4] = now_ns;
  std::array<std::uint8_t, kArtnetPollBytesMin> poll;
  build_artnet_poll(0, poll);
  writer_.add(poll, is_from_here(datagram) ? kLoopbackBroadcast : datagram.from_ipv4, options_.port);
  if (writer_.flush(first_socket().get()).error_number != 0) count_error();
}

void ArtnetSource::take_poll(const ArtnetPoll& poll, const Datagram& datagram, TimeNs now_ns) {
  if (options_.own_senders && is_from_here(datagram) && program_->artnet().is_own_poll(now_ns)) {
    ++details_.own;
    return;
  }
  ++details_.polls;
  if (!options_.answer_polls) return;
  answers_.add(poll, datagram, seed_, now_ns);
  if ((poll.flags & kArtnetPollOnChange) == 0) {
    watchers_.erase(datagram.from_ipv4);
  } else if (watchers_.size() < ArtnetAnswers::kRequestersMax || watchers_.contains(datagram.from_ipv4)) {
    ArtnetAnswers::Requester& watcher = watchers_[datagram.from_ipv4];
    watcher.ipv4 = datagram.from_ipv4;
    watcher.udp_port = datagram.from_udp_port;
    watcher.local_ipv4 = datagram.local_ipv4;
    watcher.interface_index = datagram.interface_index;
    watcher.mac = mac_of(datagram.interface_index);
    watcher.is_here = is_from_here(datagram);
    watcher.port_address_first = poll.port_address_first;
    watcher.port_address_last = poll.port_address_last;
    watcher.due_ns = now_ns + kArtnetNodeTimeoutNs;
    if (next_watch_ns_ == kTimeNever) next_watch_ns_ = now_ns + kWatchIntervalNs;
  }
}

void ArtnetSource::build_reply(std::size_t group, const ArtnetAnswers::Requester& requester, TimeNs now_ns,
                               std::span<std::uint8_t> out) {
  const std::string report = fmt::format("#0001 [{:04}] receiving", details_.polls_answered % 10'000);
  ArtnetPollReply reply;
  reply.ip = octets_of(requester.local_ipv4);
  reply.mac = requester.mac;
  reply.short_name = options_.node_name;
  reply.long_name = options_.node_name;
  reply.report = report;
  reply.bind_index = static_cast<std::uint8_t>(group + 1);
  for (const std::size_t place : groups_[group]) {
    const std::size_t senders = live_senders(place, now_ns);
    reply.add({port_addresses_[place], true, senders > 0, senders > 1});
    reply.rdm |= gateway_ && gateway_->has_line(port_addresses_[place]);
  }
  build_artnet_poll_reply(reply, out);
}

bool ArtnetSource::answer(ArtnetAnswers::Requester& requester, TimeNs now_ns) {
  if (requester.next_reply == 0) {
    ++details_.polls_answered;
    requester.mac = mac_of(requester.interface_index);
  }
  std::array<std::array<std::uint8_t, kArtnetPollReplyBytes>, ArtnetAnswers::kRepliesAtOnce> replies;
  std::size_t count = 0;
  for (; requester.next_reply < groups_.size() && count < replies.size(); ++requester.next_reply) {
    const auto& places = groups_[requester.next_reply];
    const bool wanted = std::any_of(places.begin(), places.end(), [&](std::size_t place) {
      return port_addresses_[place] >= requester.port_address_first &&
             port_addresses_[place] <= requester.port_address_last;
    });
    if (!wanted) continue;
    build_reply(requester.next_reply, requester, now_ns, replies[count]);
    add_artnet_reply(writer_, replies[count], requester, options_.port);
    ++count;
  }
  if (writer_.flush(first_socket().get()).error_number != 0) count_error();
  requester.due_ns = now_ns + ArtnetAnswers::kPauseNs;
  return requester.next_reply >= groups_.size();
}

void ArtnetSource::report_changes(TimeNs now_ns) {
  std::erase_if(watchers_, [&](const auto& watcher) { return watcher.second.due_ns <= now_ns; });
  next_watch_ns_ = watchers_.empty() ? kTimeNever : now_ns + kWatchIntervalNs;
  for (std::size_t group = 0; group < groups_.size(); ++group) {
    bool changed = false;
    for (const std::size_t place : groups_[group]) {
      UniverseState& state = states_[place];
      const std::size_t senders = live_senders(place, now_ns);
      changed |= state.reported_active != (senders > 0) || state.reported_merging != (senders > 1);
      state.reported_active = senders > 0;
      state.reported_merging = senders > 1;
    }
    if (!changed) continue;
    std::vector<std::array<std::uint8_t, kArtnetPollReplyBytes>> replies(watchers_.size());
    std::size_t count = 0;
    for (const auto& [ipv4, watcher] : watchers_) {
      build_reply(group, watcher, now_ns, replies[count]);
      add_artnet_reply(writer_, replies[count], watcher, options_.port);
      ++count;
    }
    if (writer_.flush(first_socket().get()).error_number != 0) count_error();
  }
}

Result<std::unique_ptr<Source>> make_artnet_source(const ArtnetSourceOptions& options) {
  return ArtnetSource::create(options);
}

}  // namespace footlight::drivers
