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
#include "tools/footlight/duration.h"
#include "tools/footlight/preview/ui/draw_output_questions.h"
#include "tools/footlight/preview/ui/level_source.h"
#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"
#include "tools/footlight/status/status_text.h"

namespace footlight::tools {
namespace {

constexpr const char* kDeviceDrag = "interface";  // its endpoint without a universe
constexpr const char* kOutputDrag = "output";     // its row
constexpr const char* kInputDrag = "input";       // its endpoint
constexpr std::size_t kChipsMax = 128;
constexpr const char* kModel = "mock:enttec-pro";  // of an interface, inside the program

std::string age_text(DurationNs age_ns) {
  const double age_s = static_cast<double>(std::max<DurationNs>(age_ns, 0)) * 1e-9;
  return age_s < 1 ? fmt::format("{:.0f} ms", age_s * 1e3) : fmt::format("{:.1f} s", age_s);
}

// Frames that were lost or refused, by cause; empty: none.
std::string errors_text(const PortStatus& port) {
  std::string words;
  const auto add = [&](std::uint64_t count, const char* what) {
    if (count > 0) words += fmt::format("{}{} {}", words.empty() ? "" : ", ", count, what);
  };
  add(port.port.rejected, tr("rejected"));
  add(port.port.dropped, tr("replaced unsent"));
  add(port.port.errors + port.failures, tr("errors"));
  add(port.refused, tr("refused"));
  add(port.unrouted, tr("of other universes"));
  return words;
}

const char* word_of(ArmState state) {
  switch (state) {
    case ArmState::kOff: return tr("not armed");
    case ArmState::kOpening: return tr("opening");
    case ArmState::kArmed: return tr("LIVE");
    case ArmState::kClosing: return tr("ends dark");
  }
  return "";
}

const ImVec4& colour_of(PortState state) {
  return state == PortState::kWorking ? kUiGreen : state == PortState::kGone ? kUiRed : kUiAmber;
}

// A line of its own below a row, over all columns.
void wrapped(const ImVec4& colour, const std::string& words) {
  ImGui::PushTextWrapPos(0);
  ui_text(colour, words);
  ImGui::PopTextWrapPos();
}

// "176 us": the break that a port measures, or that its widget makes; empty: it is not known.
std::string break_text(const PortStatus& port) {
  for (const PortFigure& figure : port.figures) {
    if (figure.name == "break_us_p50" || figure.name == "break_us") return fmt::format("{:.0f} us", figure.value);
  }
  return {};
}

// Which columns a table has, by what its ports know.
struct LineColumns {
  bool breaks = false;
  bool latency = false;
  void add(const PortStatus& port) {
    breaks = breaks || !break_text(port).empty();
    latency = latency || port.latency.count > 0;
  }
};

class DevicesPanel final : public Panel {
 public:
  void draw(UiDesk&, const UiInput& input) override {
    ui_text(kUiAmber, tr("Inputs"));
    draw_inputs(input);
    if (input.inputs != nullptr) draw_more_inputs(*input.inputs, input.scale);
    ImGui::Dummy({0, 4 * input.scale});
    ui_text(kUiAmber, tr("Outputs to real lamps"));
    if (input.outputs == nullptr) return;
    draw_all_outputs(input);
    if (const auto asked = draw_field("output", "enttec-pro=1", output_text_, tr_label("add an output")))
      input.outputs->add = asked;
    if (!input.outputs->refusal.empty()) wrapped(kUiRed, input.outputs->refusal);
    ImGui::Dummy({0, 4 * input.scale});
    ui_text(kUiAmber, tr("Plugged in"));
    input.outputs->looks = true;
    draw_devices(*input.outputs, input.inputs);
  }

 private:
  void draw_all_outputs(const UiInput& input) {
    if (input.outputs->rows.empty()) {
      arm_question_.drop();
      removal_question_.drop();
      wrapped(kUiDim, tr("There are none. What is added here, or with --output ENDPOINT, is armed by hand."));
      return;
    }
    draw_buttons(*input.outputs, input.scale);
    draw_outputs(*input.outputs);
    if (!input.outputs->notice.empty()) wrapped(kUiDim, input.outputs->notice);
    arm_question_.draw(input);
    removal_question_.draw(*input.outputs);
  }

