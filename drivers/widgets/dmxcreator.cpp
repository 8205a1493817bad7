// DMXCreator 512 Basic: three bulk transfers per snapshot.
//
// Endpoint 1 takes 80 01 00 00 00 02, which announces 512 slots (01 at the end: 256); then endpoint 2 takes slots 0 to
// 255 and slots 256 to 511. The device repeats its levels. Source: DMXCreator512Basic.cpp and DMXCreator.cpp of OLA.
#include <array>

#include "drivers/driver.h"
#include "drivers/mock/dmxcreator_model.h"

namespace footlight::drivers {
namespace {

constexpr std::uint8_t kAnnouncements = 0x01, kLevels = 0x02;  // endpoints
constexpr DurationNs kPatienceNs = 250 * kNsPerMs;             // per transfer
constexpr int kAttemptCountMax = 3;                            // it sometimes refuses a transfer
constexpr std::array<std::uint8_t, 6> kAnnouncement{0x80, 0x01, 0x00, 0x00, 0x00, 0x02};
constexpr std::size_t kPartSize = 256;

class DmxCreatorWidget final : public Widget {
 public:
  int line_count() const override { return 1; }
  Status can(int, LineUse use) const override {
    if (use == LineUse::kInput) return fail(ErrorCode::kUnsupported, "DMXCreator has no input; use it as an output");
    return {};
  }

  Result<WidgetTraits> begin(WidgetContext&) override { return WidgetTraits{}; }

  // Restarts with the announcement if a part was refused, so that the parts of two snapshots never mix.
  Status send(WidgetContext& context, int, std::span<const std::uint8_t, kSlotCountMax> snapshot) override {
    Status sent;
    for (int attempt = 1; attempt <= kAttemptCountMax; ++attempt) {
      sent = send_once(context, snapshot);
      if (sent || sent.error().code != ErrorCode::kIo) return sent;
      ++refused_count_;
    }
    return sent;
  }

  Status listen(WidgetContext& context, TimeNs deadline_ns) override { return context.transport().wait(deadline_ns); }

  std::vector<WidgetFigure> figures() const override {
    return {{"refused_transfers", static_cast<double>(refused_count_)}};
  }

 private:
  static Status send_once(WidgetContext& context, std::span<const std::uint8_t, kSlotCountMax> snapshot) {
    const auto write = [&](std::uint8_t endpoint, std::span<const std::uint8_t> bytes) {
      return context.transport().write_endpoint(endpoint, bytes, context.now_ns() + kPatienceNs);
    };
    FL_TRY(write(kAnnouncements, kAnnouncement));
    FL_TRY(write(kLevels, snapshot.first(kPartSize)));
    return write(kLevels, snapshot.subspan(kPartSize));
  }

  std::uint64_t refused_count_ = 0;
};

constexpr UsbModelId kModels[] = {
    {.vendor = 0x0A30,
     .product = 0x0002,
     .manufacturer_text = "",
     .product_text = "",
     .model_name = "DMXCreator 512 Basic",
     .quirks = 0,
     .transport = TransportKind::kUsb},
};

}  // namespace

extern constinit const DriverInfo dmxcreator_driver{
    .id = "dmxcreator",
    .full_name = "DMXCreator 512 Basic",
    .usb_ids = kModels,
    .capabilities = kCanOutput | kKeepsSnapshotAlive,
    .notes = "A frame is an announcement and two halves of 256 slots.",
    .make_widget = [](const PortRequest&, const UsbModelId&) -> Result<std::unique_ptr<Widget>> {
      return std::make_unique<DmxCreatorWidget>();
    },
    .make_model = []() -> std::unique_ptr<mock::UsbModel> { return std::make_unique<mock::DmxCreatorModel>(); },
};

}  // namespace footlight::drivers
