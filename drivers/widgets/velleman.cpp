// Velleman K8062 and VM116: output only.
//
// Reports go out through libusb, to the interrupt endpoint of the HID interface. A stock kernel makes no hidraw node
// for these devices: hid-quirks ignores their ids, and vmk80xx binds to them (decisions/0089-velleman-by-libusb.md).
#include <algorithm>

#include "drivers/driver.h"
#include "drivers/mock/velleman_model.h"
#include "drivers/transport/hid_descriptors.h"
#include "drivers/widgets/velleman_frame.h"

namespace footlight::drivers {
namespace {

constexpr DurationNs kReportPatienceNs = 250 * kNsPerMs;
// No source states that it repeats a snapshot. According to OLA's driver, a snapshot is sent when the next one starts.
// So snapshots are repeated, but not continuously, because a new one would have to wait.
constexpr DurationNs kRepeatNs = 100 * kNsPerMs;
constexpr HidEndpoint kOriginal{.address = 0x01, .report_size = kVellemanReportSize, .interval_ms = 10};
constexpr double kLineRateHzMax = 44.0;

class VellemanWidget final : public Widget {
 public:
  int line_count() const override { return 1; }
  Status can(int, LineUse use) const override {
    if (use == LineUse::kInput)
      return fail(ErrorCode::kUnsupported, "Velleman interfaces have no input; use it as an output");
    return {};
  }

  Result<WidgetTraits> begin(WidgetContext& context) override {
    FL_ASSIGN(const auto endpoint, ask_hid_output(context.transport(), context.now_ns() + kReportPatienceNs));
    const HidEndpoint output = endpoint.value_or(kOriginal);
    const bool upgraded = output.report_size == kVellemanUpgradedReportSize;
    endpoint_ = output.address;
    report_size_ = upgraded ? kVellemanUpgradedReportSize : kVellemanReportSize;
    sent_ns_ = INT64_MIN;

    Slots bright;
    bright.fill(1);
    const auto rate_hz = [&](const Slots& snapshot) {
      const auto look_ms = static_cast<double>(VellemanReports(snapshot, report_size_).count()) * output.interval_ms;
      return std::min(kLineRateHzMax, 1000.0 / look_ms);
    };
    WidgetTraits traits{.rate_hz_max = rate_hz(Slots{}),
                        .keep_alive_ns = kRepeatNs,
                        .identity = fmt::format("reports of {} bytes every {} ms", report_size_, output.interval_ms),
                        .remarks = {}};
    if (const double bright_hz = rate_hz(bright); bright_hz < kLineRateHzMax)
      traits.remarks.push_back(fmt::format("a frame without zeros takes {} reports of {} ms: {:.1f} a second",
                                           VellemanReports(bright, report_size_).count(), output.interval_ms,
                                           bright_hz));
    if (!upgraded && output.report_size != kVellemanReportSize)
      traits.remarks.push_back(
          fmt::format("its reports have {} bytes, of which only 8 are known to be used", output.report_size));
    return traits;
  }

  Status send(WidgetContext& context, int, std::span<const std::uint8_t, kSlotCountMax> snapshot) override {
    const bool same = std::equal(snapshot.begin(), snapshot.end(), sent_.begin());
    if (same && sent_ns_ != INT64_MIN && context.now_ns() < sent_ns_ + kRepeatNs) return {};
    const TimeNs begin_ns = context.now_ns();
    sent_ns_ = INT64_MIN;
    const VellemanReports reports(snapshot, report_size_);
    for (std::size_t i = 0; i < reports.count(); ++i)
      FL_TRY(context.transport().write_endpoint(endpoint_, reports[i], context.now_ns() + kReportPatienceNs));
    sent_ns_ = begin_ns;
    std::copy(snapshot.begin(), snapshot.end(), sent_.begin());
    report_count_ += reports.count();
    snapshot_ns_ = context.now_ns() - begin_ns;
    return {};
  }

  Status listen(WidgetContext& context, TimeNs deadline_ns) override { return context.transport().wait(deadline_ns); }

  std::vector<WidgetFigure> figures() const override {
    return {{"reports_sent", static_cast<double>(report_count_)},
            {"last_look_ms", static_cast<double>(snapshot_ns_) * 1e-6}};
  }

 private:
  std::uint8_t endpoint_ = kOriginal.address;
  std::size_t report_size_ = kVellemanReportSize;
  Slots sent_{};
  TimeNs sent_ns_ = INT64_MIN;  // when the snapshot in sent_ was started; INT64_MIN: the device may have other levels
  std::uint64_t report_count_ = 0;
  DurationNs snapshot_ns_ = 0;
};

constexpr UsbModelId kModels[] = {
    {.vendor = 0x10CF,
     .product = 0x8062,
     .manufacturer_text = "",
     .product_text = "",
     .model_name = "Velleman K8062, VM116",
     .quirks = 0,
     .transport = TransportKind::kUsb},
};

}  // namespace

extern constinit const DriverInfo velleman_driver{
    .id = "velleman",
    .full_name = "Velleman K8062, VM116",
    .usb_ids = kModels,
    .capabilities = kCanOutput,
    .notes =
        "Low speed: 20 frames a second if most slots are 0, 1.3 if none is; the replacement firmware with "
        "64-byte reports is detected by its descriptor.",
    .make_widget = [](const PortRequest&, const UsbModelId&) -> Result<std::unique_ptr<Widget>> {
      return std::make_unique<VellemanWidget>();
    },
    .make_model = []() -> std::unique_ptr<mock::UsbModel> { return std::make_unique<mock::VellemanModel>(); },
};

}  // namespace footlight::drivers
