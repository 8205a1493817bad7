// The ports and rules of a bridge, from a show file or from the command line.
//
// The show file is TOML:
//
//   universes = 9                  # optional: 1 to 9 exist even if no port names them
//   [merge]                        # optional
//   timeout = "2.5s"               # a sender that is silent for this long is dropped
//   ltp = [2, 3]                   # universes with latest takes precedence; the others have highest
//   ltp_slots = {1 = "1-24,30"}    # the same for addresses of a universe
//   ltp_rig = "rig.toml"           # the same for every address of this rig without intensity and mixed colour
//   [[in]]
//   endpoint = "sacn:1-9"          # see sim/core/endpoint.h
//   preview = false                # sacn: true also receives frames for visualisers
//   priority = 100                 # artnet; also rdm = true
//   wait_for_device = true         # devices; also receive_on_change = true
//   mode = "one-shot"              # gpio: see docs/gpio.md for this and its other keys
//   loop = true                    # log; also start = "10s", stop = "20s", speed = 2.0
//   [[out]]
//   endpoint = "enttec-pro:EN123456=3"
//   blackout_on_exit = true        # devices; also wait_for_device
//   second_port = {key = "0A1B2C3D", assign = 1, send = 2, receive = 3, receive_mode = 4, change_of_state = 5}
//                                  # devices, in and out: a DMX USB Pro Mk2, with the numbers that ENTTEC gave you
//   rate_hz_max = 40               # sacn, artnet, devices that this machine times
//   sync = true                    # artnet; without an address also broadcast = false
//   priority = 120                 # sacn; also source_name = "FOH", preview = true
//   address_priorities = "1-100:150, 101-512:0"  # sacn: per-address priority
//   sync_universe = 7000           # sacn; also multicast_ttl = 20, announce = true, cid = "8fd2a1c0-1b7e-..."
//   overwrite = true               # log, vrsl
//   standby_for = "sacn:1-9"       # any: sends only while the output with that endpoint is lost
//
// A key that does not apply to the kind of endpoint is an error, with the line.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/core/endpoint.h"
#include "sim/core/result.h"
#include "sim/merge.h"
#include "tools/footlight/bridge/open_ports.h"

namespace footlight::fixtures {
struct Rig;
}  // namespace footlight::fixtures

namespace footlight::tools {

// Equal plans make equal ports.
struct InPlan {
  Endpoint endpoint;
  InOptions options;
  bool demo = false;  // the demo show instead of the endpoint
  friend bool operator==(const InPlan&, const InPlan&) = default;
};

struct OutPlan {
  Endpoint endpoint;
  OutOptions options;
  std::string standby_for;  // text of the main output's endpoint: sends only while that is lost; empty: always
  friend bool operator==(const OutPlan&, const OutPlan&) = default;
};

// Addresses of a universe in which the latest change wins.
struct LtpSlots {
  Universe universe = 0;
  SlotSet slots;
  bool from_rig = false;  // from ltp_rig; ignored if no port carries the universe
  friend bool operator==(const LtpSlots&, const LtpSlots&) = default;
};

struct Show {
  std::vector<InPlan> ins;
  std::vector<OutPlan> outs;  // after order_standbys(): a standby comes after its main output
  int universe_count = 0;     // universes 1 to this exist in addition to those of the ports
  MergeOptions merge;
  std::vector<Universe> ltp;
  std::vector<LtpSlots> ltp_slots;  // of universes that are not in `ltp`; each universe once
  std::string ltp_rig;              // a rig file, as written in the show file; load_show() adds its slots to ltp_slots
};

// Moves each standby behind its main output. kBadInput names one whose main output is not in the show, is itself, or is
// part of a circle.
[[nodiscard]] Status order_standbys(Show& show);

// Adds the LTP slots of a rig: those of channels with an effect, none of whose functions has an attribute Dimmer,
// ColorAdd_, ColorSub_ or ColorRGB_. A slot that two fixtures share is HTP if it is HTP for one of them.
void add_ltp_slots(Show& show, const fixtures::Rig& rig);

// `file` is the name of the text in messages: "show.toml:12: ...". Errors: kBadInput.
[[nodiscard]] Result<Show> parse_show(std::string_view text, const std::string& file);
// Also returns kNotFound, kPermission, kIo.
[[nodiscard]] Result<Show> load_show(const std::string& path);

}  // namespace footlight::tools
