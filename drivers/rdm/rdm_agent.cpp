#include "drivers/rdm/rdm_agent.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <sys/eventfd.h>
#include <unistd.h>

#include "sim/core/no_signals.h"

namespace footlight::drivers {

Result<std::unique_ptr<RdmAgent>> RdmAgent::create(std::unique_ptr<RdmLine> line) {
  const int event_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (event_fd < 0) {
    return fail(ErrorCode::kIo, "RDM: cannot create an eventfd: {}; too many files are open: raise 'ulimit -n'",
                std::strerror(errno));
  }
  return std::unique_ptr<RdmAgent>(new RdmAgent(std::move(line), event_fd));
}

RdmAgent::RdmAgent(std::unique_ptr<RdmLine> line, int event_fd) : line_(std::move(line)), event_fd_(event_fd) {
  const NoSignals for_the_thread;
  thread_ = std::thread([this] {
    run();
    ended_.store(true);
  });
}

void RdmAgent::request_stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    requests_.clear();
    std::uint64_t count = 0;
    (void)!::read(event_fd_, &count, sizeof count);
  }
  line_->stop();
  wake_.notify_one();
}

RdmAgent::~RdmAgent() {
  request_stop();
  thread_.join();
  ::close(event_fd_);
}

bool RdmAgent::submit(std::uint64_t ticket, RdmMessage request) {
  {
    const std::lock_guard lock(mutex_);
    if (requests_.size() >= kRequestsMax) return false;
    requests_.push_back({ticket, std::move(request)});
  }
  wake_.notify_one();
  return true;
}

void RdmAgent::search() {
  {
    const std::lock_guard lock(mutex_);
    search_wanted_ = true;
  }
  wake_.notify_one();
}

RdmAgent::News RdmAgent::take() {
  // Under the lock, like the write: what is taken here must not leave the descriptor readable.
  const std::lock_guard lock(mutex_);
  std::uint64_t count = 0;
  (void)!::read(event_fd_, &count, sizeof count);
  return std::exchange(news_, {});
}

std::optional<std::vector<RdmUid>> RdmAgent::table() const {
  const std::lock_guard lock(mutex_);
  return table_;
}

void RdmAgent::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return stopping_ || search_wanted_ || !requests_.empty(); });
    if (stopping_) return;
    // Requests first: controllers wait for them.
    if (!requests_.empty()) {
      const Request request = std::move(requests_.front());
      requests_.pop_front();
      lock.unlock();
      auto answer = line_->transact(request.message);
      lock.lock();
      news_.answers.push_back({request.ticket, answer ? std::move(*answer) : std::nullopt});
    } else {
      search_wanted_ = false;
      lock.unlock();
      const auto found = line_->discover();
      lock.lock();
      // A failed search keeps the table, or sets an empty one if there was none.
      if (found) {
        table_.emplace();
        for (const RdmFound& one : *found) table_->push_back(one.uid);
      } else if (!table_) {
        table_.emplace();
      }
      news_.table_changed = true;
    }
    if (stopping_) return;
    const std::uint64_t one = 1;
    (void)!::write(event_fd_, &one, sizeof one);
  }
}

}  // namespace footlight::drivers
