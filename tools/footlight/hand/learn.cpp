#include "tools/footlight/hand/learn.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>

#include <unistd.h>

#include "fixtures/files/export/write_file.h"
#include "fixtures/files/import/archive.h"
#include "tools/footlight/hand/control_map.h"
#include "tools/footlight/hand/hand_text.h"

namespace footlight::tools {
namespace {

constexpr std::uint64_t kLearntBytesMax = 1u << 20;

}  // namespace

LearnPlan plan_learning(const Endpoint& port, const std::string& rig) {
  const bool midi = port.scheme == "midi";
  LearnPlan plan;
  if (port.target.ends_with(".toml")) {
    plan.map = port.target;
  } else {
    const std::string name = midi ? osc_name(port.target) : fmt::format("osc-{}", port.udp_port);
    plan.map = (std::filesystem::path(rig).parent_path() / (name + ".toml")).string();
  }
  const std::string rig_name = std::filesystem::path(rig).filename().string();
  plan.head = map_head(plan.map, midi ? port.target : "", port.udp_port, rig_name);
  plan.endpoint = fmt::format("{}:{}", port.scheme, plan.map);
  return plan;
}

Status learn_control(const LearnPlan& plan, const std::string& input, const std::string& to,
                     const std::function<Status(const std::string& endpoint)>& open) {
  const auto before = fixtures::read_whole_file(plan.map, kLearntBytesMax);
  FL_TRY(append_control(plan.map, plan.head, input, to));
  const Status opened = open(plan.endpoint);
  if (opened) return {};
  if (before) {
    FL_TRY(fixtures::write_file(plan.map, fixtures::text_of(*before)));
  } else if (unlink(plan.map.c_str()) != 0) {
    return fail(ErrorCode::kIo, "{}: cannot be removed ({}), but: {}", plan.map, std::strerror(errno),
                opened.error().message);
  }
  return opened;
}

}  // namespace footlight::tools
