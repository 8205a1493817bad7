#include "tools/footlight/trace/head_trace.h"

#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fixtures/simulate/walker.h"
#include "sim/core/check.h"

namespace footlight::tools {
namespace {

using fixtures::f32::Walker;

TraceValue degrees(double rad) { return static_cast<float>(rad * 180 / std::numbers::pi); }

// "12.5" for 12.5 s: exact, without an exponent.
std::string seconds_text(DurationNs time_ns) {
  std::string text = fmt::format("{}.{:09}", time_ns / kNsPerS, time_ns % kNsPerS);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

// Places count from 1 and come round. 0: the wheel is out of the beam.
TraceValue wheel_place(const Walker& walker, const fixtures::TypeRow& type, unsigned wheel, float place) {
  const float count = static_cast<float>(walker.rig.wheels[type.wheel_first + wheel].slot_count);
  if (!(count > 0)) return {};
  if (!(place > 0.25f) || !(place < 1e6f)) return 0.0f;  // as the walker has it
  return place - count * std::floor((place - 0.5f) / count);
}

}  // namespace

struct HeadTrace::State {
  explicit State(const fixtures::CompiledRig& compiled)
      : walker(compiled), decoded(compiled.heads.size()), open(compiled.heads.size()) {}

  // Mean opening of a shutter since the exposure began.
  struct Open {
    double share_s = 0;
    double seconds = 0;
    float mean = 0;
  };

