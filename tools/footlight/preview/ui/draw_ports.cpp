#include "tools/footlight/preview/ui/draw_ports.h"

#include <algorithm>

#include <fmt/format.h>

#include "tools/footlight/duration.h"
#include "tools/footlight/preview/ui/level_source.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"
#include "tools/footlight/status/status_text.h"

namespace footlight::tools {
namespace {

constexpr int kInputRows = 2;
constexpr float kInputNoteLines = 2;

// Widths, in units of the font.
constexpr float kEndpointMin = 8;
constexpr float kEndpointMax = 17;
constexpr float kUniverses = 6;
constexpr float kFrames = 5;
constexpr float kRate = 4.5f;
constexpr float kNewest = 4.5f;
constexpr float kBreak = 4;
constexpr float kLatency = 4.5f;

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

const ImVec4& colour_of(PortState state) {
  return state == PortState::kWorking ? kUiGreen : state == PortState::kGone ? kUiRed : kUiAmber;
}

// "176 us": the break that a port measures, or that its widget makes; empty: it is not known.
std::string break_text(const PortStatus& port) {
  for (const PortFigure& figure : port.figures) {
    if (figure.name == "break_us_p50" || figure.name == "break_us") return fmt::format("{:.0f} us", figure.value);
  }
  return {};
}

// Empty cells where the port knows nothing; none without its column.
void line_cells(const PortStatus* port, const PortColumns& line) {
  const auto value_cell = [](const std::string& words, const std::string& tip) {
    port_cell(words.empty() ? kUiDim : kUiText, words.empty() ? "-" : words);
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

// Its cells after the name. port: nullptr while its figures are not yet known.
void draw_input(const PortStatus* port, const UiInput& input, const PortColumns& columns) {
  if (port == nullptr) {
    port_cell(kUiDim, "-");
    if (columns.universes) port_cell(kUiDim, "-");
    port_figures(nullptr, true, columns);
    if (columns.newest) port_cell(kUiDim, "-");
    return;
  }
  const bool silent = is_silent(*port, *input.status);
  port_cell(silent ? kUiRed : colour_of(port->state), silent ? tr("silent") : tr(name_of(port->state)));
  std::vector<Universe> universes;
  TimeNs newest_ns = 0;
  for (const PortUniverseStatus& one : port->universes) {
    universes.push_back(one.universe);
    for (const UniverseStatus& universe : input.status->universes) {
      if (one.frames > 0 && universe.universe == one.universe)
        newest_ns = std::max(newest_ns, universe.newest.stamp_ns);
    }
  }
  if (columns.universes) port_cell(kUiText, show_universes(universes));
  port_figures(port, !universes.empty(), columns);  // a control has no universe: its events
  if (!columns.newest) return;
  if (universes.empty()) return port_cell(kUiDim, "-");
  port_cell(newest_ns == 0 ? kUiDim : silent ? kUiRed : kUiText,
            newest_ns == 0 ? tr("none yet") : age_text(input.status->stamp_ns - newest_ns));
}

void draw_input_name(const UiInput& input, const std::string& name, bool removable, bool made_up) {
  ImGui::TableNextColumn();
  const std::string words = made_up ? trf("MADE UP: {}", name) : name;
  const bool moves = removable && std::find(input.inputs->movable.begin(), input.inputs->movable.end(), name) !=
                                      input.inputs->movable.end();
  ImGui::PushStyleColor(ImGuiCol_Text, made_up ? kUiAmber : kUiText);
  if (moves) {
    ImGui::Selectable(words.c_str(), false, 0, {label_width(words), 0});
  } else {
    ui_text(words);
  }
  ImGui::PopStyleColor();
  if (ImGui::IsItemHovered()) {
    ImGui::SetTooltip("%s", moves ? (words + "\n" + tr("Drag it to another universe below.")).c_str() : words.c_str());
  }
  if (moves) drag_endpoint(kInputDrag, name.c_str(), name.size() + 1, name);
}

}  // namespace

void draw_wrapped(const ImVec4& colour, const std::string& words) {
  ImGui::PushTextWrapPos(0);
  ui_text(colour, words);
  ImGui::PopTextWrapPos();
}

float label_width(const std::string& label) { return ImGui::CalcTextSize(label.c_str(), nullptr, true).x; }

bool small_button(const char* label, float width) {
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {ImGui::GetStyle().FramePadding.x, 0});
  const bool pressed = ImGui::Button(label, {width, 0});
  ImGui::PopStyleVar();
  return pressed;
}

float button_width(std::initializer_list<const char*> labels) {
  float width = 0;
  for (const char* label : labels) width = std::max(width, label_width(label));
  return width + 2 * ImGui::GetStyle().FramePadding.x;
}

void draw_notes(const char* id, const std::vector<Note>& notes, float lines) {
  if (ImGui::BeginChild(id, {0, lines * ImGui::GetTextLineHeightWithSpacing()})) {
    for (const Note& note : notes) draw_wrapped(note.colour, note.words);
  }
  ImGui::EndChild();
}

void note_trouble(const PortStatus& port, bool known, std::vector<Note>& notes) {
  if (!port.trouble.empty()) {
    notes.push_back({kUiRed, port.trouble});
  } else if (known && !port.is_sink && !port.universes.empty() && port.frames == 0 &&
             port.state != PortState::kEnded) {
    notes.push_back(
        {kUiAmber, trf("{}: no frames yet. Start the sender; `footlight doctor` checks this machine.", port.name)});
  }
  if (const std::string errors = errors_text(port); !errors.empty()) {
    notes.push_back({kUiDim, fmt::format("{}: {}", port.name, errors)});
  }
}

void PortColumns::add(const PortStatus& port) {
  breaks = breaks || !break_text(port).empty();
  latency = latency || port.latency.count > 0;
}

void PortColumns::add(const std::string& endpoint_words) { endpoint = std::max(endpoint, label_width(endpoint_words)); }

void PortColumns::add_state(const char* word) { state = std::max(state, label_width(word)); }

void PortColumns::fit(float room) {
  const float unit = ImGui::GetFontSize();
  const float space = 2 * ImGui::GetStyle().CellPadding.x;
  endpoint = std::clamp(endpoint, unit * kEndpointMin, unit * kEndpointMax);
  room -= endpoint + state + last + 3 * space;
  const auto keep = [&](bool& column, float units) {
    column = column && room >= units * unit + space;
    if (column) room -= units * unit + space;
  };
  keep(newest, kNewest);
  keep(rate, kRate);
  keep(universes, kUniverses);
  keep(latency, kLatency);
  keep(frames, kFrames);
  keep(breaks, kBreak);
}

bool begin_port_table(const char* id, const PortColumns& columns) {
  if (!ImGui::BeginTable(id, columns.count(), ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp)) return false;
  const float unit = ImGui::GetFontSize();
  const auto column = [](const char* title, float width) {
    ImGui::TableSetupColumn(title, ImGuiTableColumnFlags_WidthFixed, width);
  };
  ImGui::TableSetupColumn(tr("endpoint"), ImGuiTableColumnFlags_WidthStretch);
  column(tr("state"), columns.state);
  if (columns.universes) column(tr("universes"), unit * kUniverses);
  if (columns.frames) column(tr_in("DMX", "frames"), unit * kFrames);
  if (columns.rate) column(tr("rate"), unit * kRate);
  if (columns.breaks) column(tr("break"), unit * kBreak);
  if (columns.latency) column(tr("latency"), unit * kLatency);
  if (columns.newest) column(tr("newest"), unit * kNewest);
  column("##buttons", columns.last);
  ImGui::TableHeadersRow();
  return true;
}

void next_port_row() {
  ImGui::TableNextRow(0, ImGui::GetTextLineHeight() + 2 * ImGui::GetStyle().CellPadding.y);
}

void end_port_table(int rows, int rows_min) {
  for (; rows < rows_min; ++rows) {
    next_port_row();
    ImGui::TableNextColumn();
  }
  ImGui::EndTable();
}

void port_cell(const ImVec4& colour, const std::string& words) {
  ImGui::TableNextColumn();
  ui_text(colour, words);
}

void port_figures(const PortStatus* port, bool levels, const PortColumns& columns) {
  if (columns.frames) {
    const std::uint64_t frames = port == nullptr ? 0 : levels ? port->frames : port->port.frames;
    port_cell(port == nullptr ? kUiDim : kUiText, port == nullptr ? "-" : fmt::format("{}", frames));
  }
  const bool known = port != nullptr && levels;
  if (columns.rate) port_cell(known ? kUiText : kUiDim, known ? fmt::format("{:.1f} /s", port->rate_hz) : "-");
  line_cells(port, columns);
}

void drag_endpoint(const char* kind, const void* data, std::size_t size, const std::string& words) {
  if (!ImGui::BeginDragDropSource(ImGuiDragDropFlags_SourceAllowNullID)) return;
  ImGui::SetDragDropPayload(kind, data, size);
  ui_text(trf("{} to a universe", words));
  ImGui::EndDragDropSource();
}

// Those that have no button come last, such as levels by hand: they come and go by themselves, and move no button.
void draw_inputs(const UiInput& input) {
  struct Row {
    std::string name;
    const PortStatus* port = nullptr;
    bool removable = false;
    bool made_up = false;
  };
  std::vector<Row> rows;
  const auto has = [](const std::vector<std::string>& list, const std::string& name) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  const std::vector<std::string> none;
  const std::vector<std::string>& removable = input.inputs != nullptr ? input.inputs->inputs : none;
  for (const std::string& name : removable) {
    const PortStatus* port = nullptr;
    for (std::size_t i = 0; input.status != nullptr && port == nullptr && i < input.status->ports.size(); ++i) {
      const PortStatus& one = input.status->ports[i];
      if (!one.is_sink && one.name == name) port = &one;
    }
    rows.push_back({name, port, true, has(input.inputs->made_up, name)});
  }
  if (input.status != nullptr) {
    for (const PortStatus& port : input.status->ports) {
      if (!port.is_sink && !has(removable, port.name)) rows.push_back({port.name, &port});
    }
  }
  PortColumns columns;
  columns.newest = true;
  for (const char* word : {tr("working"), tr("waiting"), tr("gone"), tr("ended"), tr("silent")}) {
    columns.add_state(word);
  }
  columns.last = button_width({tr_label("remove")});
  for (Row& row : rows) {
    if (row.port != nullptr) columns.add(*row.port);
    columns.add(row.made_up ? trf("MADE UP: {}", row.name) : row.name);
  }
  columns.fit(ImGui::GetContentRegionAvail().x);
  if (begin_port_table("inputs", columns)) {
    for (const Row& row : rows) {
      next_port_row();
      ImGui::PushID(row.name.c_str());
      draw_input_name(input, row.name, row.removable, row.made_up);
      draw_input(row.port, input, columns);
      ImGui::TableNextColumn();
      if (row.removable && small_button(tr_label("remove"))) input.inputs->remove = row.name;
      ImGui::PopID();
    }
    end_port_table(static_cast<int>(rows.size()), kInputRows);
  }
  std::vector<Note> notes;
  if (rows.empty()) {
    notes.push_back({kUiDim, input.transport != nullptr ? tr("None: a log drives the rig.")
                                                        : tr("None: faders drive the rig.")});
  }
  if (input.inputs != nullptr && !input.inputs->refusal.empty()) notes.push_back({kUiRed, input.inputs->refusal});
  for (const Row& row : rows) {
    if (row.port != nullptr) note_trouble(*row.port, input.status->stamp_ns != 0, notes);
  }
  if (input.inputs != nullptr && !input.inputs->why_not.empty()) notes.push_back({kUiDim, input.inputs->why_not});
  draw_notes("input notes", notes, kInputNoteLines);
}
}  // namespace footlight::tools
