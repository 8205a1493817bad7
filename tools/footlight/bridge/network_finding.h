// One sender or receiver that has made itself known on the network.
#pragma once

#include <string>
#include <vector>

#include "sim/core/dmx.h"

namespace footlight::tools {

struct NetworkFinding {
  std::string protocol;            // the scheme of its endpoints: "sacn"
  std::string name;                // as it calls itself, fit for a terminal; may be empty
  std::string address;             // IPv4
  std::string id;                  // what the protocol tells senders apart by; sACN: the CID
  std::vector<Universe> sends;     // as the wire numbers them, from 1; ascending
  std::vector<Universe> receives;  // the same
  bool complete = true;            // false: a part of what it says has not come
};

}  // namespace footlight::tools