  // Endpoint, state, universes, frames, rate, what some port knows of its line, the last one.
  static bool begin_table(const char* id, const char* last, float last_width, const LineColumns& line) {
    const int columns = 6 + (line.breaks ? 1 : 0) + (line.latency ? 1 : 0);
    if (!ImGui::BeginTable(id, columns, ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp)) return false;
    const float unit = ImGui::GetFontSize();
    ImGui::TableSetupColumn(tr("endpoint"), ImGuiTableColumnFlags_WidthStretch);
    ImGui::TableSetupColumn(tr("state"), ImGuiTableColumnFlags_WidthFixed, unit * 5);
    ImGui::TableSetupColumn(tr("universes"), ImGuiTableColumnFlags_WidthFixed, unit * 6);
    ImGui::TableSetupColumn(tr_in("DMX", "frames"), ImGuiTableColumnFlags_WidthFixed, unit * 5);
    ImGui::TableSetupColumn(tr("rate"), ImGuiTableColumnFlags_WidthFixed, unit * 4.5f);
    if (line.breaks) ImGui::TableSetupColumn(tr("break"), ImGuiTableColumnFlags_WidthFixed, unit * 4);
    if (line.latency) ImGui::TableSetupColumn(tr("latency"), ImGuiTableColumnFlags_WidthFixed, unit * 4.5f);
    ImGui::TableSetupColumn(last, ImGuiTableColumnFlags_WidthFixed, unit * last_width);
    ImGui::TableHeadersRow();
    return true;
  }
  static void cell(const ImVec4& colour, const std::string& words) {
    ImGui::TableNextColumn();
    ui_text(colour, words);
  }
  static void rate_cells(const PortStatus& port) {
    cell(kUiText, fmt::format("{}", port.frames));
    cell(kUiText, fmt::format("{:.1f} /s", port.rate_hz));
  }

  // Empty cells where the port knows nothing; none without its column.
  static void line_cells(const PortStatus* port, const LineColumns& line) {
    const auto value_cell = [](const std::string& words, const std::string& tip) {
      cell(words.empty() ? kUiDim : kUiText, words.empty() ? "-" : words);
      if (!tip.empty() && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tip.c_str());
    };
    if (line.breaks) value_cell(port != nullptr ? break_text(*port) : "", tr("the break before a frame, median"));
    if (!line.latency) return;
    const bool known = port != nullptr && port->latency.count > 0;
    value_cell(known ? show_duration(port->latency.p50_ns) : "",
               known ? trf("from the levels to the end of the call that sends them: median {}, 99 % below {}, "
                           "longest {}",
                           show_duration(port->latency.p50_ns), show_duration(port->latency.p99_ns),
                           show_duration(port->latency.max_ns))
                     : "");
  }

  static void draw_inputs(const UiInput& input) {
    if (input.status == nullptr) {
      wrapped(kUiDim,
              input.transport != nullptr ? tr("None: a log drives the rig.") : tr("None: faders drive the rig."));
      return;
    }
    LineColumns line;
    for (const PortStatus& port : input.status->ports) {
      if (!port.is_sink) line.add(port);
    }
    if (begin_table("inputs", tr("newest"), 6, line)) {
      for (const PortStatus& port : input.status->ports) {
        if (port.is_sink) continue;
        ImGui::TableNextRow();
        draw_input(port, input, line);
      }
      ImGui::EndTable();
    }
    for (const PortStatus& port : input.status->ports) {
      if (!port.is_sink) draw_trouble(port, input.status->stamp_ns != 0);
    }
  }

