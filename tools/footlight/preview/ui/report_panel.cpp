// What `footlight report` knows, of the picture that is shown: times of passes, memory, what is left out, and the error
// with the curve that it is chosen from.
#include <algorithm>
#include <array>
#include <string>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/panels.h"
#include "tools/footlight/preview/ui/report_view.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

ImU32 packed(const ImVec4& of) { return ImGui::GetColorU32(of); }

// A value at the right end of the cell.
void right_text(const std::string& words) {
  const float spare = ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(words.c_str()).x;
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() + std::max(spare, 0.0f));
  ui_text(words);
}

class ReportPanel final : public Panel {
 public:
  void draw(UiDesk&, const UiInput& input) override {
    if (input.report == nullptr || input.report->picture == 0) return ui_text(kUiDim, tr("There is no picture yet."));
    ReportView& view = *input.report;
    if (view.picture != picture_) history_.add(view.passes);
    picture_ = view.picture;
    if (!ImGui::BeginTabBar("report")) return;
    const auto tab = [&](const char* title, auto draw_tab) {
      if (!ImGui::BeginTabItem(title)) return;
      if (ImGui::BeginChild("tab")) draw_tab();
      ImGui::EndChild();
      ImGui::EndTabItem();
    };
    tab(tr_label("Error and time"), [&] { draw_error(view, input.scale); });
    tab(tr_label("Passes"), [&] { draw_passes(view, input.scale); });
    tab(tr_label("Memory"), [&] { draw_memory(view); });
    tab(tr_label("Left out"), [&] { draw_left_out(view); });
    ImGui::EndTabBar();
  }

 private:
  void draw_passes(const ReportView& view, float scale) const {
    if (history_.rows().empty()) {
      return ui_text(kUiDim, trf("This device has no time stamps; a picture took {}.", ms_text(view.picture_ms)));
    }
    ui_text(kUiDim, trf("GPU time of each pass in the last {} pictures", history_.pictures()));
    constexpr ImGuiTableFlags kFlags = ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingFixedFit;
    if (!ImGui::BeginTable("passes", 5, kFlags)) return;
    ImGui::TableSetupColumn(tr("pass"));
    ImGui::TableSetupColumn(tr("last"));
    ImGui::TableSetupColumn(tr("median"));
    ImGui::TableSetupColumn(tr("most"));
    ImGui::TableSetupColumn(tr("time, each row to its own most"), ImGuiTableColumnFlags_WidthStretch);
    ImGui::TableHeadersRow();
    draw_pass(history_.total(), scale);
    for (const PassHistory::Row& row : history_.rows()) draw_pass(row, scale);
    ImGui::EndTable();
  }

