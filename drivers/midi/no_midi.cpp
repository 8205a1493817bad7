#include "drivers/midi/midi_device.h"

namespace footlight::drivers {

Result<std::unique_ptr<MidiDevice>> open_alsa_midi(const std::string& name) {
  return fail(ErrorCode::kUnsupported,
              "midi:{}: this build has no MIDI devices; install libasound2-dev and build again, or use midi:mock",
              name);
}

}  // namespace footlight::drivers
