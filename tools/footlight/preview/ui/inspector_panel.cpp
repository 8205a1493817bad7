// The selected fixtures: every channel in real units with controls that take it over, and what the heads do now.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "fixtures/model/attributes.h"
#include "fixtures/paperwork/patch_sheet.h"
#include "fixtures/simulate/encode.h"
#include "tools/footlight/preview/ui/channel_reading.h"
#include "tools/footlight/preview/ui/draw_controls.h"
#include "tools/footlight/preview/ui/draw_wheels.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/level_source.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"
#include "tools/footlight/trace/head_trace.h"

namespace footlight::tools {
namespace {

using fixtures::PhysicalUnit;

// A name of the trace: "strobe_hz" is "strobe" in Hz (docs/trace.md).
struct TraceWords {
  std::string name;
  const char* unit;
};
TraceWords words_of_trace(std::string_view column) {
  static constexpr std::array<std::array<const char*, 2>, 5> kEnds{
      {{"_per_m", "1/m"}, {"_deg", "\u00b0"}, {"_lm", "lm"}, {"_hz", "Hz"}, {"_m", "m"}}};
  TraceWords words{std::string(column), ""};
  for (const auto& [end, unit] : kEnds) {
    if (!column.ends_with(end)) continue;
    words = {std::string(column.substr(0, column.size() - std::string_view(end).size())), unit};
    break;
  }
  // A wheel has a place and an angle.
  static constexpr std::array<std::string_view, 5> kWheels{"gobo1", "gobo2", "animation", "prism1", "prism2"};
  if (words.unit[0] != '\0' && std::find(kWheels.begin(), kWheels.end(), words.name) != kWheels.end()) {
    words.name += " turn";
  }
  std::replace(words.name.begin(), words.name.end(), '_', ' ');
  return words;
}

class InspectorPanel final : public Panel {
 public:
  explicit InspectorPanel(UiDesk& desk) : desk_(desk) { follow(); }

  void step(std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) override {
    follow();
    if (!trace_) return;
    trace_->step(levels, dt_ns, new_exposure);
    stepped_ = true;
  }

  void restart() override { start_trace(); }

  void draw(UiDesk& desk, const UiInput& input) override {
    follow();
    draw_buttons(desk);
    if (lead_ < 0) {
      ImGui::PushTextWrapPos(0);
      ui_text(kUiDim, tr("Nothing is selected. Click a fixture in the picture or in the list of fixtures (F3)."));
      ImGui::PopTextWrapPos();
      return;
    }
    draw_fixture(desk);
    if (desk.can_edit()) draw_place(desk);
    follow();
    controls_.draw(desk, input, lead_, simulated_aim());
    draw_channels(desk, input);
    wheels_.draw(desk, input, lead_);
    if (ImGui::CollapsingHeader(tr_label("Simulated now"), ImGuiTreeNodeFlags_DefaultOpen)) draw_heads(input);
  }

 private:
  // Notes what the lead fixture is where another one is selected. Its heads then start from where its levels are.
  void follow() {
    const int lead = desk_.state().selection.lead;
    if (lead == lead_ && shown_count_ == desk_.shown_count()) return;
    const bool other = lead != lead_;
    lead_ = lead;
    shown_count_ = desk_.shown_count();
    trace_.reset();
    heads_.clear();
    units_.clear();
    if (other) head_ = 0;
    dragged_.reset();
    if (lead < 0) return;
    const auto& firsts = desk_.compiled().head_first;
    const auto at = static_cast<std::size_t>(lead);
    for (std::size_t head = firsts[at]; head < firsts[at + 1]; ++head) heads_.push_back(head);
    for (const auto& channel : mode().channels) {
      std::vector<PhysicalUnit> of_functions;
      for (const auto& function : channel.functions) {
        of_functions.push_back(fixtures::attribute_info(function.attribute).unit);
      }
      units_.push_back(std::move(of_functions));
    }
    head_ = std::min(head_, heads_.empty() ? 0 : heads_.size() - 1);
    start_trace();
  }

  // Of the shown head, from where its levels are.
  void start_trace() {
    if (heads_.empty()) return;
    trace_ = std::make_unique<HeadTrace>(desk_.rig(), desk_.compiled());
    trace_->follow({heads_[head_]});
    stepped_ = false;
  }

