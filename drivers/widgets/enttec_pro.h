// The Widget for the ENTTEC DMX USB Pro, its Mk2, DMXking's ultraDMX family and other devices with their protocol.
//
// It requests serial number (label 10), parameters (3), and manufacturer (77, 78), then sends snapshots (label 6) or
// receives frames of the line (labels 5 and 9). The device repeats the last snapshot on the line at its own rate. A
// connector is either input or output: receiving switches the transmitter off.
//
// Second connectors: DMXking's are detected by a request and use labels 100 and 101. That of an ENTTEC Mk2 uses labels
// that ENTTEC gives to each applicant together with a key: SecondPort, from the user.
//
// Sources: ENTTEC's "DMX USB Pro Widget API Specification 1.44"; labels 77 and 78 from Open Lighting's USB protocol
// extensions; 99 to 101 as other programs use them with DMXking's devices. Not tried on hardware.
#pragma once

#include <array>
#include <optional>

#include "drivers/device/widget.h"
#include "drivers/driver.h"
#include "drivers/rdm/rdm_widget.h"
#include "drivers/widgets/enttec_pro_frame.h"

namespace footlight::drivers {

struct EnttecProConfig {
  // All optional
  int line_count = 1;
  bool second_needs_key = false;  // without second_port, the second line is refused before the device is queried
  std::optional<SecondPort> second_port = {};
  ProReceiveMode receive_mode = ProReceiveMode::kEveryFrame;
  DurationNs keep_alive_ns = kNsPerS;  // repeat interval of an unchanged snapshot, which the device repeats itself in
                                       // between
  DurationNs reply_timeout_ns = 250 * kNsPerMs;  // of the requests
  DurationNs write_timeout_ns = 250 * kNsPerMs;
  // RDM: how long to wait for a widget that does not report a missing response. A responder answers within 2.8 ms
  // (E1.20 section 3.1); the rest is the time in the widget and on the bus.
  DurationNs rdm_timeout_ns = 150 * kNsPerMs;
};

class EnttecPro final : public Widget, public RdmWidget {
 public:
  explicit EnttecPro(EnttecProConfig config) : config_(config) {}

  int line_count() const override { return config_.line_count; }
  Status can(int line, LineUse use) const override;
  Result<WidgetTraits> begin(WidgetContext& context) override;
  Status send(WidgetContext& context, int line, std::span<const std::uint8_t, kSlotCountMax> snapshot) override;
  Status listen(WidgetContext& context, TimeNs deadline_ns) override;
  // garbage_bytes, bad_messages, line_errors, widget_serial, firmware, break_us, mab_us, rate_hz.
  std::vector<WidgetFigure> figures() const override;

  // Labels 7, 11 and 12, with RDM firmware; port 1.
  Result<Octets> exchange_rdm(WidgetContext& context, int line, std::span<const std::uint8_t> request) override;

  // For messages other than levels, on the device's thread: sends a message, then handles everything from the device up
  // to a message with that label or the deadline (kTimeout). Frames of input lines are delivered meanwhile. The payload
  // is valid until the next call.
  Result<ProMessageView> query(WidgetContext& context, const ProMessage& question, std::uint8_t label,
                               TimeNs deadline_ns);

 private:
  struct Line {
    std::uint8_t send_label = 0;
    LineFrame frame{};  // input: the last one; output: the line's current frame
    bool shows = false;
  };
  Status write(WidgetContext& context, std::span<const std::uint8_t> bytes);
  Status find_out(WidgetContext& context);
  Status set_up_lines(WidgetContext& context, WidgetTraits& traits);
  // False: it belongs to no line.
  bool take_line_message(WidgetContext& context, const ProMessageView& message);
  void count_rejected(WidgetContext& context);

  const EnttecProConfig config_;
  ProParser parser_;
  std::array<std::uint8_t, 1024> input_{};  // bytes of the last read; unread_ refers to it
  std::span<const std::uint8_t> unread_;
  TimeNs received_ns_ = 0;
  bool cut_short_ = false;  // the last write ended in the middle
  std::array<Line, 2> lines_;
  bool is_dmxking_ = false;
  int port_count_ = 1;  // reported by a DMXking device
  std::uint32_t serial_ = 0;
  bool rdm_answers_ = false;  // it has answered an RDM label, if only with a timeout
  ProParams params_;
  std::uint64_t bad_payload_count_ = 0;
  std::uint64_t line_error_count_ = 0;
  std::uint64_t reported_rejected_ = 0;  // the count reported to the context so far
};

}  // namespace footlight::drivers
