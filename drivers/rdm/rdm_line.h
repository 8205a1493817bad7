// A DMX line with Remote Device Management (ANSI E1.20): discovery of responders, and one request with its response at
// a time. rdm_controller.h handles parameters, late answers and answers in parts.
//
// Calls block until the response or a timeout. One thread, except for stop().
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

// A responder found by discovery.
struct RdmFound {
  RdmUid uid;
  // Its answer to DISC_MUTE (E1.20 section 7.6.3); all false if a gateway did the discovery.
  bool is_proxy = false;  // it represents others, which are found as well
  bool has_sub_devices = false;
  bool is_boot_loader = false;     // supports only firmware updates
  bool is_proxied = false;         // another responder answers for it
  std::optional<RdmUid> bound_to;  // the primary responder of a physical device with several

  friend bool operator==(const RdmFound&, const RdmFound&) = default;
};

class RdmLine {
 public:
  virtual ~RdmLine() = default;
  // Sends a request and waits for its response. nullopt: no answer, or the request is a broadcast. Responses of others,
  // or to another request, are ignored. Errors: of the line's transport, or kProtocol: a damaged answer.
  [[nodiscard]] virtual Result<std::optional<RdmMessage>> transact(const RdmMessage& request) = 0;
  // Every responder on the line, sorted by UID.
  [[nodiscard]] virtual Result<std::vector<RdmFound>> discover() = 0;
  // From any thread: the current and every later search ends with kDisconnected after the current request.
  void stop() { stopped_ = true; }

 protected:
  [[nodiscard]] bool stopped() const { return stopped_; }

 private:
  std::atomic<bool> stopped_ = false;
};

// A line whose bytes are accessible: discovery is done here.
class RdmWire : public RdmLine {
 public:
  // `own`: the UID of this controller.
  explicit RdmWire(const RdmUid& own) : own_(own) {}

  [[nodiscard]] Result<std::optional<RdmMessage>> transact(const RdmMessage& request) override;
  // Binary search by DISC_UNIQUE_BRANCH and DISC_MUTE (E1.20 section 7). Responders that violate the rules (answer
  // while muted, or do not confirm the mute) cost time but do not prevent others from being found. They are listed only
  // if they have been muted once.
  [[nodiscard]] Result<std::vector<RdmFound>> discover() override;

  // Requests sent by the last discover().
  [[nodiscard]] std::size_t discovery_requests() const { return discovery_requests_; }

 protected:
  // Sends a request and returns what was received on the line: a response from its start code on, the answer or answers
  // to DISC_UNIQUE_BRANCH, or nothing.
  [[nodiscard]] virtual Result<Octets> exchange(std::span<const std::uint8_t> request) = 0;

 private:
  struct Branch {
    RdmUid low, high;
  };
  // The answer to DISC_UNIQUE_BRANCH. Empty: no responder.
  [[nodiscard]] Result<Octets> query_branch(const Branch& branch);
  [[nodiscard]] Result<std::optional<RdmFound>> mute(const RdmUid& uid);

  const RdmUid own_;
  std::uint8_t transaction_ = 0;
  std::size_t discovery_requests_ = 0;
};

}  // namespace footlight::drivers