  static void draw_pass(const PassHistory::Row& row, float scale) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ui_text(row.name);
    for (const double ms : {row.last_ms(), row.median_ms(), row.most_ms()}) {
      ImGui::TableNextColumn();
      right_text(ms_text(ms));
    }
    ImGui::TableNextColumn();
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const ImVec2 size{std::max(ImGui::GetContentRegionAvail().x, 10.0f), ImGui::GetTextLineHeight()};
    ImGui::Dummy(size);
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const float step = size.x / static_cast<float>(PassHistory::kPicturesMax);
    const float left = at.x + size.x - step * static_cast<float>(row.ms.size());  // the newest at the right end
    const auto most = static_cast<float>(row.most_ms());
    for (std::size_t i = 0; i < row.ms.size() && most > 0; ++i) {
      const float x = left + step * static_cast<float>(i);
      const float high = std::max(row.ms[i] / most * (size.y - 2 * scale), 1.0f);
      draw.AddRectFilled({x, at.y + size.y - high}, {x + std::max(step - 0.5f, 1.0f), at.y + size.y},
                         packed(ui_colours.hot));
    }
  }

  static void draw_memory(const ReportView& view) {
    ui_text(trf("{} of GPU memory for this rig and this size", bytes_text(view.bytes)));
    constexpr ImGuiTableFlags kFlags = ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingFixedFit;
    if (!ImGui::BeginTable("memory", 3, kFlags)) return;
    ImGui::TableSetupColumn(tr("buffers and images"));
    ImGui::TableSetupColumn(tr("bytes"));
    ImGui::TableSetupColumn(tr("share"), ImGuiTableColumnFlags_WidthStretch);
    ImGui::TableHeadersRow();
    for (const render::MemoryGroup& group : view.memory) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ui_text(tr(group.name.c_str()));
      ImGui::TableNextColumn();
      right_text(bytes_text(group.bytes));
      ImGui::TableNextColumn();
      const float share = static_cast<float>(group.bytes) / static_cast<float>(std::max<std::uint64_t>(view.bytes, 1));
      const ImVec2 at = ImGui::GetCursorScreenPos();
      const ImVec2 size{std::max(ImGui::GetContentRegionAvail().x, 10.0f), ImGui::GetTextLineHeight()};
      ImGui::Dummy(size);
      ImGui::GetWindowDrawList()->AddRectFilled(
          {at.x, at.y + 2}, {at.x + std::max(size.x * share, 1.0f), at.y + size.y - 2}, packed(ui_colours.bar));
    }
    ImGui::EndTable();
  }

  static void draw_left_out(const ReportView& view) {
    if (!view.has_left_out) return ui_text(kUiDim, tr("looking ..."));
    ui_wrapped(ui_colours.text, trf("Code of shaders: {} in use, {} left out.",
                                    bytes_text(view.left_out.used_code_bytes), bytes_text(view.left_out.code_bytes)));
    ui_wrapped(kUiDim, tr("Memory is that of the buffers and images that the picture would have more; of a pass, those "
                          "that come with it. -: the settings leave it out, not the rig."));
    constexpr ImGuiTableFlags kFlags = ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingFixedFit;
    if (!ImGui::BeginTable("left out", 4, kFlags)) return;
    ImGui::TableSetupColumn(tr("left out"));
    ImGui::TableSetupColumn(tr("memory"));
    ImGui::TableSetupColumn(tr("code"));
    ImGui::TableSetupColumn(tr("lacks"), ImGuiTableColumnFlags_WidthStretch);
    ImGui::TableHeadersRow();
    for (const LeftOutRow& row : view.left_out.rows) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      if (row.pass) ui_text(kUiAmber, trf("pass {}", row.name));
      if (!row.pass) ui_text(row.name);
      ImGui::TableNextColumn();
      if (row.on_gpu) right_text(bytes_text(row.bytes));
      if (!row.on_gpu) ui_text(kUiDim, row.pass ? "-" : tr("none"));
      ImGui::TableNextColumn();
      if (row.pass) right_text(bytes_text(row.code_bytes));
      ImGui::TableNextColumn();
      ui_wrapped(kUiDim, tr(row.text.c_str()));
    }
    ImGui::EndTable();
  }

  void draw_error(ReportView& view, float scale) {
    if (view.error.samples > 0) {
      ui_text(trf("Measured: relative L2 error {}", share_text(view.error.rel_l2)));
      ImGui::SameLine();
      ui_text(kUiDim, trf("95 %: {} to {}, {} samples", share_text(view.error.low), share_text(view.error.high),
                          view.error.samples));
    } else {
      ui_text(kUiDim, tr("The error of this picture is not measured: no beams, or other kinds of light."));
    }
    draw_target(view);
    if (view.measures) return ui_text(kUiAmber, tr("measuring this machine ... the picture stands still meanwhile"));
    const auto plot = plot_of(view);
    if (!plot) {
      ui_text(kUiDim, tr("Error against time was not measured on this machine yet."));
      ImGui::BeginDisabled(!view.why_not_measure.empty());
      if (ImGui::Button(tr_label("measure error against time"))) view.measure = true;
      ImGui::EndDisabled();
      if (!view.why_not_measure.empty()) ui_wrapped(kUiRed, view.why_not_measure);
      ui_wrapped(kUiDim,
                 tr("Takes seconds on a GPU and up to minutes on a CPU; the picture stands still. It is kept for "
                    "this machine."));
      return;
    }
    draw_plot(*plot, scale);
  }

  static void draw_target(const ReportView& view) {
    std::string words = tr("Asked for: nothing; knobs by hand");
    if (view.target.error > 0) words = trf("Asked for: an error of {}", share_text(view.target.error));
    if (view.target.ms > 0) words = trf("Asked for: {} a picture", ms_text(view.target.ms));
    words += trf(". GPU: {}.", ms_text(view.picture_ms));
    if (view.present) words += trf(" The curve says: {}.", share_text(view.present->error));
    ui_wrapped(ui_colours.text, words);
    if (view.present) ui_wrapped(kUiDim, render::text_of(view.present->knobs));
  }

  static void draw_plot(const ErrorPlot& plot, float scale) {
    const float line = ImGui::GetTextLineHeight();
    const ImVec2 room = ImGui::GetContentRegionAvail();
    float label = 0;
    for (const ErrorPlot::Tick& tick : plot.ticks_y) label = std::max(label, ImGui::CalcTextSize(tick.text.c_str()).x);
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const ImVec2 whole{std::max(room.x, 120 * scale), std::max(room.y - 3 * line, 110 * scale)};
    ImGui::InvisibleButton("plot", whole);
    const bool hovered = ImGui::IsItemHovered();
    const ImVec2 low{at.x + label + 8 * scale, at.y + 4 * scale};
    const float half = plot.ticks_x.empty() ? 0 : ImGui::CalcTextSize(plot.ticks_x.back().text.c_str()).x / 2;
    const ImVec2 high{at.x + whole.x - half - 2, at.y + whole.y - 1.4f * line};
    const auto place = [&](float x, float y) {
      return ImVec2{low.x + x * (high.x - low.x), high.y - y * (high.y - low.y)};
    };
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    draw.AddRectFilled(low, high, packed(ui_colours.ground));
    draw_grid(plot, draw, place, line);
    if (plot.target_x) draw.AddLine(place(*plot.target_x, 0), place(*plot.target_x, 1), packed(ui_colours.differs), 2);
    if (plot.target_y) draw.AddLine(place(0, *plot.target_y), place(1, *plot.target_y), packed(ui_colours.differs), 2);
    for (std::size_t i = 0; i + 1 < plot.curve.size(); ++i) {
      const auto& [a, b] = std::array{plot.curve[i].at, plot.curve[i + 1].at};
      draw.AddLine(place(a.x, a.y), place(b.x, b.y), packed(ui_colours.bar), 1.5f);
    }
    const ErrorPlot::Knob* nearest = nullptr;
    float nearest_px2 = 100 * scale * scale;
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    for (const ErrorPlot::Knob& knob : plot.curve) {
      const ImVec2 dot = place(knob.at.x, knob.at.y);
      draw.AddCircleFilled(dot, 3 * scale, packed(ui_colours.bar));
      const float px2 = (mouse.x - dot.x) * (mouse.x - dot.x) + (mouse.y - dot.y) * (mouse.y - dot.y);
      if (!hovered || px2 >= nearest_px2) continue;
      nearest_px2 = px2;
      nearest = &knob;
    }
    if (plot.present) draw.AddCircle(place(plot.present->x, plot.present->y), 7 * scale, packed(kUiAmber), 0, 2.5f);
    if (plot.measured) draw_measured(plot, draw, place, scale);
    if (nearest != nullptr) {
      ImGui::SetTooltip("%s\n%s, %s", render::text_of(nearest->point.knobs).c_str(),
                        share_text(nearest->point.error).c_str(), ms_text(nearest->point.ms).c_str());
    }
    draw_legend(plot);
  }

  template <class Place>
  static void draw_grid(const ErrorPlot& plot, ImDrawList& draw, Place place, float line) {
    const ImU32 thin = packed(ui_colours.odd);
    float free_x = -1e9f;  // labels do not overlap
    for (const ErrorPlot::Tick& tick : plot.ticks_x) {
      const ImVec2 at = place(tick.at, 0);
      draw.AddLine(at, place(tick.at, 1), thin);
      const float width = ImGui::CalcTextSize(tick.text.c_str()).x;
      const float left = tick.at == 0 ? at.x : at.x - width / 2;  // beside the lowest label of the other axis
      if (left < free_x) continue;
      draw.AddText({left, at.y + 2}, packed(kUiDim), tick.text.c_str());
      free_x = left + width + line / 2;
    }
    float free_y = 1e9f;
    for (const ErrorPlot::Tick& tick : plot.ticks_y) {
      const ImVec2 at = place(0, tick.at);
      draw.AddLine(at, place(1, tick.at), thin);
      if (at.y + line / 2 > free_y) continue;
      const float width = ImGui::CalcTextSize(tick.text.c_str()).x;
      draw.AddText({at.x - width - 4, at.y - line / 2}, packed(kUiDim), tick.text.c_str());
      free_y = at.y - line / 2;
    }
  }

  template <class Place>
  static void draw_measured(const ErrorPlot& plot, ImDrawList& draw, Place place, float scale) {
    const ImVec2 at = place(plot.measured->x, plot.measured->y);
    const ImU32 green = packed(kUiGreen);
    draw.AddLine({at.x, place(0, plot.measured_low).y}, {at.x, place(0, plot.measured_high).y}, green, 2);
    draw.AddLine({at.x - 5 * scale, at.y}, {at.x + 5 * scale, at.y}, green, 2);
  }

  static void draw_legend(const ErrorPlot& plot) {
    ui_text(kUiAmber, tr("o present setting"));
    if (plot.measured) {
      ImGui::SameLine();
      ui_text(kUiGreen, tr("+ measured"));
    }
    if (plot.target_x || plot.target_y) {
      ImGui::SameLine();
      ui_text(ui_colours.differs, tr("| asked for"));
    }
    ImGui::SameLine();
    ui_text(kUiDim, tr("- error against GPU time of a picture"));
    if (plot.scale == 1) return ui_text(kUiDim, tr("times of the scenes that it was measured on"));
    ui_text(kUiDim, trf("times of the scenes that it was measured on, times {:.3g}: as this picture", plot.scale));
  }

  PassHistory history_;
  std::uint64_t picture_ = 0;
};

}  // namespace

std::unique_ptr<Panel> make_report_panel(UiDesk&) { return std::make_unique<ReportPanel>(); }

}  // namespace footlight::tools
