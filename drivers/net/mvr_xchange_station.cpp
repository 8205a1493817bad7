#include "drivers/net/mvr_xchange_station.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "sim/core/check.h"

namespace footlight::drivers {
namespace {

constexpr std::size_t kEventsMax = 1000;
constexpr const char* kProvider = "Footlight";

std::span<const std::uint8_t> octets_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

// Keeps the newest, which are the last.
void limit_commits(std::vector<MvrCommit>& commits) {
  if (commits.size() <= kMvrCommitsMax) return;
  commits.erase(commits.begin(), commits.end() - static_cast<std::ptrdiff_t>(kMvrCommitsMax));
}

}  // namespace

MvrStation::MvrStation(std::string name, std::string uuid) : name_(std::move(name)), uuid_(std::move(uuid)) {}

void MvrStation::offer(MvrCommit commit, MvrFileBytes bytes) {
  FL_CHECK(bytes != nullptr);
  commit.station_uuid = uuid_;
  commit.file_bytes = bytes->size();
  std::erase_if(offers_, [&](const Offer& one) { return same_uuid(one.commit.file_uuid, commit.file_uuid); });
  offers_.push_back({std::move(commit), std::move(bytes)});
  std::uint64_t bytes_all = 0;
  for (const Offer& offer : offers_) bytes_all += offer.bytes->size();
  while (offers_.size() > kMvrOffersMax || (offers_.size() > 1 && bytes_all > kMvrOffersBytesMax)) {
    bytes_all -= offers_.front().bytes->size();
    offers_.erase(offers_.begin());
  }
}

std::vector<MvrCommit> MvrStation::offers() const {
  std::vector<MvrCommit> commits;
  for (const Offer& offer : offers_) commits.push_back(offer.commit);
  return commits;
}

std::string_view MvrStation::newest_uuid() const {
  return offers_.empty() ? std::string_view() : std::string_view(offers_.back().commit.file_uuid);
}

MvrMessage MvrStation::join() const {
  MvrMessage message;
  message.type = MvrMessageType::kJoin;
  message.provider = kProvider;
  message.station_name = name_;
  message.station_uuid = uuid_;
  message.version_major = kMvrVersionMajor;
  message.version_minor = kMvrVersionMinor;
  message.has_commits = true;
  message.commits = offers();
  return message;
}

MvrMessage MvrStation::leave() const {
  MvrMessage message;
  message.type = MvrMessageType::kLeave;
  message.station_uuid = uuid_;
  return message;
}

MvrMessage MvrStation::commit() const {
  FL_CHECK(!offers_.empty());
  MvrMessage message;
  message.type = MvrMessageType::kCommit;
  message.station_uuid = uuid_;
  message.has_commits = true;
  message.commits = {offers_.back().commit};
  return message;
}

MvrPeer* MvrStation::find_peer(std::string_view uuid) {
  const auto at =
      std::find_if(peers_.begin(), peers_.end(), [&](const MvrPeer& one) { return same_uuid(one.uuid, uuid); });
  return at == peers_.end() ? nullptr : &*at;
}

// The peer of a join, or of the answer to one; null: too many are known.
MvrPeer* MvrStation::known_peer(const MvrMessage& join) {
  ++peer_changes_;
  MvrPeer* peer = find_peer(join.station_uuid);
  if (peer == nullptr) {
    if (peers_.size() >= kMvrPeersMax) {
      const auto left = std::find_if(peers_.begin(), peers_.end(), [](const MvrPeer& one) { return !one.joined; });
      if (left == peers_.end()) return nullptr;
      peers_.erase(left);
    }
    peer = &peers_.emplace_back();
    peer->uuid = join.station_uuid;
  }
  peer->name = join.station_name;
  peer->provider = join.provider;
  peer->joined = true;
  if (join.has_commits) peer->commits = join.commits;
  limit_commits(peer->commits);
  return peer;
}

Result<MvrPeer> MvrStation::joined(const MvrMessage& answer) {
  if (!answer.ok) {
    return fail(ErrorCode::kProtocol, "the station refused to be joined: {}",
                answer.message.empty() ? "without a reason" : answer.message);
  }
  const MvrPeer* const peer = answer.station_uuid.empty() ? nullptr : known_peer(answer);
  if (peer != nullptr) return *peer;
  return MvrPeer{answer.station_uuid, answer.station_name, answer.provider, true, answer.commits};
}

void MvrStation::add_event(MvrEvent event) {
  events_.push_back(std::move(event));
  if (events_.size() > kEventsMax) events_.pop_front();
}

std::vector<MvrEvent> MvrStation::take_events() {
  std::vector<MvrEvent> events(std::make_move_iterator(events_.begin()), std::make_move_iterator(events_.end()));
  events_.clear();
  return events;
}

MvrStation::Answer MvrStation::refuse(const MvrMessage& request, const std::string& reason) {
  MvrEvent event;
  event.kind = MvrEvent::Kind::kRefused;
  event.station_uuid = request.station_uuid;
  event.text = reason;
  add_event(std::move(event));
  return {mvr_answer(request.type, false, reason), nullptr};
}

MvrStation::Answer MvrStation::answer_request(const MvrMessage& request) {
  const auto mine = [&](const std::string& uuid) { return same_uuid(uuid, uuid_); };
  if (!request.from_stations.empty() &&
      std::none_of(request.from_stations.begin(), request.from_stations.end(), mine)) {
    return refuse(request, "The file is requested from another station; this one does not pass requests on");
  }
  if (offers_.empty()) return refuse(request, "This station offers no file");
  const Offer* found = request.file_uuid.empty() ? &offers_.back() : nullptr;
  for (const Offer& offer : offers_) {
    if (!request.file_uuid.empty() && same_uuid(offer.commit.file_uuid, request.file_uuid)) found = &offer;
  }
  if (found == nullptr) return refuse(request, "This station has no file with the UUID " + request.file_uuid);
  MvrEvent event;
  event.kind = MvrEvent::Kind::kSent;
  event.commit = found->commit;
  add_event(std::move(event));
  return {mvr_answer(request.type, true), found->bytes};
}

MvrStation::Answer MvrStation::answer(const MvrMessage& request) {
  MvrEvent event;
  event.station_uuid = request.station_uuid;
  ++peer_changes_;
  switch (request.type) {
    case MvrMessageType::kJoin: {
      (void)known_peer(request);
      event.kind = MvrEvent::Kind::kJoined;
      event.station_name = request.station_name;
      add_event(std::move(event));
      MvrMessage answer = join();
      answer.type = MvrMessageType::kJoinAnswer;
      return {std::move(answer), nullptr};
    }
    case MvrMessageType::kLeave: {
      if (MvrPeer* const peer = find_peer(request.station_uuid)) {
        peer->joined = false;
        event.station_name = peer->name;
      }
      event.kind = MvrEvent::Kind::kLeft;
      add_event(std::move(event));
      return {mvr_answer(request.type, true), nullptr};
    }
    case MvrMessageType::kCommit: {
      const MvrCommit& commit = request.commits.front();
      event.kind = MvrEvent::Kind::kCommitted;
      event.commit = commit;
      if (MvrPeer* const peer = find_peer(request.station_uuid)) {
        event.station_name = peer->name;
        std::erase_if(peer->commits, [&](const MvrCommit& one) { return same_uuid(one.file_uuid, commit.file_uuid); });
        peer->commits.push_back(commit);
        limit_commits(peer->commits);
      }
      add_event(std::move(event));
      return {mvr_answer(request.type, true), nullptr};
    }
    case MvrMessageType::kRequest: return answer_request(request);
    case MvrMessageType::kNewSessionHost:
      return refuse(request, "This station does not follow a session to another group or to a WebSocket");
    default: break;
  }
  return refuse(request, "This message is an answer");  // MvrAnswering ends the connection before
}

std::span<const std::uint8_t> MvrAnswering::to_send() const {
  if (queue_.empty()) return {};
  const Piece& piece = queue_.front();
  const std::span<const std::uint8_t> bytes = piece.file != nullptr ? *piece.file : piece.own;
  return bytes.subspan(sent_);
}

Status MvrAnswering::sent(std::size_t size) {
  sent_ += size;
  if (!to_send().empty()) return {};
  queue_.pop_front();
  sent_ = 0;
  return read_on();
}

Status MvrAnswering::receive(std::span<const std::uint8_t> bytes) {
  unread_.insert(unread_.end(), bytes.begin(), bytes.end());
  return read_on();
}

Status MvrAnswering::read_on() {
  while (queue_.empty() && unread_at_ < unread_.size()) {
    FL_ASSIGN(const std::size_t size, reader_.read_message(std::span(unread_).subspan(unread_at_), *this));
    unread_at_ += size;
  }
  if (unread_at_ < unread_.size()) return {};
  unread_.clear();
  unread_at_ = 0;
  return {};
}

Status MvrAnswering::receive_json(std::string_view text) {
  FL_ASSIGN(const MvrMessage message, parse_mvr_message(text));
  if (is_answer(message.type)) {
    return fail(ErrorCode::kProtocol, "{}: an answer, where nothing was requested", name_of(message.type));
  }
  MvrStation::Answer answer = station_.answer(message);
  if (answer.file == nullptr) {
    const std::string packet = build_mvr_json(build_mvr_message(answer.message));
    queue_.push_back({{packet.begin(), packet.end()}, nullptr});
    return {};
  }
  // One packet, however large: not all programs read a file from several.
  MvrPacketHeader header;
  header.payload = MvrPayload::kFile;
  header.payload_bytes = answer.file->size();
  const auto head = build_mvr_header(header);
  queue_.push_back({{head.begin(), head.end()}, nullptr});
  if (!answer.file->empty()) queue_.push_back({{}, std::move(answer.file)});
  return {};
}

Status MvrAnswering::receive_file_part(std::span<const std::uint8_t>, std::uint64_t) {
  return fail(ErrorCode::kProtocol, "a file that was not requested");
}
Status MvrAnswering::receive_file_end() { return fail(ErrorCode::kProtocol, "a file that was not requested"); }

MvrAsking::MvrAsking(const MvrMessage& request, MvrFileSink* sink)
    : expected_(mvr_answer(request.type, true).type),
      sink_(sink),
      packet_(build_mvr_json(build_mvr_message(request))) {}

Status MvrAsking::receive(std::span<const std::uint8_t> bytes) {
  if (done()) return {};
  const Status read = reader_.read(bytes, *this);
  return done() ? Status() : read;  // what comes after the answer is no error, whatever it is
}

Status MvrAsking::closed() const {
  if (done()) return {};
  if (file_bytes_ > 0) {
    return fail(ErrorCode::kDisconnected, "the station closed the connection after {} bytes of the file", file_bytes_);
  }
  return fail(ErrorCode::kDisconnected, "the station closed the connection without an answer");
}

std::span<const std::uint8_t> MvrAsking::to_send() const { return octets_of(packet_).subspan(sent_); }

Status MvrAsking::receive_json(std::string_view text) {
  FL_ASSIGN(MvrMessage message, parse_mvr_message(text));
  if (!is_answer(message.type) || done()) return {};  // a message of its own, such as a commit to all connections
  if (message.type != expected_) {
    return fail(ErrorCode::kProtocol, "{} as the answer; expected {}", name_of(message.type), name_of(expected_));
  }
  if (sink_ != nullptr && message.ok) return {};  // the file follows
  answer_ = std::move(message);
  return {};
}

Status MvrAsking::receive_file_part(std::span<const std::uint8_t> bytes, std::uint64_t total_bytes) {
  if (done()) return {};
  if (sink_ == nullptr) return fail(ErrorCode::kProtocol, "a file that was not requested");
  file_bytes_ += bytes.size();
  return sink_->write(bytes, total_bytes);
}

Status MvrAsking::receive_file_end() {
  if (done()) return {};
  if (sink_ == nullptr) return fail(ErrorCode::kProtocol, "a file that was not requested");
  has_file_ = true;
  return {};
}

}  // namespace footlight::drivers
