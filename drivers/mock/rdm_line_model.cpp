#include "drivers/mock/rdm_line_model.h"

#include <algorithm>
#include <optional>

namespace footlight::drivers::mock {
namespace {

constexpr std::uint64_t kAllDevices = 0xFFFF'FFFF;
constexpr unsigned kUnknownPid = 0, kFormat = 1, kWriteProtect = 4, kCommandClass = 5, kOutOfRange = 6;
constexpr unsigned kFanSpeed = 0x8001;

unsigned word(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<unsigned>(bytes[at] << 8 | bytes[at + 1]);
}

std::uint64_t uid_of(std::span<const std::uint8_t> bytes, std::size_t at) {
  std::uint64_t uid = 0;
  for (std::size_t i = 0; i < 6; ++i) uid = uid << 8 | bytes[at + i];
  return uid;
}

void put(Bytes& bytes, std::uint64_t value, int octets) {
  for (int shift = 8 * (octets - 1); shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

unsigned sum(std::span<const std::uint8_t> bytes) {
  unsigned total = 0;
  for (const std::uint8_t byte : bytes) total += byte;
  return total & 0xFFFFu;
}

bool is_whole(std::span<const std::uint8_t> request) {
  if (request.size() < 26 || request[0] != 0xCC || request[1] != 0x01) return false;
  const std::size_t length = request[2];
  return length >= 24 && request.size() >= length + 2 && request[23] == length - 24 &&
         word(request, length) == sum(request.first(length));
}

Bytes text(const std::string& words) { return {words.begin(), words.end()}; }

}  // namespace

Bytes RdmResponderModel::respond(std::span<const std::uint8_t> request, unsigned parameter, std::uint8_t type,
                                 const Bytes& data, unsigned command) {
  Bytes bytes = {0xCC, 0x01, static_cast<std::uint8_t>(24 + data.size())};
  bytes.insert(bytes.end(), request.begin() + 9, request.begin() + 15);  // to the requester
  put(bytes, uid, 6);
  bytes.push_back(request[15]);
  bytes.push_back(type);
  bytes.push_back(static_cast<std::uint8_t>(std::min<std::size_t>(queue_.size(), 255)));
  bytes.insert(bytes.end(), request.begin() + 18, request.begin() + 20);
  bytes.push_back(static_cast<std::uint8_t>(command + 1));
  put(bytes, parameter, 2);
  bytes.push_back(static_cast<std::uint8_t>(data.size()));
  bytes.insert(bytes.end(), data.begin(), data.end());
  put(bytes, sum(bytes) + (damages > 0 ? 1u : 0u), 2);
  if (damages > 0) --damages;
  return bytes;
}

Bytes RdmResponderModel::answer(std::span<const std::uint8_t> request) {
  if (!is_whole(request)) return {};
  const std::uint64_t to = uid_of(request, 3);
  const bool everybody = (to & kAllDevices) == kAllDevices;
  const bool makers_own = everybody && (to >> 32 == 0xFFFF || to >> 32 == uid >> 32);
  if (to != uid && !makers_own) return {};
  if (ignores > 0) {
    --ignores;
    return {};
  }
  ++request_count;
  const unsigned command = request[20];
  const unsigned parameter = word(request, 21);
  const auto data = request.subspan(24, request[23]);

  if (command == 0x10) {
    switch (parameter) {
      case 1: {
        if (muted && !stays_unmuted) return {};
        if (data.size() != 12 || uid < uid_of(data, 0) || uid > uid_of(data, 6)) return {};
        Bytes doubled;
        for (int shift = 40; shift >= 0; shift -= 8) {
          const auto octet = static_cast<std::uint8_t>(uid >> shift);
          doubled.push_back(octet | 0xAA);
          doubled.push_back(octet | 0x55);
        }
        const unsigned check = sum(doubled);
        for (const unsigned octet : {check >> 8, check & 0xFF}) {
          doubled.push_back(static_cast<std::uint8_t>(octet | 0xAA));
          doubled.push_back(static_cast<std::uint8_t>(octet | 0x55));
        }
        Bytes bytes(preamble, 0xFE);
        bytes.push_back(0xAA);
        bytes.insert(bytes.end(), doubled.begin(), doubled.end());
        return bytes;
      }
      case 2:
      case 3: {
        muted = parameter == 2;
        if (everybody || (parameter == 2 && never_confirms_mute)) return {};
        Bytes field;
        put(field, control_field, 2);
        return respond(request, parameter, 0, field, command);
      }
      default: return {};
    }
  }
  if (command != 0x20 && command != 0x30) return {};
  const bool set = command == 0x30;
  if (everybody && !set) return {};

  if (parameter == 0x0020 && !set) {
    if (!keeps_queue) return respond(request, parameter, 2, {0, kUnknownPid}, command);
    if (queue_.empty()) return respond(request, 0x0030, 0, {}, command);  // no status messages either
    const Queued next = queue_.front();
    queue_.pop_front();
    return respond(request, next.parameter, next.reply.type, next.reply.data, next.command);
  }
  const auto left = rest_.find(parameter);
  Reply reply;
  if (left != rest_.end() && !set) {
    reply.data = left->second;
    rest_.erase(left);
  } else {
    reply = act(set, parameter, data);
  }
  if (everybody) return {};
  if (ack_timer_units > 0 && !set) {
    Bytes time;
    put(time, ack_timer_units, 2);
    if (keeps_queue) {
      queue_.push_back({parameter, command, reply});
    } else {
      ack_timer_units = 0;  // ready the next time
    }
    return respond(request, parameter, 1, time, command);
  }
  if (reply.data.size() > answer_size_max) {
    rest_[parameter] = Bytes(reply.data.begin() + static_cast<std::ptrdiff_t>(answer_size_max), reply.data.end());
    reply.data.resize(answer_size_max);
    reply.type = 3;
  }
  return respond(request, parameter, reply.type, reply.data, command);
}

RdmResponderModel::Reply RdmResponderModel::act(bool set, unsigned parameter, std::span<const std::uint8_t> data) {
  const auto refuse = [](unsigned reason) {
    Reply reply;
    reply.type = 2;
    put(reply.data, reason, 2);
    return reply;
  };
  const auto ack = [](Bytes bytes) { return Reply{0, std::move(bytes)}; };
  const RdmPersonality& current = personalities[personality - 1u];
  Bytes bytes;
  if (set) {
    switch (parameter) {
      case 0x0082:
        if (label_is_locked) return refuse(kWriteProtect);
        if (data.size() > 32) return refuse(kFormat);
        label.assign(data.begin(), data.end());
        return ack({});
      case 0x00E0:
        if (data.size() != 1) return refuse(kFormat);
        if (data[0] < 1 || data[0] > personalities.size()) return refuse(kOutOfRange);
        personality = data[0];
        return ack({});
      case 0x00F0:
        if (data.size() != 2) return refuse(kFormat);
        if (word(data, 0) < 1 || word(data, 0) > 512) return refuse(kOutOfRange);
        start_address = static_cast<std::uint16_t>(word(data, 0));
        return ack({});
      case 0x1000:
        if (data.size() != 1) return refuse(kFormat);
        if (data[0] > 1) return refuse(kOutOfRange);
        identifies = data[0] == 1;
        return ack({});
      case kFanSpeed:
        if (data.size() != 1) return refuse(kFormat);
        if (data[0] > 100) return refuse(kOutOfRange);
        fan_percent = data[0];
        return ack({});
      case 0x0050:
      case 0x0051:
      case 0x0060:
      case 0x0080:
      case 0x0081:
      case 0x00C0:
      case 0x00E1:
      case 0x0120:
      case 0x0200:
      case 0x0201: return refuse(kCommandClass);
      default: return refuse(kUnknownPid);
    }
  }
  switch (parameter) {
    case 0x0050:  // those that E1.20 requires are not listed
      for (const unsigned one : {0x0080u, 0x0081u, 0x0082u, 0x00E0u, 0x00E1u, 0x0120u, 0x0200u, 0x0201u, kFanSpeed}) {
        put(bytes, one, 2);
      }
      return ack(bytes);
    case 0x0051:
      if (data.size() != 2) return refuse(kFormat);
      if (word(data, 0) != kFanSpeed) return refuse(kOutOfRange);
      put(bytes, kFanSpeed, 2);
      bytes.insert(bytes.end(), {1, 3, 3, 0, 0, 0});  // one octet, unsigned, get and set, no unit
      put(bytes, 0, 4);
      put(bytes, 100, 4);
      put(bytes, 50, 4);
      for (const char c : std::string("Fan speed")) bytes.push_back(static_cast<std::uint8_t>(c));
      return ack(bytes);
    case 0x0060:
      put(bytes, 0x0100, 2);
      put(bytes, model_id, 2);
      put(bytes, category, 2);
      put(bytes, software, 4);
      put(bytes, current.footprint, 2);
      put(bytes, personality, 1);
      put(bytes, personalities.size(), 1);
      put(bytes, current.footprint == 0 ? 0xFFFFu : start_address, 2);
      put(bytes, 0, 2);
      put(bytes, sensors.size(), 1);
      return ack(bytes);
    case 0x0080: return ack(text(model));
    case 0x0081: return ack(text(manufacturer));
    case 0x0082: return ack(text(label));
    case 0x00C0: return ack(text(version));
    case 0x00E0:
      put(bytes, personality, 1);
      put(bytes, personalities.size(), 1);
      return ack(bytes);
    case 0x00E1: {
      if (data.size() != 1) return refuse(kFormat);
      if (data[0] < 1 || data[0] > personalities.size()) return refuse(kOutOfRange);
      const RdmPersonality& chosen = personalities[data[0] - 1u];
      put(bytes, data[0], 1);
      put(bytes, chosen.footprint, 2);
      const Bytes name = text(chosen.name);
      bytes.insert(bytes.end(), name.begin(), name.end());
      return ack(bytes);
    }
    case 0x00F0: put(bytes, start_address, 2); return ack(bytes);
    case 0x0120:
      for (unsigned slot = 0; slot < current.footprint; ++slot) {
        put(bytes, slot, 2);
        put(bytes, 0, 1);
        put(bytes, slot == 0 ? 1u : 0xFFFFu, 2);  // intensity, then an undefined type
      }
      return ack(bytes);
    case 0x0200:
    case 0x0201: {
      if (data.size() != 1) return refuse(kFormat);
      if (data[0] >= sensors.size()) return refuse(kOutOfRange);
      const RdmSensor& sensor = sensors[data[0]];
      const auto value = static_cast<std::uint16_t>(sensor.value);
      put(bytes, data[0], 1);
      if (parameter == 0x0201) {
        for (int i = 0; i < 4; ++i) put(bytes, value, 2);
        return ack(bytes);
      }
      put(bytes, sensor.type, 1);
      put(bytes, sensor.unit, 1);
      put(bytes, 0, 1);
      for (const int limit : {-20, 120, 0, 80}) put(bytes, static_cast<std::uint16_t>(limit), 2);
      put(bytes, 0, 1);
      const Bytes name = text(sensor.name);
      bytes.insert(bytes.end(), name.begin(), name.end());
      return ack(bytes);
    }
    case 0x1000: return ack({static_cast<std::uint8_t>(identifies ? 1 : 0)});
    case kFanSpeed: return ack({fan_percent});
    default: return refuse(kUnknownPid);
  }
}

Bytes RdmLineModel::answer(std::span<const std::uint8_t> request) {
  Bytes line;
  for (RdmResponderModel& responder : responders) {
    const Bytes bytes = responder.answer(request);
    // Transmitters of equal strength on one pair of wires: a 0 (the line driven low) and a 1 at the same time may read
    // as either. Here they read as 0, as with a stronger pull-down.
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      if (i < line.size()) {
        line[i] = static_cast<std::uint8_t>(line[i] & bytes[i]);
      } else {
        line.push_back(bytes[i]);
      }
    }
  }
  return line;
}

RdmLineModel example_rdm_line() {
  RdmLineModel line;
  line.responders.resize(3);
  line.responders[1].uid = 0x7FF0'0000'0002;
  line.responders[1].label = "Spot stage left";
  line.responders[1].start_address = 17;
  line.responders[1].personality = 2;
  RdmResponderModel& dimmer = line.responders[2];
  dimmer.uid = 0x7FF0'0001'0000;
  dimmer.model = "Model of a dimmer";
  dimmer.label = "House";
  dimmer.category = 0x0508;
  dimmer.model_id = 2;
  dimmer.personalities = {{"Four dimmers", 4}};
  dimmer.sensors.clear();
  dimmer.start_address = 101;
  dimmer.control_field = 8;
  dimmer.ack_timer_units = 1;
  return line;
}

}  // namespace footlight::drivers::mock
