#include "drivers/mock/vince_model.h"

namespace footlight::drivers::mock {

void VinceModel::power_on() {
  SerialModel::power_on();
  held_.clear();
  started = false;
}

void VinceModel::take(std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes) {
    if (held_.size() < 2 && byte != 0x0F) {
      held_.clear();
      continue;
    }
    held_.push_back(byte);
    if (held_.size() < 6) continue;
    const std::size_t size = 5u + (static_cast<std::size_t>(held_[3]) << 8 | held_[4]) + 1u;
    if (held_.size() < size) continue;
    if (held_.back() == 0x04)
      obey();
    else
      ++broken_count;
    held_.clear();
  }
}

void VinceModel::obey() {
  const std::uint8_t command = held_[2];
  if (command == 0x01) started = true;
  if (command == 0x02) started = false;
  if (command == 0x11 && started && status == 0 && held_.size() > 8) {
    Bytes frame{0};
    frame.insert(frame.end(), held_.begin() + 7, held_.end() - 1);
    show(0, std::move(frame));
  }
  if (answers) send_to_host(Bytes{0x0F, 0x0F, command, status, 0, 0, 0x04});
}

}  // namespace footlight::drivers::mock
