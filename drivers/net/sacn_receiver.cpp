#include "drivers/net/sacn_receiver.h"

#include <variant>

#include "drivers/net/hash.h"
#include "drivers/net/net_source.h"

namespace footlight::drivers {

SacnReceiver::SacnReceiver(const Settings& settings)
    : hear_preview_(settings.hear_preview),
      own_senders_(settings.own_senders),
      show_universes_(show_numbers(settings.universes)),
      wire_index_(wire_numbers(settings.universes)),
      level_filters_(settings.universes.size()),
      priority_filters_(settings.universes.size()),
      synchroniser_(settings.universes.size()) {}

bool SacnReceiver::take(std::span<const std::uint8_t> datagram, std::uint32_t from_ipv4, TimeNs now_ns,
                        FrameReceiver& receiver) {
  const auto packet = parse_sacn_packet(datagram);
  if (!packet) return false;
  if (const auto* data = std::get_if<SacnData>(&*packet)) {
    take_data(*data, from_ipv4, now_ns, receiver);
  } else if (const auto* sync = std::get_if<SacnSync>(&*packet)) {
    ++details_.sync;
    synchroniser_.synchronise(*sync, sender_hash(sync->cid), now_ns, [&](std::size_t place, const HeldFrame& held) {
      FrameView frame;
      frame.universe = show_universes_[place];
      frame.stamp_ns = now_ns;  // its levels take effect now
      frame.sender = held.sender;
      frame.sequence = held.sequence;
      frame.priority = held.priority;
      frame.slots = std::span(held.slots).first(held.slot_count);
      receiver.receive(frame);
    });
  } else {
    ++details_.discovery;
  }
  return true;
}

void SacnReceiver::take_data(const SacnData& data, std::uint32_t from_ipv4, TimeNs now_ns, FrameReceiver& receiver) {
  const int found = wire_index_.find(data.universe);
  if (found < 0) {
    ++details_.other_universe;
    return;
  }
  if (own_senders_ && own_senders_->has_cid(data.cid)) {
    ++details_.own;
    return;
  }
  const auto place = static_cast<std::size_t>(found);
  const SenderId sender = sender_hash(data.cid);
  const bool priorities = data.start_code == kStartCodePriorities;
  if (!priorities && data.start_code != kStartCodeLevels) {
    ++details_.other_start_code;
    level_filters_[place].skip(sender);
    return;
  }
  if (data.preview && !hear_preview_) {
    ++details_.preview;
    level_filters_[place].skip(sender);
    return;
  }
  SequenceFilter& filter = priorities ? priority_filters_[place] : level_filters_[place];
  const auto verdict = filter.judge(sender, data.sequence, data.terminated, SequenceRule::kSacn, now_ns);
  if (verdict == SequenceFilter::Verdict::kLate) {
    ++details_.late;
    return;
  }
  if (verdict == SequenceFilter::Verdict::kEndedAlready) {
    ++details_.ended_already;
    return;
  }
  if (priorities) level_filters_[place].skip(sender);
  names_.note(sender, data.source_name, from_ipv4, now_ns);
  if (data.terminated) {
    synchroniser_.drop(place, sender);
  } else if (!priorities && synchroniser_.hold(data, place, sender, now_ns)) {
    return;
  }
  FrameView frame;
  frame.universe = show_universes_[place];
  frame.stamp_ns = now_ns;
  frame.sender = sender;
  frame.sequence = data.sequence;
  frame.priority = data.priority;
  frame.terminated = data.terminated;
  frame.start_code = data.start_code;
  if (!data.terminated) frame.slots = data.slots;
  receiver.receive(frame);
}

SacnSourceDetails SacnReceiver::details() const {
  SacnSourceDetails details = details_;
  details.synchroniser = synchroniser_.counters();
  return details;
}

}  // namespace footlight::drivers
