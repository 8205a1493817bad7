// Inputs and outputs: what they receive and send, what is wrong with them, and the buttons that arm outputs.
#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "sim/core/counted.h"
#include "sim/pattern.h"
#include "tools/footlight/preview/ui/draw_output_questions.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/draw_ports.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"
#include "tools/footlight/status/status_text.h"

namespace footlight::tools {
namespace {

constexpr const char* kDeviceDrag = "interface";  // its endpoint without a universe
constexpr const char* kOutputDrag = "output";     // its id
constexpr std::size_t kChipsMax = 128;
constexpr const char* kModel = "mock:enttec-pro";  // of an interface, inside the program

const char* word_of(ArmState state) {
  switch (state) {
    case ArmState::kOff: return tr("not armed");
    case ArmState::kOpening: return tr("opening");
    case ArmState::kArmed: return tr("LIVE");
    case ArmState::kClosing: return tr("ends dark");
  }
  return "";
}

constexpr int kOutputRows = 2;
constexpr float kOutputNoteLines = 2;

class DevicesPanel final : public Panel {
 public:
  // Outputs come first: nothing of the inputs moves a row that arms or disarms.
  void draw(UiDesk&, const UiInput& input) override {
    if (input.outputs != nullptr) {
      ui_text(kUiAmber, tr("Outputs to real lamps"));
      draw_all_outputs(input);
      if (const auto asked = draw_field("output", "enttec-pro=1", output_text_, tr_label("add an output")))
        input.outputs->add = asked;
      draw_model(*input.outputs, input.scale);
      ImGui::Dummy({0, 4 * input.scale});
    }
    ui_text(kUiAmber, tr("Inputs"));
    draw_inputs(input);
    if (input.inputs != nullptr) draw_more_inputs(*input.inputs, input.scale);
    if (input.outputs == nullptr) return;
    ImGui::Dummy({0, 4 * input.scale});
    ui_text(kUiAmber, tr("Plugged in"));
    input.outputs->looks = true;
    draw_devices(*input.outputs, input.inputs);
  }

 private:
  void draw_all_outputs(const UiInput& input) {
    OutputsView& outputs = *input.outputs;
    draw_buttons(outputs, input.scale);
    draw_outputs(outputs);
    std::vector<Note> notes;
    if (!outputs.refusal.empty()) notes.push_back({kUiRed, outputs.refusal});
    if (outputs.rows.empty()) {
      notes.push_back({kUiDim, tr("There are none. What is added here, or with --output ENDPOINT, is armed by hand.")});
    }
    if (outputs.darkness == Darkness::kSilence) notes.push_back({kUiRed, blackout_words(outputs)});
    for (const OutputRow& row : outputs.rows) note_output(row, notes);
    if (!outputs.notice.empty()) notes.push_back({kUiDim, outputs.notice});
    draw_notes("output notes", notes, kOutputNoteLines);
    arm_question_.draw(input);
    removal_question_.draw(outputs);
  }

  // Fields for more; patterns, for who has no console, each with a button; what is set by hand.
  void draw_more_inputs(InputsView& view, float scale) {
    draw_by_hand(view);
    draw_adding(view, scale);
    if (view.has_patterns) {
      ui_text(kUiDim, trf("{:.1f} beats a minute", view.beats_a_minute));
      ImGui::SameLine();
      if (ImGui::SmallButton(tr_label("tap (N)"))) view.tap = true;
    }
    if (view.learns) {
      ui_text(kUiAmber, tr("Move one fader, knob or button."));
      ImGui::SameLine();
      if (ImGui::SmallButton(tr_label("stop"))) view.stop_learning = true;
    } else if (view.has_controls) {
      if (const auto asked =
              draw_field("a control", tr("for 1.17, Mover 3:Tilt"), learn_text_, tr_label("learn a control")))
        view.learn = asked;
    }
  }

  // A line that is always there.
  static void draw_by_hand(InputsView& view) {
    const bool any = !view.by_hand.empty() || view.dark_by_hand;
    if (!any) ui_text(kUiDim, tr("nothing is set by hand"));
    if (!view.by_hand.empty()) {
      ui_text(kUiGreen, view.by_hand);
      ui_same_line_for(tr_label("release all"));
      if (ImGui::SmallButton(tr_label("release all"))) view.release_hand = true;
    }
    if (!view.dark_by_hand) return;
    if (!view.by_hand.empty()) ui_same_line_for(tr("BLACKOUT by hand"));
    ui_text(kUiRed, tr("BLACKOUT by hand"));
    ui_same_line_for(tr_label("end it"));
    if (ImGui::SmallButton(tr_label("end it"))) view.end_hand_blackout = true;
  }

