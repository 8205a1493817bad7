// A DMX line that carries Remote Device Management (ANSI E1.20): who is on it, and one question and its answer at a
// time. What is asked, and what to do about answers that come late or in parts, is in rdm_controller.h.
//
// Calls block until the answer is there or its time is over. One thread, but for stop().
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "drivers/rdm/rdm_packet.h"
#include "sim/core/result.h"

namespace footlight::drivers {

// A responder as discovery finds it.
struct RdmFound {
  RdmUid uid;
  // What it said when it was muted (E1.20 section 7.6.3); all false where discovery was another's (a gateway).
  bool is_proxy = false;  // it stands for others, which are found as well
  bool has_sub_devices = false;
  bool is_boot_loader = false;     // cannot do more than be updated
  bool is_proxied = false;         // another answers for it
  std::optional<RdmUid> bound_to;  // first of the responders of one physical device

  friend bool operator==(const RdmFound&, const RdmFound&) = default;
};

class RdmLine {
 public:
  virtual ~RdmLine() = default;
  // Sends a request and waits for the response to it. nullopt: nobody answered, or the request is a broadcast.
  // Responses of others, or to another request, are not given. Errors: of what carries the line, or kProtocol: an
  // answer came and was damaged.
  [[nodiscard]] virtual Result<std::optional<RdmMessage>> transact(const RdmMessage& request) = 0;
  // Everybody on the line, by UID.
  [[nodiscard]] virtual Result<std::vector<RdmFound>> discover() = 0;
  // From any thread: a search that runs, and every later one, ends with kDisconnected after the request under way.
  void stop() { stopped_ = true; }

 protected:
  [[nodiscard]] bool stopped() const { return stopped_; }

 private:
  std::atomic<bool> stopped_ = false;
};

// A line whose bytes we see: discovery is our own.
class RdmWire : public RdmLine {
 public:
  // `own`: the UID of this controller.
  explicit RdmWire(const RdmUid& own) : own_(own) {}

  [[nodiscard]] Result<std::optional<RdmMessage>> transact(const RdmMessage& request) override;
  // Binary search by DISC_UNIQUE_BRANCH and DISC_MUTE (E1.20 section 7). Responders that break the rules - that answer
  // though muted, or do not confirm that they are - cost time and do not keep others from being found; they are in the
  // list only if they have been muted once.
  [[nodiscard]] Result<std::vector<RdmFound>> discover() override;

  // Requests sent by the last discover().
  [[nodiscard]] std::size_t discovery_requests() const { return discovery_requests_; }

 protected:
  // Puts a request on the line and returns what came back, as it was on the line: a response from its start code on,
  // the answer or answers to DISC_UNIQUE_BRANCH, or nothing.
  [[nodiscard]] virtual Result<Octets> exchange(std::span<const std::uint8_t> request) = 0;

 private:
  struct Branch {
    RdmUid low, high;
  };
  // The answer to DISC_UNIQUE_BRANCH. Empty: nobody is there.
  [[nodiscard]] Result<Octets> ask_branch(const Branch& branch);
  [[nodiscard]] Result<std::optional<RdmFound>> mute(const RdmUid& uid);

  const RdmUid own_;
  std::uint8_t transaction_ = 0;
  std::size_t discovery_requests_ = 0;
};

}  // namespace footlight::drivers
