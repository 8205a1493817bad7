// Vince USB-DMX512 converter: one output behind an FTDI chip. Every update is answered; the next one waits for the
// answer.
//
// Not tried on hardware.
#include "drivers/device/widget.h"
#include "drivers/driver.h"
#include "drivers/mock/vince_model.h"
#include "drivers/widgets/vince_frame.h"

namespace footlight::drivers {
namespace {

constexpr DurationNs kTimeoutNs = 250 * kNsPerMs;

class Vince final : public Widget {
 public:
  int line_count() const override { return 1; }
  Status can(int, LineUse use) const override {
    if (use == LineUse::kInput) return fail(ErrorCode::kUnsupported, "only the output of this model is supported");
    return {};
  }

  Result<WidgetTraits> begin(WidgetContext& context) override {
    replies_.reset();
    unread_ = {};
    cut_short_ = true;  // another program may have left half a message
    FL_TRY(context.transport().set_line({.latency_ms = 2}, context.now_ns() + kTimeoutNs));
    FL_TRY(end_message(context));
    return WidgetTraits{};
  }

  Status send(WidgetContext& context, int, std::span<const std::uint8_t, kSlotCountMax> snapshot) override {
    FL_TRY(end_message(context));
    FL_TRY(write(context, encode_vince_update(snapshot)));
    const TimeNs deadline_ns = context.now_ns() + kTimeoutNs;
    while (true) {
      VinceReply reply;
      while (replies_.next(unread_, reply)) {
        if (reply.command != static_cast<std::uint8_t>(VinceCommand::kUpdate)) continue;  // a late answer
        if (reply.status == 0) return {};
        context.count_rejected();
        return fail(ErrorCode::kTimeout, "{}: refused an update with status {}", context.transport().where(),
                    reply.status);
      }
      if (context.now_ns() >= deadline_ns)
        return fail(ErrorCode::kTimeout, "{}: no answer to an update within {} ms", context.transport().where(),
                    kTimeoutNs / kNsPerMs);
      FL_TRY(read(context, deadline_ns));
    }
  }

  Status listen(WidgetContext& context, TimeNs deadline_ns) override {
    VinceReply reply;
    while (replies_.next(unread_, reply)) {
    }
    return read(context, deadline_ns);
  }

  std::vector<WidgetFigure> figures() const override {
    return {{"garbage_bytes", static_cast<double>(replies_.garbage_byte_count())}};
  }

 private:
  // Zeros end any unfinished message, because its end is then in the wrong place; between messages they are ignored.
  Status end_message(WidgetContext& context) {
    if (!cut_short_) return {};
    constexpr std::array<std::uint8_t, kVinceUpdateSize> kZeros{};
    FL_TRY(write(context, kZeros));
    FL_TRY(write(context, kVinceStart));
    cut_short_ = false;
    return {};
  }
  Status write(WidgetContext& context, std::span<const std::uint8_t> bytes) {
    const Status written = context.transport().write(bytes, context.now_ns() + kTimeoutNs);
    if (!written) cut_short_ = true;
    return written;
  }
  Status read(WidgetContext& context, TimeNs deadline_ns) {
    FL_ASSIGN(const std::size_t count, context.transport().read(input_, deadline_ns));
    unread_ = std::span<const std::uint8_t>(input_).first(count);
    return {};
  }

  VinceReplyParser replies_;
  std::array<std::uint8_t, 256> input_{};  // bytes of the last read; unread_ refers to it
  std::span<const std::uint8_t> unread_;
  bool cut_short_ = false;
};

constexpr UsbModelId kModels[] = {{.vendor = 0x0403,
                                   .product = 0x6001,
                                   .manufacturer_text = "",
                                   .product_text = "USB-DMX512 CONVERTER",
                                   .model_name = "Vince USB-DMX512",
                                   .quirks = kQuirkGenericUsbIds}};

}  // namespace

extern constinit const DriverInfo vince_driver{
    .id = "vince",
    .full_name = "Vince USB-DMX512 converter",
    .usb_ids = kModels,
    .capabilities = kCanOutput | kKeepsSnapshotAlive,
    .notes = "One output.",
    .make_widget = [](const PortRequest&, const UsbModelId&) -> Result<std::unique_ptr<Widget>> {
      return std::make_unique<Vince>();
    },
    .make_model = []() -> std::unique_ptr<mock::UsbModel> { return std::make_unique<mock::VinceModel>(); },
};

}  // namespace footlight::drivers
