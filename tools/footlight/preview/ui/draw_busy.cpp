#include "tools/footlight/preview/ui/draw_busy.h"

#include <algorithm>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

Busy busy_with(const Transport::Seeking& seeking) {
  const double all = static_cast<double>(std::max<DurationNs>(seeking.until_ns - seeking.from_ns, 1));
  const double done = static_cast<double>(seeking.at_ns - seeking.from_ns);
  return {BusyWith::kSeek, trf("going to {} of the log", time_text(seeking.until_ns)),
          std::clamp(done / all, 0.0, 1.0), true};
}

Busy busy_of(const BusyWork& work) {
  if (work.knobs_share) return {BusyWith::kKnobs, tr("measuring this machine"), work.knobs_share, true};
  if (work.makes_frame && work.undone) {
    return {BusyWith::kEdit, tr("the edit is undone; the picture goes on soon"), std::nullopt, false};
  }
  if (work.makes_frame) {
    const char* const words = work.can_undo ? tr("preparing the picture of the edited rig")
                                            : tr("preparing the picture of the edited rig; Ctrl+Z undoes the edit");
    return {BusyWith::kEdit, words, std::nullopt, work.can_undo};
  }
  if (work.seeking) return busy_with(*work.seeking);
  if (work.compiles) {
    return {BusyWith::kShaders, tr("compiling shaders; the picture goes on as it was"), std::nullopt, false};
  }
  if (work.reads_log) return {BusyWith::kLog, trf("reading {}", *work.reads_log), std::nullopt, false};
  return {};
}

void draw_first_wait(std::uint64_t pictures, DurationNs waited_ns, float stage_width) {
  if (pictures > 0) return;
  // With all shaders in the cache the picture comes sooner.
  const char* const what = waited_ns < BusyMark::kPatienceNs ? tr("Preparing the picture") : tr("Compiling shaders");
  const std::string words = fmt::format("{} ... {:.0f} s", what, static_cast<double>(waited_ns) * 1e-9);
  const ImVec2 size = ImGui::CalcTextSize(words.c_str());
  const ImVec2 at((std::max(stage_width, 1.0f) - size.x) / 2, (ImGui::GetIO().DisplaySize.y - size.y) / 2);
  ImGui::GetBackgroundDrawList()->AddText(at, ImGui::GetColorU32(kStageColours.text), words.c_str());
}

bool BusyMark::draw(const Busy& busy, TimeNs now_ns, float stage_width, float y, float scale) {
  if (busy.with != with_) {
    with_ = busy.with;
    since_ns_ = now_ns;
  }
  const DurationNs lasts_ns = now_ns - since_ns_;
  can_cancel_ = false;
  if (with_ == BusyWith::kNothing || lasts_ns < kPatienceNs) return false;
  can_cancel_ = busy.can_cancel;
  constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
                                      ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                                      ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav;
  ImGui::SetNextWindowPos({std::max(stage_width, 1.0f) / 2, y + 8 * scale}, ImGuiCond_Always, {0.5f, 0});
  bool cancels = false;
  if (ImGui::Begin("busy", nullptr, kFlags)) {
    ui_text(busy.words);
    const float width = std::max(200 * scale, ImGui::CalcTextSize(busy.words.c_str()).x);
    const float button = ImGui::CalcTextSize(tr("cancel (Esc)")).x + 2 * ImGui::GetStyle().FramePadding.x;
    if (busy.share) {
      ImGui::ProgressBar(static_cast<float>(*busy.share),
                         {busy.can_cancel ? width - button - ImGui::GetStyle().ItemSpacing.x : width, 0});
    } else {
      ui_text(kUiDim, fmt::format("{:.0f} s", static_cast<double>(lasts_ns) * 1e-9));
    }
    if (busy.can_cancel) {
      ImGui::SameLine();
      cancels = ImGui::Button(tr_label("cancel (Esc)"), {button, 0});
    }
  }
  ImGui::End();
  return cancels;
}

}  // namespace footlight::tools
