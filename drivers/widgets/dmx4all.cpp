// DMX4ALL NanoDMX, and DMX4ALL and StageProfi interfaces behind an FTDI chip: one output, set slot by slot.
//
// Text commands open it: "C?" is answered with "G", "N511" sets the frame length to 512 slots. Then each slot takes
// three bytes: E2 and the slot for slots 0 to 255, E3 and the slot less 256 for the others, and its level. Each is
// answered with "G". Only changed slots are sent; all of them after opening, and after a second without a change.
//
// Source: the traffic of other programs. Not tried on hardware.
#include <algorithm>
#include <string_view>

#include "drivers/device/widget.h"
#include "drivers/driver.h"
#include "drivers/mock/dmx4all_model.h"

namespace footlight::drivers {
namespace {

constexpr DurationNs kTimeoutNs = 250 * kNsPerMs;
constexpr std::uint8_t kGood = 'G';
constexpr std::uint8_t kSetLow = 0xE2, kSetHigh = 0xE3;
constexpr std::size_t kLowCount = 256;
constexpr std::size_t kChunkSize = 192;  // 64 slots; its answers are read before the next

class Dmx4all final : public Widget {
 public:
  int line_count() const override { return 1; }
  Status can(int, LineUse use) const override {
    if (use == LineUse::kInput) return fail(ErrorCode::kUnsupported, "this model has an output only");
    return {};
  }

  Result<WidgetTraits> begin(WidgetContext& context) override {
    known_ = false;
    FL_TRY(context.transport().set_line({.latency_ms = 2}, context.now_ns() + kTimeoutNs));
    // Two zeros complete an unfinished command of a killed program: a slot is three bytes.
    constexpr std::uint8_t kZeros[] = {0, 0};
    FL_TRY(write(context, kZeros));
    FL_TRY(query(context, "C?"));
    FL_TRY(query(context, "N511"));
    WidgetTraits traits;
    traits.rate_hz_max = 40.0;
    return traits;
  }

  Status send(WidgetContext& context, int, std::span<const std::uint8_t, kSlotCountMax> snapshot) override {
    const bool all = !known_ || std::equal(snapshot.begin(), snapshot.end(), shown_.begin());
    std::array<std::uint8_t, kChunkSize> chunk;
    std::size_t size = 0;
    const auto flush = [&]() -> Status {
      const Status written = write(context, std::span(chunk).first(size));
      size = 0;
      if (!written) known_ = false;
      FL_TRY(written);
      return take_answers(context, context.now_ns());
    };
    if (!known_) size = 2, chunk[0] = chunk[1] = 0;  // as in begin()
    for (std::size_t slot = 0; slot < snapshot.size(); ++slot) {
      if (!all && snapshot[slot] == shown_[slot]) continue;
      if (size + 3 > chunk.size()) FL_TRY(flush());
      chunk[size++] = slot < kLowCount ? kSetLow : kSetHigh;
      chunk[size++] = static_cast<std::uint8_t>(slot % kLowCount);
      chunk[size++] = snapshot[slot];
    }
    FL_TRY(flush());
    std::copy(snapshot.begin(), snapshot.end(), shown_.begin());
    known_ = true;
    return {};
  }

  Status listen(WidgetContext& context, TimeNs deadline_ns) override { return take_answers(context, deadline_ns); }

  std::vector<WidgetFigure> figures() const override {
    return {{"good_answers", static_cast<double>(good_count_)}, {"bad_answers", static_cast<double>(bad_count_)}};
  }

 private:
  Status write(WidgetContext& context, std::span<const std::uint8_t> bytes) {
    return context.transport().write(bytes, context.now_ns() + kTimeoutNs);
  }
  Status query(WidgetContext& context, std::string_view question) {
    const std::uint64_t before = good_count_;
    FL_TRY(write(context, std::vector<std::uint8_t>(question.begin(), question.end())));
    const TimeNs deadline_ns = context.now_ns() + kTimeoutNs;
    while (good_count_ == before) {
      if (context.stopping()) return fail(ErrorCode::kDisconnected, "{}: closed", context.transport().where());
      if (context.now_ns() >= deadline_ns)
        return fail(ErrorCode::kTimeout, "{}: no answer to \"{}\" within {} ms; is it a DMX4ALL interface?",
                    context.transport().where(), question, kTimeoutNs / kNsPerMs);
      FL_TRY(take_answers(context, deadline_ns));
    }
    return {};
  }
  Status take_answers(WidgetContext& context, TimeNs deadline_ns) {
    std::array<std::uint8_t, 512> answers;
    FL_ASSIGN(const std::size_t count, context.transport().read(answers, deadline_ns));
    const auto good = std::count(answers.begin(), answers.begin() + static_cast<std::ptrdiff_t>(count), kGood);
    const std::uint64_t bad = count - static_cast<std::uint64_t>(good);
    good_count_ += static_cast<std::uint64_t>(good);
    bad_count_ += bad;
    if (bad > 0) context.count_rejected(bad);
    return {};
  }

  Slots shown_{};
  bool known_ = false;  // shown_ equals the device's levels
  std::uint64_t good_count_ = 0, bad_count_ = 0;
};

constexpr UsbModelId kModels[] = {{.vendor = 0x03EB,
                                   .product = 0x2018,
                                   .manufacturer_text = "",
                                   .product_text = "",
                                   .model_name = "DMX4ALL NanoDMX",
                                   .transport = TransportKind::kTty},
                                  {.vendor = 0x0403,
                                   .product = 0xC850,
                                   .manufacturer_text = "",
                                   .product_text = "",
                                   .model_name = "DMX4ALL interfaces, StageProfi"}};

}  // namespace

extern constinit const DriverInfo dmx4all_driver{
    .id = "dmx4all",
    .full_name = "DMX4ALL NanoDMX, DMX4ALL and StageProfi",
    .usb_ids = kModels,
    .capabilities = kCanOutput | kKeepsSnapshotAlive,
    .notes = "One output, set slot by slot: only what changes is sent.",
    .make_widget = [](const PortRequest&, const UsbModelId&) -> Result<std::unique_ptr<Widget>> {
      return std::make_unique<Dmx4all>();
    },
    .make_model = []() -> std::unique_ptr<mock::UsbModel> { return std::make_unique<mock::Dmx4allModel>(); },
};

}  // namespace footlight::drivers
