#include "drivers/net/artnet_sink.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "drivers/net/hash.h"
#include "drivers/net/net_source.h"

namespace footlight::drivers {
namespace {

// Op codes that a sink uses; the kernel drops all other broadcasts.
constexpr std::array<std::uint16_t, 2> kPollOpCodes = {kArtnetOpPoll, kArtnetOpPollReply};
// Per poll(). Remaining datagrams make the descriptor readable again at once.
constexpr int kReplyBatchesMax = 4;

std::uint32_t broadcast_of(const Interface& one) { return one.loopback ? kLoopbackBroadcast : one.broadcast; }

}  // namespace

Result<std::unique_ptr<ArtnetSink>> ArtnetSink::create(const ArtnetSinkOptions& options) {
  FL_TRY(check_universes(options.name, options.universes, kArtnetUniverseMax));
  const bool is_searching = options.addresses.empty();
  FL_ASSIGN(auto ipv4s, parse_ipv4_list(options.name, options.addresses));
  if (is_searching) {
    for (const auto& interface_name : options.interface_names) {
      FL_ASSIGN(const Interface leaving, find_interface(options.name, interface_name));
      if (broadcast_of(leaving) != 0) ipv4s.push_back(broadcast_of(leaving));
    }
    for (const auto& candidate : list_interfaces()) {
      if (!ipv4s.empty() || !options.interface_names.empty()) break;
      if (candidate.up && !candidate.loopback && candidate.broadcast != 0) ipv4s.push_back(candidate.broadcast);
    }
  }
  if (ipv4s.empty()) {
    return fail(ErrorCode::kNotFound,
                "{}: no network interface with a broadcast address is up; name the receivers, as in "
                "\"artnet:1-9@10.0.0.255\"",
                options.name);
  }
  SenderSocket wanted;
  wanted.port_name = options.name;
  // If another program holds the port exclusively, a port of our own is used: devices that answer to it are found.
  auto socket =
      is_searching ? open_yielding_sender(wanted, options.port, kPollOpCodes) : open_send_only(wanted, options.port);
  if (!socket) socket = open_sender(wanted);
  if (!socket) return tl::unexpected(std::move(socket).error());
  // The routing table selects the interface for an address, so one socket is enough.
  std::vector<Link> links;
  links.push_back({std::move(*socket), {}});
  std::vector<Destination> destinations;
  for (const std::uint32_t ipv4 : ipv4s) destinations.push_back({ipv4, 0});
  FL_TRY(check_routes(options.name, links, destinations));
  return std::unique_ptr<ArtnetSink>(new ArtnetSink(options, ipv4s, std::move(links)));
}

ArtnetSink::ArtnetSink(const ArtnetSinkOptions& options, const std::vector<std::uint32_t>& broadcasts,
                       std::vector<Link> links)
    : NetSink(options, std::move(links)),
      options_(options),
      program_(options.own_senders ? options.own_senders : std::make_shared<OwnSenders>()),
      own_frames_(program_->artnet().add_sink()),
      sequences_(options.universes.size(), 1),
      seed_(artnet_machine_seed()) {
  for (const std::uint32_t ipv4 : broadcasts) broadcasts_.push_back({ipv4, 0});
  for (std::size_t place = 0; place < options.universes.size(); ++place) {
    port_addresses_.push_back(artnet_port_address(options.universes[place].wire));
    if (!is_searching() || options_.unsubscribed == ArtnetUnsubscribed::kBroadcast) {
      set_destinations(place, broadcasts_);
    }
  }
  build_artnet_sync(sync_packet_);
  if (!is_searching()) return;
  reader_ = std::make_unique<DatagramReader>();
  next_poll_ns_ = 0;
}

std::vector<std::uint32_t> ArtnetSink::receivers_of(std::size_t place) const {
  std::vector<std::uint32_t> ipv4s;
  for (const Destination& destination : destinations(place)) ipv4s.push_back(destination.ipv4);
  return ipv4s;
}

int ArtnetSink::poll_fd() const { return is_searching() && is_open() ? socket().get() : -1; }

TimeNs ArtnetSink::next_deadline_ns() const {
  return std::min({NetSink::next_deadline_ns(), next_poll_ns_, answers_.next_due_ns()});
}

Status ArtnetSink::send(TimeNs now_ns, std::span<const FrameView> frames) {
  follow_nodes(now_ns);
  return NetSink::send(now_ns, frames);
}

Status ArtnetSink::poll(TimeNs now_ns) {
  if (is_searching() && is_open()) {
    read_socket(now_ns);
    if (next_poll_ns_ <= now_ns) poll_networks(now_ns);
    answers_.answer_due(now_ns, [&](ArtnetAnswers::Requester& requester) { return answer(requester); });
    follow_nodes(now_ns);
  }
  return NetSink::poll(now_ns);
}

void ArtnetSink::close(TimeNs now_ns) {
  NetSink::close(now_ns);
  next_poll_ns_ = kTimeNever;
  answers_ = {};
}

void ArtnetSink::read_socket(TimeNs now_ns) {
  for (int batch = 0; batch < kReplyBatchesMax; ++batch) {
    const int count = reader_->read(socket().get());
    if (count < 0) count_error();
    for (int i = 0; i < count; ++i) {
      const Datagram& datagram = (*reader_)[static_cast<std::size_t>(i)];
      const auto packet = parse_artnet_packet(datagram.bytes);
      if (!packet) {
        count_rejected();
        continue;
      }
      const TimeNs arrived_ns = now_ns - datagram.age_ns;
      if (const auto* reply = std::get_if<ArtnetPollReply>(&*packet)) {
        ++details_.replies;
        program_->artnet().receive(*reply, datagram, arrived_ns);
      } else if (const auto* poll = std::get_if<ArtnetPoll>(&*packet)) {
        // A source answers for the whole program.
        const bool is_own = is_from_here(datagram) && program_->artnet().is_own_poll(arrived_ns);
        if (!is_own && !program_->artnet().has_sources() && (poll->flags & kArtnetPollTargeted) == 0) {
          answers_.add(*poll, datagram, seed_, now_ns);
        }
      }
    }
    if (count < static_cast<int>(DatagramReader::kBatch)) return;
  }
}

void ArtnetSink::poll_networks(TimeNs now_ns) {
  const auto jitter_ns =
      static_cast<DurationNs>(mix64(seed_ ^ ++poll_count_) % static_cast<std::uint64_t>(kArtnetPollJitterNs));
  next_poll_ns_ = now_ns + kArtnetPollIntervalNs + jitter_ns;
  program_->artnet().nodes.expire(now_ns);
  // Interfaces change: poll those present now.
  own_ipv4s_.clear();
  polled_.clear();
  interfaces_.clear();
  for (const auto& candidate : list_interfaces()) {
    own_ipv4s_.push_back(candidate.ipv4);
    const auto& names = options_.interface_names;
    const bool wanted = names.empty() ? candidate.up && !candidate.loopback
                                      : std::count(names.begin(), names.end(), candidate.name) != 0;
    if (wanted && !names.empty()) interfaces_.push_back(candidate.index);
    const std::uint32_t broadcast = broadcast_of(candidate);
    if (!wanted || broadcast == 0 || std::count(polled_.begin(), polled_.end(), broadcast) != 0) continue;
    polled_.push_back(broadcast);
  }
  // Interfaces are listed, and all are gone: no device is on them.
  if (!options_.interface_names.empty() && interfaces_.empty()) interfaces_.push_back(-1);
  std::array<std::uint8_t, kArtnetPollBytesMin> packet;
  build_artnet_poll(kArtnetPollOnChange, packet);
  for (const std::uint32_t broadcast : polled_) {
    if (!program_->artnet().may_poll(broadcast, now_ns)) continue;
    writer_.add(packet, broadcast, options_.port);
    ++details_.polls;
  }
  std::vector<int> error_numbers;
  writer_.flush_each(socket().get(), error_numbers);
  for (const int error_number : error_numbers) {
    if (error_number != 0) count_error();
  }
}

void ArtnetSink::follow_nodes(TimeNs now_ns) {
  const ArtnetNodes& nodes = program_->artnet().nodes;
  if (!is_searching() || revision_ == nodes.revision()) return;
  revision_ = nodes.revision();
  any_here_ = false;
  for (std::size_t place = 0; place < port_addresses_.size(); ++place) {
    std::vector<std::uint32_t> receivers;
    nodes.subscribers_of(port_addresses_[place], true, interfaces_, receivers);
    // An input port does not need the levels that it sends, but counts as a subscriber to its port address. If there is
    // no other subscriber, devices without poll replies must still get the broadcast.
    const bool anybody = !receivers.empty();
    nodes.subscribers_of(port_addresses_[place], false, interfaces_, receivers);
    bool here = false;
    for (std::uint32_t& ipv4 : receivers) {
      if (!is_loopback(ipv4) && std::count(own_ipv4s_.begin(), own_ipv4s_.end(), ipv4) == 0) continue;
      ipv4 = kLoopbackBroadcast;
      here = true;
    }
    std::sort(receivers.begin(), receivers.end());
    receivers.erase(std::unique(receivers.begin(), receivers.end()), receivers.end());
    std::vector<Destination> wanted;
    for (const std::uint32_t ipv4 : receivers) wanted.push_back({ipv4, 0});
    const bool fall_back = !anybody && options_.unsubscribed == ArtnetUnsubscribed::kBroadcast;
    if (fall_back || receivers.size() > kArtnetSubscribersMax) {
      wanted = broadcasts_;
      here = false;  // a broadcast reaches this machine anyway
    }
    any_here_ |= here;
    const auto known = receivers_of(place);
    const bool anybody_new = std::any_of(wanted.begin(), wanted.end(), [&](const Destination& each) {
      return std::find(known.begin(), known.end(), each.ipv4) == known.end();
    });
    set_destinations(place, std::move(wanted));
    if (anybody_new) send_again(place, now_ns);
  }
}

std::size_t ArtnetSink::write_packet(const Packet& packet) {
  ArtnetDmx dmx;
  dmx.sequence = sequences_[packet.place];
  dmx.port_address = port_addresses_[packet.place];
  dmx.slots = packet.slots;
  sequences_[packet.place] = dmx.sequence == 255 ? 1 : static_cast<std::uint8_t>(dmx.sequence + 1);
  const std::size_t size = build_artnet_dmx(dmx, packet.bytes);
  if (program_->artnet().has_sources()) {
    const auto sent_slots = packet.bytes.first(size).subspan(kArtnetDmxHeaderBytes);
    own_frames_->note(dmx.port_address, dmx.sequence, artnet_digest(sent_slots));
  }
  return size;
}

void ArtnetSink::add_after(TimeNs now_ns, std::span<const std::size_t> /*places*/) {
  if (!options_.sync) return;
  program_->artnet().note_sync(now_ns);
  std::vector<Destination> to;
  for (const std::uint32_t broadcast : polled_) to.push_back({broadcast, 0});
  if (to.empty()) to = broadcasts_;
  // Frames for this machine came from loopback, and a sync is accepted only from the same address.
  if (any_here_ && std::count(polled_.begin(), polled_.end(), kLoopbackBroadcast) == 0) {
    to.push_back({kLoopbackBroadcast, 0});
  }
  add(sync_packet_, to);
  details_.sync += to.size();
}

bool ArtnetSink::answer(const ArtnetAnswers::Requester& requester) {
  ArtnetPollReply reply;
  reply.ip = octets_of(requester.local_ipv4);
  reply.mac = mac_of(requester.interface_index);
  reply.style = ArtnetPollReply::Style::kController;
  reply.short_name = options_.node_name;
  reply.long_name = options_.node_name;
  const std::string report = fmt::format("#0001 [{:04}] sending", ++details_.polls_answered % 10'000);
  reply.report = report;
  std::array<std::uint8_t, kArtnetPollReplyBytes> packet;
  build_artnet_poll_reply(reply, packet);
  add_artnet_reply(writer_, packet, requester, options_.port);
  if (writer_.flush(socket().get()).error_number != 0) count_error();
  return true;
}

Result<std::unique_ptr<Sink>> make_artnet_sink(const ArtnetSinkOptions& options) { return ArtnetSink::create(options); }

}  // namespace footlight::drivers
