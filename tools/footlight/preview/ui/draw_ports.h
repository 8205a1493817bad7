// Tables of ports in the panel of devices: columns that leave room for the endpoint, rows that stay in place, and notes
// below in a place that is always there. Dear ImGui only.
#pragma once

#include <initializer_list>
#include <string>
#include <vector>

#include <imgui/imgui.h>

#include "sim/pump.h"
#include "tools/footlight/preview/ui/panels.h"

namespace footlight::tools {

// A line of its own below a row, over all columns.
void draw_wrapped(const ImVec4& colour, const std::string& words);

// As ImGui::SmallButton(), with a width that does not depend on its label: what follows stays in place.
bool small_button(const char* label, float width = 0);
// Of a button that has one of these labels.
[[nodiscard]] float button_width(std::initializer_list<const char*> labels);
[[nodiscard]] float label_width(const std::string& label);

// What is wrong and what has happened, in a place that is always there: what is below does not move. More than fits
// scrolls.
struct Note {
  ImVec4 colour;
  std::string words;
};
void draw_notes(const char* id, const std::vector<Note>& notes, float lines);
// What is wrong with a port and what to do. known: the status of the ports has come.
void note_trouble(const PortStatus& port, bool known, std::vector<Note>& notes);

// Which columns a table has: those of which some port knows something, and that there is room for beside the endpoint.
struct PortColumns {
  float endpoint = 0;  // its widest text
  float state = 0;
  float last = 0;
  bool universes = true;
  bool frames = true;
  bool rate = true;
  bool newest = false;
  bool breaks = false;
  bool latency = false;

  void add(const PortStatus& port);
  void add(const std::string& endpoint_words);
  void add_state(const char* word);
  // The least important ones are left out first.
  void fit(float room);
  [[nodiscard]] int count() const { return 3 + universes + frames + rate + newest + breaks + latency; }
};

[[nodiscard]] bool begin_port_table(const char* id, const PortColumns& columns);
// All rows are as high, also those that are not yet used.
void next_port_row();
// rows_min: that the table has at least, so that what is below stays where it is when a port comes.
void end_port_table(int rows, int rows_min);
void port_cell(const ImVec4& colour, const std::string& words);
// Frames, rate, break and latency. nullptr: not known, "-". levels: false for a control, which has events.
void port_figures(const PortStatus* port, bool levels, const PortColumns& columns);

inline constexpr const char* kInputDrag = "input";  // what is dragged: its endpoint
void drag_endpoint(const char* kind, const void* data, std::size_t size, const std::string& words);

// The inputs, with what is wrong with them.
void draw_inputs(const UiInput& input);

}  // namespace footlight::tools
