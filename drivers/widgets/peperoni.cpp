// Peperoni Rodin, X-Switch and USBDMX21: sends snapshots in the format of each generation of firmware.
#include "drivers/driver.h"
#include "drivers/mock/peperoni_model.h"
#include "drivers/widgets/peperoni_frame.h"

namespace footlight::drivers {
namespace {

constexpr std::uint8_t kEndpointOut = 0x02, kEndpointIn = 0x82;
constexpr ControlRequest kSetStartCode{.request_type = 0x40, .request = 0x09};
constexpr ControlRequest kSetMemory{.request_type = 0x40, .request = 0x08};
constexpr ControlRequest kGetDeviceDescriptor{.request_type = 0x80, .request = 6, .value = 0x0100};
constexpr DurationNs kPatienceNs = 100 * kNsPerMs;  // more than kPeperoniWaitMs

constexpr std::uint16_t kTwoPortProduct = 0x0004;

class PeperoniWidget final : public Widget {
 public:
  explicit PeperoniWidget(int line_count) : line_count_(line_count) {}
  int line_count() const override { return line_count_; }
  Status can(int, LineUse use) const override {
    if (use == LineUse::kInput)
      return fail(ErrorCode::kUnsupported, "the input of Peperoni interfaces is not supported; use it as an output");
    return {};
  }

  Result<WidgetTraits> begin(WidgetContext& context) override {
    std::array<std::uint8_t, 18> descriptor{};
    FL_ASSIGN(const std::size_t size,
              context.transport().control_in(kGetDeviceDescriptor, descriptor, context.now_ns() + kPatienceNs));
    if (size != descriptor.size())
      return fail(ErrorCode::kProtocol, "{}: a device descriptor of {} bytes; plug it in again",
                  context.transport().where(), size);
    const auto release = static_cast<std::uint16_t>(descriptor[12] | descriptor[13] << 8);
    frames_ = peperoni_frames(release);
    const bool second_is_used = line_count_ > 1 && context.lines()[1] != LineUse::kUnused;
    const auto product = static_cast<std::uint16_t>(descriptor[10] | descriptor[11] << 8);
    if (second_is_used && product != kTwoPortProduct)
      return fail(ErrorCode::kUnsupported, "{}: this model has one output only; use connector 1",
                  context.transport().where());
    if (second_is_used && frames_ == PeperoniFrames::kControl)
      return fail(ErrorCode::kUnsupported, "{}: its firmware {:x}.{:02x} has one output only; use connector 1",
                  context.transport().where(), release >> 8, release & 0xFF);
    FL_TRY(context.transport().control_out(kSetStartCode, {}, context.now_ns() + kPatienceNs));
    stale_ = true;
    answer_owed_ = false;
    return WidgetTraits{.rate_hz_max = 44.0,
                        .keep_alive_ns = kNsPerS,
                        .identity = fmt::format("firmware {:x}.{:02x}", release >> 8, release & 0xFF),
                        .remarks = {}};
  }

  Status send(WidgetContext& context, int line, std::span<const std::uint8_t, kSlotCountMax> snapshot) override {
    Transport& transport = context.transport();
    const TimeNs deadline_ns = context.now_ns() + kPatienceNs;
    switch (frames_) {
      case PeperoniFrames::kControl: return transport.control_out(kSetMemory, snapshot, deadline_ns);
      case PeperoniFrames::kBulk:
        return transport.write_endpoint(kEndpointOut, encode_peperoni_bulk(line, snapshot), deadline_ns);
      case PeperoniFrames::kBulkWithStatus: break;
    }
    if (stale_) FL_TRY(forget_answers(context));
    stale_ = answer_owed_ = true;
    FL_TRY(transport.write_endpoint(kEndpointOut, encode_peperoni_with_status(line, snapshot), deadline_ns));
    FL_TRY(take_answer(context, line, deadline_ns));
    stale_ = false;
    return {};
  }

  Status listen(WidgetContext& context, TimeNs deadline_ns) override { return context.transport().wait(deadline_ns); }

