#include "drivers/midi/midi_device.h"

#include <array>
#include <charconv>

namespace footlight::drivers {
namespace {

constexpr DurationNs kStepNs = 20 * kNsPerMs;
constexpr int kStepsPerNote = 50;

// Controller 7 of channel 1 moves from 0 to 127 and back in 5 s; key 60 is played once a second for half a second.
class MidiModel final : public MidiDevice {
 public:
  explicit MidiModel(TimeNs now_ns) : next_ns_(now_ns + kStepNs) {}
  [[nodiscard]] int poll_fd() const override { return -1; }
  [[nodiscard]] TimeNs next_event_ns() const override { return next_ns_; }
  Status read(std::vector<MidiEvent>& into, TimeNs now_ns) override {
    while (next_ns_ <= now_ns) {
      const int place = step_ % 254;
      into.push_back({MidiKind::kController, 1, 7, place < 128 ? place : 254 - place});
      if (step_ % kStepsPerNote == 0) into.push_back({MidiKind::kNote, 1, 60, 100});
      if (step_ % kStepsPerNote == kStepsPerNote / 2) into.push_back({MidiKind::kNote, 1, 60, 0});
      ++step_;
      next_ns_ += kStepNs;
    }
    return {};
  }

 private:
  TimeNs next_ns_;
  int step_ = 0;
};

// Removes a number and the space before it.
std::optional<int> take_number(std::string_view& text, int from, int to) {
  if (!text.starts_with(' ')) return std::nullopt;
  text.remove_prefix(1);
  int number = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (fault != std::errc() || number < from || number > to) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

struct Word {
  std::string_view text;
  MidiKind kind;
  bool fine;
};
constexpr std::array<Word, 4> kWords = {{{"cc14", MidiKind::kController, true},
                                         {"cc", MidiKind::kController, false},
                                         {"note", MidiKind::kNote, false},
                                         {"pitch", MidiKind::kPitchBend, false}}};

}  // namespace

std::unique_ptr<MidiDevice> make_midi_model(TimeNs now_ns) { return std::make_unique<MidiModel>(now_ns); }

Result<std::unique_ptr<MidiDevice>> MidiDevice::open(const std::string& name, TimeNs now_ns) {
  if (name == "mock") return make_midi_model(now_ns);
  return open_alsa_midi(name);
}

std::optional<MidiInput> parse_midi_input(std::string_view text) {
  for (const Word& word : kWords) {
    std::string_view rest = text;
    if (!rest.starts_with(word.text)) continue;
    rest.remove_prefix(word.text.size());
    const auto channel = take_number(rest, 1, 16);
    const bool numbered = word.kind != MidiKind::kPitchBend;
    const auto number = numbered ? take_number(rest, 0, word.fine ? 31 : 127) : std::optional(0);
    if (channel && number && rest.empty()) return MidiInput{word.kind, word.fine, *channel, *number};
  }
  return std::nullopt;
}

std::string midi_input_text(const MidiEvent& event) {
  switch (event.kind) {
    case MidiKind::kController: return fmt::format("cc {} {}", event.channel, event.number);
    case MidiKind::kNote: return fmt::format("note {} {}", event.channel, event.number);
    case MidiKind::kPitchBend: break;
  }
  return fmt::format("pitch {}", event.channel);
}

}  // namespace footlight::drivers
