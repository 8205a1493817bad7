#include "drivers/net/mvr_xchange_group.h"

#include <algorithm>
#include <utility>

#include "drivers/net/mvr_xchange_names.h"

namespace footlight::drivers {
namespace {

// A station that has changed its group or its UUID is another one.
bool is_found_as(const MvrGroup::Member& member, const MvrFound& found) {
  const auto& others = found.others;
  const MvrAddress& address = member.station.address;
  return (found.address == address || std::find(others.begin(), others.end(), address) != others.end()) &&
         same_ascii(found.group, member.station.group) && same_uuid(found.uuid, member.uuid);
}

// The addresses of a station are found one by one.
void take_others(MvrGroup::Member& member, const MvrFound& found) {
  auto& others = member.station.others;
  others = found.others;
  others.push_back(found.address);
  std::erase(others, member.station.address);
}

}  // namespace

MvrGroup::MvrGroup(MvrStation& station, MvrDiscovery* discovery, std::string group,
                   const std::vector<MvrAddress>& named)
    : station_(station), discovery_(discovery), group_(std::move(group)) {
  for (const MvrAddress& address : named) add_named(address);
}

void MvrGroup::add_named(const MvrAddress& address) {
  if (member_at(address) != nullptr) return;
  Member member;
  member.station.name = text_of(address);
  member.station.address = address;
  member.named = true;
  members_.push_back(std::move(member));
}

MvrGroup::Member* MvrGroup::member_at(const MvrAddress& address) {
  const auto at =
      std::find_if(members_.begin(), members_.end(), [&](const Member& one) { return one.station.address == address; });
  return at == members_.end() ? nullptr : &*at;
}

bool MvrGroup::talks_with(const MvrAddress& address) const {
  return std::any_of(talks_.begin(), talks_.end(), [&](const Talk& one) { return one.to == address; });
}

void MvrGroup::add_descriptors(std::vector<pollfd>& waiting) const {
  if (discovery_ != nullptr) discovery_->add_descriptors(waiting);
  for (const Talk& talk : talks_) talk.client->add_descriptors(waiting);
}

// Members that are not found any more are forgotten, so that they are joined when they are back.
void MvrGroup::find_members() {
  if (discovery_ == nullptr || leaves_) return;
  const std::vector<MvrFound> found = discovery_->found();
  std::erase_if(members_, [&](const Member& member) {
    return !member.named && !talks_with(member.station.address) &&
           std::none_of(found.begin(), found.end(), [&](const MvrFound& one) { return is_found_as(member, one); });
  });
  for (const MvrFound& one : found) {
    const auto known =
        std::find_if(members_.begin(), members_.end(), [&](const Member& member) { return is_found_as(member, one); });
    if (known != members_.end()) {
      if (!talks_with(known->station.address)) take_others(*known, one);
      continue;
    }
    if (same_uuid(one.uuid, station_.uuid()) || member_at(one.address) != nullptr) continue;
    if (!group_.empty() && !same_ascii(one.group, dns_label(group_))) continue;
    Member member;
    member.station = one;
    member.uuid = one.uuid;
    members_.push_back(std::move(member));
  }
}

void MvrGroup::start(Member& member, const MvrMessage& message, TimeNs now_ns) {
  if (message.type != MvrMessageType::kLeave) member.informed = station_.newest_uuid();
  auto client = MvrClient::open(member.station.name, member.station.address, message, now_ns);
  Talk talk{nullptr, member.station.address, message.type};
  if (!client) {
    end(talk, tl::unexpected(std::move(client).error()), now_ns);
    return;
  }
  talk.client = std::move(*client);
  talks_.push_back(std::move(talk));
}

// Fails if the answer is a refusal.
Status MvrGroup::answered(Member& member, const Talk& talk) {
  const MvrMessage& answer = talk.client->asking().answer();
  if (talk.type == MvrMessageType::kCommit) {
    if (answer.ok) return {};
    return fail(ErrorCode::kProtocol, "the station refused a new file: {}",
                answer.message.empty() ? "without a reason" : answer.message);
  }
  FL_ASSIGN(member.peer, station_.joined(answer));
  member.joined = true;
  member.left = false;
  member.trouble.clear();
  member.failed_addresses = 0;
  if (!member.peer.name.empty()) member.station.name = member.peer.name;
  if (!member.peer.uuid.empty()) member.station.uuid = member.peer.uuid;
  return {};
}

void MvrGroup::end(const Talk& talk, const Status& status, TimeNs now_ns) {
  Member* const member = member_at(talk.to);
  if (member == nullptr) return;
  if (talk.type == MvrMessageType::kLeave) {
    member->joined = false;
    return;
  }
  if (status) {
    const Status taken = answered(*member, talk);
    if (taken) {
      if (leaves_ && talk.type == MvrMessageType::kJoin) start(*member, station_.leave(), now_ns);
      return;
    }
    member->trouble = fmt::format("{} ({}): {}", member->station.name, text_of(talk.to), taken.error().message);
  } else {
    auto& others = member->station.others;
    if (++member->failed_addresses <= others.size() && !leaves_) {
      others.push_back(std::exchange(member->station.address, others.front()));
      others.erase(others.begin());
      member->joined = false;
      start(*member, station_.join(), now_ns);
      return;
    }
    member->trouble = status.error().message;
  }
  member->failed_addresses = 0;
  member->joined = false;
  member->retry_ns = now_ns + kMvrRejoinNs;
}

// What members sent to this station by themselves: new files, and that they leave or are back.
void MvrGroup::follow_peers() {
  if (std::exchange(peer_changes_, station_.peer_changes()) == station_.peer_changes()) return;
  for (Member& member : members_) {
    for (const MvrPeer& peer : station_.peers()) {
      if (member.peer.uuid.empty() || !same_uuid(peer.uuid, member.peer.uuid)) continue;
      member.peer = peer;
      // A member that does not answer stays one that failed, although it did not say that it leaves.
      if (peer.joined && member.left) {
        member.joined = true;
        member.trouble.clear();
      }
      if (!peer.joined) member.joined = false;
      member.left = !peer.joined;
    }
  }
}

void MvrGroup::step(TimeNs now_ns) {
  if (discovery_ != nullptr) discovery_->step(now_ns);
  for (std::size_t i = 0; i < talks_.size();) {
    const auto done = talks_[i].client->step(now_ns);
    if (done && !*done) {
      ++i;
      continue;
    }
    const Talk talk = std::move(talks_[i]);
    talks_.erase(talks_.begin() + static_cast<std::ptrdiff_t>(i));
    end(talk, done ? Status() : Status(tl::unexpected(done.error())), now_ns);
  }
  find_members();
  if (leaves_) return;
  follow_peers();
  for (Member& member : members_) {
    if (member.left || talks_with(member.station.address)) continue;
    if (!member.joined && now_ns >= member.retry_ns) {
      if (joins_) start(member, station_.join(), now_ns);
    } else if (member.joined && member.informed != station_.newest_uuid()) {
      start(member, station_.commit(), now_ns);
    }
  }
}

void MvrGroup::leave(TimeNs now_ns) {
  leaves_ = true;
  for (Member& member : members_) {
    if (member.joined) start(member, station_.leave(), now_ns);
  }
}

}  // namespace footlight::drivers
