// footlight scene: stores the levels of the running bridge under a name, and recalls them.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <set>

#include <nlohmann/json.hpp>

#include "tools/footlight/command.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/hand/hand_client.h"
#include "tools/footlight/hand/hand_text.h"
#include "tools/footlight/hand/scene_file.h"
#include "tools/footlight/paths.h"

namespace footlight::tools {
namespace {

struct Options {
  HandClientOptions bridge;
  std::string file;
  std::string name;
  std::vector<std::string> targets;
  DurationNs over_ns = 0;
  int priority = kHandPriorityDefault;
};

Result<std::string> file_of(const Options& options) {
  std::string file = options.file.empty() ? scene_file_place() : options.file;
  if (file.empty()) return fail(ErrorCode::kBadInput, "neither HOME nor XDG_CONFIG_HOME is set: give --file FILE");
  return file;
}

Status need_name(const Options& options, const char* word) {
  if (!options.name.empty()) return {};
  return fail(ErrorCode::kBadInput, "scene {}: expected a name, for example 'footlight scene {} Warm'", word, word);
}

using Slot = std::pair<Universe, std::uint16_t>;

// Of the merged levels those that the targets name.
Result<std::vector<HandLevel>> chosen(const std::vector<HandLevel>& merged, const std::vector<HandLevel>& targets) {
  std::set<Slot> wanted;
  for (const HandLevel& target : targets) {
    for (int i = 0; i < target.count; ++i) wanted.emplace(target.universe, target.slots[static_cast<std::size_t>(i)]);
  }
  std::vector<HandLevel> levels;
  for (const HandLevel& level : merged) {
    if (wanted.erase({level.universe, level.slots[0]}) != 0) levels.push_back(level);
  }
  if (wanted.empty()) return levels;
  return fail(ErrorCode::kNotFound, "universe {} has no levels: nothing was sent in it yet, or the bridge lacks it",
              wanted.begin()->first);
}

Result<int> store(const Options& options) {
  FL_TRY(need_name(options, "store"));
  FL_ASSIGN(const std::string file, file_of(options));
  FL_ASSIGN(HandClient client, HandClient::connect(options.bridge, "scene store"));
  FL_ASSIGN(const std::string page, client.page());
  const nlohmann::json json = nlohmann::json::parse(page, nullptr, /*allow_exceptions=*/false);
  if (json.is_object() && json.value("blackout", false)) {
    return fail(ErrorCode::kBadInput, "blackout is on, so the scene would be dark; 'footlight blackout off' first");
  }
  FL_ASSIGN(std::vector<HandLevel> levels, client.merged_levels());
  if (!options.targets.empty()) {
    FL_ASSIGN(const auto targets, client.targets(options.targets));
    FL_ASSIGN(levels, chosen(levels, targets));
  }
  if (levels.empty()) return fail(ErrorCode::kNotFound, "the bridge has no levels yet: nothing was sent to it");
  FL_TRY(store_scene(file, options.name, assignments_of(levels)));
  client.report(fmt::format("scene {}: {} stored in {}", options.name, counted_slots(levels), file));
  return kExitOk;
}

Result<int> recall(const Options& options) {
  FL_TRY(need_name(options, "recall"));
  FL_ASSIGN(const std::string path, file_of(options));
  FL_ASSIGN(const SceneFile file, load_scenes(path));
  FL_ASSIGN(const LevelScene* scene, file.find(options.name));
  FL_ASSIGN(HandClient client, HandClient::connect(options.bridge, "scene recall"));
  HandCommand command;
  command.over_ns = options.over_ns;
  command.priority = static_cast<std::uint8_t>(options.priority);
  for (const SceneLevel& level : scene->levels) {
    const auto levels = client.assignments({level.text});
    if (!levels) return fail(levels.error().code, "{}:{}: {}", path, level.at, levels.error().message);
    command.levels.insert(command.levels.end(), levels->begin(), levels->end());
  }
  FL_TRY(client.send(command));
  const std::string over = options.over_ns == 0 ? "set by hand" : "fading over " + show_duration(options.over_ns);
  client.report(fmt::format("scene {}: {}: {}", options.name, over, counted_slots(command.levels)));
  return kExitOk;
}

Result<int> list(const Options& options) {
  FL_ASSIGN(const std::string path, file_of(options));
  FL_ASSIGN(const SceneFile file, load_scenes(path));
  for (const LevelScene& scene : file.scenes) fmt::print("{}\n", scene.name);
  if (!file.scenes.empty()) return kExitOk;
  return fail(ErrorCode::kNotFound, "{}: has no scene; 'footlight scene store NAME' stores one", path);
}

Result<int> remove(const Options& options) {
  FL_TRY(need_name(options, "delete"));
  FL_ASSIGN(const std::string path, file_of(options));
  FL_TRY(delete_scene(path, options.name));
  HandClient::print_done(fmt::format("scene {}: deleted from {}", options.name, path));
  return kExitOk;
}

void add_file(Arguments& arguments, Options& options) {
  arguments.option("--file", options.file, "FILE", "the scenes; default: ~/.config/footlight/scenes.toml");
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  Arguments storing = arguments.subcommand("store", "Store the merged levels of the bridge",
                                           "  footlight scene store Warm\n"
                                           "  footlight scene store Front 1.1-24 'Par *' --rig rig.toml\n"
                                           "A scene with this name is replaced.");
  storing.word("NAME", options->name, "the name of the scene");
  storing.words("TARGET", options->targets, "slots and fixtures; default: every universe in which something was sent");
  add_file(storing, *options);
  add_hand_options(storing, options->bridge);
  storing.job([options]() -> Result<int> { return store(*options); });

  Arguments recalling = arguments.subcommand("recall", "Set the levels of a scene",
                                             "  footlight scene recall Warm --over 3s\n"
                                             "Its slots are then set by hand, until 'footlight release'.");
  recalling.word("NAME", options->name, "the name of the scene");
  recalling.duration("--over", options->over_ns, "fade for this time, at most 24h [0s]");
  recalling.option("--priority", options->priority, 1, kPriorityMax, "priority of its slots; consoles have 100 [150]");
  add_file(recalling, *options);
  add_hand_options(recalling, options->bridge);
  recalling.job([options]() -> Result<int> { return recall(*options); });

  Arguments listing = arguments.subcommand("list", "Print the names of the scenes", "  footlight scene list\n");
  add_file(listing, *options);
  listing.job([options]() -> Result<int> { return list(*options); });

  Arguments removing = arguments.subcommand("delete", "Delete a scene", "  footlight scene delete Warm\n");
  removing.word("NAME", options->name, "the name of the scene");
  add_file(removing, *options);
  removing.job([options]() -> Result<int> { return remove(*options); });
}

}  // namespace

extern const CommandInfo scene_command{
    .name = "scene",
    .help = "Store and recall levels of the running bridge",
    .examples =
        "  footlight scene store Warm\n"
        "  footlight scene recall Warm --over 3s\n"
        "Scenes are in a TOML file that may be edited; see docs/control.md.",
    .add = add,
};

}  // namespace footlight::tools
