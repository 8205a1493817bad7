// Opens ports from endpoints. Only here networks, devices and logs come together.
//
//   PortOpener opener(clock);
//   FL_ASSIGN(const Endpoint endpoint, parse_port("sacn:1-9"));
//   FL_ASSIGN(std::unique_ptr<Source> source, opener.open_source(endpoint));
//
// Threads: one; the ports belong to the thread that runs the pump.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/driver.h"
#include "drivers/gpio/gpio_chip.h"
#include "drivers/gpio/strobe_line.h"
#include "drivers/net/net.h"
#include "sim/core/clock.h"
#include "sim/core/dmx.h"
#include "sim/core/endpoint.h"
#include "sim/core/ports.h"
#include "sim/core/result.h"
#include "sim/hand.h"
#include "sim/tempo.h"

namespace footlight::drivers {
class OwnSenders;
class RdmDirectory;
}  // namespace footlight::drivers

namespace footlight::tools {

// parse_endpoint() with the device schemes of this build.
[[nodiscard]] Result<Endpoint> parse_port(std::string_view text);
[[nodiscard]] Result<std::vector<Endpoint>> parse_ports(std::span<const std::string> texts);  // or the first error

// `mock:chase`, `mock:full`, `mock:sine`: an input that plays a pattern (sim/pattern.h).
[[nodiscard]] bool plays_pattern(const Endpoint& endpoint);
// True for osc and midi, which set levels by hand, and for lines that tap the tempo. Errors: those of parse_port().
[[nodiscard]] Result<bool> is_control(const std::string& text);
// True for models of devices and patterns: nothing outside of this process is behind the port.
[[nodiscard]] bool is_made_up(const Endpoint& endpoint);

// All optional. Options that do not apply to the kind of endpoint are ignored.
struct InOptions {
  bool wait_for_device = false;                    // device, gpio: start even if it is not plugged in
  bool receive_on_change = false;                  // device: report only changes, if supported
  std::optional<drivers::SecondPort> second_port;  // device: key and labels of a DMX USB Pro Mk2's second connector
  bool yields = false;                             // network: leaves unicast to every other program of this machine
  bool hear_preview = false;                       // sacn: also receive frames that are marked for visualisers
  int priority = kPriorityDefault;                 // artnet, gpio: priority of its frames in the merge
  bool rdm = false;                                // artnet: an RDM gateway to the devices that output its universes
  DurationNs log_start_ns = 0;                     // log: first time to play
  DurationNs log_stop_ns = kTimeNever;
  bool log_loop = false;
  double log_speed = 1.0;
  bool gpio_active_low = false;  // gpio: see drivers/gpio/gpio_chip.h
  drivers::GpioBias gpio_bias = drivers::GpioBias::kAsIs;
  drivers::StrobeConfig gpio_strobe;       // gpio: the effect of an edge
  std::vector<WireUniverse> log_renumber;  // log: if not empty, only these universes
  friend bool operator==(const InOptions&, const InOptions&) = default;
};

struct OutOptions {
  bool wait_for_device = false;
  bool blackout_on_exit = false;                   // device: zeros at the end; false: the last levels are held
  std::optional<drivers::SecondPort> second_port;  // device: see InOptions
  bool preview = false;                            // sacn: mark every frame for visualisers
  int priority = kPriorityDefault;                 // sacn
  std::string source_name = "Footlight";           // sacn
  double rate_hz_max = 0.0;                        // network, and devices timed by the host; 0: no limit
  bool sync = false;                               // artnet: an ArtSync after each batch of frames
  bool broadcast = true;  // artnet without an address: broadcast universes that no node outputs
  // sacn, as in drivers::SacnSinkOptions:
  std::vector<std::uint8_t> address_priorities;
  int sync_universe = 0;
  int multicast_ttl = 0;  // 0: default
  bool announce = true;
  drivers::Cid cid = {};       // all zero: derived from the machine, the name and the endpoint
  bool log_overwrite = false;  // log, vrsl: replace files
  friend bool operator==(const OutOptions&, const OutOptions&) = default;
};

// Options of the network ports; the scheme of the endpoint must match.
[[nodiscard]] drivers::SacnSourceOptions sacn_source_options(const Endpoint& endpoint, const InOptions& options);
[[nodiscard]] drivers::ArtnetSourceOptions artnet_source_options(const Endpoint& endpoint, const InOptions& options);
[[nodiscard]] drivers::SacnSinkOptions sacn_sink_options(const Endpoint& endpoint, const OutOptions& options);
[[nodiscard]] drivers::ArtnetSinkOptions artnet_sink_options(const Endpoint& endpoint, const OutOptions& options);

class PortOpener {
 public:
  // The clock must outlive the ports. `stopping` is called while a port takes long to open; true ends that with
  // kTimeout.
  explicit PortOpener(Clock& clock, std::function<bool()> stopping = {});

  // Errors: those of the factories in drivers/ and sim/dmx_log/; the message begins with the endpoint.
  [[nodiscard]] Result<std::unique_ptr<Source>> open_source(const Endpoint& endpoint, const InOptions& options = {});
  // `show_universes`: the universes that a log records; other kinds carry those of their endpoint.
  [[nodiscard]] Result<std::unique_ptr<Sink>> open_sink(const Endpoint& endpoint,
                                                        std::span<const Universe> show_universes,
                                                        const OutOptions& options = {});

  // Control endpoints (osc, midi) speak to what the link names. Null, as at first: they are refused.
  std::shared_ptr<HandLink> hand_link;
  // Of the patterns that it opens.
  const std::shared_ptr<Tempo> tempo = std::make_shared<Tempo>();

 private:
  [[nodiscard]] Result<std::unique_ptr<Source>> open_control(const Endpoint& endpoint);

  Clock& clock_;
  const std::function<bool()> stopping_;
  std::shared_ptr<drivers::RdmDirectory> rdm_directory_;  // lines of open devices
  std::shared_ptr<drivers::OwnSenders> own_senders_;      // so that inputs ignore outputs of this program
};

// The demo show as a source; `options` as for a log.
[[nodiscard]] Result<std::unique_ptr<Source>> open_demo_source(const InOptions& options = {});

// Nanoseconds since 1970-01-01 UTC, for the headers of logs.
[[nodiscard]] std::int64_t wall_clock_unix_ns();

}  // namespace footlight::tools