  Walker walker;
  std::vector<Walker::Decoded> decoded;  // after the last step: levels, motors and spins
  std::vector<Open> open;
};

HeadTrace::HeadTrace(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled)
    : rig_(rig), compiled_(compiled), state_(std::make_unique<State>(compiled)), followed_(compiled.heads.size()) {
  std::iota(followed_.begin(), followed_.end(), std::size_t{0});
}

HeadTrace::~HeadTrace() = default;

void HeadTrace::follow(std::vector<std::size_t> heads) { followed_ = std::move(heads); }

// As Walker::step(), and keeps what that forgets.
void HeadTrace::step(std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
  Walker& walker = state_->walker;
  FL_CHECK_EQ(levels.size(), compiled_.universes.size() * kSlotCountMax);
  FL_CHECK_GE(dt_ns, 0);
  walker.levels = levels;
  const auto dt = static_cast<std::uint64_t>(dt_ns);
  const f32::Turns dt_words(static_cast<std::uint32_t>(dt), static_cast<std::uint32_t>(dt >> 32));
  for (const std::size_t i : followed_) {
    const fixtures::HeadRow& row = compiled_.heads[i];
    const fixtures::TypeRow& type = compiled_.types[row.type];
    Walker::Decoded& decoded = state_->decoded[i];
    f32::Shutter shutter = f32::shutter_begin();
    if (row.strobe != fixtures::kNoAddress && walker.states[i].started != 0) shutter = walker.shutters[row.strobe];
    walker.decode_head(decoded, type, row);
    walker.head_step(walker.states[i], decoded, type, row, dt_words, new_exposure);
    // The shutter once more, on a copy: a state holds its product with the light only.
    const float mean = walker.head_opening(shutter, decoded, compiled_.lights[type.light], row, dt_words);
    State::Open& open = state_->open[i];
    if (new_exposure) open = {};
    const double dt_s = static_cast<double>(dt_ns) * 1e-9;
    open.share_s += static_cast<double>(mean) * dt_s;
    open.seconds += dt_s;
    open.mean = open.seconds > 0 ? static_cast<float>(open.share_s / open.seconds) : mean;
  }
  walker.levels = {};  // the caller's
}

std::size_t HeadTrace::head_count() const { return compiled_.heads.size(); }
std::size_t HeadTrace::fixture_of(std::size_t head) const { return compiled_.heads[head].fixture; }
int HeadTrace::number_of(std::size_t head) const { return static_cast<int>(compiled_.heads[head].head) + 1; }

TraceRow HeadTrace::row(std::size_t head, DurationNs time_ns) const {
  Walker& walker = state_->walker;
  const Walker::HeadState& state = walker.states[head];
  const Walker::Decoded& decoded = state_->decoded[head];
  const fixtures::HeadRow& row = compiled_.heads[head];
  const fixtures::TypeRow& type = compiled_.types[row.type];
  const auto joint = [&](unsigned param, float rad) -> TraceValue {
    for (unsigned j = 0; j < type.joint_count; ++j) {
      if (compiled_.joints[type.joint_first + j].param == param) return degrees(static_cast<double>(rad));
    }
    return {};
  };
  const float light = walker.rgb_luminance({state.red, state.green, state.blue});
  const auto pose = walker.pose(head);

  TraceRow cells{
      {"time_s", seconds_text(time_ns)},
      {"fixture", rig_.fixtures[row.fixture].name},
      {"head", std::int64_t{number_of(head)}},
      {"pan_deg", joint(fixtures::kParamPan, state.pan)},
      {"tilt_deg", joint(fixtures::kParamTilt, state.tilt)},
      {"turn_deg", joint(fixtures::kParamTurn, state.turn)},
      {"zoom_deg", degrees(2.0 * static_cast<double>(state.zoom))},
      {"light", light},
      {"light_lm", light * type.flux_lm},
      {"red", state.red},
      {"green", state.green},
      {"blue", state.blue},
      {"dimmer", decoded.value[fixtures::kParamDimmer]},
      {"shutter", state_->open[head].mean},
      {"strobe_hz",
       row.strobe != fixtures::kNoAddress ? TraceValue(decoded.value[fixtures::kParamStrobeHz]) : TraceValue()},
      {"color1", wheel_place(walker, type, fixtures::kWheelColor1, decoded.value[fixtures::kParamColor1])},
      {"color2", wheel_place(walker, type, fixtures::kWheelColor2, decoded.value[fixtures::kParamColor2])},
      {"gobo1", wheel_place(walker, type, fixtures::kWheelGobo1, decoded.value[fixtures::kParamGobo1])},
      {"gobo2", wheel_place(walker, type, fixtures::kWheelGobo2, decoded.value[fixtures::kParamGobo2])},
      {"animation", wheel_place(walker, type, fixtures::kWheelAnimation, decoded.value[fixtures::kParamAnimation])},
      {"prism1", wheel_place(walker, type, fixtures::kWheelPrism, decoded.value[fixtures::kParamPrism])},
      {"prism2", wheel_place(walker, type, fixtures::kWheelPrism2, decoded.value[fixtures::kParamPrism2])},
      {"beams", std::int64_t{state.beams}},
  };

  // What shapes the beam: heads without any of it have no such state.
  const Walker::OpticsState* optics = row.optics == fixtures::kNoAddress ? nullptr : &walker.optics_states[row.optics];
  const auto of_wheel = [&](unsigned wheel, float Walker::OpticsState::*angle_rad) -> TraceValue {
    const bool has = optics != nullptr && compiled_.wheels[type.wheel_first + wheel].slot_count > 0;
    return has ? degrees(static_cast<double>(optics->*angle_rad)) : TraceValue();
  };
  cells.emplace_back("gobo1_deg", of_wheel(fixtures::kWheelGobo1, &Walker::OpticsState::angle_1));
  cells.emplace_back("gobo2_deg", of_wheel(fixtures::kWheelGobo2, &Walker::OpticsState::angle_2));
  cells.emplace_back("animation_deg", of_wheel(fixtures::kWheelAnimation, &Walker::OpticsState::animation_angle));
  cells.emplace_back("prism1_deg", of_wheel(fixtures::kWheelPrism, &Walker::OpticsState::prism_angle));
  cells.emplace_back("prism2_deg", of_wheel(fixtures::kWheelPrism2, &Walker::OpticsState::prism_2_angle));
  cells.emplace_back("iris", optics != nullptr ? TraceValue(optics->iris) : TraceValue());
  cells.emplace_back("frost", optics != nullptr ? TraceValue(optics->frost) : TraceValue());
  const bool focused = optics != nullptr && !(optics->focus < 0);
  cells.emplace_back("focus_per_m", focused ? TraceValue(optics->focus) : TraceValue());
  static constexpr std::array<std::array<const char*, 3>, 4> kBlades{{{"blade1_a", "blade1_b", "blade1_deg"},
                                                                      {"blade2_a", "blade2_b", "blade2_deg"},
                                                                      {"blade3_a", "blade3_b", "blade3_deg"},
                                                                      {"blade4_a", "blade4_b", "blade4_deg"}}};
  const bool blades = optics != nullptr && compiled_.needs.blades;
  for (std::size_t b = 0; b < kBlades.size(); ++b) {
    cells.emplace_back(kBlades[b][0], blades ? TraceValue(optics->blade_a[b]) : TraceValue());
    cells.emplace_back(kBlades[b][1], blades ? TraceValue(optics->blade_b[b]) : TraceValue());
    cells.emplace_back(kBlades[b][2], blades ? degrees(static_cast<double>(optics->blade_angle[b])) : TraceValue());
  }

  // Where the beam leaves and goes.
  static constexpr std::array<const char*, 3> kLens{"lens_x_m", "lens_y_m", "lens_z_m"};
  static constexpr std::array<const char*, 3> kAxis{"beam_x", "beam_y", "beam_z"};
  for (int c = 0; c < 3; ++c) cells.emplace_back(kLens[static_cast<std::size_t>(c)], pose.lens_m[c]);
  for (int c = 0; c < 3; ++c) cells.emplace_back(kAxis[static_cast<std::size_t>(c)], pose.axis[c]);
  return cells;
}

namespace {

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

struct ToCsv {
  std::string operator()(std::monostate) const { return {}; }
  std::string operator()(const std::string& text) const { return csv_cell(text); }
  std::string operator()(std::int64_t number) const { return fmt::format("{}", number); }
  std::string operator()(float number) const { return fmt::format("{}", number); }
};

struct ToJson {
  std::string operator()(std::monostate) const { return "null"; }
  std::string operator()(const std::string& text) const {
    return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  }
  std::string operator()(std::int64_t number) const { return fmt::format("{}", number); }
  std::string operator()(float number) const { return std::isfinite(number) ? fmt::format("{}", number) : "null"; }
};

}  // namespace

std::string csv_names_of(const TraceRow& row) {
  std::string line;
  for (const auto& [name, value] : row) line += fmt::format("{}{}", line.empty() ? "" : ",", name);
  return line + "\n";
}

std::string csv_line_of(const TraceRow& row) {
  std::string line;
  for (std::size_t i = 0; i < row.size(); ++i) line += (i > 0 ? "," : "") + std::visit(ToCsv{}, row[i].second);
  return line + "\n";
}

std::string json_line_of(const TraceRow& row) {
  std::string line;
  for (const auto& [name, value] : row) {
    // Exact decimals stand as text in a row and are numbers in JSON.
    const bool seconds = std::string_view(name) == "time_s";
    line += fmt::format("{}\"{}\":{}", line.empty() ? "{" : ",", name,
                        seconds ? std::get<std::string>(value) : std::visit(ToJson{}, value));
  }
  return line + "}\n";
}

}  // namespace footlight::tools
