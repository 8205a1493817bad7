#include "drivers/mock/dmxcreator_model.h"

#include <algorithm>

namespace footlight::drivers::mock {

Bytes DmxCreatorModel::device_descriptor() const {
  return {18, 1, 0x10, 0x01, 0xFF, 0, 0, 8, 0x30, 0x0A, 0x02, 0x00, 0x00, 0x01, 1, 2, 3, 1};  // 0A30:0002
}

Bytes DmxCreatorModel::config_descriptor() const {
  return {9, 2, 32,   0, 1,  1,    0, 0x80, 50,  // one interface, bus powered
          9, 4, 0,    0, 2,  0xFF, 0, 0,    0,   // vendor class
          7, 5, 0x01, 2, 64, 0,    0, 7,    5,  0x02, 2, 64, 0, 0};
}

void DmxCreatorModel::power_on() {
  UsbModel::power_on();
  ++power_on_count;
  memory.fill(0);
  announcement_.clear();
  levels_.clear();
  awaited_ = 0;
}

std::optional<Bytes> DmxCreatorModel::control(const SetupPacket& setup, std::span<const std::uint8_t>) {
  if ((setup.request_type & 0x60) == 0) return standard_request(*this, setup);
  return std::nullopt;
}

void DmxCreatorModel::data_out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) {
  if (endpoint == 0x01) {
    if (!announcement_.empty() && !bytes.empty() && bytes[0] == 0x80) {  // the rest of the last snapshot never came
      ++broken_count;
      announcement_.clear();
    }
    announcement_.insert(announcement_.end(), bytes.begin(), bytes.end());
    if (announcement_.size() < 6) return;
    const bool good = announcement_[0] == 0x80 && announcement_[1] == 0x01 &&
                      (announcement_[5] == 1 || announcement_[5] == 2) && announcement_.size() == 6;
    if (!good) ++broken_count;
    if (awaited_ > 0) ++cut_count;
    awaited_ = good ? announcement_[5] * std::size_t{256} : 0;
    announcement_.clear();
    levels_.clear();
    return;
  }
  levels_.insert(levels_.end(), bytes.begin(), bytes.end());
  if (endpoint != 0x02 || levels_.size() > awaited_) {
    ++broken_count;
    levels_.clear();
    awaited_ = 0;
  } else if (levels_.size() == awaited_) {
    std::copy(levels_.begin(), levels_.end(), memory.begin());
    levels_.clear();
    awaited_ = 0;
    Bytes frame{0};
    frame.insert(frame.end(), memory.begin(), memory.end());
    show(0, std::move(frame));
  }
}

}  // namespace footlight::drivers::mock