  // How to be rid of inputs, and fields for more; patterns, for who has no console, each with a button.
  void draw_more_inputs(InputsView& view, float scale) {
    const auto is_on = [](const std::vector<std::string>& list, const std::string& endpoint) {
      return std::find(list.begin(), list.end(), endpoint) != list.end();
    };
    for (const std::string& endpoint : view.inputs) {
      const bool made_up = is_on(view.made_up, endpoint);
      ImGui::PushID(endpoint.c_str());
      const std::string words = made_up ? trf("MADE UP: {}", endpoint) : endpoint;
      if (is_on(view.movable, endpoint)) {
        ImGui::PushStyleColor(ImGuiCol_Text, made_up ? kUiAmber : kUiDim);
        ImGui::Selectable(words.c_str(), false, 0, {ImGui::CalcTextSize(words.c_str()).x, 0});
        ImGui::PopStyleColor();
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tr("Drag it to another universe below."));
        drag_source(kInputDrag, endpoint.c_str(), endpoint.size() + 1, endpoint);
      } else {
        ui_text(made_up ? kUiAmber : kUiDim, words);
      }
      ImGui::SameLine();
      if (ImGui::SmallButton(tr_label("remove"))) view.remove = endpoint;
      ImGui::PopID();
    }
    if (!view.by_hand.empty()) {
      ui_text(kUiGreen, view.by_hand);
      ImGui::SameLine();
      if (ImGui::SmallButton(tr_label("release all"))) view.release_hand = true;
    }
    if (view.dark_by_hand) {
      ui_text(kUiRed, tr("BLACKOUT by hand"));
      ImGui::SameLine();
      if (ImGui::SmallButton(tr_label("end it"))) view.end_hand_blackout = true;
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
    if (const auto asked = draw_field("input", "sacn:1-9", input_text_, tr_label("add an input"))) view.add = asked;
    ImGui::SameLine(0, 16 * scale);
    ImGui::BeginDisabled(!view.why_not.empty());
    ui_text(kUiDim, tr("or made up:"));
    for (const std::string_view word : kPatternWords) {
      const std::string endpoint = fmt::format("mock:{}", word);
      if (is_on(view.inputs, endpoint)) continue;
      const std::string label = trf("add {}", word) + fmt::format("###{}", word);
      const float width = ImGui::CalcTextSize(label.c_str(), nullptr, true).x + 2 * ImGui::GetStyle().FramePadding.x;
      ImGui::SameLine(0, 8 * scale);
      if (ImGui::GetContentRegionAvail().x < width) ImGui::NewLine();
      if (ImGui::SmallButton(label.c_str())) view.add = endpoint;
    }
    ImGui::EndDisabled();
    if (view.has_patterns) {
      ui_text(kUiDim, trf("{:.1f} beats a minute", view.beats_a_minute));
      ImGui::SameLine();
      if (ImGui::SmallButton(tr_label("tap (N)"))) view.tap = true;
    }
    if (!view.refusal.empty()) wrapped(kUiRed, view.refusal);
    if (!view.why_not.empty()) wrapped(kUiDim, view.why_not);
  }

  // A field for an endpoint. Enter or its button adds what it has.
  static std::optional<std::string> draw_field(const char* what, const char* example, std::array<char, 160>& text,
                                               const char* words) {
    ImGui::PushID(what);
    ImGui::SetNextItemWidth(ImGui::GetFontSize() * 12);
    constexpr ImGuiInputTextFlags kFlags = ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll;
    bool adds = ImGui::InputTextWithHint("##endpoint", example, text.data(), text.size(), kFlags);
    ImGui::SameLine();
    adds = ImGui::Button(words) || adds;
    ImGui::PopID();
    const std::string asked = text.data();
    if (!adds || asked.empty()) return std::nullopt;
    text[0] = 0;
    return asked;
  }

  static void draw_input(const PortStatus& port, const UiInput& input, const LineColumns& line) {
    cell(kUiText, port.name);
    const bool silent = is_silent(port, *input.status);
    cell(silent ? kUiRed : colour_of(port.state), silent ? tr("silent") : tr(name_of(port.state)));
    std::vector<Universe> universes;
    TimeNs newest_ns = 0;
    for (const PortUniverseStatus& one : port.universes) {
      universes.push_back(one.universe);
      for (const UniverseStatus& universe : input.status->universes) {
        if (one.frames > 0 && universe.universe == one.universe)
          newest_ns = std::max(newest_ns, universe.newest.stamp_ns);
      }
    }
    cell(kUiText, show_universes(universes));
    if (universes.empty()) {  // a control: its events
      cell(kUiText, fmt::format("{}", port.port.frames));
      cell(kUiDim, "-");
      return cell(kUiDim, "-");
    }
    rate_cells(port);
    line_cells(&port, line);
    cell(newest_ns == 0 ? kUiDim : silent ? kUiRed : kUiText,
         newest_ns == 0 ? tr("none yet") : age_text(input.status->stamp_ns - newest_ns));
  }