  void draw_adding(InputsView& view, float scale) {
    const auto is_on = [&](const std::string& endpoint) {
      return std::find(view.inputs.begin(), view.inputs.end(), endpoint) != view.inputs.end();
    };
    if (const auto asked = draw_field("input", "sacn:1-9", input_text_, tr_label("add an input"))) view.add = asked;
    ui_same_line_for(tr("or made up:"), false, 16 * scale);
    ImGui::BeginDisabled(!view.why_not.empty());
    ui_text(kUiDim, tr("or made up:"));
    for (const std::string_view word : kPatternWords) {
      const std::string endpoint = fmt::format("mock:{}", word);
      if (is_on(endpoint)) continue;
      const std::string label = trf("add {}", word) + fmt::format("###{}", word);
      const float width = ImGui::CalcTextSize(label.c_str(), nullptr, true).x + 2 * ImGui::GetStyle().FramePadding.x;
      ImGui::SameLine(0, 8 * scale);
      if (ImGui::GetContentRegionAvail().x < width) ImGui::NewLine();
      if (ImGui::SmallButton(label.c_str())) view.add = endpoint;
    }
    ImGui::EndDisabled();
  }

  // A field for an endpoint. Enter or its button adds what it has.
  static std::optional<std::string> draw_field(const char* what, const char* example, std::array<char, 160>& text,
                                               const char* words) {
    ImGui::PushID(what);
    ImGui::SetNextItemWidth(std::min(ImGui::GetFontSize() * 12, ImGui::GetContentRegionAvail().x));
    constexpr ImGuiInputTextFlags kFlags = ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll;
    bool adds = ImGui::InputTextWithHint("##endpoint", example, text.data(), text.size(), kFlags);
    ui_same_line_for(words);
    adds = ImGui::Button(words) || adds;
    ImGui::PopID();
    const std::string asked = text.data();
    if (!adds || asked.empty()) return std::nullopt;
    text[0] = 0;
    return asked;
  }

  void draw_buttons(OutputsView& outputs, float scale) {
    const bool any_off = std::any_of(outputs.rows.begin(), outputs.rows.end(),
                                     [](const OutputRow& row) { return row.state == ArmState::kOff; });
    ImGui::BeginDisabled(!any_off);
    if (ImGui::Button(tr_label("arm all ..."))) arm_question_.ask(ArmQuestion::kAll);
    ImGui::EndDisabled();
    ui_same_line_for(tr_label("disarm all"));
    ImGui::BeginDisabled(!outputs.any_on());
    if (ImGui::Button(tr_label("disarm all"))) outputs.disarm_all();
    ImGui::EndDisabled();
    ui_same_line_for(tr_label("BLACKOUT"), false, 24 * scale);
    ImGui::BeginDisabled(is_blackout(outputs.darkness));
    ImGui::PushStyleColor(ImGuiCol_Text, kStageColours.text);
    ImGui::PushStyleColor(ImGuiCol_Button, {0.45f, 0.10f, 0.10f, 1});
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, {0.62f, 0.14f, 0.14f, 1});
    if (ImGui::Button(tr_label("BLACKOUT"))) outputs.blackout = true;
    ImGui::PopStyleColor(3);
    ImGui::EndDisabled();
    // A button of its own, so that a second click on the first one does not end what it began.
    const char* const end = tr_label("end the blackout");
    ui_same_line_for(end);
    if (!is_blackout(outputs.darkness)) {
      ImGui::Dummy({button_width({end}), ImGui::GetFrameHeight()});
    } else if (ImGui::Button(end)) {
      outputs.blackout = false;
    }
    draw_hold(outputs, scale);
  }

  // On the line of the buttons if there is room.
  static void draw_hold(OutputsView& outputs, float scale) {
    const std::string words = trf("live only while {} is held", tr(kHoldKeyName));
    ui_same_line_for(words.c_str(), true, 24 * scale);
    ImGui::Checkbox((words + "###hold").c_str(), &outputs.needs_hold);
    if (!ImGui::IsItemHovered()) return;
    ImGui::SetTooltip("%s", tr("A dead man's switch: lamps are dark when the key is released, when another window has "
                               "the keyboard, and half a second after this one hangs."));
  }

  static std::string name_of_row(const OutputRow& row) {
    return row.made_up ? trf("{} (made up)", row.endpoint) : row.endpoint;
  }

