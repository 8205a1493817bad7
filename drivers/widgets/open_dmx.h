// ENTTEC Open DMX USB and other bare serial cables: this machine times the line.
//
// Output: a serial chip without DMX support sends break, mark and 513 bytes. A frame starts when the transmitter
// reports that it is empty, not at a computed time, so no frame is cut. The break lasts at least kBreakMinNs between
// the chip's replies to "start" and "end", the mark at least kMarkMinNs until the bytes are written. The time added by
// the bus is measured and reported in figures(). Frames are due at absolute times, so the delay of one does not add to
// the next.
//
// Input: the chip detects the break, so frames of every length are separated without guessing.
//
// Not tried on hardware: the length of break and mark over a real bus, and so the rate that a cable reaches.
#pragma once

#include <array>

#include "drivers/device/widget.h"
#include "drivers/driver.h"
#include "drivers/widgets/line_frame.h"
#include "sim/core/histogram.h"

namespace footlight::drivers {

struct OpenDmxConfig {
  // All optional
  double rate_hz = 40.0;  // requested; 1 to 44
  DurationNs reply_timeout_ns = 250 * kNsPerMs;
};

class OpenDmx final : public Widget {
 public:
  static constexpr DurationNs kBreakMinNs = 110 * kNsPerUs;  // E1.11 requires 92 us
  static constexpr DurationNs kMarkMinNs = 14 * kNsPerUs;    // E1.11 requires 12 us
  static constexpr DurationNs kSlotNs = 44 * kNsPerUs;       // 11 bits of 4 us

  explicit OpenDmx(OpenDmxConfig config) : config_(config) {}

  int line_count() const override { return 1; }
  Status can(int, LineUse) const override { return {}; }
  Result<WidgetTraits> begin(WidgetContext& context) override;
  Status send(WidgetContext& context, int line, std::span<const std::uint8_t, kSlotCountMax> snapshot) override;
  Status listen(WidgetContext& context, TimeNs deadline_ns) override;
  Status end(WidgetContext& context) override;
  // Output: requested_hz, rate_hz, break_us_min, _p50, _max, mab_us_..., period_us_..., waits_for_transmitter. Input:
  // frames, short_frames, framing_errors, overruns, stray_bytes.
  std::vector<WidgetFigure> figures() const override;

 private:
  struct Spread {
    Histogram histogram;
    DurationNs min_ns = kTimeNever;
    void record(DurationNs duration_ns);
    void add_to(std::vector<WidgetFigure>& figures, std::string_view name) const;
  };
  Status wait_until_empty(WidgetContext& context);
  // The line ends high, also after an error.
  Status send_break(WidgetContext& context, TimeNs deadline_ns);

  const OpenDmxConfig config_;
  LineFrameParser parser_;
  std::array<LineByte, 1024> received_{};
  TimeNs empty_ns_ = 0;  // when the last written frame should be out
  TimeNs broke_ns_ = 0;  // when the last break started; 0: none yet
  Spread breaks_, marks_, periods_;
  std::uint64_t waits_ = 0;  // times the transmitter was busy when it should have been empty
};

}  // namespace footlight::drivers
