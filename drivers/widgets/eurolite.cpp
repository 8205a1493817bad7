// Eurolite USB-DMX512 PRO and PRO MK2: outputs that receive the label 6 message of a DMX USB Pro and never answer. The
// PRO has its own bulk endpoint, the MK2 is behind an FTDI chip with FTDI's own ids and names.
//
// Source: the traffic of other programs. Not tried on hardware.
#include "drivers/device/widget.h"
#include "drivers/driver.h"
#include "drivers/mock/enttec_pro_model.h"
#include "drivers/mock/eurolite_model.h"
#include "drivers/widgets/enttec_pro_frame.h"

namespace footlight::drivers {
namespace {

constexpr std::uint8_t kBulkOut = 0x02;
constexpr DurationNs kWriteTimeoutNs = 250 * kNsPerMs;

class Eurolite final : public Widget {
 public:
  explicit Eurolite(bool is_serial) : is_serial_(is_serial) {}

  int line_count() const override { return 1; }
  Status can(int, LineUse use) const override {
    if (use == LineUse::kInput) return fail(ErrorCode::kUnsupported, "this model has an output only");
    return {};
  }
  Result<WidgetTraits> begin(WidgetContext& context) override {
    cut_short_ = false;
    WidgetTraits traits;
    if (!is_serial_) return traits;
    FL_TRY(context.transport().set_line({}, context.now_ns() + kWriteTimeoutNs));
    // A program that was killed in the middle of a message leaves the device waiting for the rest.
    FL_TRY(context.transport().write(pro_flush_bytes(), context.now_ns() + kWriteTimeoutNs));
    return traits;
  }
  Status send(WidgetContext& context, int, std::span<const std::uint8_t, kSlotCountMax> snapshot) override {
    const TimeNs deadline_ns = context.now_ns() + kWriteTimeoutNs;
    if (cut_short_) {
      FL_TRY(write(context, pro_flush_bytes(), deadline_ns));
      cut_short_ = false;
    }
    return write(context, encode_send_dmx(snapshot).bytes(), deadline_ns);
  }
  Status listen(WidgetContext& context, TimeNs deadline_ns) override {
    if (!is_serial_) return context.transport().wait(deadline_ns);
    // An unplug is detected by reading the chip's status.
    std::array<std::uint8_t, 64> bytes;
    FL_TRY(context.transport().read(bytes, deadline_ns));
    return {};
  }

 private:
  Status write(WidgetContext& context, std::span<const std::uint8_t> bytes, TimeNs deadline_ns) {
    Transport& transport = context.transport();
    const Status written =
        is_serial_ ? transport.write(bytes, deadline_ns) : transport.write_endpoint(kBulkOut, bytes, deadline_ns);
    if (!written) cut_short_ = true;
    return written;
  }

  const bool is_serial_;
  bool cut_short_ = false;  // the last write ended in the middle
};

constexpr UsbModelId kProModels[] = {{.vendor = 0x04D8,
                                      .product = 0xFA63,
                                      .manufacturer_text = "",
                                      .product_text = "",
                                      .model_name = "Eurolite USB-DMX512 PRO",
                                      .transport = TransportKind::kUsb}};
constexpr UsbModelId kMk2Models[] = {{.vendor = 0x0403,
                                      .product = 0x6001,
                                      .manufacturer_text = "",
                                      .product_text = "",
                                      .model_name = "Eurolite USB-DMX512 PRO MK2",
                                      .quirks = kQuirkGenericUsbIds}};

}  // namespace

extern constinit const DriverInfo eurolite_pro_driver{
    .id = "eurolite-pro",
    .full_name = "Eurolite USB-DMX512 PRO",
    .usb_ids = kProModels,
    .capabilities = kCanOutput | kKeepsSnapshotAlive,
    .notes = "One output.",
    .make_widget = [](const PortRequest&, const UsbModelId&) -> Result<std::unique_ptr<Widget>> {
      return std::make_unique<Eurolite>(false);
    },
    .make_model = []() -> std::unique_ptr<mock::UsbModel> { return std::make_unique<mock::EuroliteModel>(); },
};

extern constinit const DriverInfo eurolite_mk2_driver{
    .id = "eurolite-mk2",
    .full_name = "Eurolite USB-DMX512 PRO MK2",
    .usb_ids = kMk2Models,
    .capabilities = kCanOutput | kKeepsSnapshotAlive,
    .notes =
        "One output. Must be named by its serial number or port, because it identifies itself only as an FTDI chip.",
    .make_widget = [](const PortRequest&, const UsbModelId&) -> Result<std::unique_ptr<Widget>> {
      return std::make_unique<Eurolite>(true);
    },
    .make_model = []() -> std::unique_ptr<mock::UsbModel> {
      auto model = std::make_unique<mock::EnttecProModel>();
      model->manufacturer = "FTDI";
      model->product = "FT232R USB UART";
      model->serial = "AL02QX3T";
      model->answers = false;
      return model;
    },
};

}  // namespace footlight::drivers
