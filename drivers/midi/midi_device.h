// MIDI input: ALSA's sequencer, to which every MIDI device and program of this machine is connected, or a model.
//
// The library is loaded when the first device is opened, and not before. Threads: none; nothing blocks.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::drivers {

enum class MidiKind : std::uint8_t { kController, kNote, kPitchBend };

// A note that ends is a note with the value 0.
struct MidiEvent {
  MidiKind kind = MidiKind::kController;
  int channel = 1;  // 1 to 16
  int number = 0;   // controller or key, 0 to 127; pitch bend: 0
  int value = 0;    // 0 to 127; pitch bend: 0 to 16,383
  friend bool operator==(const MidiEvent&, const MidiEvent&) = default;
};

class MidiDevice {
 public:
  virtual ~MidiDevice() = default;
  // `name`: a part of the device's name as `aconnect -i` prints it, or CLIENT:PORT; "mock": a model, whose controller 7
  // moves up and down and whose key 60 is played once a second. Errors: kNotFound (the message lists the devices),
  // kPermission, kIo, kUnsupported (this build or this machine has no ALSA).
  [[nodiscard]] static Result<std::unique_ptr<MidiDevice>> open(const std::string& name, TimeNs now_ns);
  [[nodiscard]] virtual int poll_fd() const = 0;  // -1: next_event_ns() only
  [[nodiscard]] virtual TimeNs next_event_ns() const { return kTimeNever; }
  // Appends the events that have come. An error means that the device is gone.
  virtual Status read(std::vector<MidiEvent>& into, TimeNs now_ns) = 0;
  // After an error of read(): connects again if the device is back. Does not block. Errors: kNotFound, kIo.
  virtual Status reconnect() { return {}; }
  [[nodiscard]] virtual std::uint64_t overruns() const { return 0; }  // events that were lost
};

// The model alone, for builds without ALSA.
[[nodiscard]] std::unique_ptr<MidiDevice> make_midi_model(TimeNs now_ns);
// Of the operating system.
[[nodiscard]] Result<std::unique_ptr<MidiDevice>> open_alsa_midi(const std::string& name);

// A control of a device: "cc 1 7", "cc14 1 7", "note 1 60", "pitch 1".
struct MidiInput {
  MidiKind kind = MidiKind::kController;
  bool fine = false;  // cc14: with the controller 32 above it as the lower 7 bits
  int channel = 1;
  int number = 0;
  friend bool operator==(const MidiInput&, const MidiInput&) = default;
};
// nullopt: another text, or a number out of range. cc14 has controllers 0 to 31.
[[nodiscard]] std::optional<MidiInput> parse_midi_input(std::string_view text);
[[nodiscard]] std::string midi_input_text(const MidiEvent& event);

}  // namespace footlight::drivers