  [[nodiscard]] const fixtures::PatchedFixture& fixture() const {
    return desk_.rig().fixtures[static_cast<std::size_t>(lead_)];
  }
  [[nodiscard]] const fixtures::Mode& mode() const { return fixtures::mode_of(desk_.rig(), fixture()); }

  static void draw_buttons(UiDesk& desk) {
    bool highlight = desk.highlights();
    if (ImGui::Checkbox(tr_label("highlight (L)"), &highlight)) desk.set_highlight(highlight);
    bool locate = desk.locates();
    ui_same_line_for(tr_label("locate (Shift+L)"), true);
    if (ImGui::Checkbox(tr_label("locate (Shift+L)"), &locate)) desk.set_locate(locate);
    const std::size_t taken = desk.state().taken.size();
    const std::string release = trf("release all {} (R)", taken) + "###release";
    ui_same_line_for(release.c_str());
    ImGui::BeginDisabled(taken == 0);
    if (ImGui::Button(release.c_str())) desk.release_all();
    ImGui::EndDisabled();
  }

  void draw_fixture(const UiDesk& desk) const {
    const fixtures::PatchedFixture& one = fixture();
    const fixtures::FixtureType& type = fixtures::type_of(desk.rig(), one);
    ui_text(kUiAmber, one.name);
    if (const std::size_t count = desk.state().selection.fixtures.size(); count > 1) {
      ImGui::SameLine();
      ui_text(kUiDim, trf("and {} more; controls set them all", count - 1));
    }
    ImGui::PushTextWrapPos(0);
    ui_text(kUiDim, fmt::format("{} {}, {}", type.manufacturer, type.name, mode().name));
    const fixtures::PatchedFixture& edited = desk.edited().fixtures[static_cast<std::size_t>(lead_)];
    const glm::dvec3 at_m = fixtures::position_of(edited);
    ui_text(kUiDim, trf("{}  at {:.2f} {:.2f} {:.2f} m",
                        edited.patched ? fixtures::text_of_patch(edited) : tr("no address"), at_m.x, at_m.y, at_m.z));
    ImGui::PopTextWrapPos();
  }

  // Position and rotation. A change moves all selected fixtures by as much, or sets them all to the same number.
  void draw_place(UiDesk& desk) {
    if (!ImGui::CollapsingHeader(tr_label("Place"), ImGuiTreeNodeFlags_DefaultOpen)) return;
    const auto& one = desk.edited().fixtures[static_cast<std::size_t>(lead_)];
    const bool several = desk.selected().size() > 1;
    if (several) ImGui::Checkbox(tr_label("the same for all"), &same_);
    const bool same = several && same_;
    // Of one axis that was changed: by how much, and to what.
    const auto drag = [](const char* label, const glm::dvec3& shown, float speed, const char* format, int& axis) {
      std::array<double, 3> values{shown.x, shown.y, shown.z};
      ImGui::DragScalarN(label, ImGuiDataType_Double, values.data(), 3, speed, nullptr, nullptr, format);
      axis = -1;
      double value = 0;
      for (int i = 0; i < 3; ++i) {
        if (values.at(static_cast<std::size_t>(i)) == shown[i]) continue;
        axis = i;
        value = values.at(static_cast<std::size_t>(i));
      }
      return value;
    };
    int axis = -1;
    const glm::dvec3 position_m = fixtures::position_of(one);
    const double place = drag("m", position_m, 0.02f, "%.3f", axis);
    if (axis >= 0) {
      fixtures::PlaceAt at;
      at.position_m.at(static_cast<std::size_t>(axis)) = place;
      glm::dvec3 by_m(0);
      by_m[axis] = place - position_m[axis];
      put(desk, same ? fixtures::place_fixtures(desk.edited(), desk.selected(), at)
                     : fixtures::move_fixtures(desk.edited(), desk.selected(), by_m));
      return;
    }
    const glm::dvec3 rotation_deg = fixtures::rotation_deg_of(one);
    const double angle = drag("\u00b0", rotation_deg, 0.5f, "%.2f", axis);
    if (axis < 0) return;
    glm::dvec3 by_deg(0);
    by_deg[axis] = angle - rotation_deg[axis];
    std::array<std::optional<double>, 3> to_deg;
    to_deg.at(static_cast<std::size_t>(axis)) = angle;
    put(desk, several && !same ? fixtures::add_rotation(desk.edited(), desk.selected(), by_deg)
                               : fixtures::turn_fixtures(desk.edited(), desk.selected(), to_deg));
  }

