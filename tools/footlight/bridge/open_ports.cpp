#include "tools/footlight/bridge/open_ports.h"

#include <algorithm>
#include <chrono>

#include "drivers/device/device_rdm.h"
#include "drivers/driver.h"
#include "drivers/gpio/gpio_source.h"
#include "drivers/net/net.h"
#include "drivers/net/vrsl_osc.h"
#include "drivers/ports_factory.h"
#include "drivers/rdm/rdm_controller.h"
#include "drivers/rdm/rdm_directory.h"
#include "sim/dmx_log/log_ports.h"
#include "sim/pattern.h"
#include "tools/demo_show/demo_assets.h"
#include "tools/footlight/hand/midi_hand.h"
#include "tools/footlight/hand/osc_hand.h"
#include "tools/footlight/hand/tempo_taps.h"
#include "tools/footlight/sound/live_sound.h"
#include "tools/footlight/sound/sound_log.h"
#include "tools/footlight/vrsl/open_pictures.h"

namespace footlight::tools {
namespace {

drivers::PortRequest device_request(const Endpoint& endpoint) {
  drivers::PortRequest request;
  request.scheme = endpoint.scheme;
  request.target = endpoint.target;
  request.universes = endpoint.show_universes();
  request.name = endpoint.text;
  if (endpoint.names_connectors)
    for (const WireUniverse& universe : endpoint.universes) request.connectors.push_back(universe.wire);
  return request;
}

LogSourceOptions log_source_options(const InOptions& options) {
  LogSourceOptions log;
  log.start_ns = options.log_start_ns;
  log.stop_ns = options.log_stop_ns;
  log.loop = options.log_loop;
  log.speed = options.log_speed;
  for (const WireUniverse& universe : options.log_renumber) log.renumber.emplace_back(universe.wire, universe.show);
  log.only_renumbered = !options.log_renumber.empty();
  return log;
}

Result<std::unique_ptr<Source>> as_source(Result<std::unique_ptr<LogSource>> log) {
  if (!log) return tl::unexpected<Error>(std::move(log).error());
  return std::unique_ptr<Source>(std::move(*log));
}

}  // namespace

Result<Endpoint> parse_port(std::string_view text) {
  std::vector<std::string_view> schemes;
  for (const drivers::DriverInfo* driver : drivers::drivers()) schemes.push_back(driver->id);
  return parse_endpoint(text, schemes);
}

Result<std::vector<Endpoint>> parse_ports(std::span<const std::string> texts) {
  std::vector<Endpoint> endpoints;
  for (const std::string& text : texts) {
    FL_ASSIGN(Endpoint endpoint, parse_port(text));
    endpoints.push_back(std::move(endpoint));
  }
  return endpoints;
}

bool plays_pattern(const Endpoint& endpoint) { return endpoint.scheme == "mock" && is_pattern(endpoint.target); }

namespace {

bool taps_tempo(const Endpoint& endpoint) { return endpoint.kind == EndpointKind::kGpio && endpoint.universes.empty(); }

}  // namespace

Result<bool> is_control(const std::string& text) {
  FL_ASSIGN(const Endpoint endpoint, parse_port(text));
  return endpoint.kind == EndpointKind::kControl || taps_tempo(endpoint);
}

bool is_made_up(const Endpoint& endpoint) {
  if (endpoint.scheme == "mock") return true;
  const bool has_models = endpoint.kind == EndpointKind::kGpio || endpoint.kind == EndpointKind::kControl ||
                          endpoint.kind == EndpointKind::kPicture || endpoint.scheme == "audio";
  return has_models && endpoint.target == "mock";
}

PortOpener::PortOpener(Clock& clock, std::function<bool()> stopping)
    : clock_(clock),
      stopping_(std::move(stopping)),
      rdm_directory_(std::make_shared<drivers::RdmDirectory>()),
      own_senders_(std::make_shared<drivers::OwnSenders>()) {}

drivers::SacnSourceOptions sacn_source_options(const Endpoint& endpoint, const InOptions& options) {
  auto sacn = drivers::options_of<drivers::SacnSourceOptions>(endpoint, nullptr);
  sacn.hear_preview = options.hear_preview;
  sacn.yields = options.yields;
  return sacn;
}

drivers::ArtnetSourceOptions artnet_source_options(const Endpoint& endpoint, const InOptions& options) {
  auto artnet = drivers::options_of<drivers::ArtnetSourceOptions>(endpoint, nullptr);
  artnet.priority = static_cast<std::uint8_t>(options.priority);
  artnet.yields = options.yields;
  return artnet;
}

drivers::SacnSinkOptions sacn_sink_options(const Endpoint& endpoint, const OutOptions& options) {
  auto sacn = drivers::options_of<drivers::SacnSinkOptions>(endpoint, nullptr);
  sacn.source_name = options.source_name;
  sacn.priority = static_cast<std::uint8_t>(options.priority);
  sacn.preview = options.preview;
  sacn.rate_hz_max = options.rate_hz_max;
  sacn.address_priorities = options.address_priorities;
  sacn.sync_universe = options.sync_universe;
  if (options.multicast_ttl != 0) sacn.multicast_ttl = options.multicast_ttl;
  sacn.announce = options.announce;
  sacn.cid = options.cid;
  return sacn;
}

drivers::ArtnetSinkOptions artnet_sink_options(const Endpoint& endpoint, const OutOptions& options) {
  auto artnet = drivers::options_of<drivers::ArtnetSinkOptions>(endpoint, nullptr);
  artnet.rate_hz_max = options.rate_hz_max;
  artnet.sync = options.sync;
  if (!options.broadcast) artnet.unsubscribed = drivers::ArtnetUnsubscribed::kSilent;
  return artnet;
}

Result<std::unique_ptr<Source>> PortOpener::open_source(const Endpoint& endpoint, const InOptions& options) {
  switch (endpoint.kind) {
    case EndpointKind::kFile: {
      const bool sound = endpoint.scheme == "audio";
      if (sound) {
        FL_ASSIGN(const fixtures::SoundMap map, sound_map_of(endpoint.text));
        if (is_sound_device(map.sound)) {
          return open_live_sound(map, {endpoint.text, map.link, options.wait_for_device, options.priority});
        }
      }
      FL_ASSIGN(LogReader reader, read_level_log(sound ? endpoint.text : endpoint.target, {}, stopping_));
      return as_source(LogSource::from_reader(std::move(reader), sound ? endpoint.text : "log:" + endpoint.target,
                                              log_source_options(options)));
    }
    case EndpointKind::kDevice: {
      if (plays_pattern(endpoint)) {
        FL_ASSIGN(const Pattern pattern, pattern_of(endpoint.target));
        std::vector<Universe> universes = endpoint.show_universes();
        std::sort(universes.begin(), universes.end());
        return std::make_unique<PatternSource>(endpoint.text, pattern, every_slot(std::move(universes)), tempo);
      }
      drivers::PortRequest request = device_request(endpoint);
      request.wait_for_device = options.wait_for_device;
      request.receive_on_change = options.receive_on_change;
      request.second_port = options.second_port;
      return drivers::open_source(request, clock_);
    }
    case EndpointKind::kGpio: {
      drivers::GpioConfig gpio;
      gpio.name = endpoint.text;
      gpio.chip = endpoint.target;
      gpio.lines = endpoint.lines;
      const bool taps = taps_tempo(endpoint);
      gpio.universe = taps ? 1 : endpoint.universes.front().show;
      gpio.address = endpoint.first_address;
      gpio.active_low = options.gpio_active_low;
      gpio.bias = options.gpio_bias;
      gpio.strobe = options.gpio_strobe;
      gpio.priority = static_cast<std::uint8_t>(options.priority);
      gpio.wait_for_device = options.wait_for_device;
      if (!taps) return drivers::open_gpio_source(std::move(gpio), clock_);
      gpio.strobe.flashes_hz_max = 0;  // no light flashes
      FL_ASSIGN(std::unique_ptr<Source> lines, drivers::open_gpio_source(std::move(gpio), clock_));
      return std::make_unique<TempoTaps>(std::move(lines), tempo);
    }
    case EndpointKind::kControl: return open_control(endpoint);
    case EndpointKind::kPicture: return open_picture_source(endpoint);
    case EndpointKind::kNetwork: break;
  }
  if (endpoint.scheme == "sacn") {
    auto sacn = sacn_source_options(endpoint, options);
    sacn.own_senders = own_senders_;
    sacn.stopping = stopping_;
    return drivers::make_sacn_source(sacn);
  }
  if (endpoint.scheme == "vrsl-osc") {
    auto osc = drivers::options_of<drivers::VrslOscSourceOptions>(endpoint, own_senders_);
    osc.yields = options.yields;
    return drivers::make_vrsl_osc_source(osc);
  }
  auto artnet = artnet_source_options(endpoint, options);
  artnet.own_senders = own_senders_;
  if (options.rdm) artnet.rdm_directory = rdm_directory_;
  return drivers::make_artnet_source(artnet);
}

Result<std::unique_ptr<Source>> PortOpener::open_control(const Endpoint& endpoint) {
  if (hand_link == nullptr) {
    return fail(
        ErrorCode::kBadInput,
        "{}: controls set levels by hand, which only 'footlight run' and the window of 'footlight preview' have",
        endpoint.text);
  }
  ControlMap map;
  const bool mapped = endpoint.target.ends_with(".toml");
  if (mapped) {
    FL_ASSIGN(map, load_control_map(endpoint.target));
  }
  if (endpoint.scheme == "osc") {
    OscHandOptions osc{.name = endpoint.text, .link = hand_link};
    if (!endpoint.addresses.empty()) osc.address = endpoint.addresses.front();
    osc.udp_port = mapped ? static_cast<std::uint16_t>(map.port) : endpoint.udp_port;
    if (osc.udp_port == 0) {
      return fail(ErrorCode::kBadInput, "{}: the map needs a line port = 8000, the UDP port", endpoint.text);
    }
    osc.map = std::move(map);
    FL_ASSIGN(std::unique_ptr<OscHand> source, OscHand::open(std::move(osc)));
    return std::unique_ptr<Source>(std::move(source));
  }
  const std::string device_name = mapped ? map.device : endpoint.target;
  if (device_name.empty()) {
    return fail(ErrorCode::kBadInput, "{}: the map needs a line device = \"NAME\", a part of the device's name",
                endpoint.text);
  }
  if (mapped && map.controls.empty()) {
    return fail(ErrorCode::kBadInput, "{}: the map has no [[control]]; 'footlight learn midi:{} --map {}' adds one",
                endpoint.text, device_name, endpoint.target);
  }
  MidiHandOptions midi{.name = endpoint.text, .link = hand_link};
  if (!endpoint.universes.empty()) midi.universe = endpoint.universes.front().show;
  midi.first_address = endpoint.first_address;
  midi.map = std::move(map);
  FL_ASSIGN(auto device, drivers::MidiDevice::open(device_name, clock_.now_ns()));
  FL_ASSIGN(std::unique_ptr<MidiHand> source, MidiHand::make(std::move(midi), std::move(device)));
  return std::unique_ptr<Source>(std::move(source));
}

Result<std::unique_ptr<Sink>> PortOpener::open_sink(const Endpoint& endpoint, std::span<const Universe> show_universes,
                                                    const OutOptions& options) {
  switch (endpoint.kind) {
    case EndpointKind::kFile: {
      if (endpoint.scheme == "audio") {
        return fail(ErrorCode::kBadInput, "{}: sound is an input; use --in or [[in]]", endpoint.text);
      }
      LogSinkOptions log;
      log.universes.assign(show_universes.begin(), show_universes.end());
      log.start_ns = clock_.now_ns();
      log.writer.wall_start_unix_ns = wall_clock_unix_ns();
      log.writer.overwrite = options.log_overwrite;
      FL_ASSIGN(std::unique_ptr<LogSink> sink, LogSink::create(endpoint.target, log));
      return std::unique_ptr<Sink>(std::move(sink));
    }
    case EndpointKind::kDevice: {
      if (plays_pattern(endpoint)) {
        return fail(ErrorCode::kBadInput, "{}: a pattern is an input; use --in or [[in]]", endpoint.text);
      }
      drivers::PortRequest request = device_request(endpoint);
      request.wait_for_device = options.wait_for_device;
      request.blackout_on_exit = options.blackout_on_exit;
      request.rate_hz = options.rate_hz_max;
      request.second_port = options.second_port;
      FL_ASSIGN(std::unique_ptr<Sink> sink, drivers::open_sink(request, clock_));
      if (const auto* device = dynamic_cast<const drivers::DeviceSink*>(sink.get())) {
        drivers::put_rdm_lines(*rdm_directory_, *device, drivers::rdm_own_uid());
      }
      return sink;
    }
    case EndpointKind::kGpio:
      return fail(ErrorCode::kBadInput, "{}: GPIO lines are inputs; use --in or [[in]]", endpoint.text);
    case EndpointKind::kControl:
      return fail(ErrorCode::kBadInput, "{}: controls are inputs; use --in or [[in]]", endpoint.text);
    case EndpointKind::kPicture: return open_picture_sink(endpoint, options.log_overwrite);
    case EndpointKind::kNetwork: break;
  }
  if (endpoint.scheme == "sacn") {
    auto sacn = sacn_sink_options(endpoint, options);
    sacn.own_senders = own_senders_;
    return drivers::make_sacn_sink(sacn);
  }
  if (endpoint.scheme == "vrsl-osc") {
    auto osc = drivers::options_of<drivers::VrslOscSinkOptions>(endpoint, own_senders_);
    osc.rate_hz_max = options.rate_hz_max;
    return drivers::make_vrsl_osc_sink(osc);
  }
  auto artnet = artnet_sink_options(endpoint, options);
  artnet.own_senders = own_senders_;
  return drivers::make_artnet_sink(artnet);
}

Result<std::unique_ptr<Source>> open_demo_source(const InOptions& options) {
  const auto bytes = demo::demo_log_bytes();
  FL_ASSIGN(LogReader reader, LogReader::open_bytes({bytes.begin(), bytes.end()}, "demo"));
  return as_source(LogSource::from_reader(std::move(reader), "demo", log_source_options(options)));
}

std::int64_t wall_clock_unix_ns() {
  const auto since_epoch = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(since_epoch).count();
}

}  // namespace footlight::tools
