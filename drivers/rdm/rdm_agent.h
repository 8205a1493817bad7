// An RDM line for those who must not wait: requests are taken at once and answered later, by a thread of its own.
//
// Made for the pump: a descriptor becomes readable when there is something to take. At most kRequestsMax requests wait;
// more are refused, since a controller asks again.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "drivers/rdm/rdm_line.h"

namespace footlight::drivers {

class RdmAgent {
 public:
  static constexpr std::size_t kRequestsMax = 16;

  // The line is called on the agent's thread alone. kIo: no descriptor is to be had.
  [[nodiscard]] static Result<std::unique_ptr<RdmAgent>> create(std::unique_ptr<RdmLine> line);
  // Waits for the call of the line that runs. request_stop() does not wait: from then on no answer comes and the
  // descriptor stays quiet. The destructor waits for nothing once has_ended() is true.
  ~RdmAgent();
  void request_stop();
  [[nodiscard]] bool has_ended() const { return ended_.load(); }
  RdmAgent(const RdmAgent&) = delete;
  RdmAgent& operator=(const RdmAgent&) = delete;

  // --- From one thread.
  // False: too many wait. `ticket` comes back with the answer.
  bool ask(std::uint64_t ticket, RdmMessage request);
  // Searches the line anew; nothing where a search waits already.
  void search();
  [[nodiscard]] int fd() const { return event_fd_; }
  struct Answer {
    std::uint64_t ticket = 0;
    std::optional<RdmMessage> message;  // none: nobody answered, or the line failed
  };
  // What has come since the last call; makes the descriptor quiet.
  struct News {
    std::vector<Answer> answers;
    bool table_changed = false;  // a search has ended
  };
  [[nodiscard]] News take();
  // By UID, as the last search found them; nullopt: none has ended yet.
  [[nodiscard]] std::optional<std::vector<RdmUid>> table() const;

 private:
  RdmAgent(std::unique_ptr<RdmLine> line, int event_fd);
  void run();

  struct Request {
    std::uint64_t ticket = 0;
    RdmMessage message;
  };
  const std::unique_ptr<RdmLine> line_;
  const int event_fd_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  // All below: guarded by mutex_.
  std::deque<Request> requests_;
  bool search_wanted_ = false;
  bool stopping_ = false;
  News news_;
  std::optional<std::vector<RdmUid>> table_;
  std::atomic<bool> ended_{false};
  std::thread thread_;  // last: it uses what is above
};

}  // namespace footlight::drivers