  static void put(UiDesk& desk, Result<fixtures::RigEdit> edit) {
    if (const Status edited = desk.edit(std::move(edit)); !edited) desk.tell(tr_known(edited.error().message));
  }

  void draw_channels(UiDesk& desk, const UiInput& input) {
    const auto& channels = mode().channels;
    if (channels.empty()) {
      ui_text(kUiDim, tr("This mode has no channels."));
      return;
    }
    constexpr ImGuiTableFlags kFlags =
        ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg | ImGuiTableFlags_Resizable | ImGuiTableFlags_BordersInnerV;
    const float line = ImGui::GetFrameHeightWithSpacing();
    const float room = ImGui::GetContentRegionAvail().y;
    const float wanted = line * static_cast<float>(channels.size() + 1) + 4;
    const float height = std::min(wanted, std::max(room - 6 * line, std::min(room, 7 * line)));
    if (!ImGui::BeginTable("channels", 5, kFlags, {0, height})) return;
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableSetupColumn(tr("Channel"), ImGuiTableColumnFlags_WidthStretch, 1.1f);
    ImGui::TableSetupColumn(tr("Value"), ImGuiTableColumnFlags_WidthStretch, 1.9f);
    ImGui::TableSetupColumn(tr("Level"), ImGuiTableColumnFlags_WidthStretch, 0.6f);
    ImGui::TableSetupColumn(tr("Slot"), ImGuiTableColumnFlags_WidthStretch, 0.6f);
    ImGui::TableSetupColumn(tr("From"), ImGuiTableColumnFlags_WidthStretch, 0.7f);
    ImGui::TableHeadersRow();
    ImGuiListClipper clipper;
    clipper.Begin(static_cast<int>(channels.size()), line);
    while (clipper.Step()) {
      for (int c = clipper.DisplayStart; c < clipper.DisplayEnd; ++c) draw_channel(desk, input, c);
    }
    ImGui::EndTable();
  }

  void draw_channel(UiDesk& desk, const UiInput& input, int c) {
    const ChannelKey key{lead_, c};
    const fixtures::Channel& channel = desk.index().channel(key);
    const auto place = desk.index().place(key);
    const std::uint32_t raw = desk.index().read(key, input.levels);
    const bool taken = desk.state().taken.contains(key);
    const ChannelReading reading = reading_of(fixtures::type_of(desk.rig(), fixture()), channel, raw, [&](int other) {
      return desk.index().read({lead_, other}, input.levels);
    });
    ImGui::PushID(c);
    ImGui::TableNextRow(0, ImGui::GetFrameHeightWithSpacing());
    ImGui::TableNextColumn();
    ImGui::AlignTextToFramePadding();
    ui_text(taken ? kUiGreen : ImGui::GetStyleColorVec4(ImGuiCol_Text), name_of(channel));
    ImGui::TableNextColumn();
    ImGui::BeginDisabled(!place);
    draw_control(desk, input, key, channel, reading, raw);
    ImGui::EndDisabled();
    ImGui::TableNextColumn();
    ui_text(kUiDim, fmt::format("{}", raw));
    ImGui::TableNextColumn();
    if (taken) {
      if (ImGui::SmallButton("x")) desk.release(key, input.levels);
      if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tr("release: the input sets it again"));
      ImGui::SameLine(0, 4);
    }
    ui_text(kUiDim, place ? fmt::format("{}.{}", place->universe, place->address) : "-");
    ImGui::TableNextColumn();
    draw_source(source_of_channel(desk, input, key));
    ImGui::PopID();
  }

  // Who sets the channel. With several senders of a universe it is one of those that are named.
  static void draw_source(const LevelSource& source) {
    const bool own = source.kind == SourceKind::kTaken || source.kind == SourceKind::kHighlight;
    ui_text(own ? kUiGreen : source.silent || source.kind == SourceKind::kNobody ? kUiRed : kUiDim, source.brief);
    if (!ImGui::IsItemHovered()) return;
    const std::string age =
        source.age_ns > 0 ? trf("\nnewest frame {:.1f} s ago", static_cast<double>(source.age_ns) * 1e-9) : "";
    ImGui::SetTooltip("%s%s", source.words.c_str(), age.c_str());
  }

