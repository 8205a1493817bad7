// Something out of the ordinary, said once: a line for people, and beside it what a machine wants to sort by.
//
// The ids are a promise: scripts and alarms look for them, so an id keeps its meaning from version to version. All of
// them are listed in docs/events.md, and a test compares.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "sim/core/dmx.h"

namespace footlight {

enum class NoticeLevel : std::uint8_t {
  kInfo,     // it is as it should be, or so again
  kWarning,  // somebody should look at it; the rest goes on
  kError,    // something that was asked for is not done
};

// Valid during the call that hands it over.
struct Notice {
  NoticeLevel level = NoticeLevel::kInfo;
  std::string_view id;    // "port-lost": lower case and dashes
  std::string_view text;  // one line for people, complete without the rest
  std::string_view port;  // name of the port that it is about; empty: none
  Universe universe = 0;  // 0: none, or several
};

// Takes notices; must not block for long.
using NoticeReceiver = std::function<void(const Notice&)>;

}  // namespace footlight