  void draw_outputs(OutputsView& outputs) {
    PortColumns columns;
    for (const char* word :
         {tr("not armed"), tr("opening"), tr("LIVE"), tr("ends dark"), tr("LIVE, lost"), tr("zeros")}) {
      columns.add_state(word);
    }
    const float arm = button_width({tr_label("arm ..."), tr_label("disarm")});
    columns.last = arm + ImGui::GetStyle().ItemSpacing.x + button_width({tr_label("remove")});
    for (const OutputRow& row : outputs.rows) {
      if (row.status) columns.add(*row.status);
      columns.add(name_of_row(row));
    }
    columns.fit(ImGui::GetContentRegionAvail().x);
    if (!begin_port_table("outputs", columns)) return;
    for (const OutputRow& row : outputs.rows) {
      next_port_row();
      ImGui::PushID(row.id);
      draw_output(outputs, row, columns);
      ImGui::TableNextColumn();
      draw_output_buttons(outputs, row, arm);
      ImGui::PopID();
    }
    end_port_table(static_cast<int>(outputs.rows.size()), kOutputRows);
  }

  static void note_output(const OutputRow& row, std::vector<Note>& notes) {
    if (!row.trouble.empty()) notes.push_back({kUiRed, trf("not armed: {}", row.trouble)});
    if (!row.left_out.empty()) {
      notes.push_back({kUiAmber, trf("{}: universe {} is not sent: no fixture of this rig has an address there",
                                     row.endpoint, show_universes(row.left_out))});
    }
    if (row.status) note_trouble(*row.status, true, notes);
  }

  // All of it, since columns may be cut or left out.
  static std::string tip_of(const OutputRow& row) {
    std::string tip = name_of_row(row) + "\n" + trf("universe {}", show_universes(row.universes));
    if (row.status) tip += "\n" + trf("{} frames, {:.1f} /s", row.status->frames, row.status->rate_hz);
    if (row.can_move) tip += std::string("\n") + tr("Drag it to another universe below.");
    return tip;
  }

  void draw_output(OutputsView& outputs, const OutputRow& row, const PortColumns& columns) {
    ImGui::TableNextColumn();
    const std::string words = name_of_row(row);
    ImGui::PushStyleColor(ImGuiCol_Text, row.made_up ? kUiAmber : kUiText);
    if (row.can_move) {
      ImGui::Selectable(words.c_str(), false, 0, {label_width(words), 0});
    } else {
      ui_text(words);
    }
    ImGui::PopStyleColor();
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tip_of(row).c_str());
    if (row.can_move) drag_endpoint(kOutputDrag, &row.id, sizeof(row.id), row.endpoint);
    const bool lost = row.status && row.status->state == PortState::kGone;
    port_cell(row.state == ArmState::kOff     ? kUiDim
         : row.state == ArmState::kArmed ? kUiRed
                                         : kUiAmber,
         lost                                                                   ? tr("LIVE, lost")
         : row.state == ArmState::kArmed && outputs.darkness != Darkness::kNone ? tr("zeros")
                                                                                : word_of(row.state));
    if (columns.universes) port_cell(kUiText, show_universes(row.universes));
    port_figures(row.status ? &*row.status : nullptr, true, columns);
  }

  // Each stays in its place, whatever the state: a second click does nothing else than the first one.
  void draw_output_buttons(OutputsView& outputs, const OutputRow& row, float arm_width) {
    if (row.state == ArmState::kOff) {
      if (small_button(tr_label("arm ..."), arm_width)) arm_question_.ask(row.id);
    } else {
      ImGui::BeginDisabled(row.state == ArmState::kClosing);
      if (small_button(tr_label("disarm"), arm_width)) outputs.disarm.push_back(row.id);
      ImGui::EndDisabled();
    }
    ImGui::SameLine();
    if (!small_button(tr_label("remove"))) return;
    if (row.state == ArmState::kOff) {
      outputs.remove.push_back(row.id);
    } else {
      removal_question_.ask(row.id);
    }
  }

  // DMX interfaces of this machine. A drag to a universe makes one an output; so does its button, for the chosen one.
  void draw_devices(OutputsView& outputs, InputsView* inputs) {
    if (outputs.devices.empty()) draw_wrapped(kUiDim, tr("No DMX interface. `footlight doctor` checks this machine."));
    for (std::size_t i = 0; i < outputs.devices.size(); ++i) {
      const PluggedDevice& device = outputs.devices[i];
      ImGui::PushID(static_cast<int>(i));
      draw_device(outputs, device.endpoint,
                  device.endpoint.empty() ? device.model : device.endpoint + "  " + device.model, device.can_send);
      ImGui::SameLine();
      ui_text(device.fix.empty() ? kUiGreen : kUiAmber, device.state);
      if (!device.fix.empty()) draw_wrapped(kUiDim, device.fix);
      ImGui::PopID();
    }
    if (!outputs.universes.empty()) draw_universes(outputs, inputs);
  }

