// The whole hardware boundary: a source of frames and a sink for frames.
//
// The pump (sim/pump.h) runs one loop on one thread. Each port gives it a file descriptor to wait for; a port that
// needs a thread of its own (USB, HID) keeps it inside, leaves frames in a mailbox of its own and makes an eventfd
// readable. So nothing here blocks, and nothing in the loop takes a lock that a device thread holds during I/O.
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

// Takes frames from sources. Called on the pump's thread.
class FrameReceiver {
 public:
  virtual ~FrameReceiver() = default;
  // May call send() of any sink before it returns, so that a frame that a second one of its sender would replace leaves
  // first: hold no lock that your own sink needs.
  virtual void receive(const FrameView& frame) = 0;
};

// What a port counts; read from any thread is not allowed, the pump copies it out.
struct PortCounters {
  std::uint64_t frames = 0;    // frames received or sent
  std::uint64_t rejected = 0;  // packets or messages that broke their protocol
  std::uint64_t dropped = 0;   // frames replaced by a newer one before they were used
  std::uint64_t errors = 0;    // reads or writes that the system refused
};

// What a port measures of itself beyond PortCounters: {"break_us_p50", 176.0}. For status lines and metrics.
struct PortFigure {
  std::string name;  // lower case, with the unit last
  double value = 0.0;
};

enum class PortState { kWorking, kWaiting, kGone, kEnded };
// kWorking: in use. kWaiting: open, nothing heard or not ready yet. kGone: unplugged; poll() tries again.
// kEnded: a log has reached its end; it will give no more frames.

// A Notice (sim/core/notice.h) without what the pump adds: the port's name.
struct PortNotice {
  NoticeLevel level = NoticeLevel::kInfo;
  std::string_view id;  // of docs/events.md; a constant
  std::string text;     // for people, without the port's name
};

class Port {
 public:
  virtual ~Port() = default;
  // The endpoint that names it, as the user wrote it: "sacn:1-9", "enttec-pro:EN123456".
  [[nodiscard]] virtual std::string name() const = 0;
  // Readable when poll() has something to do; -1 where only next_deadline_ns() matters.
  [[nodiscard]] virtual int poll_fd() const { return -1; }
  // When poll() wants to be called though the descriptor is quiet. kTimeNever: not at all.
  [[nodiscard]] virtual TimeNs next_deadline_ns() const { return kTimeNever; }
  [[nodiscard]] virtual PortState state() const = 0;
  // Why the state is kGone, for people; empty otherwise.
  [[nodiscard]] virtual std::string trouble() const { return {}; }
  [[nodiscard]] virtual PortCounters counters() const = 0;
  // Replaces the contents of `into`, whose memory is used again. May be as old as the last call.
  virtual void take_figures(std::vector<PortFigure>& into) const { into.clear(); }
  // Something that a working port did or saw (flashes held back by a safety cap), each once; nothing where there is no
  // more. Asked for after every poll(), on the pump's thread.
  [[nodiscard]] virtual std::optional<PortNotice> take_notice() { return std::nullopt; }
};

// Frames of one sender and universe, by the numbers that the sender gave them.
struct SenderLosses {
  std::uint64_t lost = 0;  // numbers that never came
  std::uint64_t late = 0;  // came after a later one, and were not used
};

class Source : public Port {
 public:
  // Hands over everything that has arrived, oldest first, without blocking. Failure means that the port is lost for
  // good.
  virtual Status poll(TimeNs now_ns, FrameReceiver& receiver) = 0;
  // The universes that it may deliver, after renumbering.
  [[nodiscard]] virtual std::span<const Universe> universes() const = 0;
  // What people call a sender whose frames this source has delivered: "FOH desk (10.0.0.7)"; empty: nothing better than
  // the port's own name. On the pump's thread; may allocate.
  [[nodiscard]] virtual std::string sender_text(SenderId /*sender*/) const { return {}; }
  // Of a sender and universes()[place], since the sender was first heard; zeros where the wire numbers nothing. On the
  // pump's thread.
  [[nodiscard]] virtual SenderLosses sender_losses(std::size_t /*place*/, SenderId /*sender*/) const { return {}; }
};

class Sink : public Port {
 public:
  // Takes the newest frames: those of `frames` whose universe it carries. Never queues: what it has not sent when the
  // next call comes is replaced and counted as dropped. Does not block.
  virtual Status send(TimeNs now_ns, std::span<const FrameView> frames) = 0;
  // Called when poll_fd() is readable or next_deadline_ns() has passed: keep-alives, device housekeeping.
  virtual Status poll(TimeNs now_ns) = 0;
  [[nodiscard]] virtual std::span<const Universe> universes() const = 0;
  // The pump calls send() at most this often per universe; 0: as soon as a universe changes.
  [[nodiscard]] virtual double rate_hz_max() const { return 0.0; }
  // Frames that have left on its line, repeated ones too, where this machine times the line. nullopt: the device times
  // it, or frames leave as they are handed over.
  [[nodiscard]] virtual std::optional<std::uint64_t> frames_on_line() const { return std::nullopt; }
  // A standby whose main sink is back (sim/pump.h, SinkRole): nothing comes until the next send(). A sink that repeats
  // itself stops here, or two speak for one universe.
  virtual void rest(TimeNs /*now_ns*/) {}
  // Says the last words of the protocol (sACN: three packets with the terminated bit) and gives the device back.
  virtual void close(TimeNs now_ns) = 0;
};

}  // namespace footlight
