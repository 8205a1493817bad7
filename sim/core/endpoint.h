// The syntax of endpoints: where frames come from or go to, in show files and on the command line.
//
//   sacn:1-9                  universes 1 to 9 over multicast          sacn:1,3,5-7    single ones
//   sacn:1-9@10.0.0.7         to (out) or on (in) one address          artnet:1-9@10.9.0.255
//   sacn:1-9@10.0.0.7:5569    with a UDP port of its own               sacn:1-9%eth0   through one interface
//   sacn:1-9@10.0.0.7,10.0.0.8                                  to several, on one UDP port
//   sacn:1-9%eth0,eth1        through several interfaces
//   sacn:101-109=1-9          renumbered: wire on the left, show on the right
//   vrsl-osc:1-9@10.0.0.7     the OSC messages of VR Stage Lighting's grid node; universes 1 to 9
//   enttec-pro:EN123456=3     a device by its serial, as universe 3 of the show; without "=" as universe 1
//   enttec-pro:EN123456=3,4   its connectors 1 and 2                   enttec-pro:EN123456/2=4  connector 2 alone
//   enttec-pro                the only one plugged in                  mock:enttec-pro a model of one in this process
//   gpio:gpiochip0/17=1.25    an input line of a GPIO chip, as universe 1 address 25
//   gpio:gpiochip0/16-23=1.25 eight lines, as addresses 25 to 32       gpio:gpiochip0/BLACKOUT,4=1.25  names, lists
//   gpio:gpiochip0/17=tempo   each edge is a tap of the tempo of patterns; no universe
//   gpio:mock/2=1.25          a line of a model in this process: a contact that closes twice a second
//   vrsl:1-9@frame_%05d.png   universes as pictures, for or from VR Stage Lighting (docs/vrsl_pictures.md)
//   vrsl:1-3=11-13@show.png   its universes 1 to 3 as 11 to 13 of the show
//   vrsl:1-9@mock             a loopback device in this process; read alone: a moving pattern
//   vrsl:1-9@TARGET?KEY=VALUE&KEY=VALUE     with options; the last "?" begins them, so that of a URL is followed by one
//   audio:map.toml            a sound map: the sound, and the slots that it sets (docs/sound.md)
//   audio:track.flac=1.25     a sound file: its four bands and its beat as addresses 25 to 29 of universe 1
//   audio:alsa:default=1.25   the same of a device
//   audio:mock=1.25           of a model of a device: a beat of 120 a minute
//   osc:8000                  OSC of phones on a UDP port, which sets levels by hand (docs/control.md)
//   osc:8000@10.0.0.7         only on that address of this machine       osc:map.toml    with a control map
//   midi:nanoKONTROL2=1.1     a MIDI device: controller n sets address n after the first
//   midi:map.toml             with a control map                         midi:mock=1.1   a model of a device
//   log:FILE                  a file; everything after "log:" is its name
//
// Universe numbers count from 1 on both sides, in every protocol. Parsing checks the text only. Opening the endpoint
// checks whether the device, the interface or the file exists.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/core/dmx.h"
#include "sim/core/result.h"

namespace footlight {

// One universe of a port: its number on the wire and its number in the show.
struct WireUniverse {
  int wire = 0;
  Universe show = 0;
  friend bool operator==(const WireUniverse&, const WireUniverse&) = default;
};

enum class EndpointKind {
  kNetwork,  // sacn, artnet, vrsl-osc: universes are required
  kDevice,   // one of the device schemes: a universe for each connector
  kGpio,     // gpio: input lines, one slot each; one universe
  kFile,     // log, audio: the file determines the universes, except for audio with a place
  kControl,  // osc, midi: sets levels by hand, in no universe of its own
  kPicture,  // vrsl: universes 1 to 9 of a grid in pictures
};

// "layout=vertical-left" of an endpoint of pictures.
struct EndpointOption {
  std::string key;
  std::string value;
  friend bool operator==(const EndpointOption&, const EndpointOption&) = default;
};

struct Endpoint {
  std::string text;  // as the user wrote it
  EndpointKind kind = EndpointKind::kNetwork;
  std::string scheme;  // "sacn"
  // device: serial or model, or empty; gpio: chip; file and picture: its name; audio: a map, a sound file,
  // alsa:DEVICE or mock; control: a map, or the name of a MIDI device; network: empty
  std::string target;
  std::vector<std::string> addresses;        // network: IPv4 addresses, or none
  std::uint16_t udp_port = 0;                // network: 0: the protocol's own port; osc
  std::vector<std::string> interface_names;  // network: "eth0", or none
  std::vector<std::string> lines;            // gpio: numbers or names, at least one, each once
  Address first_address = 1;                 // gpio, audio, midi: of the first line, band or controller
  std::vector<EndpointOption> options;       // picture: each key once; the port checks keys and values
  // In the order in which they were written; empty for a file. Device: `wire` is the connector, from 1.
  std::vector<WireUniverse> universes;
  bool names_connectors = false;  // device: false: the first connectors that can do what is needed

  [[nodiscard]] std::vector<Universe> show_universes() const;
  friend bool operator==(const Endpoint&, const Endpoint&) = default;
};

// The slots of audio with a place: four bands and the beat.
inline constexpr int kPlainSoundSlots = 5;
// True for "alsa", "alsa:DEVICE" and "mock", which are no files.
inline constexpr std::string_view kMockSound = "mock";
[[nodiscard]] bool is_sound_device(std::string_view sound);

// `device_schemes`: the ids of the drivers of this build. All errors are kBadInput; the message begins with the
// endpoint and names what was expected, with an example.
[[nodiscard]] Result<Endpoint> parse_endpoint(std::string_view text, std::span<const std::string_view> device_schemes);

// Reads "1-9", "1,3,7-9" or "101-109=1-9" (wire on the left, show on the right; both sides have equally many, in
// order). No number appears twice on either side. `wire_max`: the protocol's highest number. Errors: kBadInput; the
// message names the wrong part.
[[nodiscard]] Result<std::vector<WireUniverse>> parse_wire_universes(std::string_view text,
                                                                     int wire_max = kUniverseMax);

// Reads "1-100:150, 101-512:0": address ranges with a priority (0 to 200). Returns 512 priorities; addresses that are
// not listed have 0. Errors: kBadInput; the message names the wrong part.
[[nodiscard]] Result<std::vector<std::uint8_t>> parse_address_priorities(std::string_view text);

}  // namespace footlight
