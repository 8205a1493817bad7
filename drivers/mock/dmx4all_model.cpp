#include "drivers/mock/dmx4all_model.h"

#include <algorithm>
#include <cstdlib>

namespace footlight::drivers::mock {

void Dmx4allModel::power_on() {
  SerialModel::power_on();
  held_.clear();
  frame_.assign(513, 0);
  slot_count = 0;
}

void Dmx4allModel::take(std::span<const std::uint8_t> bytes) {
  const std::uint64_t before = command_count;
  for (const std::uint8_t byte : bytes) take_byte(byte);
  if (command_count != before) show(0, frame_);
}

void Dmx4allModel::done() {
  ++command_count;
  held_.clear();
  if (answers) send_to_host(Bytes{'G'});
}

void Dmx4allModel::take_byte(std::uint8_t byte) {
  if (held_.empty() && byte != 0xE2 && byte != 0xE3 && byte != 'C' && byte != 'N') {
    ++refused_count;
    return;
  }
  held_.push_back(byte);
  const std::uint8_t command = held_[0];
  if (command == 0xE2 || command == 0xE3) {
    if (held_.size() < 3) return;
    frame_[1u + (command == 0xE3 ? 256u : 0u) + held_[1]] = held_[2];
    return done();
  }
  if (command == 'C') {
    if (held_.size() == 2 && held_[1] == '?') return done();
    if (held_.size() < 8) return;  // CnnnLvvv
    const std::string text(held_.begin(), held_.end());
    const int slot = std::atoi(text.substr(1, 3).c_str()), level = std::atoi(text.substr(5, 3).c_str());
    if (slot >= 0 && slot < 512 && level >= 0 && level <= 255)
      frame_[1u + static_cast<std::size_t>(slot)] = static_cast<std::uint8_t>(level);
    return done();
  }
  if (held_.size() < 4) return;  // Nnnn
  slot_count = std::atoi(std::string(held_.begin() + 1, held_.end()).c_str()) + 1;
  done();
}

}  // namespace footlight::drivers::mock
