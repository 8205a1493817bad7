#include "drivers/net/artnet_port.h"

#include <algorithm>
#include <array>
#include <map>
#include <variant>

#include "drivers/net/bytes.h"
#include "drivers/net/hash.h"

namespace footlight::drivers {
namespace {

constexpr int kBindIndexMax = 255;
// Data older than this no longer counts as coming in (Art-Net 4 repeats unchanged data every 4 s).
constexpr DurationNs kActiveNs = 10 * kNsPerS;

std::array<std::uint8_t, 4> octets_of(std::uint32_t ipv4) {
  std::array<std::uint8_t, 4> octets = {};
  write_u32_be(octets, 0, ipv4);
  return octets;
}

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
        Settings settings;
        settings.name = options.name;
        settings.universes = options.universes;
        settings.addresses = options.addresses;
        settings.interface_names = options.interface_names;
        settings.udp_port = options.port;
        settings.kernel_stamps = options.kernel_stamps;
        settings.packet_info = true;
        return settings;
      }()),
      options_(options),
      filters_(options.universes.size()),
      heard_ns_(options.universes.size(), -kActiveNs) {
  std::map<int, std::vector<std::size_t>> by_net_and_subnet;
  for (std::size_t place = 0; place < options.universes.size(); ++place) {
    by_net_and_subnet[artnet_port_address(options.universes[place].wire) >> 4].push_back(place);
  }
  for (const auto& [upper, places] : by_net_and_subnet) {
    for (std::size_t first = 0; first < places.size(); first += kArtnetReplyPortsMax) {
      const std::size_t last = std::min(first + kArtnetReplyPortsMax, places.size());
      groups_.push_back(
          {{places.begin() + static_cast<std::ptrdiff_t>(first), places.begin() + static_cast<std::ptrdiff_t>(last)}});
    }
  }
}

void ArtnetSource::take(const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& receiver) {
  const auto packet = parse_artnet_packet(datagram.bytes);
  if (!packet) {
    count_rejected();
    return;
  }
  if (!hears_interface(datagram.interface_index)) {
    ++details_.other_interface;
    return;
  }
  if (const auto* dmx = std::get_if<ArtnetDmx>(&*packet)) {
    take_dmx(*dmx, datagram, stamp_ns, receiver);
  } else if (const auto* poll = std::get_if<ArtnetPoll>(&*packet)) {
    ++details_.polls;
    if (options_.answer_polls) answer(*poll, datagram, stamp_ns);
  } else if (std::holds_alternative<ArtnetSync>(*packet)) {
    ++details_.sync;
  } else {
    ++details_.other_op_code;
  }
}

void ArtnetSource::take_dmx(const ArtnetDmx& dmx, const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& receiver) {
  const int place = place_of(artnet_wire_universe(dmx.port_address));
  if (place < 0) {
    ++details_.other_universe;
    return;
  }
  // Sinks of this program send from a port of their own; the address is checked too, as another machine may use the
  // same port. A datagram that left here comes back from the address that it arrives at.
  if (options_.own_senders && options_.own_senders->has_udp_port(datagram.from_udp_port) &&
      datagram.from_ipv4 == datagram.local_ipv4) {
    ++details_.own;
    return;
  }
  const auto at = static_cast<std::size_t>(place);
  const SenderId sender = sender_hash(octets_of(datagram.from_ipv4));
  if (dmx.sequence != 0 &&
      filters_[at].judge(sender, dmx.sequence, false, false, stamp_ns) == SequenceFilter::Verdict::kLate) {
    ++details_.late;
    return;
  }
  heard_ns_[at] = stamp_ns;
  FrameView frame;
  frame.universe = show_universe(place);
  frame.stamp_ns = stamp_ns;
  frame.sender = sender;
  frame.sequence = dmx.sequence;
  frame.priority = options_.priority;
  frame.slots = dmx.slots;
  deliver(frame, receiver);
}

