#include "drivers/mock/eurolite_model.h"

#include <algorithm>

namespace footlight::drivers::mock {
namespace {

constexpr std::uint8_t kHead[] = {0x7E, 0x06, 0x01, 0x02};  // label 6, 513 bytes
constexpr std::size_t kMessageSize = 518;

}  // namespace

Bytes EuroliteModel::device_descriptor() const {
  return {18, 1, 0x00, 0x02, 0, 0, 0, 64, 0xD8, 0x04, 0x63, 0xFA, 0x00, 0x01, 1, 2, 3, 1};  // 04D8:FA63
}

Bytes EuroliteModel::config_descriptor() const {
  return {9, 2, 32,   0, 1,  1,    0,    0x80, 50,  // one interface
          9, 4, 0,    0, 2,  0xFF, 0xFF, 0xFF, 0,   // vendor class, two endpoints
          7, 5, 0x82, 2, 64, 0,    0,    7,    5,  0x02, 2, 64, 0, 0};
}

std::optional<Bytes> EuroliteModel::control(const SetupPacket& setup, std::span<const std::uint8_t>) {
  if ((setup.request_type & 0x60u) != 0) return std::nullopt;
  return standard_request(*this, setup);
}

void EuroliteModel::data_out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) {
  if (endpoint != 0x02) return;
  for (const std::uint8_t byte : bytes) {
    if (held_.size() < std::size(kHead) && byte != kHead[held_.size()]) {
      stray_byte_count += held_.size() + 1;
      held_.clear();
      continue;
    }
    held_.push_back(byte);
    if (held_.size() < kMessageSize) continue;
    if (held_.back() == 0xE7) show(0, Bytes(held_.begin() + std::ssize(kHead), held_.end() - 1));
    held_.clear();
  }
}

}  // namespace footlight::drivers::mock
