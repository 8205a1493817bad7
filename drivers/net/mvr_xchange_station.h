// A station of MVR-xchange in TCP mode, without sockets: bytes in, bytes out.
//
// Each connection has one side that requests and one that answers, and the answer comes on the same connection. So a
// station that offers files has one MvrAnswering for each connection that it accepted, and makes an MvrAsking and a
// connection of its own for each message that it sends.
//
// No clock and no thread; not safe to share between threads.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/net/mvr_xchange_message.h"
#include "drivers/net/mvr_xchange_packet.h"
#include "sim/core/result.h"

namespace footlight::drivers {

inline constexpr std::size_t kMvrOffersMax = 8;  // revisions that a station keeps; the oldest is dropped for a new one
inline constexpr std::uint64_t kMvrOffersBytesMax = 256u << 20;  // of all of them; the newest is kept whatever its size
inline constexpr std::size_t kMvrPeersMax = 256;  // stations that are known; more are answered, and not listed

using MvrFileBytes = std::shared_ptr<const std::vector<std::uint8_t>>;

// Another station, from its messages.
struct MvrPeer {
  std::string uuid;
  std::string name;
  std::string provider;
  bool joined = true;  // false: it has left
  std::vector<MvrCommit> commits;
};

struct MvrEvent {
  enum class Kind {
    kJoined,  // also a join that repeats
    kLeft,
    kCommitted,  // `commit` is its new file
    kSent,       // the answer is the file `commit`; the sending has begun
    kRefused,    // `text` is what was sent as the reason
  };
  Kind kind = Kind::kJoined;
  std::string station_uuid;  // of the other station; empty: a request, which does not state it
  std::string station_name;  // empty: unknown
  MvrCommit commit;
  std::string text;
};

class MvrStation {
 public:
  // `uuid`: the same after every start, and no other station's.
  MvrStation(std::string name, std::string uuid);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::string& uuid() const { return uuid_; }

  // The newest revision from now on. Sets the commit's station and size.
  void offer(MvrCommit commit, MvrFileBytes bytes);
  [[nodiscard]] std::vector<MvrCommit> offers() const;  // the oldest first
  [[nodiscard]] std::string_view newest_uuid() const;   // of the newest file; empty: none

  // Messages to others.
  [[nodiscard]] MvrMessage join() const;
  [[nodiscard]] MvrMessage leave() const;
  [[nodiscard]] MvrMessage commit() const;  // of the newest; only after offer()
  // Reads the answer to join(). Fails if the other station refused, with its reason.
  [[nodiscard]] Result<MvrPeer> joined(const MvrMessage& answer);

  // The answer to a message of another station: the file if it is not null, else the message.
  struct Answer {
    MvrMessage message;
    MvrFileBytes file;
  };
  [[nodiscard]] Answer answer(const MvrMessage& request);

  [[nodiscard]] const std::vector<MvrPeer>& peers() const { return peers_; }
  [[nodiscard]] std::uint64_t peer_changes() const { return peer_changes_; }  // counts changes of peers()
  // What happened since the last call, the oldest first. At most the newest thousand.
  [[nodiscard]] std::vector<MvrEvent> take_events();

 private:
  struct Offer {
    MvrCommit commit;
    MvrFileBytes bytes;
  };
  MvrPeer* find_peer(std::string_view uuid);
  MvrPeer* known_peer(const MvrMessage& join);
  void add_event(MvrEvent event);
  [[nodiscard]] Answer answer_request(const MvrMessage& request);
  [[nodiscard]] Answer refuse(const MvrMessage& request, const std::string& reason);

  const std::string name_;
  const std::string uuid_;
  std::vector<Offer> offers_;
  std::vector<MvrPeer> peers_;
  std::uint64_t peer_changes_ = 0;
  std::deque<MvrEvent> events_;
};

// A connection that was accepted: answers any number of messages, in their order.
class MvrAnswering final : private MvrPacketReceiver {
 public:
  explicit MvrAnswering(MvrStation& station) : station_(station) {}
  // Errors (kProtocol): bytes that are no message, an answer or a file. Close the connection then.
  [[nodiscard]] Status receive(std::span<const std::uint8_t> bytes);
  // The next bytes to send, valid until sent(); empty: none. Receive nothing meanwhile, so that a peer that reads
  // nothing does not fill the memory. A message that came with others is read when those are answered.
  [[nodiscard]] std::span<const std::uint8_t> to_send() const;
  // Errors as of receive(), from messages that had to wait.
  [[nodiscard]] Status sent(std::size_t size);
  // Nothing is to send, and no message has begun.
  [[nodiscard]] bool idle() const { return queue_.empty() && reader_.between_messages(); }

 private:
  Status receive_json(std::string_view text) override;
  Status receive_file_part(std::span<const std::uint8_t> bytes, std::uint64_t total_bytes) override;
  Status receive_file_end() override;

  Status read_on();

  struct Piece {
    std::vector<std::uint8_t> own;
    MvrFileBytes file;  // null: `own`
  };
  MvrStation& station_;
  MvrPacketReader reader_;
  std::deque<Piece> queue_;  // the answer to one message
  std::size_t sent_ = 0;     // of the first piece
  std::vector<std::uint8_t> unread_;
  std::size_t unread_at_ = 0;  // what is before has been read
};

// Receives a file.
class MvrFileSink {
 public:
  virtual ~MvrFileSink() = default;
  // `total_bytes`: of the file, as far as its packets have announced it.
  virtual Status write(std::span<const std::uint8_t> bytes, std::uint64_t total_bytes) = 0;
};

// A connection that was opened for one message, and its answer.
class MvrAsking final : private MvrPacketReceiver {
 public:
  // `sink`: of a file that is requested; else null. Must live as long.
  explicit MvrAsking(const MvrMessage& request, MvrFileSink* sink = nullptr);
  // Errors: of the sink; kProtocol (no message, an answer to something else, a file that was not requested).
  Status receive(std::span<const std::uint8_t> bytes);
  // The other side closed the connection. kDisconnected if the answer is not whole.
  [[nodiscard]] Status closed() const;
  [[nodiscard]] std::span<const std::uint8_t> to_send() const;
  void sent(std::size_t size) { sent_ += size; }

  [[nodiscard]] bool done() const { return answer_.has_value() || has_file_; }
  [[nodiscard]] bool has_file() const { return has_file_; }               // the sink has the whole file
  [[nodiscard]] std::uint64_t file_bytes() const { return file_bytes_; }  // that the sink has
  [[nodiscard]] const MvrMessage& answer() const { return *answer_; }     // done, and no file

 private:
  Status receive_json(std::string_view text) override;
  Status receive_file_part(std::span<const std::uint8_t> bytes, std::uint64_t total_bytes) override;
  Status receive_file_end() override;

  const MvrMessageType expected_;
  MvrFileSink* const sink_;
  const std::string packet_;
  std::size_t sent_ = 0;
  MvrPacketReader reader_;
  std::optional<MvrMessage> answer_;
  bool has_file_ = false;
  std::uint64_t file_bytes_ = 0;
};

}  // namespace footlight::drivers
