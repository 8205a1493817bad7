// footlight learn: prints the next control that is moved, for a control map.
#include <cstdio>
#include <memory>

#include <poll.h>

#include "drivers/midi/midi_device.h"
#include "drivers/net/osc_packet.h"
#include "drivers/net/udp.h"
#include "sim/system_clock.h"
#include "tools/footlight/bridge/open_ports.h"
#include "tools/footlight/command.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/hand/control_map.h"
#include "tools/footlight/hand/hand_text.h"
#include "tools/footlight/hand/osc_hand.h"
#include "tools/footlight/stop_signal.h"

namespace footlight::tools {
namespace {

constexpr const char* kPrompt = "Move one fader, knob or button.\n";
constexpr DurationNs kStepNs = 100 * kNsPerMs;

struct Options {
  std::string endpoint;
  std::string to = "1.1";
  std::string map;
  DurationNs patience_ns = 30 * kNsPerS;
};

// Returns the first control that moves, as in a map; empty: none did.
Result<std::string> learn_midi(const std::string& device_name, DurationNs patience_ns, const StopSignal& signal) {
  SystemClock clock;
  const TimeNs end_ns = clock.now_ns() + patience_ns;
  FL_ASSIGN(const auto device, drivers::MidiDevice::open(device_name, clock.now_ns()));
  std::vector<drivers::MidiEvent> events;
  std::fputs(kPrompt, stderr);
  while (!signal.came() && clock.now_ns() < end_ns) {
    FL_TRY(device->read(events, clock.now_ns()));
    // The end of a key that was held before is no choice.
    for (const drivers::MidiEvent& event : events) {
      if (event.kind != drivers::MidiKind::kNote || event.value > 0) return drivers::midi_input_text(event);
    }
    events.clear();
    pollfd wait = {.fd = device->poll_fd(), .events = POLLIN, .revents = 0};
    (void)::poll(&wait, 1, static_cast<int>(kStepNs / kNsPerMs));
  }
  return std::string();
}

Result<std::string> learn_osc(OscHandOptions options, DurationNs patience_ns, const StopSignal& signal) {
  SystemClock clock;
  const TimeNs end_ns = clock.now_ns() + patience_ns;
  options.link = std::make_shared<HandLink>();
  FL_ASSIGN(const auto source, OscHand::open(std::move(options)));
  drivers::DatagramReader reader;
  std::vector<drivers::OscMessage> messages;
  std::fputs(kPrompt, stderr);
  while (!signal.came() && clock.now_ns() < end_ns) {
    const int count = reader.read(source->poll_fd());
    for (int i = 0; i < count; ++i) {
      messages.clear();
      if (!drivers::parse_osc(reader[static_cast<std::size_t>(i)].bytes, messages)) continue;
      for (const drivers::OscMessage& message : messages)
        if (message.all_numbers) return std::string(message.address);
    }
    pollfd wait = {.fd = source->poll_fd(), .events = POLLIN, .revents = 0};
    (void)::poll(&wait, 1, static_cast<int>(kStepNs / kNsPerMs));
  }
  return std::string();
}

Result<int> learn(const Options& options) {
  if (options.endpoint.empty()) {
    return fail(ErrorCode::kBadInput, "learn: expected an endpoint, for example 'footlight learn midi:nanoKONTROL2'");
  }
  const std::string& text = options.endpoint;
  const bool midi = text.starts_with("midi:"), osc = text.starts_with("osc:");
  if (!midi && !osc) return fail(ErrorCode::kBadInput, "{}: expected midi:DEVICE or osc:PORT", text);
  const std::string target = text.substr(text.find(':') + 1);
  StopSignal signal;
  std::string input;
  if (midi) {
    FL_ASSIGN(input, learn_midi(target, options.patience_ns, signal));
  } else {
    FL_ASSIGN(const Endpoint endpoint, parse_port(text));
    OscHandOptions wanted;
    wanted.name = text;
    wanted.udp_port = endpoint.udp_port;
    if (!endpoint.addresses.empty()) wanted.address = endpoint.addresses.front();
    FL_ASSIGN(input, learn_osc(std::move(wanted), options.patience_ns, signal));
  }
  if (signal.came()) return kExitOk;
  if (input.empty()) {
    return fail(ErrorCode::kNotFound, "{}: nothing was moved within {}; --wait sets another time", text,
                show_duration(options.patience_ns));
  }
  if (options.map.empty()) {
    std::fputs(control_text(input, options.to).c_str(), stdout);
    return kExitOk;
  }
  FL_ASSIGN(const Endpoint endpoint, parse_port(midi ? "osc:1" : text));  // of OSC its UDP port
  const std::string head = map_head(options.map, midi ? target : "", endpoint.udp_port, "");
  FL_TRY(append_control(options.map, head, input, options.to));
  std::fprintf(stderr, "%s: '%s' controls %s\n", options.map.c_str(), input.c_str(), options.to.c_str());
  return kExitOk;
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  arguments.word("ENDPOINT", options->endpoint, "midi:DEVICE or osc:PORT");
  arguments.option("--to", options->to, "TARGET",
                   "what it controls: 1.17, 'Mover 3:Tilt', 'scene Warm', blackout, release or tempo [1.1]");
  arguments.option("--map", options->map, "FILE", "add it to this control map; default: print it");
  arguments.duration("--wait", options->patience_ns, "how long to wait for a movement [30s]");
  arguments.job([options]() -> Result<int> { return learn(*options); });
}

}  // namespace

extern const CommandInfo learn_command{
    .name = "learn",
    .help = "Find out what a fader sends, and add it to a control map",
    .examples =
        "  footlight learn midi:nanoKONTROL2 --to 1.17 --map desk.toml\n"
        "  footlight learn midi:mock --to 'scene Warm'      a model of a device\n"
        "  footlight learn osc:8000 --to blackout --map phone.toml\n"
        "then 'footlight run --in midi:desk.toml --out ...'. See docs/control.md.",
    .add = add,
};

}  // namespace footlight::tools