  std::vector<WidgetFigure> figures() const override {
    return {{"device_timeouts", static_cast<double>(timeout_count_)}};
  }

 private:
  Status take_answer(WidgetContext& context, int line, TimeNs deadline_ns) {
    Transport& transport = context.transport();
    while (true) {
      std::array<std::uint8_t, kUsbTransferSizeMax> answer{};
      FL_ASSIGN(const std::size_t size, transport.read_endpoint(kEndpointIn, answer, deadline_ns));
      if (size > 0) {
        const auto status = decode_peperoni_status(std::span<const std::uint8_t>(answer).first(size));
        if (status) answer_owed_ = false;
        if (status == PeperoniStatus::kOk) return {};
        if (status == PeperoniStatus::kTimeout) {
          ++timeout_count_;
          return fail(ErrorCode::kTimeout, "{}: its transmitter was not free within {} ms", transport.where(),
                      kPeperoniWaitMs);
        }
        if (status)
          return fail(ErrorCode::kIo, "{}: refused universe {} with status {}", transport.where(), line + 1,
                      static_cast<int>(*status));
        context.count_rejected();
      } else if (context.now_ns() >= deadline_ns) {
        return fail(ErrorCode::kTimeout, "{}: no answer to a frame within {} ms", transport.where(),
                    kPatienceNs / kNsPerMs);
      }
      // Otherwise it was woken: a newer snapshot waits, and the answer to this one is still due.
    }
  }

  // Answers to earlier messages must not be taken for the next one; they do not identify their message. Waits for a due
  // answer.
  Status forget_answers(WidgetContext& context) {
    const TimeNs give_up_ns = context.now_ns() + (answer_owed_ ? kPatienceNs : 0);
    std::array<std::uint8_t, kUsbTransferSizeMax> answer{};
    while (true) {
      FL_ASSIGN(const std::size_t size,
                context.transport().read_endpoint(kEndpointIn, answer, answer_owed_ ? give_up_ns : context.now_ns()));
      if (size > 0) {
        context.count_rejected();
        answer_owed_ = false;
      } else if (!answer_owed_ || context.now_ns() >= give_up_ns) {
        return {};
      }
    }
  }

  const int line_count_;
  PeperoniFrames frames_ = PeperoniFrames::kControl;
  bool stale_ = true;         // answers may be on their way
  bool answer_owed_ = false;  // an answer is due
  std::uint64_t timeout_count_ = 0;
};

constexpr UsbModelId model(std::uint16_t product, std::string_view name, unsigned quirks = 0) {
  return {.vendor = 0x0CE1,
          .product = product,
          .manufacturer_text = "",
          .product_text = "",
          .model_name = name,
          .quirks = quirks,
          .transport = TransportKind::kUsb};
}
constexpr UsbModelId kModels[] = {
    model(0x0002, "Peperoni Rodin 1"),         model(0x0013, "Peperoni Rodin 1 Mk3"),
    model(0x0003, "Peperoni Rodin 2"),         model(0x0008, "Peperoni Rodin T"),
    model(0x0001, "Peperoni USBDMX X-Switch"), model(kTwoPortProduct, "Peperoni USBDMX21", kQuirkTwoPorts),
};

}  // namespace

extern constinit const DriverInfo peperoni_driver{
    .id = "peperoni",
    .full_name = "Peperoni Rodin, X-Switch, USBDMX21",
    .usb_ids = kModels,
    .capabilities = kCanOutput | kKeepsSnapshotAlive,
    .notes = "Outputs only. The transfer format depends on the firmware; from 5.00 each frame is acknowledged.",
    .make_widget = [](const PortRequest&, const UsbModelId& row) -> Result<std::unique_ptr<Widget>> {
      // For a device that is not plugged in yet, begin() finds out whether it has a second output.
      const bool unknown = row.vendor == 0;
      return std::make_unique<PeperoniWidget>(unknown || (row.quirks & kQuirkTwoPorts) != 0 ? 2 : 1);
    },
    .make_model = []() -> std::unique_ptr<mock::UsbModel> { return std::make_unique<mock::PeperoniModel>(); },
};

}  // namespace footlight::drivers
