// A sender or receiver found on the network.
#pragma once

#include <string>
#include <vector>

#include "sim/core/dmx.h"

namespace footlight::tools {

struct NetworkFinding {
  std::string protocol;            // the scheme of its endpoints: "sacn"
  std::string name;                // its own name, printable; may be empty
  std::string address;             // IPv4
  std::string id;                  // distinguishes senders; sACN: the CID
  std::vector<Universe> sends;     // wire numbers, from 1; ascending
  std::vector<Universe> receives;  // the same
  bool complete = true;            // false: a part of its list is missing
};

}  // namespace footlight::tools
