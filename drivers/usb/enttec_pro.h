// ENTTEC DMX USB Pro: a sink and a source for one universe.
//
// Inside each is one device thread. It opens the widget, asks for its serial number (label 10) and parameters (label
// 3), then sends the newest frame (label 6) or takes what the line brings (labels 5 and 9). After an unplug it looks
// for the same device until it is back, and sends the last frame again. Between that thread and the pump stand a
// one-frame mailbox, where a newer frame replaces an unused one and is counted as dropped, and an eventfd. The mailbox
// lock is held for a copy of 512 bytes and never during I/O.
//
// The widget itself repeats the last frame on the line at its own rate. We send it again every keep_alive_ns as well,
// so that a widget that lost power for a moment recovers.
//
// Its one line is either input or output: a source switches the widget's transmitter off.
//
// Closing a sink leaves the last look on the line, since the widget goes on without us: a crashed or restarted bridge
// must not black a stage out. blackout_on_exit asks for zeros instead.
//
// Threads: the ports belong to one thread, the pump's. Errors while running: state() turns to kGone and trouble() says
// why.
#pragma once

#include <memory>
#include <string>

#include "drivers/driver.h"
#include "drivers/usb/enttec_pro_frame.h"
#include "drivers/device/transport.h"
#include "sim/core/ports.h"

namespace footlight::drivers {

struct EnttecProConfig {
  // Required
  Universe universe = 0;  // as people count
  std::string name;       // Port::name(): the endpoint as the user wrote it
  // Optional
  bool blackout_on_exit = false;                              // sink only
  bool wait_for_device = false;                               // open() succeeds though nothing is plugged in
  ProReceiveMode receive_mode = ProReceiveMode::kEveryFrame;  // source only
  DurationNs keep_alive_ns = kNsPerS;            // sink: how long an unchanged frame is left to the widget alone
  DurationNs reply_timeout_ns = 250 * kNsPerMs;  // of labels 10 and 3
  DurationNs write_timeout_ns = 250 * kNsPerMs;
  DurationNs retry_ns = 250 * kNsPerMs;  // how often a lost device is looked for where nothing announces it
};

// What a widget said of itself.
struct EnttecProIdentity {
  std::string usb_serial;           // of the USB descriptor; may be empty
  std::uint32_t widget_serial = 0;  // label 10; 0: it does not know
  ProParams params;
};

// Beyond PortCounters; a copy, taken at one instant.
struct EnttecProStats {
  std::uint64_t garbage_bytes = 0;      // bytes from the widget that belong to no message
  std::uint64_t bad_messages = 0;       // false starts, and payloads that are not what their label promises
  std::uint64_t line_errors = 0;        // source: frames that the widget marked as damaged; not passed on
  std::uint64_t other_start_codes = 0;  // source: frames that carry no levels (RDM, text, tests); not passed on
  std::uint64_t connects = 0;           // times the device was opened
  std::uint64_t keep_alives = 0;        // sink: frames sent again although unchanged
};

class EnttecPro;  // the thread and what it shares

class EnttecProSink final : public Sink {
 public:
  // Opens the device on the caller's thread, then starts the device thread. Clock: outlives the sink.
  static Result<std::unique_ptr<EnttecProSink>> open(EnttecProConfig config, std::unique_ptr<Connector> connector,
                                                     Clock& clock);
  // Without close(): ends at once, a write in progress is cut off.
  ~EnttecProSink() override;

  std::string name() const override;
  int poll_fd() const override;  // readable when state() may have changed
  PortState state() const override;
  std::string trouble() const override;
  PortCounters counters() const override;
  // Slots past the end of a short frame keep the levels sent before.
  Status send(TimeNs now_ns, std::span<const FrameView> frames) override;
  Status poll(TimeNs now_ns) override;
  std::span<const Universe> universes() const override;
  double rate_hz_max() const override;  // what the widget puts on its line
  void close(TimeNs now_ns) override;   // returns within write_timeout_ns, twice that with blackout_on_exit

  [[nodiscard]] EnttecProIdentity identity() const;
  [[nodiscard]] EnttecProStats stats() const;

 private:
  explicit EnttecProSink(std::unique_ptr<EnttecPro> device);
  std::unique_ptr<EnttecPro> device_;
};

class EnttecProSource final : public Source {
 public:
  static Result<std::unique_ptr<EnttecProSource>> open(EnttecProConfig config, std::unique_ptr<Connector> connector,
                                                       Clock& clock);
  ~EnttecProSource() override;

  std::string name() const override;
  int poll_fd() const override;  // readable when a frame has come or state() may have changed
  TimeNs next_deadline_ns() const override;
  PortState state() const override;  // kWaiting: open, and the line has been quiet for 1.25 s
  std::string trouble() const override;
  PortCounters counters() const override;
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override;  // at most one frame: the newest
  std::span<const Universe> universes() const override;

  [[nodiscard]] EnttecProIdentity identity() const;
  [[nodiscard]] EnttecProStats stats() const;

 private:
  explicit EnttecProSource(std::unique_ptr<EnttecPro> device);
  std::unique_ptr<EnttecPro> device_;
  LineFrame frame_{};    // of the last poll(); FrameView points into it
  TimeNs heard_ns_ = 0;  // when the newest frame came
  bool line_is_quiet_ = true;
};

}  // namespace footlight::drivers
