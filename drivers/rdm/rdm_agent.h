// A non-blocking RDM line: requests are accepted at once and answered later, by its own thread.
//
// For the pump: a descriptor becomes readable when take() has something. At most kRequestsMax requests wait; more are
// refused, since a controller repeats them.
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

  // Only the agent's thread calls the line. kIo: no descriptor is available.
  [[nodiscard]] static Result<std::unique_ptr<RdmAgent>> create(std::unique_ptr<RdmLine> line);
  // Waits for the current call of the line to end. request_stop() does not wait: after it no answer comes and the
  // descriptor stays unreadable. The destructor does not wait after has_ended() is true.
  ~RdmAgent();
  void request_stop();
  [[nodiscard]] bool has_ended() const { return ended_.load(); }
  RdmAgent(const RdmAgent&) = delete;
  RdmAgent& operator=(const RdmAgent&) = delete;

  // --- From one thread.
  // False: too many requests wait. `ticket` is returned with the answer.
  bool submit(std::uint64_t ticket, RdmMessage request);
  // Searches the line again; no effect if a search waits already.
  void search();
  [[nodiscard]] int fd() const { return event_fd_; }
  struct Answer {
    std::uint64_t ticket = 0;
    std::optional<RdmMessage> message;  // none: no answer, or the line failed
  };
  // Everything since the last call; clears the descriptor.
  struct News {
    std::vector<Answer> answers;
    bool table_changed = false;  // a search has ended
  };
  [[nodiscard]] News take();
  // Sorted by UID, from the last search; nullopt: no search has ended yet.
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
  std::thread thread_;  // last member: it uses those above
};

}  // namespace footlight::drivers
