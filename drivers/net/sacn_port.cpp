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
        settings.address = options.address;
        settings.interface_name = options.interface_name;
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
  std::vector<std::uint32_t> destinations;
  if (options.address.empty()) {
    for (const auto& universe : options.universes) destinations.push_back(sacn_group_ipv4(universe.wire));
  } else {
    FL_ASSIGN(const std::uint32_t ipv4, parse_ipv4(options.name, options.address));
    destinations.assign(options.universes.size(), ipv4);
  }
  SenderSocket wanted;
  wanted.port_name = options.name;
  if (!options.interface_name.empty()) {
    FL_ASSIGN(const Interface leaving, find_interface(options.name, options.interface_name));
    wanted.interface_index = leaving.index;
  }
  if (const int error_number = route_error(destinations.front(), wanted.interface_index); error_number != 0) {
    return tl::unexpected(
        net_error(options.name, fmt::format("send to {}", text_of_ipv4(destinations.front())), error_number));
  }
  FL_ASSIGN(Fd socket, open_sender(wanted));
  std::unique_ptr<SacnSink> sink(new SacnSink(options, std::move(destinations), std::move(socket)));
  if (options.own_senders) options.own_senders->add_cid(sink->cid());
  return sink;
}

SacnSink::SacnSink(const SacnSinkOptions& options, std::vector<std::uint32_t> destinations, Fd socket)
    : NetSink({options.name, options.universes, options.interface_name, options.port, options.rate_hz_max},
              std::move(destinations), std::move(socket)),
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
  }
}

std::size_t SacnSink::write_packet(const Packet& packet) {
  return update_sacn_data(packet.bytes, sequences_[packet.place]++, packet.terminated, packet.slots);
}

Result<std::unique_ptr<Source>> make_sacn_source(const SacnSourceOptions& options) {
  return SacnSource::create(options);
}

Result<std::unique_ptr<Sink>> make_sacn_sink(const SacnSinkOptions& options) { return SacnSink::create(options); }

}  // namespace footlight::drivers