  // Pan and tilt that the head has reached, degrees.
  [[nodiscard]] std::optional<glm::dvec2> simulated_aim() const {
    if (!trace_ || !stepped_) return std::nullopt;
    std::optional<float> pan_deg;
    std::optional<float> tilt_deg;
    for (const auto& [column, value] : trace_->row(heads_[head_], 0)) {
      if (!std::holds_alternative<float>(value)) continue;
      if (std::string_view(column) == "pan_deg") pan_deg = std::get<float>(value);
      if (std::string_view(column) == "tilt_deg") tilt_deg = std::get<float>(value);
    }
    if (!pan_deg || !tilt_deg) return std::nullopt;
    return glm::dvec2(static_cast<double>(*pan_deg), static_cast<double>(*tilt_deg));
  }

  // A slider in real units over the function that the channel is in, else one over all its raw values, and a list of
  // all its functions and ranges. A slider stays what it is while it is dragged, whatever the channel gets to.
  void draw_control(UiDesk& desk, const UiInput& input, ChannelKey key, const fixtures::Channel& channel,
                    const ChannelReading& reading, std::uint32_t raw) {
    const bool lists =
        channel.functions.size() > 1 || (!channel.functions.empty() && !channel.functions[0].sets.empty());
    const float arrow = lists ? ImGui::GetFrameHeight() + 2 : 0;
    ImGui::SetNextItemWidth(-arrow - 0.01f);
    const Drag* drag = dragged_ && dragged_->channel == key.channel ? &*dragged_ : nullptr;
    const bool in_slot = reading.set != nullptr && reading.set->wheel_slot > 0;
    const fixtures::ChannelFunction* function = drag != nullptr ? drag->function : reading.function;
    const bool slides = drag != nullptr
                            ? function != nullptr
                            : function != nullptr && function->physical_from != function->physical_to && !in_slot;
    Drag next{key.channel, slides ? function : nullptr, 0};
    if (slides) {
      const bool has_value = drag == nullptr || (reading.function == function && !in_slot);
      next.value = draw_value(desk, input, key, *function, has_value ? reading.value : drag->value);
    } else {
      std::uint32_t level = raw;
      const std::uint32_t low = 0;
      const std::uint32_t high = fixtures::raw_max(channel.byte_count);
      if (ImGui::SliderScalar("##raw", ImGuiDataType_U32, &level, &low, &high, ui_format(text_of(reading)).c_str(),
                              ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoInput)) {
        desk.take(key, level, input.levels);
      }
    }
    if (ImGui::IsItemActive()) {
      dragged_ = next;
    } else if (drag != nullptr) {
      dragged_.reset();
    }
    if (!lists) return;
    ImGui::SameLine(0, 2);
    if (ImGui::ArrowButton("ranges", ImGuiDir_Down)) ImGui::OpenPopup("ranges of it");
    if (ImGui::BeginPopup("ranges of it")) {
      for (const auto& each : channel.functions) draw_ranges(desk, input, key, each, raw);
      ImGui::EndPopup();
    }
  }

  // The slider of a function in its unit. Returns the value that it has.
  double draw_value(UiDesk& desk, const UiInput& input, ChannelKey key, const fixtures::ChannelFunction& function,
                    double shown) {
    const fixtures::Channel& channel = desk.index().channel(key);
    const auto unit =
        units_[static_cast<std::size_t>(key.channel)][static_cast<std::size_t>(&function - channel.functions.data())];
    const double factor = unit == PhysicalUnit::kShare ? 100 : 1;
    auto value = static_cast<float>(shown * factor);
    // What is typed (Ctrl and a click) is in the same unit.
    const char* format = unit == PhysicalUnit::kShare          ? "%.1f %%"
                         : unit == PhysicalUnit::kAngle        ? "%.1f\u00b0"
                         : unit == PhysicalUnit::kAngularSpeed ? "%.1f\u00b0/s"
                         : unit == PhysicalUnit::kFrequency    ? "%.2f Hz"
                         : unit == PhysicalUnit::kTemperature  ? "%.0f K"
                         : unit == PhysicalUnit::kTime         ? "%.2f s"
                         : unit == PhysicalUnit::kLength       ? "%.2f m"
                                                               : "%.3g";
    const auto from = static_cast<float>(function.physical_from * factor);
    const auto to = static_cast<float>(function.physical_to * factor);
    if (ImGui::SliderFloat("##value", &value, std::min(from, to), std::max(from, to), format,
                           ImGuiSliderFlags_AlwaysClamp)) {
      fixtures::Channel only = channel;
      only.functions = {function};
      const auto nearest = fixtures::nearest_raw(fixtures::type_of(desk.rig(), fixture()), only, function.attribute,
                                                 static_cast<double>(value) / factor);
      if (nearest) desk.take(key, nearest->raw, input.levels);
    }
    return static_cast<double>(value) / factor;
  }