  // What is wrong and what to do.
  static void draw_trouble(const PortStatus& port, bool known) {
    if (!port.trouble.empty()) {
      wrapped(kUiRed, port.trouble);
    } else if (known && !port.is_sink && !port.universes.empty() && port.frames == 0 &&
               port.state != PortState::kEnded) {
      wrapped(kUiAmber, trf("{}: no frames yet. Start the sender; `footlight doctor` checks this machine.", port.name));
    }
    if (const std::string errors = errors_text(port); !errors.empty()) {
      wrapped(kUiDim, fmt::format("{}: {}", port.name, errors));
    }
  }

  void draw_buttons(OutputsView& outputs, float scale) {
    const bool any_off = std::any_of(outputs.rows.begin(), outputs.rows.end(),
                                     [](const OutputRow& row) { return row.state == ArmState::kOff; });
    ImGui::BeginDisabled(!any_off);
    if (ImGui::Button(tr_label("arm all ..."))) arm_question_.ask(ArmQuestion::kAll);
    ImGui::EndDisabled();
    ImGui::SameLine();
    ImGui::BeginDisabled(!outputs.any_on());
    if (ImGui::Button(tr_label("disarm all"))) outputs.disarm_all();
    ImGui::EndDisabled();
    ImGui::SameLine(0, 24 * scale);
    if (!is_blackout(outputs.darkness)) {
      ImGui::PushStyleColor(ImGuiCol_Text, kStageColours.text);
      ImGui::PushStyleColor(ImGuiCol_Button, {0.45f, 0.10f, 0.10f, 1});
      ImGui::PushStyleColor(ImGuiCol_ButtonHovered, {0.62f, 0.14f, 0.14f, 1});
      if (ImGui::Button(tr_label("BLACKOUT"))) outputs.blackout = true;
      ImGui::PopStyleColor(3);
    } else if (ImGui::Button(tr_label("end the blackout"))) {
      outputs.blackout = false;
    }
    draw_hold(outputs, scale);
    if (outputs.darkness == Darkness::kSilence) ui_text(kUiRed, blackout_words(outputs));
  }

  // On the line of the buttons if there is room.
  static void draw_hold(OutputsView& outputs, float scale) {
    const std::string words = trf("live only while {} is held", tr(kHoldKeyName));
    ImGui::SameLine(0, 24 * scale);
    const float width = ImGui::CalcTextSize(words.c_str()).x + ImGui::GetFrameHeightWithSpacing();
    if (ImGui::GetContentRegionAvail().x < width) ImGui::NewLine();
    ImGui::Checkbox((words + "###hold").c_str(), &outputs.needs_hold);
    if (!ImGui::IsItemHovered()) return;
    ImGui::SetTooltip("%s", tr("A dead man's switch: lamps are dark when the key is released, when another window has "
                               "the keyboard, and half a second after this one hangs."));
  }

  void draw_outputs(OutputsView& outputs) {
    LineColumns line;
    for (const OutputRow& row : outputs.rows) {
      if (row.status) line.add(*row.status);
    }
    if (begin_table("outputs", "##arm", 10, line)) {
      for (std::size_t i = 0; i < outputs.rows.size(); ++i) {
        ImGui::TableNextRow();
        ImGui::PushID(static_cast<int>(i));
        draw_output(outputs, i, line);
        ImGui::PopID();
      }
      ImGui::EndTable();
    }
    for (const OutputRow& row : outputs.rows) {
      if (!row.trouble.empty()) wrapped(kUiRed, trf("not armed: {}", row.trouble));
      if (!row.left_out.empty()) {
        wrapped(kUiAmber, trf("{}: universe {} is not sent: no fixture of this rig has an address there", row.endpoint,
                              show_universes(row.left_out)));
      }
      if (row.status) draw_trouble(*row.status, true);
    }
  }