  // A name that can be dragged, and a button.
  void draw_device(OutputsView& outputs, const std::string& endpoint, const std::string& words, bool can_send) {
    if (!can_send || outputs.universes.empty()) return ui_text(kUiText, words);
    const float width = ImGui::CalcTextSize(words.c_str()).x;
    ImGui::Selectable(words.c_str(), false, 0, {width, 0});
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tr("Drag it to a universe below."));
    drag_endpoint(kDeviceDrag, endpoint.c_str(), endpoint.size() + 1, endpoint);
    ImGui::SameLine();
    if (ImGui::SmallButton(tr_label("add"))) outputs.add = fmt::format("{}={}", endpoint, chosen(outputs));
  }

  // An interface that is none, to arm without lamps. On the line of the field, if there is room.
  void draw_model(OutputsView& outputs, float scale) {
    const auto at = std::find_if(outputs.rows.begin(), outputs.rows.end(),
                                 [](const OutputRow& row) { return row.endpoint.starts_with(kModel); });
    if (at != outputs.rows.end() || outputs.universes.empty()) return;
    ImGui::SameLine(0, 16 * scale);
    const char* const label = tr_label("add a made-up interface");
    if (ImGui::GetContentRegionAvail().x < button_width({label})) ImGui::NewLine();
    if (ImGui::SmallButton(label)) outputs.add = fmt::format("{}={}", kModel, chosen(outputs));
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tr("A model inside the program: it sends to no lamp."));
    drag_endpoint(kDeviceDrag, kModel, std::string_view(kModel).size() + 1, kModel);
  }

  Universe chosen(const OutputsView& outputs) {
    const bool there = std::binary_search(outputs.universes.begin(), outputs.universes.end(), universe_);
    if (!there) universe_ = outputs.universes.front();
    return universe_;
  }

  // Those of the rig: a click chooses the one that `add` is for, and what is dropped on one is patched to it.
  void draw_universes(OutputsView& outputs, InputsView* inputs) {
    ui_text(kUiDim, tr("Universes: drag an interface or an output here; `add` is for the amber one"));
    const float right = ImGui::GetCursorScreenPos().x + ImGui::GetContentRegionAvail().x;
    for (std::size_t i = 0; i < outputs.universes.size() && i < kChipsMax; ++i) {
      const Universe universe = outputs.universes[i];
      const std::string words = fmt::format("{}", universe);
      const float width = ImGui::CalcTextSize(words.c_str()).x + 4 * ImGui::GetStyle().FramePadding.x;
      if (i > 0 && ImGui::GetItemRectMax().x + width + ImGui::GetStyle().ItemSpacing.x < right) ImGui::SameLine();
      ImGui::PushStyleColor(ImGuiCol_Text, universe == chosen(outputs) ? kUiAmber : kUiText);
      if (ImGui::Button(words.c_str(), {width, 0})) universe_ = universe;
      ImGui::PopStyleColor();
      if (!ImGui::BeginDragDropTarget()) continue;
      if (const ImGuiPayload* device = ImGui::AcceptDragDropPayload(kDeviceDrag)) {
        outputs.add = fmt::format("{}={}", static_cast<const char*>(device->Data), universe);
      } else if (const ImGuiPayload* row = ImGui::AcceptDragDropPayload(kOutputDrag)) {
        OutputId id = 0;
        std::memcpy(&id, row->Data, sizeof(id));
        outputs.move = OutputsView::Move{id, universe};
      } else if (const ImGuiPayload* input = inputs == nullptr ? nullptr : ImGui::AcceptDragDropPayload(kInputDrag)) {
        inputs->move = InputsView::Move{static_cast<const char*>(input->Data), universe};
      }
      ImGui::EndDragDropTarget();
    }
    if (outputs.universes.size() > kChipsMax) {
      ui_text(kUiDim, trf("and {} more: type the endpoint", outputs.universes.size() - kChipsMax));
    }
  }

  ArmQuestion arm_question_;
  RemovalQuestion removal_question_;
  Universe universe_ = kUniverseMin;
  std::array<char, 160> input_text_{};
  std::array<char, 160> output_text_{};
  std::array<char, 160> learn_text_{};
};

}  // namespace

std::unique_ptr<Panel> make_devices_panel(UiDesk&) { return std::make_unique<DevicesPanel>(); }

}  // namespace footlight::tools
