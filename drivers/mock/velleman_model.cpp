#include "drivers/mock/velleman_model.h"

namespace footlight::drivers::mock {

HidModel::Shape VellemanModel::shape() const {
  return {.vendor = 0x10CF,
          .product = 0x8062,
          .low_speed = !upgraded,
          .endpoint_out = 0x01,
          .endpoint_in = 0x81,
          .report_size = static_cast<std::uint8_t>(upgraded ? 64 : 8)};
}

void VellemanModel::power_on() {
  HidModel::power_on();
  next_ = 512;
}

void VellemanModel::data_out(std::uint8_t, std::span<const std::uint8_t> bytes) {
  ++report_count;
  bool good = false;
  if (bytes.size() == shape().report_size) {
    const int zeros = bytes[1];
    switch (bytes[0]) {
      case 4:
        if (next_ < 512) ++cut_count;
        next_ = 0;
        good = zeros >= 1 && zeros <= (upgraded ? 255 : 101) &&
               take(bytes.subspan(2), static_cast<std::size_t>(zeros - 1));
        break;
      case 5: good = zeros <= (upgraded ? 254 : 100) && take(bytes.subspan(2), static_cast<std::size_t>(zeros)); break;
      case 2: good = take(bytes.subspan(1), 0); break;
      case 3: good = take(bytes.subspan(1, 1), 0); break;
      case 6: good = upgraded && zeros <= 62 && take(bytes.subspan(2, static_cast<std::size_t>(zeros)), 0); break;
      default: break;
    }
  }
  if (!good) {
    ++broken_count;
    next_ = 512;
  }
}

bool VellemanModel::take(std::span<const std::uint8_t> slots, std::size_t zeros) {
  if (next_ + zeros + slots.size() > 512) return false;
  for (std::size_t i = 0; i < zeros; ++i) coming_[next_++] = 0;
  for (const std::uint8_t slot : slots) coming_[next_++] = slot;
  if (next_ == 512) {
    Bytes frame{0};
    frame.insert(frame.end(), coming_.begin(), coming_.end());
    show(0, std::move(frame));
  }
  return true;
}

}  // namespace footlight::drivers::mock
