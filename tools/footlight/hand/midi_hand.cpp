#include "tools/footlight/hand/midi_hand.h"

#include <cmath>

namespace footlight::tools {
namespace {

constexpr DurationNs kReconnectNs = kNsPerS;
constexpr int kFineOffset = 32;  // from a controller to the one with its lower 7 bits
constexpr int kCoarseMax = 127;
constexpr int kFineMax = 16'383;

}  // namespace

Result<std::unique_ptr<MidiHand>> MidiHand::make(MidiHandOptions options, std::unique_ptr<drivers::MidiDevice> device) {
  auto source = std::unique_ptr<MidiHand>(new MidiHand(std::move(options), std::move(device)));
  const ControlMap& map = source->options_.map;
  std::optional<fixtures::Rig> rig;
  if (!map.rig.empty()) {
    FL_ASSIGN(rig, fixtures::load_rig(map.rig));
  }
  const RigOf rig_of = [&](const std::string& text) -> Result<const fixtures::Rig*> {
    if (rig) return &*rig;
    return fail(ErrorCode::kBadInput, "{}: names a fixture, so the map needs a line rig = \"FILE\"", text);
  };
  for (const ControlPlan& plan : map.controls) {
    const auto input = drivers::parse_midi_input(plan.input);
    if (!input) {
      return fail(
          ErrorCode::kBadInput,
          "{}:{}: input: expected \"cc CHANNEL CONTROLLER\", \"cc14 ...\" (controllers 0 to 31), \"note CHANNEL "
          "KEY\" or \"pitch CHANNEL\", channels from 1, got \"{}\"",
          map.name, plan.at, plan.input);
    }
    FL_ASSIGN(Control control, Control::make(plan, map, rig_of));
    source->controls_.push_back({*input, std::move(control)});
  }
  source->command_.priority = static_cast<std::uint8_t>(map.priority);
  source->command_.levels.resize(1);
  source->command_.levels[0].universe = source->options_.universe;
  return source;
}

Status MidiHand::poll(TimeNs now_ns, FrameReceiver& /*receiver*/) {
  if (gone()) {
    if (now_ns < retry_ns_) return {};
    if (const Status back = device_->reconnect(); !back) {
      trouble_ = back.error().message;
      retry_ns_ = now_ns + kReconnectNs;
      return {};
    }
    trouble_.clear();
  }
  events_.clear();
  if (const Status read = device_->read(events_, now_ns); !read) {
    trouble_ = read.error().message;
    retry_ns_ = now_ns + kReconnectNs;
  }
  counters_.errors = device_->overruns();
  for (const drivers::MidiEvent& event : events_) ++(obey(event, now_ns) ? counters_.frames : others_);
  return {};
}

// nullopt: the event is not of this control, or its other half is still to come.
std::optional<double> MidiHand::share_of(Mapped& mapped, const drivers::MidiEvent& event) {
  const drivers::MidiInput& input = mapped.input;
  if (event.kind != input.kind || event.channel != input.channel) return std::nullopt;
  if (input.kind == drivers::MidiKind::kPitchBend) return static_cast<double>(event.value) / kFineMax;
  if (!input.fine) {
    if (event.number != input.number) return std::nullopt;
    // A key is pressed, however softly.
    if (input.kind == drivers::MidiKind::kNote) return event.value > 0 ? 1.0 : 0.0;
    return static_cast<double>(event.value) / kCoarseMax;
  }
  if (event.number == input.number) {
    mapped.coarse = event.value;
    return std::nullopt;
  }
  if (event.number != input.number + kFineOffset || mapped.coarse < 0) return std::nullopt;
  return static_cast<double>(mapped.coarse * 128 + event.value) / kFineMax;
}

bool MidiHand::obey(const drivers::MidiEvent& event, TimeNs now_ns) {
  HandLearner& learner = options_.link->learner;
  // The end of a key that was held before is no choice.
  if (learner.waits() && (event.kind != drivers::MidiKind::kNote || event.value > 0)) {
    return learner.take(options_.name, drivers::midi_input_text(event));
  }
  HandTaker* const taker = options_.link->taker;
  if (taker == nullptr) return false;
  bool any = false;
  for (Mapped& mapped : controls_) {
    const auto share = share_of(mapped, event);
    if (!share) continue;
    any = true;
    note(mapped.control.move(*share, now_ns, *taker));
  }
  if (!controls_.empty() || event.kind != drivers::MidiKind::kController) return any;
  const Address address = options_.first_address + event.number;
  if (!is_address(address)) return false;
  HandLevel& level = command_.levels[0];
  level.slots[0] = static_cast<std::uint16_t>(slot_of_address(address));
  level.value = static_cast<std::uint32_t>(std::lround(event.value * 255.0 / kCoarseMax));
  note(taker->take(command_, now_ns));
  return true;
}

void MidiHand::note(const Status& taken) {
  if (taken || refused_) return;
  refused_ = true;
  notice_ = PortNotice{NoticeLevel::kWarning, "control-refused", taken.error().message};
}

}  // namespace footlight::tools
