// The hardware boundary: a source of frames and a sink for frames.
//
// The pump (sim/pump.h) runs one loop on one thread. Each port gives it a file descriptor to wait for. A port that
// needs a thread (USB, HID) runs it internally: the thread leaves frames in the port's mailbox and makes an eventfd
// readable. So no call here blocks, and the loop takes no lock that a device thread holds during I/O.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/dmx.h"
#include "sim/core/notice.h"
#include "sim/core/result.h"

namespace footlight {

// Receives frames from sources. Called on the pump's thread.
class FrameReceiver {
 public:
  virtual ~FrameReceiver() = default;
  // May call send() of any sink before it returns, to send a frame before the next one of its sender replaces it. So
  // hold no lock that your own sink needs.
  virtual void receive(const FrameView& frame) = 0;
};

// Counters of a port. Not safe to read from other threads; the pump copies them.
struct PortCounters {
  std::uint64_t frames = 0;    // frames received or sent
  std::uint64_t rejected = 0;  // packets or messages that broke their protocol
  std::uint64_t dropped = 0;   // frames replaced by a newer one before they were used
  std::uint64_t errors = 0;    // reads or writes that the operating system refused
};

// A value that a port measures beyond PortCounters: {"break_us_p50", 176.0}. For status lines and metrics.
struct PortFigure {
  std::string name;  // lower case, unit last
  double value = 0.0;
};

enum class PortState { kWorking, kWaiting, kGone, kEnded };
// kWorking: in use. kWaiting: open, nothing received or not ready yet. kGone: unplugged; poll() tries again. kEnded: a
// log has reached its end and gives no more frames.

// A Notice (sim/core/notice.h) without the port's name, which the pump adds.
struct PortNotice {
  NoticeLevel level = NoticeLevel::kInfo;
  std::string_view id;  // listed in docs/events.md; a constant
  std::string text;     // without the port's name
};

class Port {
 public:
  virtual ~Port() = default;
  // The endpoint as the user wrote it: "sacn:1-9", "enttec-pro:EN123456".
  [[nodiscard]] virtual std::string name() const = 0;
  // Readable when poll() has work; -1: only next_deadline_ns() matters.
  [[nodiscard]] virtual int poll_fd() const { return -1; }
  // When poll() must be called even if the descriptor is not readable. kTimeNever: no deadline.
  [[nodiscard]] virtual TimeNs next_deadline_ns() const { return kTimeNever; }
  [[nodiscard]] virtual PortState state() const = 0;
  // Why the state is kGone; empty otherwise.
  [[nodiscard]] virtual std::string trouble() const { return {}; }
  [[nodiscard]] virtual PortCounters counters() const = 0;
  // Replaces the contents of `into`, reusing its memory. May be as old as the last call.
  virtual void take_figures(std::vector<PortFigure>& into) const { into.clear(); }
  // The next event of a working port (flashes held back by a safety limit), each returned once; nullopt if there is
  // none. Called after every poll(), on the pump's thread.
  [[nodiscard]] virtual std::optional<PortNotice> take_notice() { return std::nullopt; }
};

// Lost and late frames of one sender and universe, by the sender's sequence numbers.
struct SenderLosses {
  std::uint64_t lost = 0;  // numbers that were never received
  std::uint64_t late = 0;  // received after a later one, and not used
};

class Source : public Port {
 public:
  // Passes everything that has arrived to `receiver`, oldest first, without blocking. Failure means that the port is
  // lost for good.
  virtual Status poll(TimeNs now_ns, FrameReceiver& receiver) = 0;
  // The universes that it may deliver, after renumbering.
  [[nodiscard]] virtual std::span<const Universe> universes() const = 0;
  // A name for a sender whose frames this source has delivered: "FOH desk (10.0.0.7)"; empty: nothing better than the
  // port's name. On the pump's thread; may allocate.
  [[nodiscard]] virtual std::string sender_text(SenderId /*sender*/) const { return {}; }
  // For a sender and universes()[place], since its first frame; zeros if the protocol has no numbers. On the pump's
  // thread.
  [[nodiscard]] virtual SenderLosses sender_losses(std::size_t /*place*/, SenderId /*sender*/) const { return {}; }
};

class Sink : public Port {
 public:
  // Sends the newest frames: those of `frames` whose universe it carries. Never queues: a frame that is still unsent at
  // the next call is replaced and counted as dropped. Does not block.
  virtual Status send(TimeNs now_ns, std::span<const FrameView> frames) = 0;
  // Called when poll_fd() is readable or next_deadline_ns() has passed: keep-alives, device housekeeping.
  virtual Status poll(TimeNs now_ns) = 0;
  [[nodiscard]] virtual std::span<const Universe> universes() const = 0;
  // The pump calls send() at most this often per universe; 0: as soon as a universe changes.
  [[nodiscard]] virtual double rate_hz_max() const { return 0.0; }
  // Frames sent on its line, repeats included, if this machine times the line. nullopt: the device times it, or frames
  // leave as they are passed to send().
  [[nodiscard]] virtual std::optional<std::uint64_t> frames_on_line() const { return std::nullopt; }
  // Called on a standby when its main sink is back (sim/pump.h, SinkRole): no frames come until the next send(). A sink
  // that repeats frames must stop here, or two sinks send one universe.
  virtual void rest(TimeNs /*now_ns*/) {}
  // Sends the protocol's final messages (sACN: three packets with the terminated bit) and closes the device.
  virtual void close(TimeNs now_ns) = 0;
};

}  // namespace footlight
