// MIDI as an input of the hand: faders, knobs and keys of a device, by a control map (docs/control.md).
//
// Without a map, controller n of any channel sets the address n after a first one, and the keys do nothing.
// Values are shares: 0 to 127, of "cc14" and "pitch" 0 to 16,383. A "cc14" waits for its lower 7 bits, which a device
// sends second. It delivers no frames: it speaks to a HandTaker. If the device vanishes the port is gone, and what it
// has set stays; it is looked for once a second.
//
// Threads: the pump's. An event allocates nothing.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/midi/midi_device.h"
#include "sim/core/ports.h"
#include "tools/footlight/hand/control_map.h"

namespace footlight::tools {

struct MidiHandOptions {
  std::string name;  // the endpoint
  ControlMap map;
  Universe universe = 1;  // without controls in the map
  Address first_address = 1;
  std::shared_ptr<HandLink> link;
};

class MidiHand final : public Source {
 public:
  // Errors: those of Control::make() and of the rig; kBadInput: an input that is no MIDI control.
  [[nodiscard]] static Result<std::unique_ptr<MidiHand>> make(MidiHandOptions options,
                                                              std::unique_ptr<drivers::MidiDevice> device);

  [[nodiscard]] std::string name() const override { return options_.name; }
  [[nodiscard]] int poll_fd() const override { return gone() ? -1 : device_->poll_fd(); }
  [[nodiscard]] TimeNs next_deadline_ns() const override { return gone() ? retry_ns_ : device_->next_event_ns(); }
  [[nodiscard]] PortState state() const override {
    return gone() ? PortState::kGone : counters_.frames == 0 ? PortState::kWaiting : PortState::kWorking;
  }
  [[nodiscard]] std::string trouble() const override { return trouble_; }
  [[nodiscard]] PortCounters counters() const override { return counters_; }  // frames: events that did something
  void take_figures(std::vector<PortFigure>& into) const override {
    into.assign(1, {"other_events", static_cast<double>(others_)});
  }
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override;
  [[nodiscard]] std::span<const Universe> universes() const override { return {}; }
  [[nodiscard]] std::optional<PortNotice> take_notice() override { return std::exchange(notice_, std::nullopt); }

 private:
  struct Mapped {
    drivers::MidiInput input;
    Control control;
    int coarse = -1;  // of cc14: the upper 7 bits, once they came
  };

  MidiHand(MidiHandOptions options, std::unique_ptr<drivers::MidiDevice> device)
      : options_(std::move(options)), device_(std::move(device)) {}
  [[nodiscard]] bool gone() const { return !trouble_.empty(); }
  [[nodiscard]] static std::optional<double> share_of(Mapped& mapped, const drivers::MidiEvent& event);
  bool obey(const drivers::MidiEvent& event, TimeNs now_ns);
  void note(const Status& taken);

  const MidiHandOptions options_;
  std::unique_ptr<drivers::MidiDevice> device_;
  std::vector<Mapped> controls_;
  std::vector<drivers::MidiEvent> events_;
  HandCommand command_;
  PortCounters counters_;
  std::uint64_t others_ = 0;  // that mean nothing here
  std::string trouble_;
  TimeNs retry_ns_ = kTimeNever;
  std::optional<PortNotice> notice_;
  bool refused_ = false;
};

}  // namespace footlight::tools
