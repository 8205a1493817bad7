#include "drivers/mock/enttec_pro_model.h"

#include <algorithm>
#include <string_view>

namespace footlight::drivers::mock {
namespace {

constexpr std::size_t kPayloadSizeMax = 600;

}  // namespace

void EnttecProModel::power_on() {
  SerialModel::power_on();
  awaits_ = Awaits::kStart;
  payload_.clear();
  receive_modes = {0, 0};  // a new widget receives until the first label 6
  second_port_open = false;
  for (auto& frame : seen_) frame.fill(0);
}

void EnttecProModel::take(std::span<const std::uint8_t> bytes) {
  byte_count += bytes.size();
  for (const std::uint8_t byte : bytes) take_byte(byte);
}

void EnttecProModel::take_byte(std::uint8_t byte) {
  const auto refuse = [this] {
    ++false_start_count;
    awaits_ = Awaits::kStart;
  };
  switch (awaits_) {
    case Awaits::kStart:
      if (byte == 0x7E)
        awaits_ = Awaits::kLabel;
      else
        ++false_start_count;
      break;
    case Awaits::kLabel:
      label_ = byte;
      awaits_ = Awaits::kLengthLow;
      break;
    case Awaits::kLengthLow:
      payload_size_ = byte;
      awaits_ = Awaits::kLengthHigh;
      break;
    case Awaits::kLengthHigh:
      payload_size_ |= static_cast<std::size_t>(byte) << 8;
      payload_.clear();
      if (payload_size_ > kPayloadSizeMax)
        refuse();
      else
        awaits_ = payload_size_ == 0 ? Awaits::kEnd : Awaits::kPayload;
      break;
    case Awaits::kPayload:
      payload_.push_back(byte);
      if (payload_.size() == payload_size_) awaits_ = Awaits::kEnd;
      break;
    case Awaits::kEnd:
      if (byte != 0xE7) return refuse();
      awaits_ = Awaits::kStart;
      obey(label_, payload_);
      break;
  }
}

void EnttecProModel::obey(std::uint8_t label, const Bytes& payload) {
  newest_label = label;
  const bool second = second_port && second_port_open;
  const auto is_second = [&](std::uint8_t wanted) { return second && wanted != 0 && label == wanted; };
  const auto named = [&](std::uint16_t id, std::string_view name) {
    Bytes answer{static_cast<std::uint8_t>(id & 0xFF), static_cast<std::uint8_t>(id >> 8)};
    answer.insert(answer.end(), name.begin(), name.end());
    send(label, answer);
  };
  const auto output = [&](std::size_t line) {
    receive_modes[line] = -1;
    show(static_cast<int>(line), payload);
  };
  const auto set_mode = [&](std::size_t line) {
    if (payload.size() != 1) return;
    receive_modes[line] = payload[0];
    seen_[line].fill(0);
  };
  if (second_port && is_second(second_port->send)) return output(1);
  if (second_port && is_second(second_port->receive_mode)) return set_mode(1);
  switch (label) {
    case 3: {
      const std::size_t wanted = payload.size() == 2 ? payload[0] | static_cast<std::size_t>(payload[1]) << 8 : 0;
      Bytes answer{static_cast<std::uint8_t>(firmware & 0xFF), static_cast<std::uint8_t>(firmware >> 8), break_units,
                   mab_units, rate_hz};
      for (std::size_t i = 0; i < std::min<std::size_t>(wanted, 508); ++i)
        answer.push_back(i < user_.size() ? user_[i] : std::uint8_t{0xFF});
      send(3, answer);
      break;
    }
    case 4:
      if (payload.size() < 5) break;
      break_units = payload[2];
      mab_units = payload[3];
      rate_hz = payload[4];
      user_.assign(payload.begin() + 5, payload.end());
      break;
    case 6: output(0); break;
    case 7:
    case 11: {
      if (!rdm_line) break;
      ++rdm_request_count;
      receive_modes[0] = 0;  // its port is an input until the next label 6
      const Bytes answer = rdm_line->answer(payload);
      if (!answer.empty()) {
        Bytes received = {0};
        received.insert(received.end(), answer.begin(), answer.end());
        send(5, received);
      } else if (reports_rdm_timeout) {
        send(12, {});
      }
      break;
    }
    case 8: set_mode(0); break;
    case 10: {
      Bytes answer;
      for (int shift = 0; shift < 32; shift += 8)
        answer.push_back(static_cast<std::uint8_t>(widget_serial_bcd >> shift & 0xFF));
      send(10, answer);
      break;
    }
    case 13:
      second_port_open =
          second_port && std::equal(payload.begin(), payload.end(), second_port->key.begin(), second_port->key.end());
      break;
    case 77:
      if (esta_id) named(*esta_id, manufacturer);
      break;
    case 78:
      if (esta_id) named(device_id, product);
      break;
    case 99:
      if (port_count > 0) send(99, Bytes{port_count});
      break;
    case 100:
    case 101:
      if (port_count > 1) output(label - 100u);
      break;
    default: break;  // the widget ignores unknown labels
  }
}

void EnttecProModel::send(std::uint8_t label, std::span<const std::uint8_t> payload) {
  if (!answers) return;
  const std::uint8_t head[] = {0x7E, label, static_cast<std::uint8_t>(payload.size() & 0xFF),
                               static_cast<std::uint8_t>(payload.size() >> 8)};
  const std::uint8_t end[] = {0xE7};
  send_to_host(head);
  send_to_host(payload);
  send_to_host(end);
}

bool EnttecProModel::listens(int line) const {
  if (line == 1) return second_port && second_port_open && receive_modes[1] >= 0;
  return line == 0 && receive_modes[0] >= 0;
}

// Ignored while it sends, as in the hardware: line and transmitter are connected.
void EnttecProModel::receive_line_frame(int line, std::span<const std::uint8_t> line_frame, std::uint8_t status) {
  if (!listens(line)) return;
  const int receive_mode = receive_modes[static_cast<std::size_t>(line)];
  auto& seen = seen_[static_cast<std::size_t>(line)];
  const std::uint8_t received_label = line == 1 ? second_port->receive : 5;
  const std::uint8_t change_label = line == 1 ? second_port->change_of_state : 9;
  constexpr std::size_t kBlockSize = 8, kBlockSpan = 40;  // a message covers 40 bytes from a multiple of 8
  if (receive_mode == 0) {
    Bytes payload{status};
    payload.insert(payload.end(), line_frame.begin(), line_frame.end());
    send(received_label, payload);
  } else if (receive_mode == 1) {
    for (std::size_t i = 0; i < line_frame.size();) {
      if (line_frame[i] == seen[i]) {
        ++i;
        continue;
      }
      const std::size_t first = i / kBlockSize * kBlockSize;
      Bytes payload{static_cast<std::uint8_t>(first / kBlockSize), 0, 0, 0, 0, 0};
      for (; i < std::min(first + kBlockSpan, line_frame.size()); ++i) {
        if (line_frame[i] == seen[i]) continue;
        seen[i] = line_frame[i];
        payload[1 + (i - first) / 8] =
            static_cast<std::uint8_t>(payload[1 + (i - first) / 8] | 1u << ((i - first) % 8));
        payload.push_back(line_frame[i]);
      }
      send(change_label, payload);
    }
  }
}

}  // namespace footlight::drivers::mock
