#include "drivers/mock/nodle_model.h"

#include <algorithm>

namespace footlight::drivers::mock {

void NodleModel::power_on() {
  HidModel::power_on();
  mode = 0;
  memory.fill(0);
  received_any_ = false;
}

void NodleModel::data_out(std::uint8_t, std::span<const std::uint8_t> bytes) {
  if (bytes.size() != 33 || bytes[0] > 16) {
    ++broken_count;
    return;
  }
  if (bytes[0] == 16) {
    mode = bytes[1] & 7;
    ++mode_count;
    received_any_ = false;
  } else {
    for (std::size_t i = 0; i < 32; ++i) memory[bytes[0] * std::size_t{32} + i] = bytes[1 + i];
    ++block_count;
  }
  if ((mode & 2) == 0) return;
  Bytes frame{0};
  frame.insert(frame.end(), memory.begin(), memory.end());
  show(0, std::move(frame));
}

void NodleModel::receive_line_frame(int line, std::span<const std::uint8_t> line_frame, std::uint8_t) {
  if (!listens(line) || line_frame.empty() || line_frame[0] != 0) return;
  std::array<std::uint8_t, 512> slots = received_;
  std::copy(line_frame.begin() + 1, line_frame.end(), slots.begin());
  for (std::size_t block = 0; block < 16; ++block) {
    const auto levels = std::span(slots).subspan(block * 32, 32);
    if (received_any_ &&
        std::equal(levels.begin(), levels.end(), received_.begin() + static_cast<std::ptrdiff_t>(block * 32)))
      continue;
    Bytes report{static_cast<std::uint8_t>(block)};
    report.insert(report.end(), levels.begin(), levels.end());
    send_to_host(report);
  }
  received_ = slots;
  received_any_ = true;
}

}  // namespace footlight::drivers::mock
