#include "drivers/widgets/open_dmx.h"

#include <algorithm>

#include "drivers/mock/open_dmx_model.h"

namespace footlight::drivers {
namespace {

constexpr DurationNs kPollPauseNs = 500 * kNsPerUs;  // between two checks of a transmitter that is late
constexpr double kRateHzMax = 44.0;                  // 513 slots of 44 us with the shortest break and mark
constexpr double kRateHzMin = 1.0;                   // E1.11: at least a frame a second

double us_of(DurationNs duration_ns) { return static_cast<double>(duration_ns) * 1e-3; }

}  // namespace

void OpenDmx::Spread::record(DurationNs duration_ns) {
  histogram.record(duration_ns);
  min_ns = std::min(min_ns, duration_ns);
}

void OpenDmx::Spread::add_to(std::vector<WidgetFigure>& figures, std::string_view name) const {
  if (histogram.count() == 0) return;
  figures.push_back({fmt::format("{}_min", name), us_of(min_ns)});
  figures.push_back({fmt::format("{}_p50", name), us_of(histogram.quantile_ns(0.5))});
  figures.push_back({fmt::format("{}_max", name), us_of(histogram.max_ns())});
}

Result<WidgetTraits> OpenDmx::begin(WidgetContext& context) {
  const TimeNs deadline_ns = context.now_ns() + config_.reply_timeout_ns;
  parser_.reset();
  empty_ns_ = broke_ns_ = 0;
  FL_TRY(context.transport().set_line({.latency_ms = 1}, deadline_ns));
  FL_TRY(context.transport().set_break(false, deadline_ns));
  const double rate_hz = std::clamp(config_.rate_hz, kRateHzMin, kRateHzMax);
  WidgetTraits traits;
  traits.rate_hz_max = rate_hz;
  traits.keep_alive_ns = static_cast<DurationNs>(1e9 / rate_hz);
  traits.host_timed = true;
  traits.identity = "timed by this machine";
  return traits;
}

Status OpenDmx::wait_until_empty(WidgetContext& context) {
  const TimeNs give_up_ns = std::max(context.now_ns(), empty_ns_) + config_.reply_timeout_ns;
  while (true) {
    const TimeNs now_ns = context.now_ns();
    if (now_ns < empty_ns_ && !context.stopping()) {
      FL_TRY(context.transport().wait(empty_ns_));  // may be woken: the clock decides
      continue;
    }
    FL_ASSIGN(const bool empty, context.transport().transmitter_empty(give_up_ns));
    if (empty) return {};
    ++waits_;
    if (now_ns >= give_up_ns)
      return fail(ErrorCode::kTimeout, "{}: its transmitter does not finish a frame", context.transport().where());
    FL_TRY(context.transport().wait(now_ns + kPollPauseNs));
  }
}

Status OpenDmx::send_break(WidgetContext& context, TimeNs deadline_ns) {
  Transport& transport = context.transport();
  const TimeNs start_ns = context.now_ns();
  if (Status began = transport.set_break(true, deadline_ns); !began) {
    (void)transport.set_break(false, context.now_ns() + config_.reply_timeout_ns);
    return began;
  }
  // The chip has started by now, at an unknown time before. So this length is at most the true one.
  const TimeNs low_ns = context.now_ns();
  if (broke_ns_ != 0) periods_.record(start_ns - broke_ns_);
  broke_ns_ = start_ns;
  context.sleep_until_ns(low_ns + kBreakMinNs);
  const TimeNs ending_ns = context.now_ns();
  FL_TRY(transport.set_break(false, deadline_ns));
  breaks_.record(ending_ns - low_ns);
  return {};
}

Status OpenDmx::send(WidgetContext& context, int, std::span<const std::uint8_t, kSlotCountMax> snapshot) {
  FL_TRY(wait_until_empty(context));
  const TimeNs deadline_ns = context.now_ns() + config_.reply_timeout_ns;
  FL_TRY(send_break(context, deadline_ns));
  const TimeNs high_ns = context.now_ns();
  context.sleep_until_ns(high_ns + kMarkMinNs);
  std::array<std::uint8_t, 1 + kSlotCountMax> frame;
  frame[0] = kStartCodeLevels;
  std::copy(snapshot.begin(), snapshot.end(), frame.begin() + 1);
  const TimeNs writing_ns = context.now_ns();
  marks_.record(writing_ns - high_ns);
  const Status written = context.transport().write(frame, deadline_ns);
  empty_ns_ = writing_ns + static_cast<DurationNs>(frame.size()) * kSlotNs;
  FL_TRY(written);
  // Wait until the frame is out: there may be a newer snapshot by then.
  while (context.now_ns() < empty_ns_ && !context.stopping()) FL_TRY(context.transport().wait(empty_ns_));
  return {};
}

Status OpenDmx::listen(WidgetContext& context, TimeNs deadline_ns) {
  if (context.lines()[0] != LineUse::kInput) return context.transport().wait(deadline_ns);
  FL_ASSIGN(const std::size_t count, context.transport().read_line(received_, deadline_ns));
  const LineFrameParser::Counters before = parser_.counters();
  for (const LineByte& byte : std::span(received_).first(count))
    if (const auto frame = parser_.take(byte)) context.deliver(0, frame->bytes, frame->stamp_ns);
  const LineFrameParser::Counters& after = parser_.counters();
  const std::uint64_t rejected = after.framing_errors - before.framing_errors + after.overruns - before.overruns;
  if (rejected > 0) context.count_rejected(rejected);
  return {};
}

// The last frame must be out before the chip is closed, or the kernel's driver cuts it.
Status OpenDmx::end(WidgetContext& context) {
  if (context.lines()[0] != LineUse::kOutput || broke_ns_ == 0) return {};
  while (context.now_ns() < empty_ns_) FL_TRY(context.transport().wait(empty_ns_));
  return {};
}

std::vector<WidgetFigure> OpenDmx::figures() const {
  std::vector<WidgetFigure> figures;
  if (periods_.histogram.count() > 0) {
    figures.push_back({"requested_hz", config_.rate_hz});
    figures.push_back({"rate_hz", 1e9 * static_cast<double>(periods_.histogram.count()) /
                                      static_cast<double>(periods_.histogram.sum_ns())});
    figures.push_back({"waits_for_transmitter", static_cast<double>(waits_)});
  }
  breaks_.add_to(figures, "break_us");
  marks_.add_to(figures, "mab_us");
  periods_.add_to(figures, "period_us");
  const LineFrameParser::Counters& in = parser_.counters();
  if (in.frames + in.stray_bytes + in.framing_errors + in.overruns > 0) {
    figures.push_back({"frames", static_cast<double>(in.frames)});
    figures.push_back({"short_frames", static_cast<double>(in.short_frames)});
    figures.push_back({"framing_errors", static_cast<double>(in.framing_errors)});
    figures.push_back({"overruns", static_cast<double>(in.overruns)});
    figures.push_back({"stray_bytes", static_cast<double>(in.stray_bytes)});
  }
  return figures;
}

// --- The driver's row

namespace {

constexpr UsbModelId row(std::uint16_t product, std::string_view name) {
  return {.vendor = 0x0403,
          .product = product,
          .manufacturer_text = {},
          .product_text = {},
          .model_name = name,
          .quirks = kQuirkGenericUsbIds,
          .transport = TransportKind::kFtdi};
}
constexpr UsbModelId kModels[] = {row(0x6001, "ENTTEC Open DMX USB, and cables with an FT232"),
                                  row(0x6015, "cables with an FT-X"), row(0x6014, "cables with an FT232H"),
                                  row(0x6010, "cables with an FT2232, first line"),
                                  row(0x6011, "cables with an FT4232H, first line")};

Result<std::unique_ptr<Widget>> make_open_dmx(const PortRequest& request, const UsbModelId&) {
  return std::make_unique<OpenDmx>(OpenDmxConfig{.rate_hz = request.rate_hz > 0.0 ? request.rate_hz : 40.0});
}

}  // namespace

extern constinit const DriverInfo open_dmx_driver{
    .id = "open-dmx",
    .full_name = "ENTTEC Open DMX USB and bare FTDI cables",
    .usb_ids = kModels,
    .capabilities = kCanOutput | kCanInput,
    .notes =
        "This machine times the line. Must be named by its serial number or port, because it looks like any other "
        "serial adapter. The line stops when the program ends.",
    .make_widget = make_open_dmx,
    .make_model = []() -> std::unique_ptr<mock::UsbModel> { return std::make_unique<mock::OpenDmxModel>(); },
};

}  // namespace footlight::drivers
