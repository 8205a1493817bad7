// Reads and sets parameters of responders: repeats lost requests, waits as long as the responder requests, assembles
// answers that come in parts, and converts refusals to messages.
//
// Blocks for as long as the responder takes, up to some seconds. One thread.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "drivers/rdm/rdm_line.h"
#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::drivers {

// A UID for this machine, from the range that ESTA reserves for prototypes (manufacturers 7FF0 to 7FFF).
[[nodiscard]] RdmUid rdm_own_uid();

class RdmController {
 public:
  // Both outlive it.
  RdmController(RdmLine& line, Clock& clock, const RdmUid& own = rdm_own_uid())
      : line_(line), clock_(clock), own_(own) {}

  // The data of a parameter. `name`: of the parameter, for messages. Errors:
  // - kTimeout: no answer to three requests, or not the promised one.
  // - kUnsupported: refused: unknown parameter, or not readable or settable.
  // - kPermission: refused: write protect.
  // - kBadInput: refused: out of range, or a wrong format.
  // - kIo: refused: hardware fault.
  // - kProtocol: other refusals and malformed answers.
  // - Those of the line.
  [[nodiscard]] Result<Octets> get(const RdmUid& uid, std::uint16_t parameter, std::span<const std::uint8_t> argument,
                                   std::string_view name, std::uint16_t sub_device = 0);
  // The data of the responder's answer, often empty; empty for broadcasts.
  [[nodiscard]] Result<Octets> set(const RdmUid& uid, std::uint16_t parameter, std::span<const std::uint8_t> data,
                                   std::string_view name, std::uint16_t sub_device = 0);

 private:
  [[nodiscard]] Result<Octets> transact(RdmMessage request, std::string_view name);
  // One response, after up to three attempts.
  [[nodiscard]] Result<RdmMessage> try_thrice(RdmMessage& request, std::string_view name);
  [[nodiscard]] Result<RdmMessage> wait_for_queued(const RdmMessage& request, const RdmMessage& timer,
                                                   std::string_view name);

  RdmLine& line_;
  Clock& clock_;
  const RdmUid own_;
  std::uint8_t transaction_ = 0;
};

}  // namespace footlight::drivers
