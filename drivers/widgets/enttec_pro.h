// ENTTEC DMX USB Pro, its Mk2, DMXking's ultraDMX family and what else speaks their protocol: the Widget.
//
// It asks for serial number (label 10), parameters (3), and who made it (77, 78), then sends looks (label 6) or takes
// what the line brings (labels 5 and 9). The device repeats the last look on the line at its own rate. A connector is
// either input or output: listening switches the transmitter off.
//
// Second connectors: DMXking's are found out by asking and sent to by labels 100 and 101. That of an ENTTEC Mk2 speaks
// with labels that ENTTEC hands to each applicant together with a key: SecondPort, from the user.
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
  bool second_needs_key = false;  // the second line is refused without second_port before the device is asked
  std::optional<SecondPort> second_port = {};
  ProReceiveMode receive_mode = ProReceiveMode::kEveryFrame;
  DurationNs keep_alive_ns = kNsPerS;            // how long an unchanged look is left to the device alone
  DurationNs reply_timeout_ns = 250 * kNsPerMs;  // of the questions
  DurationNs write_timeout_ns = 250 * kNsPerMs;
  // RDM: how long a widget that does not say that nobody answered is waited for. A responder answers within 2.8 ms
  // (E1.20 section 3.1); the rest is the way through the widget and the bus.
  DurationNs rdm_timeout_ns = 150 * kNsPerMs;
};

class EnttecPro final : public Widget, public RdmWidget {
 public:
  explicit EnttecPro(EnttecProConfig config) : config_(std::move(config)) {}

  int line_count() const override { return config_.line_count; }
  Status can(int line, LineUse use) const override;
  Result<WidgetTraits> begin(WidgetContext& context) override;
  Status send(WidgetContext& context, int line, std::span<const std::uint8_t, kSlotCountMax> snapshot) override;
  Status listen(WidgetContext& context, TimeNs deadline_ns) override;
  // garbage_bytes, bad_messages, line_errors, widget_serial, firmware, break_us, mab_us, rate_hz.
  std::vector<WidgetFigure> figures() const override;

  // Labels 7, 11 and 12, with firmware for RDM; port 1.
  Result<Octets> exchange_rdm(WidgetContext& context, int line, std::span<const std::uint8_t> request) override;

  // For what is not levels, from the device's thread: sends a message, and takes everything that the device says
  // up to a message with that label or the deadline (kTimeout). Frames of input lines are delivered meanwhile. The
  // payload is valid until the next call.
  Result<ProMessageView> ask(WidgetContext& context, const ProMessage& question, std::uint8_t label,
                             TimeNs deadline_ns);

 private:
  struct Line {
    std::uint8_t send_label = 0;
    LineFrame frame{};  // input: the last one; output: what the line shows
    bool shows = false;
  };
  Status write(WidgetContext& context, std::span<const std::uint8_t> bytes);
  Status find_out(WidgetContext& context);
  Status set_up_lines(WidgetContext& context, WidgetTraits& traits);
  // False: not one that belongs to a line.
  bool take_line_message(WidgetContext& context, const ProMessageView& message);
  void count_rejected(WidgetContext& context);

  const EnttecProConfig config_;
  ProParser parser_;
  std::array<std::uint8_t, 1024> input_{};  // bytes of the last read; unread_ points into it
  std::span<const std::uint8_t> unread_;
  TimeNs heard_ns_ = 0;
  bool cut_short_ = false;  // the last write ended in the middle
  std::array<Line, 2> lines_;
  bool is_dmxking_ = false;
  int port_count_ = 1;  // as a DMXking device says it
  std::uint32_t serial_ = 0;
  bool rdm_answers_ = false;  // to RDM it has said something, if only that nobody answered
  ProParams params_;
  std::uint64_t bad_payload_count_ = 0;
  std::uint64_t line_error_count_ = 0;
  std::uint64_t told_rejected_ = 0;  // what the context has been told
};

}  // namespace footlight::drivers
