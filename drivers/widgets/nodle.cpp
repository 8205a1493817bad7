// Nodle U1 and R4S, Digital Enlightenment USB-DMX, FX5: an output and an input that work at the same time.
#include <algorithm>

#include "drivers/driver.h"
#include "drivers/mock/nodle_model.h"
#include "drivers/transport/hid_descriptors.h"
#include "drivers/widgets/nodle_frame.h"

namespace footlight::drivers {
namespace {

constexpr int kOutputLine = 0, kInputLine = 1;
constexpr DurationNs kReportPatienceNs = 250 * kNsPerMs;  // OLA: 60 ms were too few on a Raspberry Pi 1
constexpr DurationNs kRefreshNs = kNsPerS;                // all blocks, changed or not
// The blocks of one frame come one after the other. A pause of this length, or a number that does not increase, ends
// the frame.
constexpr DurationNs kPassPauseNs = 3 * kNsPerMs;
constexpr double kLineRateHzMax = 44.0;

class NodleWidget final : public Widget {
 public:
  int line_count() const override { return 2; }
  Status can(int line, LineUse use) const override {
    if (use == LineUse::kInput && line != kInputLine)
      return fail(ErrorCode::kUnsupported, "connector 1 is the output; the input is connector 2");
    if (use == LineUse::kOutput && line != kOutputLine)
      return fail(ErrorCode::kUnsupported, "connector 2 is the input; the output is connector 1");
    return {};
  }

  Result<WidgetTraits> begin(WidgetContext& context) override {
    known_ = pending_ = false;
    last_block_ = -1;
    line_frame_.fill(0);
    const bool output = context.lines()[kOutputLine] == LineUse::kOutput;
    const bool input = context.lines()[kInputLine] == LineUse::kInput;
    // A closed output keeps its last levels while the input is still in use.
    output_used_ = output_used_ || output;
    FL_TRY(set_mode(context, input));

    FL_ASSIGN(const auto endpoint, ask_hid_output(context.transport(), context.now_ns() + kReportPatienceNs));
    const int interval_ms = endpoint ? endpoint->interval_ms : 1;
    const double rate_hz = 1000.0 / (kNodleBlockCount * interval_ms);
    WidgetTraits traits{.rate_hz_max = std::min(kLineRateHzMax, 1000.0 / interval_ms),
                        .keep_alive_ns = kRefreshNs,
                        .identity = {},
                        .remarks = {}};
    if (rate_hz < kLineRateHzMax)
      traits.remarks.push_back(
          fmt::format("a frame in which all 16 blocks of 32 slots change takes {} ms: {:.1f} a second",
                      kNodleBlockCount * interval_ms, rate_hz));
    return traits;
  }

  Status send(WidgetContext& context, int, std::span<const std::uint8_t, kSlotCountMax> snapshot) override {
    const TimeNs now_ns = context.now_ns();
    const bool all = !known_ || now_ns >= refreshed_ns_ + kRefreshNs;
    known_ = false;
    for (int block = 0; block < kNodleBlockCount; ++block) {
      const std::ptrdiff_t first = std::ptrdiff_t{block} * kNodleBlockSize;
      const auto levels = snapshot.subspan(static_cast<std::size_t>(first), kNodleBlockSize);
      const auto at = sent_.begin() + first;
      if (!all && std::equal(levels.begin(), levels.end(), at)) continue;
      FL_TRY(context.transport().write(encode_nodle_block(block, snapshot), context.now_ns() + kReportPatienceNs));
      std::copy(levels.begin(), levels.end(), at);
      ++block_count_;
    }
    known_ = true;
    if (all) refreshed_ns_ = now_ns;
    return {};
  }

  Status listen(WidgetContext& context, TimeNs deadline_ns) override {
    if (context.lines()[kInputLine] != LineUse::kInput) return context.transport().wait(deadline_ns);
    std::array<std::uint8_t, 65> report{};
    while (true) {
      const TimeNs pass_end_ns = received_ns_ + kPassPauseNs;
      FL_ASSIGN(const std::size_t size,
                context.transport().read(report, pending_ ? std::min(deadline_ns, pass_end_ns) : deadline_ns));
      const TimeNs now_ns = context.now_ns();
      if (size == 0) {
        if (pending_ && now_ns >= pass_end_ns) deliver(context);
        return {};
      }
      // A new pass: the blocks so far are a frame, whatever this report is.
      const bool new_pass = pending_ && size > 1 && report[1] <= last_block_;
      if (new_pass) deliver(context);
      const auto block = apply_nodle_report(std::span<const std::uint8_t>(report).first(size),
                                            std::span(line_frame_).subspan<1, kSlotCountMax>());
      if (block) {
        pending_ = true;
        last_block_ = *block;
        received_ns_ = now_ns;
      } else {
        context.count_rejected();
      }
      if (new_pass || now_ns >= deadline_ns) return {};
    }
  }

  // The input is no longer used. The output stays as it is.
  Status end(WidgetContext& context) override { return set_mode(context, false); }

  std::vector<WidgetFigure> figures() const override { return {{"blocks_sent", static_cast<double>(block_count_)}}; }

 private:
  Status set_mode(WidgetContext& context, bool input) const {
    const auto mode = static_cast<std::uint8_t>((output_used_ ? kNodleOutput : 0) | (input ? kNodleInput : 0));
    return context.transport().write(encode_nodle_mode(mode), context.now_ns() + kReportPatienceNs);
  }
  void deliver(WidgetContext& context) {
    pending_ = false;
    last_block_ = -1;
    context.deliver(kInputLine, line_frame_, received_ns_);
  }

  bool output_used_ = false;
  Slots sent_{};  // the device's levels, if known_
  bool known_ = false;
  TimeNs refreshed_ns_ = 0;
  std::uint64_t block_count_ = 0;

  std::array<std::uint8_t, 1 + kSlotCountMax> line_frame_{};  // of the input
  bool pending_ = false;                                      // line_frame_ has blocks that were not delivered
  int last_block_ = -1;
  TimeNs received_ns_ = 0;
};

constexpr UsbModelId model(std::uint16_t vendor, std::uint16_t product, std::string_view name) {
  return {.vendor = vendor,
          .product = product,
          .manufacturer_text = "",
          .product_text = "",
          .model_name = name,
          .quirks = 0,
          .transport = TransportKind::kHid};
}
constexpr UsbModelId kModels[] = {
    model(0x16D0, 0x0830, "DMXControl Projects Nodle U1"),
    model(0x16D0, 0x0833, "DMXControl Projects Nodle R4S"),
    model(0x04B4, 0x0F1F, "Digital Enlightenment USB-DMX"),
    model(0x16C0, 0x088B, "FX5 USB-DMX"),
};

}  // namespace

extern constinit const DriverInfo nodle_driver{
    .id = "nodle",
    .full_name = "Nodle, Digital Enlightenment, FX5",
    .usb_ids = kModels,
    .capabilities = kCanOutput | kCanInput | kKeepsSnapshotAlive,
    .notes =
        "Connector 1 is the output, connector 2 the input; both work at the same time. Only blocks of 32 slots that "
        "have changed are sent, and all of them once a second.",
    .make_widget = [](const PortRequest&, const UsbModelId&) -> Result<std::unique_ptr<Widget>> {
      return std::make_unique<NodleWidget>();
    },
    .make_model = []() -> std::unique_ptr<mock::UsbModel> { return std::make_unique<mock::NodleModel>(); },
};

}  // namespace footlight::drivers
