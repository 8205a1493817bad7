#include "drivers/rdm/rdm_controller.h"

#include <algorithm>
#include <string>

#include "drivers/machine_id.h"

namespace footlight::drivers {
namespace {

constexpr int kTries = 3;
constexpr DurationNs kTimerUnitNs = 100 * kNsPerMs;  // of ACK_TIMER
constexpr DurationNs kPatienceNs = 10 * kNsPerS;     // for a promised answer
constexpr int kPartsMax = 256;                       // of an ACK_OVERFLOW
constexpr std::uint8_t kStatusError = 4;  // the queue returns messages of any severity, and status messages of this one

ErrorCode code_of_nack(std::uint16_t reason) {
  switch (reason) {
    case kRdmNackUnknownPid:
    case kRdmNackCommandClass: return ErrorCode::kUnsupported;
    case kRdmNackWriteProtect: return ErrorCode::kPermission;
    case kRdmNackFormat:
    case kRdmNackOutOfRange:
    case kRdmNackSubDevice: return ErrorCode::kBadInput;
    case kRdmNackHardwareFault: return ErrorCode::kIo;
    default: return ErrorCode::kProtocol;
  }
}

std::uint16_t word_of(const Octets& data) {
  return data.size() < 2 ? std::uint16_t{0xFFFF} : static_cast<std::uint16_t>(data[0] << 8 | data[1]);
}

}  // namespace

RdmUid rdm_own_uid() {
  const std::string text = machine_id();
  std::uint32_t digest = 2'166'136'261u;  // FNV-1a, 32 bits
  for (const char c : text) digest = (digest ^ static_cast<unsigned char>(c)) * 16'777'619u;
  return {0x7FF0, digest == 0xFFFF'FFFF ? 0 : digest};
}

Result<Octets> RdmController::get(const RdmUid& uid, std::uint16_t parameter, std::span<const std::uint8_t> argument,
                                  std::string_view name, std::uint16_t sub_device) {
  if (uid.is_broadcast()) return fail(ErrorCode::kBadInput, "{}: a request needs one device; name its UID", name);
  RdmMessage request;
  request.to = uid;
  request.command = RdmCommand::kGet;
  request.parameter = parameter;
  request.sub_device = sub_device;
  request.data.assign(argument.begin(), argument.end());
  return transact(std::move(request), name);
}

Result<Octets> RdmController::set(const RdmUid& uid, std::uint16_t parameter, std::span<const std::uint8_t> data,
                                  std::string_view name, std::uint16_t sub_device) {
  RdmMessage request;
  request.to = uid;
  request.command = RdmCommand::kSet;
  request.parameter = parameter;
  request.sub_device = sub_device;
  request.data.assign(data.begin(), data.end());
  if (!uid.is_broadcast()) return transact(std::move(request), name);
  request.from = own_;
  request.transaction = ++transaction_;
  FL_TRY(line_.transact(request));
  return Octets{};
}

Result<RdmMessage> RdmController::try_thrice(RdmMessage& request, std::string_view name) {
  std::string damage;
  for (int i = 0; i < kTries; ++i) {
    request.from = own_;
    request.transaction = ++transaction_;
    auto answer = line_.transact(request);
    if (answer && *answer) return std::move(**answer);
    if (answer) continue;
    if (answer.error().code != ErrorCode::kProtocol) return tl::unexpected(std::move(answer).error());
    damage = answer.error().message;
  }
  if (!damage.empty()) {
    return fail(ErrorCode::kProtocol, "{}: {}: answers arrive damaged ({}); check the cable and its terminator",
                text_of(request.to), name, damage);
  }
  return fail(ErrorCode::kTimeout, "{}: {}: no answer to {} requests; is it on this line? See 'footlight rdm list'",
              text_of(request.to), name, kTries);
}

Result<RdmMessage> RdmController::wait_for_queued(const RdmMessage& request, const RdmMessage& timer,
                                                  std::string_view name) {
  const TimeNs until_ns = clock_.now_ns() + kPatienceNs;
  DurationNs wait_ns = std::max<DurationNs>(1, word_of(timer.data)) * kTimerUnitNs;
  while (clock_.now_ns() + wait_ns <= until_ns) {
    clock_.sleep_until_ns(clock_.now_ns() + wait_ns);
    wait_ns = kTimerUnitNs;
    RdmMessage fetch;
    fetch.to = request.to;
    fetch.command = RdmCommand::kGet;
    fetch.parameter = kRdmQueuedMessage;
    fetch.data = {kStatusError};
    FL_ASSIGN(RdmMessage message, try_thrice(fetch, name));
    if (message.parameter == request.parameter && message.sub_device == request.sub_device) return message;
    if (message.response_type() == RdmResponseType::kAckTimer) {
      wait_ns = std::max<DurationNs>(1, word_of(message.data)) * kTimerUnitNs;
    } else if (message.response_type() == RdmResponseType::kNack && request.command == RdmCommand::kGet) {
      // It keeps no queue: repeat the request itself.
      RdmMessage again = request;
      FL_ASSIGN(message, try_thrice(again, name));
      if (message.response_type() != RdmResponseType::kAckTimer) return message;
      wait_ns = std::max<DurationNs>(1, word_of(message.data)) * kTimerUnitNs;
    }
  }
  return fail(ErrorCode::kTimeout, "{}: {}: requested time and has not answered within {} s; try again later",
              text_of(request.to), name, kPatienceNs / kNsPerS);
}

Result<Octets> RdmController::transact(RdmMessage request, std::string_view name) {
  Octets data;
  for (int part = 0; part < kPartsMax; ++part) {
    FL_ASSIGN(RdmMessage answer, try_thrice(request, name));
    if (answer.response_type() == RdmResponseType::kAckTimer) {
      FL_ASSIGN(answer, wait_for_queued(request, answer, name));
    }
    if (answer.response_type() == RdmResponseType::kNack) {
      const std::uint16_t reason = word_of(answer.data);
      return fail(code_of_nack(reason), "{}: {}: the device refuses: {} (NACK {:#06x})", text_of(request.to), name,
                  text_of_nack(reason), reason);
    }
    if (answer.parameter != request.parameter) {
      return fail(ErrorCode::kProtocol, "{}: {}: the answer is to another parameter ({:#06x})", text_of(request.to),
                  name, answer.parameter);
    }
    data.insert(data.end(), answer.data.begin(), answer.data.end());
    if (answer.response_type() == RdmResponseType::kAck) return data;
  }
  return fail(ErrorCode::kProtocol, "{}: {}: the answer does not end; {} parts were received", text_of(request.to),
              name, kPartsMax);
}

}  // namespace footlight::drivers