void ArtnetSource::answer(const ArtnetPoll& poll, const Datagram& datagram, TimeNs now_ns) {
  std::array<std::uint8_t, 6> mac = {};
  for (const auto& candidate : list_interfaces()) {
    if (candidate.index == datagram.interface_index) mac = candidate.mac;
  }
  ++details_.polls_answered;
  const std::string report = fmt::format("#0001 [{:04}] receiving", details_.polls_answered % 10'000);
  const std::size_t count = std::min<std::size_t>(groups_.size(), kBindIndexMax);
  std::vector<std::array<std::uint8_t, kArtnetPollReplyBytes>> replies(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::array<ArtnetPollReply::Port, kArtnetReplyPortsMax> ports;
    const auto& places = groups_[i].places;
    bool wanted = false;
    for (std::size_t p = 0; p < places.size(); ++p) {
      ports[p].port_address = artnet_port_address(options_.universes[places[p]].wire);
      ports[p].active = now_ns - heard_ns_[places[p]] < kActiveNs;
      wanted |= ports[p].port_address >= poll.port_address_first && ports[p].port_address <= poll.port_address_last;
    }
    if (!wanted) continue;
    ArtnetPollReply reply;
    reply.ip = octets_of(datagram.local_ipv4);
    reply.mac = mac;
    reply.short_name = options_.node_name;
    reply.long_name = options_.node_name;
    reply.report = report;
    reply.bind_index = static_cast<std::uint8_t>(i + 1);
    reply.ports = std::span(ports).first(places.size());
    build_artnet_poll_reply(reply, replies[i]);
    // Unicast to the asker: to the port of Art-Net, and to the one it asked from where that is another.
    writer_.add(replies[i], datagram.from_ipv4, options_.port);
    if (datagram.from_udp_port != options_.port) {
      writer_.add(replies[i], datagram.from_ipv4, datagram.from_udp_port);
    }
  }
  if (writer_.flush(first_socket().get()).error_number != 0) count_error();
}

Result<std::unique_ptr<ArtnetSink>> ArtnetSink::create(const ArtnetSinkOptions& options) {
  FL_TRY(check_universes(options.name, options.universes, kArtnetUniverseMax));
  FL_ASSIGN(auto ipv4s, parse_ipv4_list(options.name, options.addresses));
  if (ipv4s.empty()) {
    for (const auto& interface_name : options.interface_names) {
      FL_ASSIGN(const Interface leaving, find_interface(options.name, interface_name));
      if (leaving.broadcast != 0) ipv4s.push_back(leaving.broadcast);
    }
    for (const auto& candidate : list_interfaces()) {
      if (!ipv4s.empty() || !options.interface_names.empty()) break;
      if (candidate.up && !candidate.loopback && candidate.broadcast != 0) ipv4s.push_back(candidate.broadcast);
    }
  }
  if (ipv4s.empty()) {
    return fail(
        ErrorCode::kNotFound,
        "{}: no network interface with a broadcast address is up; say where to send, as in \"artnet:1-9@10.0.0.255\"",
        options.name);
  }
  std::vector<Destination> destinations;
  for (const std::uint32_t ipv4 : ipv4s) destinations.push_back({ipv4, 0});
  // Broadcast addresses find their interface by themselves, so one socket is enough.
  FL_ASSIGN(auto links, open_links(options.name, {}, kMulticastTtlDefault));
  FL_TRY(check_routes(options.name, links, destinations));
  if (options.own_senders) options.own_senders->add_udp_port(local_udp_port(links.front().socket));
  return std::unique_ptr<ArtnetSink>(new ArtnetSink(options, destinations, std::move(links)));
}

ArtnetSink::ArtnetSink(const ArtnetSinkOptions& options, const std::vector<Destination>& destinations,
                       std::vector<Link> links)
    : NetSink({options.name, options.universes, options.port, options.rate_hz_max}, std::move(links)),
      sequences_(options.universes.size(), 1) {
  for (const auto& universe : options.universes) port_addresses_.push_back(artnet_port_address(universe.wire));
  for (std::size_t place = 0; place < options.universes.size(); ++place) set_destinations(place, destinations);
}

std::size_t ArtnetSink::write_packet(const Packet& packet) {
  ArtnetDmx dmx;
  dmx.sequence = sequences_[packet.place];
  dmx.port_address = port_addresses_[packet.place];
  dmx.slots = packet.slots;
  sequences_[packet.place] = dmx.sequence == 255 ? 1 : static_cast<std::uint8_t>(dmx.sequence + 1);
  return build_artnet_dmx(dmx, packet.bytes);
}

Result<std::unique_ptr<Source>> make_artnet_source(const ArtnetSourceOptions& options) {
  return ArtnetSource::create(options);
}

Result<std::unique_ptr<Sink>> make_artnet_sink(const ArtnetSinkOptions& options) { return ArtnetSink::create(options); }

}  // namespace footlight::drivers