  static void draw_ranges(UiDesk& desk, const UiInput& input, ChannelKey key, const fixtures::ChannelFunction& function,
                          std::uint32_t raw) {
    const auto entry = [&](const std::string& name, std::uint32_t from, std::uint32_t to, const char* indent) {
      const std::string label = fmt::format("{}{}  {}-{}###{}", indent, name, from, to, from);
      if (ImGui::Selectable(label.c_str(), raw >= from && raw <= to)) {
        desk.take(key, from + (to - from) / 2, input.levels);
      }
    };
    ImGui::PushID(&function);
    entry(function.name.empty() ? function.attribute : function.name, function.dmx_from, function.dmx_to, "");
    for (std::size_t i = 0; i < function.sets.size(); ++i) {
      const fixtures::ChannelSet& set = function.sets[i];
      if (set.name.empty() && set.wheel_slot < 1) continue;
      ImGui::PushID(static_cast<int>(i));
      entry(set.name.empty() ? trf("slot {}", set.wheel_slot) : set.name, set.dmx_from, set.dmx_to, "    ");
      ImGui::PopID();
    }
    ImGui::PopID();
  }

  // The values that the motors, lamps and shutters of a head have reached.
  void draw_heads(const UiInput& input) {
    if (!trace_) {
      ui_text(kUiDim, tr("This fixture has no beam."));
      return;
    }
    if (heads_.size() > 1) {
      ImGui::SetNextItemWidth(-1);
      int shown = static_cast<int>(head_) + 1;
      if (ImGui::SliderInt("##head", &shown, 1, static_cast<int>(heads_.size()), tr_printf("head %d"),
                           ImGuiSliderFlags_AlwaysClamp)) {
        head_ = static_cast<std::size_t>(shown - 1);
        start_trace();
      }
    }
    // Without a step since it was chosen, as in a paused log, the head is where its levels are.
    if (!stepped_ && input.levels.size() == desk_.compiled().universes.size() * kSlotCountMax) {
      step(input.levels, 0, true);
    }
    if (!stepped_) return;
    if (!ImGui::BeginTable("now", 4, ImGuiTableFlags_SizingStretchProp)) return;
    for (const auto& [column, value] : trace_->row(heads_[head_], 0)) {
      if (std::holds_alternative<std::monostate>(value) || std::holds_alternative<std::string>(value)) continue;
      if (std::string_view(column) == "head") continue;
      const TraceWords words = words_of_trace(column);
      const double number = std::holds_alternative<float>(value) ? static_cast<double>(std::get<float>(value))
                                                                 : static_cast<double>(std::get<std::int64_t>(value));
      ImGui::TableNextColumn();
      ui_text(kUiDim, tr(words.name.c_str()));
      ImGui::TableNextColumn();
      ui_text(std::abs(number) >= 1000 ? fmt::format("{:.0f} {}", number, words.unit)
                                       : fmt::format("{:.4g} {}", number, words.unit));
    }
    ImGui::EndTable();
  }

  // The slider that the mouse or the keyboard holds.
  struct Drag {
    int channel = 0;
    const fixtures::ChannelFunction* function = nullptr;  // it slides over; nullptr: over all raw values
    double value = 0;                                     // that it has, of the function
  };

  UiDesk& desk_;
  std::uint64_t shown_count_ = 0;                 // UiDesk::shown_count() of what follows
  bool same_ = false;                             // places are set, not changed by as much
  int lead_ = -1;                                 // index into Rig::fixtures; -1: none is selected
  std::vector<std::vector<PhysicalUnit>> units_;  // of each function of each channel of the lead fixture
  std::vector<std::size_t> heads_;                // of it
  std::size_t head_ = 0;                          // which of them is shown
  std::unique_ptr<HeadTrace> trace_;              // null: it has no head
  bool stepped_ = false;                          // trace_ was, so it has something to show
  std::optional<Drag> dragged_;                   // of the lead fixture
  InspectorControls controls_;
  InspectorWheels wheels_;
};

}  // namespace

std::unique_ptr<Panel> make_inspector_panel(UiDesk& desk) { return std::make_unique<InspectorPanel>(desk); }

}  // namespace footlight::tools