  void draw_output(OutputsView& outputs, std::size_t index, const LineColumns& line) {
    const OutputRow& row = outputs.rows[index];
    ImGui::TableNextColumn();
    const std::string words = row.made_up ? trf("{} (made up)", row.endpoint) : row.endpoint;
    ImGui::PushStyleColor(ImGuiCol_Text, row.made_up ? kUiAmber : kUiText);
    if (row.can_move) {
      ImGui::Selectable(words.c_str(), false, 0, {ImGui::CalcTextSize(words.c_str()).x, 0});
      if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tr("Drag it to another universe below."));
      drag_source(kOutputDrag, &index, sizeof(index), row.endpoint);
    } else {
      ui_text(words);
    }
    ImGui::PopStyleColor();
    const bool lost = row.status && row.status->state == PortState::kGone;
    cell(row.state == ArmState::kOff     ? kUiDim
         : row.state == ArmState::kArmed ? kUiRed
                                         : kUiAmber,
         lost                                                                   ? tr("LIVE, lost")
         : row.state == ArmState::kArmed && outputs.darkness != Darkness::kNone ? tr("zeros")
                                                                                : word_of(row.state));
    cell(kUiText, show_universes(row.universes));
    if (row.status) {
      rate_cells(*row.status);
    } else {
      cell(kUiDim, "-");
      cell(kUiDim, "-");
    }
    line_cells(row.status ? &*row.status : nullptr, line);
    ImGui::TableNextColumn();
    if (row.state == ArmState::kOff) {
      if (ImGui::SmallButton(tr_label("arm ..."))) arm_question_.ask(index);
    } else if (row.state != ArmState::kClosing) {
      if (ImGui::SmallButton(tr_label("disarm"))) outputs.disarm.push_back(index);
    }
    ImGui::SameLine();
    if (ImGui::SmallButton(tr_label("remove"))) {
      if (row.state == ArmState::kOff) {
        outputs.remove.push_back(index);
      } else {
        removal_question_.ask(row.endpoint);
      }
    }
  }

  // DMX interfaces of this machine. A drag to a universe makes one an output; so does its button, for the chosen one.
  void draw_devices(OutputsView& outputs, InputsView* inputs) {
    if (outputs.devices.empty()) wrapped(kUiDim, tr("No DMX interface. `footlight doctor` checks this machine."));
    for (std::size_t i = 0; i < outputs.devices.size(); ++i) {
      const PluggedDevice& device = outputs.devices[i];
      ImGui::PushID(static_cast<int>(i));
      draw_device(outputs, device.endpoint,
                  device.endpoint.empty() ? device.model : device.endpoint + "  " + device.model, device.can_send);
      ImGui::SameLine();
      ui_text(device.fix.empty() ? kUiGreen : kUiAmber, device.state);
      if (!device.fix.empty()) wrapped(kUiDim, device.fix);
      ImGui::PopID();
    }
    draw_model(outputs);
    if (!outputs.universes.empty()) draw_universes(outputs, inputs);
  }

  // A name that can be dragged, and a button.
  void draw_device(OutputsView& outputs, const std::string& endpoint, const std::string& words, bool can_send) {
    if (!can_send || outputs.universes.empty()) return ui_text(kUiText, words);
    const float width = ImGui::CalcTextSize(words.c_str()).x;
    ImGui::Selectable(words.c_str(), false, 0, {width, 0});
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tr("Drag it to a universe below."));
    drag_source(kDeviceDrag, endpoint.c_str(), endpoint.size() + 1, endpoint);
    ImGui::SameLine();
    if (ImGui::SmallButton(tr_label("add"))) outputs.add = fmt::format("{}={}", endpoint, chosen(outputs));
  }

  static void drag_source(const char* kind, const void* data, std::size_t size, const std::string& words) {
    if (!ImGui::BeginDragDropSource(ImGuiDragDropFlags_SourceAllowNullID)) return;
    ImGui::SetDragDropPayload(kind, data, size);
    ui_text(trf("{} to a universe", words));
    ImGui::EndDragDropSource();
  }

  // An interface that is none, to arm without lamps.
  void draw_model(OutputsView& outputs) {
    const auto at = std::find_if(outputs.rows.begin(), outputs.rows.end(),
                                 [](const OutputRow& row) { return row.endpoint.starts_with(kModel); });
    if (at != outputs.rows.end() || outputs.universes.empty()) return;
    ui_text(kUiDim, tr("No interface at hand? A made-up one sends to no lamp:"));
    ImGui::SameLine();
    if (ImGui::SmallButton(tr_label("add a made-up interface")))
      outputs.add = fmt::format("{}={}", kModel, chosen(outputs));
    drag_source(kDeviceDrag, kModel, std::string_view(kModel).size() + 1, kModel);
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
        std::size_t index = 0;
        std::memcpy(&index, row->Data, sizeof(index));
        outputs.move = OutputsView::Move{index, universe};
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
