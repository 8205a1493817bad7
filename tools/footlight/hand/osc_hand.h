// OSC as an input of the hand: phones and tablets with fader programs (docs/control.md).
//
//   /footlight/1/17 128              an integer is a level from 0 to 255; further arguments are the next addresses
//   /footlight/1/17 0.5              a float is a share from 0 to 1
//   /footlight/fixture/Mover_3/Tilt 0.5    of the attribute's range; needs a rig
//   /footlight/blackout 1            0: off; without an argument: on
//   /footlight/release               everything; /footlight/release/1/17: one slot
//   /footlight/tempo 128             beats a minute, of made-up inputs; /footlight/tap: a tap, with 0 nothing
//   /footlight/scene/Warm            with 0 nothing happens, so that a button recalls once
//
// and the addresses of a control map. In names, characters that OSC reserves (space # * , ? [ ] { } and /) are
// underscores. Other addresses are counted. It delivers no frames: it speaks to a HandTaker.
//
// Threads: the pump's. A message allocates nothing.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "drivers/fd.h"
#include "drivers/net/osc_packet.h"
#include "drivers/net/udp.h"
#include "sim/core/ports.h"
#include "tools/footlight/hand/control_map.h"

namespace footlight::tools {

struct OscHandOptions {
  std::string name;            // the endpoint
  std::string address;         // IPv4 address of this machine; "": any
  std::uint16_t udp_port = 0;  // 0: chosen by the system
  ControlMap map;              // with a rig: fixtures can be set by name
  std::shared_ptr<HandLink> link;
};

class OscHand final : public Source {
 public:
  // Errors: kIo (the UDP port is in use), and those of Control::make() and of the rig.
  [[nodiscard]] static Result<std::unique_ptr<OscHand>> open(OscHandOptions options);

  [[nodiscard]] std::string name() const override { return options_.name; }
  [[nodiscard]] int poll_fd() const override { return socket_.get(); }
  [[nodiscard]] PortState state() const override {
    return counters_.frames == 0 ? PortState::kWaiting : PortState::kWorking;
  }
  [[nodiscard]] PortCounters counters() const override { return counters_; }  // frames: messages that did something
  void take_figures(std::vector<PortFigure>& into) const override {
    into.assign(1, {"other_messages", static_cast<double>(others_)});
  }
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override;
  [[nodiscard]] std::span<const Universe> universes() const override { return {}; }
  [[nodiscard]] std::optional<PortNotice> take_notice() override { return std::exchange(notice_, std::nullopt); }

  [[nodiscard]] std::uint16_t udp_port() const;
  // One packet, as poll() reads it. For tests.
  void take(std::span<const std::uint8_t> packet, TimeNs now_ns);

 private:
  struct Hash {
    using is_transparent = void;
    std::size_t operator()(std::string_view text) const { return std::hash<std::string_view>{}(text); }
  };
  using Controls = std::unordered_map<std::string, std::vector<Control>, Hash, std::equal_to<>>;

  explicit OscHand(OscHandOptions options) : options_(std::move(options)) {}
  [[nodiscard]] Status listen();
  [[nodiscard]] Status make_controls();
  [[nodiscard]] Status make_fixtures(const fixtures::Rig& rig);
  // False: the address means nothing here.
  bool obey(const drivers::OscMessage& message, TimeNs now_ns);
  bool set_slots(std::string_view place, const drivers::OscMessage& message, HandAction action, TimeNs now_ns);
  bool give(const HandCommand& command, TimeNs now_ns);

  const OscHandOptions options_;
  drivers::Fd socket_;
  drivers::DatagramReader reader_;
  std::vector<drivers::OscMessage> messages_;
  Controls controls_;  // by address
  HandCommand command_;
  PortCounters counters_;
  std::uint64_t others_ = 0;  // that mean nothing here
  std::optional<PortNotice> notice_;
  bool refused_ = false;  // a command was refused, which was reported
};

}  // namespace footlight::tools
