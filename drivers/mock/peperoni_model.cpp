#include "drivers/mock/peperoni_model.h"

namespace footlight::drivers::mock {
namespace {

constexpr std::size_t kShortSize = 4 + 512, kLongSize = 13 + 519;

}  // namespace

Bytes PeperoniModel::device_descriptor() const {
  return {18,
          1,
          0x10,
          0x01,
          0xFF,
          0,
          0,
          8,
          0xE1,
          0x0C,
          static_cast<std::uint8_t>(usb_product & 0xFF),
          static_cast<std::uint8_t>(usb_product >> 8),
          static_cast<std::uint8_t>(release & 0xFF),
          static_cast<std::uint8_t>(release >> 8),
          1,
          2,
          3,
          1};
}

Bytes PeperoniModel::config_descriptor() const {
  return {9, 2, 32,   0, 1,  1,    0,    0x80, 250,  // one interface, bus powered
          9, 4, 0,    0, 2,  0xFF, 0xFF, 0xFF, 0,    // vendor class
          7, 5, 0x82, 2, 64, 0,    0,    7,    5,   0x02, 2, 64, 0, 0};
}

void PeperoniModel::power_on() {
  UsbModel::power_on();
  ++power_on_count;
  coming_.clear();
  to_host_.clear();
  start_code = -1;
}

std::optional<Bytes> PeperoniModel::control(const SetupPacket& setup, std::span<const std::uint8_t> data) {
  if ((setup.request_type & 0x60) == 0) return standard_request(*this, setup);
  if (setup.request_type != 0x40) return std::nullopt;
  switch (setup.request) {
    case 0x09: start_code = setup.value; return Bytes{};
    case 0x08:
      if (setup.index != 0 || setup.length != 512 || data.size() != 512) {
        ++broken_count;
        return std::nullopt;
      }
      show_levels(0, data);
      return Bytes{};
    default: return std::nullopt;
  }
}

void PeperoniModel::data_out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) {
  if (endpoint != 0x02 || release < 0x0400) {
    ++broken_count;
    return;
  }
  // The rest of a message that was cut short never comes: the next one starts at the head of a transfer.
  const bool is_head = bytes.size() >= 4 && ((bytes[0] == 0x02 && bytes[1] == 'M' && bytes[2] == 'k') ||
                                             (bytes[0] == 0x01 && bytes[2] == 0x00 && bytes[3] == 0x02));
  if (is_head && !coming_.empty()) {
    ++broken_count;
    coming_.clear();
  }
  coming_.insert(coming_.end(), bytes.begin(), bytes.end());
  take_message();
}

void PeperoniModel::take_message() {
  const bool is_long = !coming_.empty() && coming_[0] == 0x02;
  const std::size_t size = is_long ? kLongSize : kShortSize;
  if (coming_.size() < size) return;
  const Bytes message = std::move(coming_);
  coming_.clear();
  const auto part = [&](std::size_t from, std::size_t count) { return std::span(message).subspan(from, count); };
  const auto has_magic = [&](std::size_t from) {
    return message[from] == 0x02 && message[from + 1] == 'M' && message[from + 2] == 'k' && message[from + 3] == '2';
  };
  if (message.size() != size) {
    ++broken_count;
  } else if (!is_long) {
    const bool good = message[0] == 0x01 && (message[1] == 0 || (message[1] == 4 && usb_product == 0x0004)) &&
                      message[2] == 0x00 && message[3] == 0x02;
    if (good)
      show_levels(message[1] == 4 ? 1 : 0, part(4, 512));
    else
      ++broken_count;
  } else {
    const bool good = release >= 0x0500 && has_magic(0) && message[4] == 0x00 && message[6] == 0x07 &&
                      message[7] == 0x02 && has_magic(13) && message[17] == 0x01 && message[18] == 0x02 &&
                      message[19] == 0;
    if (!good) {
      ++broken_count;
      return;
    }
    const bool known = message[5] == 0 || (message[5] == 1 && usb_product == 0x0004);
    settings = message[8];
    break_code = message[11];
    mark_code = message[12];
    if (known && status == 0) show_levels(message[5], part(20, 512));
    if (answers) send_to_host(Bytes{0x02, 'M', 'k', '2', 0x34, 0x12, known ? status : std::uint8_t{3}, 0});
  }
}

void PeperoniModel::show_levels(int universe, std::span<const std::uint8_t> levels) {
  Bytes frame{0};
  frame.insert(frame.end(), levels.begin(), levels.end());
  show(universe, std::move(frame));
}

Bytes PeperoniModel::data_in(std::uint8_t, std::size_t size_max) {
  if (to_host_.empty()) return {};
  Bytes bytes = std::move(to_host_.front());
  to_host_.pop_front();
  if (bytes.size() > size_max) bytes.resize(size_max);
  return bytes;
}

}  // namespace footlight::drivers::mock
