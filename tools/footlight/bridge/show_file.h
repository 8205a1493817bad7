// What a bridge connects: read from a show file or put together from the command line.
//
// The show file is TOML:
//
//   universes = 9                  # optional: 1 to 9 are there even where no port names them
//   [merge]                        # optional
//   timeout = "2.5s"               # how long a silent sender is remembered
//   ltp = [2, 3]                   # in these universes the latest change wins, not the highest level
//   ltp_slots = {1 = "1-24,30"}    # in universe 1 it does so at these addresses
//   ltp_rig = "rig.toml"           # and at every address of this rig that sets neither intensity nor mixed colour
//   [[in]]
//   endpoint = "sacn:1-9"          # see sim/core/endpoint.h
//   preview = false                # sacn: hear frames for visualisers, too
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
//   address_priorities = "1-100:150, 101-512:0"  # sacn: who wins, address by address
//   sync_universe = 7000           # sacn; also multicast_ttl = 20, announce = true, cid = "8fd2a1c0-1b7e-..."
//   overwrite = true               # log
//   standby_for = "sacn:1-9"       # any: fed only while the output of that endpoint is lost
//
// A key that the kind of endpoint has no use for is an error, with the line.
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
  bool demo = false;  // the demo show in place of the endpoint
  friend bool operator==(const InPlan&, const InPlan&) = default;
};

struct OutPlan {
  Endpoint endpoint;
  OutOptions options;
  std::string standby_for;  // the text of another one's endpoint: fed only while that one is lost; empty: always
  friend bool operator==(const OutPlan&, const OutPlan&) = default;
};

// Addresses of a universe in which the latest change wins.
struct LtpSlots {
  Universe universe = 0;
  SlotSet slots;
  bool from_rig = false;  // a rig put them there, so that they mean nothing where no port carries the universe
  friend bool operator==(const LtpSlots&, const LtpSlots&) = default;
};

struct Show {
  std::vector<InPlan> ins;
  std::vector<OutPlan> outs;  // after order_standbys(): who stands by for another comes after it
  int universe_count = 0;     // universes 1 to this are there beside those that ports name
  MergeOptions merge;
  std::vector<Universe> ltp;
  std::vector<LtpSlots> ltp_slots;  // of other universes than those of `ltp`; each universe once
  std::string ltp_rig;              // a rig file, as the show file names it; load_show() adds its slots to ltp_slots
};

// Puts those that stand by behind those that they stand by for. kBadInput names one that stands by for nobody of the
// show, for itself, or in a circle.
[[nodiscard]] Status order_standbys(Show& show);

// The slots of a rig that are LTP: those of channels that do something, and of whose functions none has an attribute
// Dimmer, ColorAdd_, ColorSub_ or ColorRGB_. A slot that two fixtures share is HTP where it is so for one of them.
void add_ltp_slots(Show& show, const fixtures::Rig& rig);

// `file` stands for the text in messages: "show.toml:12: ...". Errors: kBadInput.
[[nodiscard]] Result<Show> parse_show(std::string_view text, const std::string& file);
// Also kNotFound, kPermission, kIo.
[[nodiscard]] Result<Show> load_show(const std::string& path);

}  // namespace footlight::tools
