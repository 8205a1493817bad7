// A notice of an unusual event, sent once: a line for people, and fields that a program can sort by.
//
// The ids are stable: scripts and alarms search for them, so an id keeps its meaning from version to version. All ids
// are listed in docs/events.md, and a test compares the two.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "sim/core/dmx.h"

namespace footlight {

enum class NoticeLevel : std::uint8_t {
  kInfo,     // normal operation, or normal again
  kWarning,  // needs attention; the rest continues
  kError,    // something that was requested is not done
};

// Valid during the call that receives it.
struct Notice {
  NoticeLevel level = NoticeLevel::kInfo;
  std::string_view id;    // "port-lost": lower case and dashes
  std::string_view text;  // one line, complete without the other fields
  std::string_view port;  // name of the port concerned; empty: none
  Universe universe = 0;  // 0: none, or several
};

// Receives notices; must not block for long.
using NoticeReceiver = std::function<void(const Notice&)>;

}  // namespace footlight
