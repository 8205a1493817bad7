// ENTTEC Open DMX USB and other bare serial cables: this machine times the line.
//
// Output: break, mark and 513 bytes by a serial chip that knows nothing of DMX. A frame begins when the transmitter
// says that the last one has left it (and not when the clock would have it), so no frame is cut. The break lasts at
// least kBreakMinNs between the answers of the chip to "begin" and "end", the mark at least kMarkMinNs until the
// bytes are handed over; what the bus adds is measured and told in figures(). Frames follow each other at absolute
// times, so lateness of one is not handed on.
//
// Input: a break is what the chip calls one, so frames of every length are told apart without guessing.
//
// Not tried on hardware: how long the bus makes break and mark, and so which rate a cable reaches.
#pragma once

#include <array>

#include "drivers/device/widget.h"
#include "drivers/driver.h"
#include "drivers/widgets/line_frame.h"
#include "sim/core/histogram.h"

namespace footlight::drivers {

struct OpenDmxConfig {
  // All optional
  double rate_hz = 40.0;  // asked for; 1 to 44
  DurationNs reply_timeout_ns = 250 * kNsPerMs;
};

class OpenDmx final : public Widget {
 public:
  static constexpr DurationNs kBreakMinNs = 110 * kNsPerUs;  // E1.11 asks for 92 us
  static constexpr DurationNs kMarkMinNs = 14 * kNsPerUs;    // and for 12 us
  static constexpr DurationNs kSlotNs = 44 * kNsPerUs;       // 11 bits of 4 us

  explicit OpenDmx(OpenDmxConfig config) : config_(config) {}

  int line_count() const override { return 1; }
  Status can(int, LineUse) const override { return {}; }
  Result<WidgetTraits> begin(WidgetContext& context) override;
  Status send(WidgetContext& context, int line, std::span<const std::uint8_t, kSlotCountMax> snapshot) override;
  Status listen(WidgetContext& context, TimeNs deadline_ns) override;
  Status end(WidgetContext& context) override;
  // Output: asked_hz, rate_hz, break_us_min, _p50, _max, mab_us_..., period_us_..., waits_for_transmitter. Input:
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
  // The line ends high, whatever went wrong.
  Status send_break(WidgetContext& context, TimeNs deadline_ns);

  const OpenDmxConfig config_;
  LineFrameParser parser_;
  std::array<LineByte, 1024> heard_{};
  TimeNs empty_ns_ = 0;  // when the frame that was written last should have left
  TimeNs broke_ns_ = 0;  // when the last break began; 0: none yet
  Spread breaks_, marks_, periods_;
  std::uint64_t waits_ = 0;  // times the transmitter was still busy when the clock said that it should not be
};

}  // namespace footlight::drivers
