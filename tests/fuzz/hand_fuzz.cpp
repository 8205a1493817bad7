// Commands of the hand as text: messages on the socket, assignments, scene files, and scene files that are changed.
#include "tests/fuzz/fuzz.h"
#include "tools/footlight/hand/hand_text.h"
#include "tools/footlight/hand/scene_file.h"

using namespace footlight;
using namespace footlight::tools;
using footlight::testing::require;

void footlight::testing::add_seeds(Seeds& seeds) {
  HandCommand command;
  for (const char* text :
       {"1.17=255", "1.1-12=50%", "2.1=255,128,0,7", "3.*=1", "1.17+18=30000", "1.1+3+5+7=4294967295"}) {
    require(parse_slot_assignment(text, command.levels).has_value());
    seeds.add("assignment-" + std::to_string(command.levels.size()), "\x01" + std::string(text));
  }
  command.over_ns = kNsPerS;
  command.levels.back().jumps = true;
  seeds.add("set", "\x02" + hand_message(command));
  for (const HandAction action : {HandAction::kRelease, HandAction::kReleaseAll, HandAction::kBlackout,
                                  HandAction::kLift, HandAction::kHold, HandAction::kRenew}) {
    command.action = action;
    seeds.add("action-" + std::to_string(static_cast<int>(action)), "\x02" + hand_message(command));
  }
  seeds.add("scenes",
            "\x03# A\n[[scene]]\nname = \"a\"\nlevels = [\"1.1-12=0\", \"Mover 3:Tilt=30\"]\n\n# B\n[[scene]]\n"
            "name = \"b\"\nlevels = [\n  \"1.17=50%\",\n]\n");
}

namespace {

void check_levels(const std::vector<HandLevel>& levels) {
  for (const HandLevel& level : levels) {
    require(is_universe(level.universe) && level.count >= 1 && level.count <= kHandSlotsMax);
    require(level.value <= hand_value_max(level.count));
    for (int i = 0; i < level.count; ++i) require(level.slots[static_cast<std::size_t>(i)] < kSlotCountMax);
  }
}

void check_assignment(std::string_view text) {
  std::vector<HandLevel> levels;
  if (!parse_slot_assignment(text, levels)) return;
  require(!levels.empty() && levels.size() <= kSlotCountMax);
  check_levels(levels);
  std::vector<HandLevel> again;
  for (const std::string& line : assignments_of(levels)) require(parse_slot_assignment(line, again).has_value());
  require(again == levels);
}

void check_message(std::string_view text) {
  const auto command = parse_hand_message(text);
  if (!command) {
    require(!command.error().message.empty());
    return;
  }
  require(command->levels.size() <= kHandLevelsMax);
  require(command->priority >= 1 && command->priority <= kPriorityMax);
  check_levels(command->levels);
  const auto again = parse_hand_message(hand_message(*command));
  require(again.has_value() && again->action == command->action && again->over_ns == command->over_ns);
  // Numbers in several slots are released slot by slot.
  if (command->action != HandAction::kRelease) require(*again == *command);
}

void check_scenes(std::string_view text) {
  const auto file = parse_scenes(std::string(text), "fuzz.toml");
  if (!file) {
    require(file.error().message.starts_with("fuzz.toml"));
    return;
  }
  const auto with = with_scene(*file, "new one", {"1.17=255"});
  if (with) {
    const auto again = parse_scenes(*with, "fuzz.toml");
    if (again) require(again->find("new one").has_value() && again->scenes.size() >= file->scenes.size());
  }
  for (const LevelScene& scene : file->scenes) {
    const auto without = without_scene(*file, scene.name);
    if (!without) continue;
    const auto again = parse_scenes(*without, "fuzz.toml");
    if (again) require(!again->find(scene.name).has_value());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  switch (data[0] % 3) {
    case 0: check_scenes(text); break;
    case 1: check_assignment(text); break;
    default: check_message(text); break;
  }
  return 0;
}
