#include "drivers/widgets/udmx.h"

#include <algorithm>
#include <array>

#include "drivers/driver.h"
#include "drivers/mock/udmx_model.h"

namespace footlight::drivers {
namespace {

constexpr ControlRequest kSetRange{.request_type = 0x40, .request = 2};
constexpr DurationNs kPacketNs = kNsPerMs;                  // low speed: one packet of 8 bytes per bus frame
constexpr DurationNs kTransferPatienceNs = 500 * kNsPerMs;  // as in other programs; a whole universe takes 66 ms
constexpr int kAttemptCountMax = 3;                         // it sometimes refuses a transfer and accepts the next
constexpr int kRefreshSlotCount = 64;    // of an unchanged snapshot, each time it is due: 10 ms of the bus
constexpr double kLineRateHzMax = 41.5;  // of 512 slots; a logic capture of one shows 24.1 ms a frame (sigrok-dumps)

class UdmxWidget final : public Widget {
 public:
  int line_count() const override { return 1; }
  Status can(int, LineUse use) const override {
    if (use == LineUse::kInput) return fail(ErrorCode::kUnsupported, "uDMX has no input; use it as an output");
    return {};
  }

  Result<WidgetTraits> begin(WidgetContext&) override {
    known_ = false;
    return WidgetTraits{
        .rate_hz_max = kLineRateHzMax,
        .keep_alive_ns = kNsPerS,
        .identity = {},
        .remarks = {"a frame in which all 512 slots change takes 66 ms of its low-speed bus: 15 a second"}};
  }

  Status send(WidgetContext& context, int, std::span<const std::uint8_t, kSlotCountMax> snapshot) override {
    if (!known_) {
      FL_TRY(send_range(context, snapshot, {0, kSlotCountMax}));
      std::copy(snapshot.begin(), snapshot.end(), sent_.begin());
      known_ = true;
      return {};
    }
    bool changed = false;
    int from = 0;
    while (const auto range = next_udmx_range(sent_, snapshot, from)) {
      FL_TRY(send_range(context, snapshot, *range));
      from = range->first + range->count;
      changed = true;
    }
    if (!changed) {
      FL_TRY(send_range(context, snapshot, {refresh_slot_, kRefreshSlotCount}));
      refresh_slot_ = (refresh_slot_ + kRefreshSlotCount) % kSlotCountMax;
    }
    return {};
  }

  Status listen(WidgetContext& context, TimeNs deadline_ns) override { return context.transport().wait(deadline_ns); }

  std::vector<WidgetFigure> figures() const override {
    return {{"slots_sent", static_cast<double>(slot_count_)},
            {"refused_transfers", static_cast<double>(refused_count_)}};
  }

 private:
  Status send_range(WidgetContext& context, std::span<const std::uint8_t, kSlotCountMax> snapshot, UdmxRange range) {
    ControlRequest request = kSetRange;
    request.value = static_cast<std::uint16_t>(range.count);
    request.index = static_cast<std::uint16_t>(range.first);
    const auto levels = snapshot.subspan(static_cast<std::size_t>(range.first), static_cast<std::size_t>(range.count));
    for (int attempt = 1;; ++attempt) {
      const Status sent = context.transport().control_out(request, levels, context.now_ns() + kTransferPatienceNs);
      if (sent) break;
      if (sent.error().code != ErrorCode::kIo || attempt == kAttemptCountMax) {
        known_ = false;  // unknown which slots it has accepted
        return sent;
      }
      ++refused_count_;
    }
    std::copy(levels.begin(), levels.end(), sent_.begin() + range.first);
    slot_count_ += levels.size();
    return {};
  }

  std::array<std::uint8_t, kSlotCountMax> sent_{};  // the device's levels, if known_
  bool known_ = false;
  int refresh_slot_ = 0;
  std::uint64_t slot_count_ = 0;
  std::uint64_t refused_count_ = 0;
};

constexpr UsbModelId kModels[] = {
    // The ids are Objective Development's and free for all: the name must decide.
    {.vendor = 0x16C0,
     .product = 0x05DC,
     .manufacturer_text = "",
     .product_text = "uDMX",
     .model_name = "Anyma uDMX",
     .quirks = kQuirkGenericUsbIds,
     .transport = TransportKind::kUsb},
    {.vendor = 0x03EB,
     .product = 0x8888,
     .manufacturer_text = "",
     .product_text = "",
     .model_name = "AVLdiy D512",
     .quirks = 0,
     .transport = TransportKind::kUsb},
};

}  // namespace

DurationNs udmx_transfer_ns(int slot_count) {
  constexpr int kPacketSize = 8;
  return (2 + (slot_count + kPacketSize - 1) / kPacketSize) * kPacketNs;  // 2: the request and its status
}

std::optional<UdmxRange> next_udmx_range(std::span<const std::uint8_t, kSlotCountMax> known,
                                         std::span<const std::uint8_t, kSlotCountMax> wanted, int from) {
  const auto next_change = [&](int slot) {
    while (slot < kSlotCountMax && known[static_cast<std::size_t>(slot)] == wanted[static_cast<std::size_t>(slot)])
      ++slot;
    return slot;
  };
  const int first = next_change(from);
  if (first == kSlotCountMax) return std::nullopt;
  int end = first + 1;
  for (int next = next_change(end); next < kSlotCountMax; next = next_change(end)) {
    if (udmx_transfer_ns(next + 1 - first) > udmx_transfer_ns(end - first) + udmx_transfer_ns(1)) break;
    end = next + 1;
  }
  return UdmxRange{first, end - first};
}

extern constinit const DriverInfo udmx_driver{
    .id = "udmx",
    .full_name = "Anyma uDMX and clones",
    .usb_ids = kModels,
    .capabilities = kCanOutput | kKeepsSnapshotAlive,
    .notes = "Low speed: only slots that have changed are sent; a frame in which all change takes 66 ms.",
    .make_widget = [](const PortRequest&, const UsbModelId&) -> Result<std::unique_ptr<Widget>> {
      return std::make_unique<UdmxWidget>();
    },
    .make_model = []() -> std::unique_ptr<mock::UsbModel> { return std::make_unique<mock::UdmxModel>(); },
};

}  // namespace footlight::drivers
