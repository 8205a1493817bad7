#include "tools/footlight/hand/control_map.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "fixtures/files/export/write_file.h"
#include "fixtures/files/import/archive.h"
#include "fixtures/files/toml/toml_reader.h"
#include "fixtures/files/toml/toml_text.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/hand/hand_text.h"
#include "tools/footlight/paths.h"

namespace footlight::tools {
namespace {

constexpr std::uint64_t kMapBytesMax = 1u << 20;
constexpr std::size_t kControlsMax = 4'096;
constexpr std::string_view kScene = "scene ";

Result<ControlPlan> read_control(const fixtures::TomlNode& node, const std::string& name) {
  fixtures::TomlReader reader(node, name, "[[control]]");
  ControlPlan plan;
  plan.at = reader.place();
  plan.input = reader.text("input");
  plan.to = reader.text("to");
  plan.low = reader.text("low", plan.low);
  plan.high = reader.text("high", plan.high);
  plan.toggle = reader.boolean("toggle", false);
  const auto over = parse_duration(reader.text("over", "0s"));
  if (!over || *over > kHandFadeMaxNs) {
    reader.trouble(reader.place_of("over"), "over: expected a time of at most 24h, as in \"500ms\"");
  }
  FL_TRY(reader.finish());
  plan.over_ns = *over;
  return plan;
}

}  // namespace

Result<ControlMap> parse_control_map(std::string_view text, const std::string& name) {
  FL_ASSIGN(const fixtures::TomlNode root, fixtures::parse_toml(text, name));
  fixtures::TomlReader reader(root, name, "");
  ControlMap map;
  map.name = name;
  map.device = reader.text("device", "");
  map.port = static_cast<int>(reader.integer("port", 0, 65'535, 0));
  map.rig = reader.text("rig", "");
  map.scenes = reader.text("scenes", "");
  map.priority = static_cast<int>(reader.integer("priority", 1, kPriorityMax, kHandPriorityDefault));
  for (const fixtures::TomlNode* node : reader.tables("control")) {
    FL_ASSIGN(ControlPlan plan, read_control(*node, name));
    for (const ControlPlan& other : map.controls) {
      if (other.input != plan.input || other.to != plan.to) continue;
      return fail(ErrorCode::kBadInput, "{}:{}: '{}' controls {} already, at line {}", name, plan.at, plan.input,
                  plan.to, other.at.line);
    }
    map.controls.push_back(std::move(plan));
    if (map.controls.size() > kControlsMax) {
      return fail(ErrorCode::kBadInput, "{}: more than {} controls", name, kControlsMax);
    }
  }
  FL_TRY(reader.finish());
  return map;
}

Result<ControlMap> load_control_map(const std::string& path) {
  FL_ASSIGN(const auto bytes, fixtures::read_whole_file(path, kMapBytesMax));
  FL_ASSIGN(ControlMap map, parse_control_map(fixtures::text_of(bytes), path));
  const auto beside = [&](std::string& file) {
    if (!file.empty()) file = (std::filesystem::path(path).parent_path() / file).lexically_normal().string();
  };
  beside(map.rig);
  beside(map.scenes);
  return map;
}

Result<Control> Control::make(const ControlPlan& plan, const ControlMap& map, const RigOf& rig) {
  Control control;
  control.toggle_ = plan.toggle;
  control.command_.over_ns = plan.over_ns;
  control.command_.priority = static_cast<std::uint8_t>(map.priority);
  if (plan.to == "blackout") {
    control.kind_ = Kind::kBlackout;
    return control;
  }
  if (plan.to == "release") {
    control.kind_ = Kind::kRelease;
    control.command_.action = HandAction::kReleaseAll;
    return control;
  }
  if (plan.to == "tempo") {  // each press is a tap
    control.kind_ = Kind::kTempo;
    control.toggle_ = false;
    control.command_.action = HandAction::kTempo;
    return control;
  }
  if (plan.to.starts_with(kScene)) {
    control.kind_ = Kind::kScene;
    control.scene_ = {.name = plan.to.substr(kScene.size()),
                      .file = map.scenes.empty() ? scene_file_place() : map.scenes,
                      .rig = map.rig,
                      .over_ns = plan.over_ns,
                      .priority = control.command_.priority};
    return control;
  }
  std::vector<HandLevel> high;
  const auto read = [&]() -> Status {
    FL_TRY(add_assignment(plan.to + "=" + plan.low, rig, control.command_.levels));
    return add_assignment(plan.to + "=" + plan.high, rig, high);
  };
  if (const Status levels = read(); !levels) {
    return fail(levels.error().code, "{}:{}: {}", map.name, plan.at, levels.error().message);
  }
  for (const HandLevel& level : control.command_.levels) control.low_.push_back(level.value);
  for (const HandLevel& level : high) control.high_.push_back(level.value);
  if (control.low_.size() == control.high_.size()) return control;
  return fail(ErrorCode::kBadInput, "{}:{}: low and high have different numbers of levels", map.name, plan.at);
}

Status Control::move(double share, TimeNs now_ns, HandTaker& taker) {
  const bool was_pressed = pressed_;
  pressed_ = share >= 0.5;
  const bool press = pressed_ && !was_pressed;
  if (kind_ == Kind::kBlackout) return black_out(press, was_pressed && !pressed_, now_ns, taker);
  if (toggle_) {
    if (!press) return {};
    on_ = !on_;
    share = on_ ? 1 : 0;
  }
  switch (kind_) {
    case Kind::kScene:
      if (press) taker.recall(scene_);
      return {};
    case Kind::kTempo:
    case Kind::kRelease: return press ? taker.take(command_, now_ns) : Status();
    case Kind::kBlackout:
    case Kind::kLevels: break;
  }
  for (std::size_t i = 0; i < low_.size(); ++i) {
    const double low = low_[i], high = high_[i];
    command_.levels[i].value =
        static_cast<std::uint32_t>(std::llround(low + (high - low) * std::clamp(share, 0.0, 1.0)));
  }
  return taker.take(command_, now_ns);
}

Status Control::tap(TimeNs now_ns, HandTaker& taker) {
  pressed_ = false;
  Status done = move(1, now_ns, taker);
  pressed_ = began_ = false;
  return done;
}

// What is sent depends on the bridge, not on what this control did before: others begin and end blackouts, too.
Status Control::black_out(bool press, bool end, TimeNs now_ns, HandTaker& taker) {
  const bool is_on = taker.blacked_out();
  if (toggle_) {
    if (!press) return {};
    command_.action = is_on ? HandAction::kLift : HandAction::kBlackout;
    return taker.take(command_, now_ns);
  }
  if (pressed_) {
    // Also if it was pressed before: the message of its end may have been lost.
    began_ = (began_ && !press) || !is_on;
    command_.action = HandAction::kBlackout;
    return taker.take(command_, now_ns);
  }
  if (!end || !std::exchange(began_, false)) return {};
  command_.action = HandAction::kLift;
  return taker.take(command_, now_ns);
}

std::string map_head(const std::string& path, const std::string& device, int udp_port, const std::string& rig) {
  const bool midi = !device.empty();
  std::string text = fmt::format("# For 'footlight run --in {}:{}'.\n", midi ? "midi" : "osc", path);
  text += midi ? fmt::format("device = {}\n", fixtures::toml_text(device)) : fmt::format("port = {}\n", udp_port);
  if (!rig.empty()) text += fmt::format("rig = {}\n", fixtures::toml_text(rig));
  return text;
}

std::string control_text(const std::string& input, const std::string& to) {
  return fmt::format("[[control]]\ninput = {}\nto = {}\n", fixtures::toml_text(input), fixtures::toml_text(to));
}

Status append_control(const std::string& path, const std::string& head, const std::string& input,
                      const std::string& to) {
  std::string text = head;
  if (const auto bytes = fixtures::read_whole_file(path, kMapBytesMax)) {
    text = fixtures::text_of(*bytes);
  } else if (bytes.error().code != ErrorCode::kNotFound) {
    return tl::unexpected(bytes.error());
  }
  if (!text.empty() && text.back() != '\n') text += '\n';
  text += (text.empty() ? "" : "\n") + control_text(input, to);
  FL_TRY(parse_control_map(text, path));
  return fixtures::write_file(path, text);
}

}  // namespace footlight::tools
