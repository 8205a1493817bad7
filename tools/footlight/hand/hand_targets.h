// What a command of the hand is about: slots ("1.17") or fixtures of a rig ("Mover 3:Tilt"), as on the command line,
// in scenes and in control maps.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "fixtures/model/rig.h"
#include "sim/core/result.h"
#include "sim/hand.h"

namespace footlight::tools {

// Called only for texts with the name of a fixture; `text` is for messages.
using RigOf = std::function<Result<const fixtures::Rig*>(const std::string& text)>;

// "1.17=255", "Mover 3:Tilt=30".
[[nodiscard]] Status add_assignment(const std::string& text, const RigOf& rig, std::vector<HandLevel>& into);
// "1.17", "Mover 3", "Mover 3:Tilt"; values are 0.
[[nodiscard]] Status add_target(const std::string& text, const RigOf& rig, std::vector<HandLevel>& into);

}  // namespace footlight::tools
