// Adds a control that was learnt to the map of its port, and opens the port again with it.
#pragma once

#include <functional>
#include <string>

#include "sim/core/endpoint.h"
#include "sim/core/result.h"

namespace footlight::tools {

struct LearnPlan {
  std::string map;       // the path of the map, which may not exist yet
  std::string head;      // its first lines then
  std::string endpoint;  // of the port with this map
};
// Of a port of OSC or MIDI: its own map, or a new one in the folder of the rig, named after the device or the UDP port.
// rig: the path of its file; "": none, and the map is in the current folder.
[[nodiscard]] LearnPlan plan_learning(const Endpoint& port, const std::string& rig);

// Adds the control and calls `open` with the plan's endpoint. If that fails, the map is as it was before. Errors: those
// of append_control() and of `open`; kIo: the map cannot be put back.
[[nodiscard]] Status learn_control(const LearnPlan& plan, const std::string& input, const std::string& to,
                                   const std::function<Status(const std::string& endpoint)>& open);

}  // namespace footlight::tools
