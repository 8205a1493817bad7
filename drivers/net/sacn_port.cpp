#include "drivers/net/sacn_port.h"

#include <variant>

#include "drivers/net/hash.h"

namespace footlight::drivers {

Result<std::unique_ptr<SacnSource>> SacnSource::create(const SacnSourceOptions& options) {
  FL_TRY(check_universes(options.name, options.universes, kUniverseMax));
  std::unique_ptr<SacnSource> source(new SacnSource(options));
  FL_TRY(source->open());
  return source;
}

SacnSource::SacnSource(const SacnSourceOptions& options)
    : NetSource([&] {
        Settings settings;
        settings.name = options.name;
        settings.universes = options.universes;
        settings.addresses = options.addresses;
        settings.interface_names = options.interface_names;
        settings.udp_port = options.port;
        settings.kernel_stamps = options.kernel_stamps;
        for (const auto& universe : options.universes) settings.groups.push_back(sacn_group_ipv4(universe.wire));
        return settings;
      }()),
      hear_preview_(options.hear_preview),
      own_senders_(options.own_senders),
      filters_(options.universes.size()) {}

void SacnSource::take(const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& receiver) {
  const auto packet = parse_sacn_packet(datagram.bytes);
  if (!packet) {
    count_rejected();
  } else if (const auto* data = std::get_if<SacnData>(&*packet)) {
    take_data(*data, stamp_ns, receiver);
  } else if (std::holds_alternative<SacnSync>(*packet)) {
    ++details_.sync;
  } else {
    ++details_.discovery;
  }
}

void SacnSource::take_data(const SacnData& data, TimeNs stamp_ns, FrameReceiver& receiver) {
  const int place = place_of(data.universe);
  if (place < 0) {
    ++details_.other_universe;
    return;
  }
  if (own_senders_ && own_senders_->has_cid(data.cid)) {
    ++details_.own;
    return;
  }
  if (data.start_code != kStartCodeLevels) {
    ++details_.other_start_code;
    return;
  }
  if (data.preview && !hear_preview_) {
    ++details_.preview;
    return;
  }
  const SenderId sender = sender_hash(data.cid);
  const auto verdict =
      filters_[static_cast<std::size_t>(place)].judge(sender, data.sequence, data.terminated, true, stamp_ns);
  if (verdict == SequenceFilter::Verdict::kLate) {
    ++details_.late;
    return;
  }
  if (verdict == SequenceFilter::Verdict::kEndedAlready) {
    ++details_.ended_already;
    return;
  }
  FrameView frame;
  frame.universe = show_universe(place);
  frame.stamp_ns = stamp_ns;
  frame.sender = sender;
  frame.sequence = data.sequence;
  frame.priority = data.priority;
  frame.terminated = data.terminated;
  if (!data.terminated) frame.slots = data.slots;
  deliver(frame, receiver);
}

Result<std::unique_ptr<SacnSink>> SacnSink::create(const SacnSinkOptions& options) {
  FL_TRY(check_universes(options.name, options.universes, kUniverseMax));
  if (options.priority > kPriorityMax) {
    return fail(ErrorCode::kBadInput, "{}: expected a priority from 0 to {}, got {}", options.name, kPriorityMax,
                options.priority);
  }
  if (options.multicast_ttl < 1 || options.multicast_ttl > 255) {
    return fail(ErrorCode::kBadInput, "{}: expected a multicast time to live from 1 to 255, got {}", options.name,
                options.multicast_ttl);
  }
  FL_ASSIGN(const auto unicast, parse_ipv4_list(options.name, options.addresses));
  FL_ASSIGN(auto links, open_links(options.name, options.interface_names, options.multicast_ttl));
  std::unique_ptr<SacnSink> sink(new SacnSink(options, std::move(links), unicast));
  FL_TRY(check_routes(options.name, sink->links(), sink->destinations(0)));
  if (options.own_senders) options.own_senders->add_cid(sink->cid());
  return sink;
}

SacnSink::SacnSink(const SacnSinkOptions& options, std::vector<Link> links, std::span<const std::uint32_t> unicast)
    : NetSink({options.name, options.universes, options.port, options.rate_hz_max}, std::move(links)),
      cid_(sacn_cid_of(options)),
      sequences_(options.universes.size(), 0) {
  for (std::size_t place = 0; place < options.universes.size(); ++place) {
    SacnData data;
    data.cid = cid_;
    data.source_name = options.source_name;
    data.priority = options.priority;
    data.preview = options.preview;
    data.universe = options.universes[place].wire;
    build_sacn_data(data, packet_bytes(place));
    set_destinations(place, destinations_of(data.universe, unicast));
  }
}

std::vector<NetSink::Destination> SacnSink::destinations_of(int universe,
                                                            std::span<const std::uint32_t> unicast) const {
  std::vector<Destination> destinations;
  for (const std::uint32_t ipv4 : unicast) destinations.push_back({ipv4, 0});
  if (!unicast.empty()) return destinations;
  for (std::size_t link = 0; link < links().size(); ++link) {
    destinations.push_back({sacn_group_ipv4(universe), static_cast<std::uint8_t>(link)});
  }
  return destinations;
}

std::size_t SacnSink::write_packet(const Packet& packet) {
  return update_sacn_data(packet.bytes, sequences_[packet.place]++, packet.terminated, packet.slots);
}

Result<std::unique_ptr<Source>> make_sacn_source(const SacnSourceOptions& options) {
  return SacnSource::create(options);
}

Result<std::unique_ptr<Sink>> make_sacn_sink(const SacnSinkOptions& options) { return SacnSink::create(options); }

}  // namespace footlight::drivers
