// From the words of an endpoint to a port of the pump: the one place that sees networks, devices and logs together.
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

namespace footlight::drivers {
class OwnSenders;
class RdmDirectory;
}  // namespace footlight::drivers

namespace footlight::tools {

// parse_endpoint() with the device schemes of this build.
[[nodiscard]] Result<Endpoint> parse_port(std::string_view text);
[[nodiscard]] Result<std::vector<Endpoint>> parse_ports(std::span<const std::string> texts);  // or the first error

// All optional; those that the kind of endpoint has no use for are not looked at.
struct InOptions {
  bool wait_for_device = false;                    // device, gpio: begin although it is not plugged in
  bool receive_on_change = false;                  // device: report changes only, where it can
  std::optional<drivers::SecondPort> second_port;  // device: key and labels of a DMX USB Pro Mk2's second connector
  bool yields = false;                             // network: leaves unicast to every other program of this machine
  bool hear_preview = false;                       // sacn: frames that are meant for visualisers, too
  int priority = kPriorityDefault;                 // artnet, gpio: what its frames carry into the merge
  bool rdm = false;             // artnet: a gateway for RDM to the devices that its universes are sent to
  DurationNs log_start_ns = 0;  // log: where in it to begin
  DurationNs log_stop_ns = kTimeNever;
  bool log_loop = false;
  double log_speed = 1.0;
  bool gpio_active_low = false;  // gpio: see drivers/gpio/gpio_chip.h
  drivers::GpioBias gpio_bias = drivers::GpioBias::kAsIs;
  drivers::StrobeConfig gpio_strobe;       // gpio: what an edge does
  std::vector<WireUniverse> log_renumber;  // log: where not empty, only these
  friend bool operator==(const InOptions&, const InOptions&) = default;
};

struct OutOptions {
  bool wait_for_device = false;
  bool blackout_on_exit = false;                   // device: zeros at the end, not the last look
  std::optional<drivers::SecondPort> second_port;  // device: see InOptions
  bool preview = false;                            // sacn: flag every frame as meant for visualisers
  int priority = kPriorityDefault;                 // sacn
  std::string source_name = "Footlight";           // sacn
  double rate_hz_max = 0.0;                        // network, and devices that the host times: 0 for as frames come
  bool sync = false;                               // artnet: an ArtSync after each batch of frames
  bool broadcast = true;  // artnet, searching: universes that no device has asked for go to everybody
  // sacn, as in drivers::SacnSinkOptions:
  std::vector<std::uint8_t> address_priorities;
  int sync_universe = 0;
  int multicast_ttl = 0;  // 0: the default
  bool announce = true;
  drivers::Cid cid = {};  // all zero: made from the machine, the name and the endpoint
  bool log_overwrite = false;
  friend bool operator==(const OutOptions&, const OutOptions&) = default;
};

// What the ports of the network are made with; the scheme of the endpoint has to be theirs.
[[nodiscard]] drivers::SacnSourceOptions sacn_source_options(const Endpoint& endpoint, const InOptions& options);
[[nodiscard]] drivers::ArtnetSourceOptions artnet_source_options(const Endpoint& endpoint, const InOptions& options);
[[nodiscard]] drivers::SacnSinkOptions sacn_sink_options(const Endpoint& endpoint, const OutOptions& options);
[[nodiscard]] drivers::ArtnetSinkOptions artnet_sink_options(const Endpoint& endpoint, const OutOptions& options);

class PortOpener {
 public:
  // The clock outlives the ports. `stopping`: asked while a port opens that takes long; true ends it with kTimeout.
  explicit PortOpener(Clock& clock, std::function<bool()> stopping = {});

  // Errors: those of the factories in drivers/ and sim/dmx_log/; the message begins with the endpoint.
  [[nodiscard]] Result<std::unique_ptr<Source>> open_source(const Endpoint& endpoint, const InOptions& options = {});
  // `show_universes`: what a log records; the other kinds carry what their endpoint names.
  [[nodiscard]] Result<std::unique_ptr<Sink>> open_sink(const Endpoint& endpoint,
                                                        std::span<const Universe> show_universes,
                                                        const OutOptions& options = {});

 private:
  Clock& clock_;
  const std::function<bool()> stopping_;
  std::shared_ptr<drivers::RdmDirectory> rdm_directory_;  // lines of the devices that are open
  std::shared_ptr<drivers::OwnSenders> own_senders_;      // so that no input hears what an output of this program sends
};

// The demo show as a source; `options` as for a log.
[[nodiscard]] Result<std::unique_ptr<Source>> open_demo_source(const InOptions& options = {});

// Nanoseconds since 1970-01-01 UTC, for the headers of logs.
[[nodiscard]] std::int64_t wall_clock_unix_ns();

}  // namespace footlight::tools
