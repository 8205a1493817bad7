// What slots are for, by a rig: for the monitor, and for `footlight log compare`.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "fixtures/model/rig.h"
#include "sim/core/result.h"
#include "tools/footlight/monitor/level_moment.h"
#include "tools/footlight/preview/ui/rig_index.h"
#include "tools/footlight/preview/ui/slot_names.h"

namespace footlight::tools {

class SlotMeanings {
 public:
  // Of a rig in a file; an empty path: of no rig. Errors name the file.
  [[nodiscard]] static Result<SlotMeanings> of(const std::string& path);

  [[nodiscard]] bool has_rig() const { return rig_ != nullptr; }
  // Empty: nothing uses the slot.
  [[nodiscard]] std::vector<SlotName> of_slot(Universe universe, Address address) const;
  // The same in words, with values in real units: "Spot 1: Pan, byte 1 of 2: -32.5°".
  [[nodiscard]] std::string words(Universe universe, Address address, const LevelView& levels) const;

 private:
  // Its index in CompiledRig::universes; their number: the rig does not use it.
  [[nodiscard]] std::size_t at(Universe universe) const;

  std::unique_ptr<fixtures::Rig> rig_;
  std::unique_ptr<fixtures::CompiledRig> compiled_;
  std::unique_ptr<RigIndex> index_;
};

}  // namespace footlight::tools
