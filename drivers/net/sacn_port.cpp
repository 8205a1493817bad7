#include "drivers/net/sacn_port.h"

#include <algorithm>

#include "drivers/net/sacn_discovery.h"

namespace footlight::drivers {
namespace {

// From the first frame to the first announcement, when the other universes have started.
constexpr DurationNs kFirstAnnounceNs = kNsPerS;

}  // namespace

Result<std::unique_ptr<SacnSource>> SacnSource::create(const SacnSourceOptions& options) {
  FL_TRY(check_universes(options.name, options.universes, kUniverseMax));
  std::unique_ptr<SacnSource> source(new SacnSource(options));
  FL_TRY(source->open());
  return source;
}

SacnSource::SacnSource(const SacnSourceOptions& options)
    : NetSource([&] {
        Settings settings(options);
        for (const auto& universe : options.universes) settings.groups.push_back(sacn_group_ipv4(universe.wire));
        return settings;
      }()),
      rules_({options.universes, options.hear_preview, options.own_senders}) {}

void SacnSource::take(const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& receiver) {
  // Counts the frames that pass the rules.
  class Outlet final : public FrameReceiver {
   public:
    Outlet(SacnSource& source, FrameReceiver& to) : source_(source), to_(to) {}
    void receive(const FrameView& frame) override { source_.deliver(frame, to_); }

   private:
    SacnSource& source_;
    FrameReceiver& to_;
  } outlet(*this, receiver);
  if (!rules_.take(datagram.bytes, datagram.from_ipv4, stamp_ns, outlet)) count_rejected();
  if (const auto change = rules_.take_change()) follow(*change);
}

void SacnSource::follow(const SacnSynchroniser::Change& change) {
  if (!settings().addresses.empty()) return;  // unicast: synchronisation packets come the same way
  if (change.left != 0 && place_of(change.left) < 0) drop_group(sacn_group_ipv4(change.left));
  // Without the group the data would be used at once, as it is until the group is joined.
  if (change.joined != 0 && !add_group(sacn_group_ipv4(change.joined))) count_error();
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
  if (options.sync_universe != 0 && !is_universe(options.sync_universe)) {
    return fail(ErrorCode::kBadInput, "{}: expected a synchronisation universe from 1 to {}, or 0 for none, got {}",
                options.name, kUniverseMax, options.sync_universe);
  }
  if (options.address_priorities.size() > kSlotCountMax) {
    return fail(ErrorCode::kBadInput, "{}: expected priorities for at most {} addresses, got {}", options.name,
                kSlotCountMax, options.address_priorities.size());
  }
  for (const int priority : options.address_priorities) {
    if (priority <= kPriorityMax) continue;
    return fail(ErrorCode::kBadInput, "{}: expected priorities of addresses from 0 to {}, got {}", options.name,
                kPriorityMax, priority);
  }
  FL_ASSIGN(const auto unicast, parse_ipv4_list(options.name, options.addresses));
  FL_ASSIGN(auto links, open_links(options.name, options.interface_names, options.multicast_ttl));
  std::unique_ptr<SacnSink> sink(new SacnSink(options, std::move(links), unicast));
  FL_TRY(check_routes(options.name, sink->links(), sink->destinations(0)));
  if (options.own_senders) options.own_senders->add_cid(sink->cid());
  return sink;
}

SacnSink::SacnSink(const SacnSinkOptions& options, std::vector<Link> links, std::span<const std::uint32_t> unicast)
    : NetSink(options, std::move(links)),
      source_name_(options.source_name),
      cid_(sacn_cid_of(options)),
      cid_is_chosen_(options.cid != Cid{}),
      sequences_(options.universes.size(), 0),
      address_priorities_(options.address_priorities),
      sync_universe_(options.sync_universe) {
  if (!address_priorities_.empty()) {
    address_priorities_.resize(kSlotCountMax);  // explicit zeros: the same meaning as addresses past the end
    priority_packets_.resize(options.universes.size());
    priorities_due_ns_.assign(options.universes.size(), -kTimeNever);
    priorities_left_.assign(options.universes.size(), 1 + kRepeats);
  }
  for (std::size_t place = 0; place < options.universes.size(); ++place) {
    SacnData data;
    data.cid = cid_;
    data.source_name = source_name_;
    data.priority = options.priority;
    data.preview = options.preview;
    data.universe = options.universes[place].wire;
    data.sync_universe = sync_universe_;
    data.force_sync = sync_universe_ != 0;
    build_sacn_data(data, packet_bytes(place));
    set_destinations(place, destinations_of(data.universe, unicast));
    if (!address_priorities_.empty()) {
      data.start_code = kStartCodePriorities;
      data.sync_universe = 0;
      data.force_sync = false;
      build_sacn_data(data, priority_packets_[place]);
    }
  }
  if (sync_universe_ != 0) sync_destinations_ = destinations_of(sync_universe_, unicast);
  if (options.announce && unicast.empty()) {
    announce_destinations_ = destinations_of(kSacnDiscoveryUniverse, {});
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

void SacnSink::add_before(TimeNs now_ns, std::span<const std::size_t> places) {
  if (announce_due_ns_ == kTimeNever && !announce_destinations_.empty()) announce_due_ns_ = now_ns + kFirstAnnounceNs;
  if (address_priorities_.empty()) return;
  for (const std::size_t place : places) {
    if (priorities_left_[place] > 0)
      --priorities_left_[place];  // they follow the rule for unchanged data (ETC's rule 8)
    else if (priorities_due_ns_[place] > now_ns)
      continue;
    priorities_due_ns_[place] = now_ns + kKeepAliveNs;
    auto& packet = priority_packets_[place];
    const std::size_t size = update_sacn_data(packet, sequences_[place]++, false, address_priorities_);
    add(std::span(packet).first(size), destinations(place));
  }
}

void SacnSink::add_after(TimeNs, std::span<const std::size_t>) {
  if (sync_universe_ == 0) return;
  build_sacn_sync({cid_, sync_sequence_++, sync_universe_}, sync_packet_);
  add(sync_packet_, sync_destinations_);
}

void SacnSink::announce() {
  std::vector<int> universes;
  for (std::size_t place = 0; place < settings().universes.size(); ++place) {
    if (is_known(place)) universes.push_back(settings().universes[place].wire);
  }
  std::sort(universes.begin(), universes.end());
  const std::size_t page_count = (universes.size() + kSacnDiscoveryUniversesMax - 1) / kSacnDiscoveryUniversesMax;
  std::vector<std::array<std::uint8_t, kSacnDiscoveryBytesMax>> packets(page_count);
  for (std::size_t page = 0; page < page_count; ++page) {
    const auto rest = std::span<const int>(universes).subspan(page * kSacnDiscoveryUniversesMax);
    const std::size_t size =
        build_sacn_discovery(cid_, source_name_, static_cast<int>(page), static_cast<int>(page_count) - 1,
                             rest.first(std::min<std::size_t>(rest.size(), kSacnDiscoveryUniversesMax)), packets[page]);
    add(std::span(packets[page]).first(size), announce_destinations_);
  }
  send_added();
}

TimeNs SacnSink::next_deadline_ns() const { return std::min(NetSink::next_deadline_ns(), announce_due_ns_); }

Status SacnSink::poll(TimeNs now_ns) {
  FL_TRY(NetSink::poll(now_ns));
  if (is_open() && now_ns >= announce_due_ns_) {
    announce();
    // On a grid, so that the interval is constant; from now on if a stall delayed it.
    announce_due_ns_ = std::max(announce_due_ns_ + kSacnAnnounceNs, now_ns + 1);
  }
  return {};
}

void SacnSink::rest(TimeNs now_ns) {
  NetSink::rest(now_ns);
  std::fill(priorities_due_ns_.begin(), priorities_due_ns_.end(), -kTimeNever);
  std::fill(priorities_left_.begin(), priorities_left_.end(), 1 + kRepeats);
  announce_due_ns_ = kTimeNever;
}

void SacnSink::close(TimeNs now_ns) {
  NetSink::close(now_ns);
  announce_due_ns_ = kTimeNever;
}

Result<std::unique_ptr<Source>> make_sacn_source(const SacnSourceOptions& options) {
  return SacnSource::create(options);
}

Result<std::unique_ptr<Sink>> make_sacn_sink(const SacnSinkOptions& options) { return SacnSink::create(options); }

}  // namespace footlight::drivers
