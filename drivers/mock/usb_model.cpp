#include "drivers/mock/usb_model.h"

namespace footlight::drivers::mock {
namespace {

constexpr std::uint8_t kGetStatus = 0, kClearFeature = 1, kSetFeature = 3, kGetDescriptor = 6, kGetConfiguration = 8,
                       kSetConfiguration = 9, kGetInterface = 10, kSetInterface = 11;
constexpr unsigned kDeviceDescriptor = 1, kConfigDescriptor = 2, kStringDescriptor = 3;

Bytes clipped(Bytes bytes, std::size_t size_max) {
  if (bytes.size() > size_max) bytes.resize(size_max);
  return bytes;
}

Bytes string_descriptor(const std::string& text) {
  Bytes bytes{static_cast<std::uint8_t>(2 + 2 * text.size()), kStringDescriptor};
  for (const char c : text) {
    bytes.push_back(static_cast<std::uint8_t>(c));  // UTF-16, low byte first; the texts are ASCII
    bytes.push_back(0);
  }
  return bytes;
}

std::optional<Bytes> descriptor(const UsbModel& model, const SetupPacket& setup) {
  constexpr std::uint8_t kEnglish[] = {4, kStringDescriptor, 0x09, 0x04};
  const std::size_t index = setup.value & 0xFFu;
  switch (setup.value >> 8) {
    case kDeviceDescriptor: return clipped(model.device_descriptor(), setup.length);
    case kConfigDescriptor: return clipped(model.config_descriptor(), setup.length);
    case kStringDescriptor: {
      if (index == 0) return clipped(Bytes(std::begin(kEnglish), std::end(kEnglish)), setup.length);
      const std::vector<std::string> texts = model.strings();
      if (index > texts.size()) return std::nullopt;
      return clipped(string_descriptor(texts[index - 1]), setup.length);
    }
    default: return std::nullopt;
  }
}

}  // namespace

const UsbModel::Line& UsbModel::line(int number) const {
  static const Line kNone;
  const auto index = static_cast<std::size_t>(number);
  return index < lines_.size() ? lines_[index] : kNone;
}

void UsbModel::power_on() {
  for (Line& line : lines_) line.frame.clear();
}

void UsbModel::show(int line, Bytes frame) {
  const auto index = static_cast<std::size_t>(line);
  if (index >= lines_.size()) lines_.resize(index + 1);
  lines_[index].frame = std::move(frame);
  ++lines_[index].frame_count;
  if (on_frame) on_frame(line, lines_[index].frame);
}

void UsbModel::receive_line_frame(int, std::span<const std::uint8_t>, std::uint8_t) {}
void UsbModel::send_to_host(std::span<const std::uint8_t>) {}

std::optional<Bytes> standard_request(const UsbModel& model, const SetupPacket& setup) {
  switch (setup.request) {
    case kGetDescriptor: return descriptor(model, setup);
    case kGetStatus: return clipped({0, 0}, setup.length);
    case kGetConfiguration: return clipped({1}, setup.length);
    case kGetInterface: return clipped({0}, setup.length);
    case kClearFeature:
    case kSetFeature:
    case kSetConfiguration:
    case kSetInterface: return Bytes{};
    default: return std::nullopt;
  }
}

}  // namespace footlight::drivers::mock
