#include "tools/footlight/preview/preview_panel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include <imgui/imgui.h>

#include "tools/footlight/preview/ui/level_source.h"
#include "tools/footlight/preview/ui/report_view.h"
#include "tools/footlight/preview/ui/ui_desk.h"
#include "tools/footlight/preview/ui/ui_theme.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr std::size_t kCamerasShown = 20;  // the palette has all of them

std::string flash_words(const PreviewFacts& facts) {
  return facts.flashes_held ? tr("Harmful flashes are held back") : tr("Harmful flashes: more than 3 a second");
}

// A label on the left, a value on the right edge.
void row(const char* word, const std::string& figure) {
  ui_text(kUiDim, word);
  const float width = ImGui::CalcTextSize(figure.c_str()).x;
  ImGui::SameLine(ImGui::GetContentRegionMax().x - width);
  ui_text(figure);
}

void heading(const char* word) {
  ImGui::Dummy({0, 1});
  ImGui::Separator();
  ui_text(kUiAmber, word);
}

// A pass: its name, a bar of its share of the longest, its time.
void pass_bar(const render::PassTime& pass, double longest_ms) {
  const float line = ImGui::GetTextLineHeight();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float left = at.x + line * 4.6f;
  const float right = at.x + ImGui::GetContentRegionAvail().x - line * 4.4f;
  const double share = longest_ms > 0 ? pass.gpu_ms / longest_ms : 0;
  const float end = left + (right - left) * static_cast<float>(std::clamp(share, 0.0, 1.0));
  ImDrawList* draw = ImGui::GetWindowDrawList();
  const float top = at.y + line * 0.32f;
  const float bottom = at.y + line * 0.76f;
  draw->AddRectFilled({left, top}, {right, bottom}, ImGui::GetColorU32(ui_colours.even), 2);
  draw->AddRectFilled({left, top}, {std::max(end, left + 2), bottom}, ImGui::GetColorU32(ui_colours.hot), 2);
  row(pass.name.c_str(), ms_text(pass.gpu_ms));
}

void draw_cost(const PreviewFacts& facts) {
  heading(tr("Cost"));
  row(tr("frames"), fmt::format("{:.1f} /s", facts.fps));
  row("p50, p90", fmt::format("{}, {}", ms_text(facts.frame_p50_ms), ms_text(facts.frame_p90_ms)));
  double longest_ms = 0;
  double total_ms = 0;
  for (const auto& pass : facts.passes) {
    longest_ms = std::max(longest_ms, pass.gpu_ms);
    total_ms += pass.gpu_ms;
  }
  row("GPU", ms_text(total_ms));
  for (const auto& pass : facts.passes) pass_bar(pass, longest_ms);
  row(tr("beams"), trf("{} lit, {} dark", facts.live_beams, facts.dark_beams));
  if (facts.shadows_lost > 0) {
    ImGui::PushTextWrapPos(0);
    ui_text(kUiRed, trf("{} of {} shadows are missing: no room", facts.shadows_lost, facts.shadows));
    ImGui::PopTextWrapPos();
  }
  row(tr("panels"), ms_text(facts.ui_ms));
  row(tr("picture"), fmt::format("{} x {}, {:.0f} MiB", facts.width, facts.height, std::ceil(facts.gpu_mib)));
}

// What the knobs are chosen for. A new choice may compile shaders, so it is made at the release of the slider.
void draw_request(const PreviewFacts& facts, PreviewControls& controls) {
  const char* const kinds[] = {tr("by hand"), tr("for an error"), tr("for a time")};
  int kind = facts.quality.error > 0 ? 1 : facts.quality.ms > 0 ? 2 : 0;
  const auto ask = [&] {
    controls.quality = kind == 1   ? render::QualityRequest{.error = static_cast<double>(controls.error_percent) / 100}
                       : kind == 2 ? render::QualityRequest{.ms = static_cast<double>(controls.picture_ms)}
                                   : render::QualityRequest{};
  };
  ImGui::SetNextItemWidth(-1);
  if (ImGui::Combo("##quality", &kind, kinds, 3)) ask();
  if (kind == 0) return;
  constexpr ImGuiSliderFlags kFlags = ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp;
  ImGui::SetNextItemWidth(-1);
  if (kind == 1) {
    ImGui::SliderFloat("##error", &controls.error_percent, 0.001f, 10, tr_printf("error %.3f %%"), kFlags);
  } else {
    ImGui::SliderFloat("##ms", &controls.picture_ms, 0.5f, 1000, tr_printf("%.1f ms a picture"), kFlags);
  }
  if (ImGui::IsItemDeactivatedAfterEdit()) ask();
}

void draw_quality(const PreviewFacts& facts, PreviewControls& controls) {
  heading(tr("Error"));
  // Of the light, at a sample of the pixels of the last pictures.
  if (facts.error.samples > 0) {
    row(tr("measured, rel. L2"), share_text(facts.error.rel_l2));
    row(tr("95 % interval"), trf("{} to {}", share_text(facts.error.low), share_text(facts.error.high)));
    row(tr("samples"), fmt::format("{}", facts.error.samples));
  } else {
    ui_text(kUiDim, tr("nothing to measure"));
  }
  draw_request(facts, controls);
  if (facts.measures_knobs) return ui_text(kUiAmber, tr("measuring this machine ..."));
  if (facts.chosen) {
    const bool by_error = facts.quality.error > 0;
    row(tr("asked for"), by_error ? share_text(facts.quality.error) : ms_text(facts.quality.ms));
    row(tr("predicted"), share_text(facts.chosen->error));
    ImGui::PushTextWrapPos(0);
    ui_text(kUiDim, render::text_of(facts.chosen->knobs));
    ImGui::PopTextWrapPos();
    if (!by_error) return;
  } else {
    ImGui::SetNextItemWidth(-1);
    ImGui::SliderInt("##nodes", &controls.nodes, 1, 8, tr_printf("%d nodes a beam"), ImGuiSliderFlags_AlwaysClamp);
  }
  const char* divisors[] = {tr("every pixel"), tr("half resolution"), tr("quarter resolution")};
  int choice = controls.divisor == 4 ? 2 : controls.divisor - 1;
  ImGui::SetNextItemWidth(-1);
  if (ImGui::Combo("##divisor", &choice, divisors, 3)) controls.divisor = 1 << choice;
}

// The menu of a camera, after its button.
void draw_camera_menu(const PreviewFacts& facts, PreviewControls& controls, std::size_t index) {
  if (!ImGui::BeginPopupContextItem()) return;
  using What = CameraRequest::What;
  std::string& name = controls.camera_name;
  if (ImGui::IsWindowAppearing()) name = facts.cameras[index];
  std::array<char, 257> text{};
  name.copy(text.data(), text.size() - 1);
  ImGui::BeginDisabled(!facts.can_edit);
  const bool entered =
      ImGui::InputText(tr_label("name"), text.data(), text.size(), ImGuiInputTextFlags_EnterReturnsTrue);
  name = text.data();
  if (entered) controls.camera_request = {What::kRename, index, name};
  if (ImGui::Selectable(tr_label("store this view here"))) controls.camera_request = {What::kStore, index, {}};
  if (ImGui::Selectable(tr_label("delete this camera"))) controls.camera_request = {What::kDelete, index, {}};
  ImGui::EndDisabled();
  if (entered) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
}

// The slider's lower end is thinner than what is seen in any rig.
void draw_haze(const PreviewFacts& facts, PreviewControls& controls) {
  if (!facts.can_haze) return;
  ImGui::Checkbox(tr_label("haze"), &controls.haze);
  if (!controls.haze || facts.locked) return;
  ImGui::SameLine();
  ImGui::SetNextItemWidth(-1);
  auto haze = static_cast<float>(facts.room_haze_per_m);
  if (ImGui::SliderFloat("##haze per m", &haze, 0.0005f, 1, "%.4f /m",
                         ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp)) {
    controls.haze_per_m = static_cast<double>(haze);
  }
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip("%s", tr("Light that the room's haze scatters, per metre. Ctrl and a click: type."));
}

// A line below what cannot be moved.
void tell_lock(const PreviewFacts& facts) {
  if (!facts.locked) return;
  ImGui::PushTextWrapPos(0);
  ui_text(kUiDim, locked_words());
  ImGui::PopTextWrapPos();
}

void draw_flashes(const PreviewFacts& facts, PreviewControls& controls) {
  ImGui::SetNextItemWidth(-1);
  if (!ImGui::BeginCombo("##flashes", trf("harmful flashes: {}", tr(word_of(facts.flashes))).c_str())) return;
  for (const FlashMode mode : kFlashModes) {
    if (ImGui::Selectable(tr_label(words_of(mode)), mode == facts.flashes)) controls.flashes = mode;
  }
  ImGui::EndCombo();
}

void draw_view(const PreviewFacts& facts, PreviewControls& controls) {
  heading(tr("Camera"));
  for (std::size_t i = 0; i < facts.cameras.size() && i < kCamerasShown; ++i) {
    const std::string label = fmt::format("{} {}###camera{}", i + 1, facts.cameras[i], i);
    const float width = ImGui::CalcTextSize(label.c_str(), nullptr, true).x + 2 * ImGui::GetStyle().FramePadding.x;
    if (i > 0) {
      ImGui::SameLine();
      if (ImGui::GetContentRegionAvail().x < width) ImGui::NewLine();
    }
    if (ImGui::Button(label.c_str())) controls.camera = static_cast<int>(i);
    draw_camera_menu(facts, controls, i);
  }
  ImGui::Checkbox(tr_label("auto exposure"), &controls.auto_exposure);
  if (!controls.auto_exposure) {
    ImGui::SetNextItemWidth(-1);
    ImGui::SliderFloat("##ev", &controls.exposure_ev, -4, 16, tr_printf("exposure %.1f EV"));
  }
  ImGui::Checkbox(tr_label("white balance"), &controls.balances_white);
  if (controls.balances_white) {
    ImGui::SetNextItemWidth(-1);
    ImGui::SliderFloat("##white", &controls.white_k, static_cast<float>(render::kWhiteMinK),
                       static_cast<float>(render::kWhiteMaxK), tr_printf("white %.0f K"),
                       ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
  }
  ImGui::SetNextItemWidth(-1);
  if (ImGui::BeginCombo("##tone", trf("tone curve {}", render::word_of(controls.tone)).c_str())) {
    for (const render::ToneCurve tone : render::kToneCurves) {
      if (ImGui::Selectable(render::word_of(tone).data(), tone == controls.tone)) controls.tone = tone;
    }
    ImGui::EndCombo();
  }
  ImGui::SetNextItemWidth(-1);
  ImGui::SliderFloat("##glare", &controls.glare_percent, 0, 20, tr_printf("glare %.1f %%"),
                     ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
  draw_haze(facts, controls);
  if (facts.can_probes) {
    ImGui::Checkbox(tr_label("reflections"), &controls.probes);
    if (ImGui::IsItemHovered())
      ImGui::SetTooltip("%s", tr("What shiny floors, trusses and metals mirror of the stage, by reflection probes."));
  }
  draw_flashes(facts, controls);
  if (facts.machines > 0) {
    row(tr("haze of the room"), fmt::format("{:.4f} /m", facts.room_haze_per_m));
    row(tr("+ machines' haze"), fmt::format("{:.4f} /m", facts.machine_haze_per_m));
    row(tr("+ machines' fog"), fmt::format("{:.4f} /m", facts.machine_fog_per_m));
  }
  ImGui::Checkbox(tr_label("work light"), &controls.work_light);
  if (controls.work_light) {
    ImGui::SetNextItemWidth(-1);
    ImGui::SliderFloat("##work", &controls.work_light_lx, 1, 1000, "%.0f lx", ImGuiSliderFlags_Logarithmic);
  }
}

double seconds_of(DurationNs time_ns) { return static_cast<double>(time_ns) * 1e-9; }
TimeNs ns_of(float time_s) { return static_cast<TimeNs>(static_cast<double>(time_s) * 1e9); }

void draw_log(PreviewControls& controls) {
  heading(tr("Log"));
  Transport& transport = controls.transport;
  const double duration_s = seconds_of(transport.duration_ns);
  float time_s = controls.drag_s.value_or(static_cast<float>(seconds_of(transport.now_ns)));
  const TimeNs shown_ns = controls.drag_s ? ns_of(*controls.drag_s) : transport.now_ns;
  ImGui::SetNextItemWidth(-1);
  // The label is a format string for ImGui; it has no per cent sign.
  const std::string label = ui_format(trf("{} of {}", time_text(shown_ns), time_text(transport.duration_ns)));
  if (ImGui::SliderFloat("##time", &time_s, 0, static_cast<float>(std::max(duration_s, 0.1)), label.c_str(),
                         ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoInput)) {
    controls.drag_s = time_s;
    // A seek that is slow waits for the release.
    if (transport.is_quick(ns_of(time_s))) transport.seek_ns = ns_of(time_s);
  }
  if (ImGui::IsItemDeactivated() && controls.drag_s) {
    transport.seek_ns = ns_of(*std::exchange(controls.drag_s, std::nullopt));
  }
  if (ImGui::Button(transport.playing ? tr_label("pause", "play") : tr_label("play"),
                    {ImGui::GetTextLineHeight() * 4, 0})) {
    transport.playing = !transport.playing;
  }
  ImGui::SameLine();
  ImGui::Checkbox(tr_label("repeat"), &transport.repeats);
  if (transport.speed != 1) {
    ImGui::SameLine();
    ui_text(kUiAmber, fmt::format("x {}", transport.speed));
  }
}

const ImVec4& colour_of(PortState state) {
  switch (state) {
    case PortState::kWorking: return kUiGreen;
    case PortState::kGone: return kUiRed;
    case PortState::kWaiting:
    case PortState::kEnded: break;
  }
  return kUiAmber;
}

const char* word_of(PortState state) {
  switch (state) {
    case PortState::kWorking: return tr("working");
    case PortState::kGone: return tr("gone");
    case PortState::kWaiting: return tr("waiting");
    case PortState::kEnded: return tr("ended");
  }
  return "";
}

std::string age_text(DurationNs age_ns) {
  const double age_s = static_cast<double>(age_ns) * 1e-9;
  if (age_s < 1) return trf("{:.0f} ms ago", age_s * 1e3);
  if (age_s < 120) return trf("{:.1f} s ago", age_s);
  return trf("{:.0f} min ago", age_s / 60);
}

void draw_live(const PreviewFacts& facts, const LiveLevels& live) {
  heading(tr("Live"));
  for (const PortStatus& port : facts.status.ports) {
    if (port.is_sink) continue;  // the window itself
    const bool silent = is_silent(port, facts.status);
    ui_text(silent ? kUiRed : colour_of(port.state), port.name);
    const std::string figure = silent                              ? tr("silent")
                               : port.state == PortState::kWorking ? fmt::format("{:.0f} /s", port.rate_hz)
                                                                   : word_of(port.state);
    ImGui::SameLine(ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(figure.c_str()).x);
    ui_text(silent ? kUiRed : kUiText, figure);
    if (!port.trouble.empty()) {
      ImGui::PushTextWrapPos(0);
      ui_text(kUiRed, port.trouble);
      ImGui::PopTextWrapPos();
    }
  }
  const auto universes = live.universes();
  for (std::size_t i = 0; i < universes.size() && i < 32; ++i) {
    const FrameStamp& stamp = live.stamps()[i];
    const std::string word = trf("universe {}", universes[i]);
    const bool fed = live.fed(universes[i]);
    row(word.c_str(), !fed                  ? tr("no input")
                      : stamp.revision == 0 ? tr("no frames yet")
                                            : age_text(std::max<DurationNs>(facts.now_ns - stamp.stamp_ns, 0)));
  }
  if (universes.size() > 32)
    ui_text(kUiDim,
            trf_n("and {} more universe", "and {} more universes", universes.size() - 32, universes.size() - 32));
  if (!facts.notice.empty()) {
    ImGui::PushTextWrapPos(0);
    ui_text(kUiDim, facts.notice);
    ImGui::PopTextWrapPos();
  }
}

void draw_hand(const PreviewFacts& facts, PreviewControls& controls, HandLevels& hand) {
  heading(tr("Faders"));
  const std::string shown =
      controls.hand_fixture < 0 ? tr("all fixtures") : facts.fixtures[static_cast<std::size_t>(controls.hand_fixture)];
  ImGui::SetNextItemWidth(-1);
  if (ImGui::BeginCombo("##fixture", shown.c_str())) {
    if (ImGui::Selectable(tr_label("all fixtures"), controls.hand_fixture < 0)) controls.hand_fixture = -1;
    for (std::size_t i = 0; i < facts.fixtures.size(); ++i) {
      ImGui::PushID(static_cast<int>(i));
      if (ImGui::Selectable(facts.fixtures[i].c_str(), controls.hand_fixture == static_cast<int>(i))) {
        controls.hand_fixture = static_cast<int>(i);
      }
      ImGui::PopID();
    }
    ImGui::EndCombo();
  }
  // For all fixtures: uses the faders of the fixture that has the most.
  std::size_t index = 0;
  if (controls.hand_fixture >= 0) {
    index = static_cast<std::size_t>(controls.hand_fixture);
  } else {
    for (std::size_t i = 1; i < hand.fixture_count(); ++i) {
      if (hand.faders(i).size() > hand.faders(index).size()) index = i;
    }
  }
  if (index >= hand.fixture_count()) return;
  for (const Fader& fader : hand.faders(index)) {
    const std::string_view kind = fader.unit;
    const double unit = kind == "%" ? 0.01 : 1;
    const std::string format = fmt::format("{} %.0f{}", ui_format(tr(fader.name)),
                                           kind == "%"    ? " %%"
                                           : kind.empty() ? ""
                                                          : std::string(kind));
    auto value = static_cast<float>(fader.value / unit);
    ImGui::PushID(fader.name);
    ImGui::SetNextItemWidth(-1);
    if (ImGui::SliderFloat("##fader", &value, static_cast<float>(fader.from / unit),
                           static_cast<float>(fader.to / unit), format.c_str(), ImGuiSliderFlags_AlwaysClamp)) {
      for (std::size_t i = 0; i < hand.fixture_count(); ++i) {
        if (controls.hand_fixture < 0 || i == index) hand.set(i, fader.attribute, value * unit);
      }
    }
    ImGui::PopID();
  }
}

void draw_strip(const PreviewFacts& facts, const Transport& transport) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const float height = ImGui::GetTextLineHeight() + 8;
  ImGui::SetNextWindowPos({0, size.y - height});
  ImGui::SetNextWindowSize({size.x, height});
  ImGui::SetNextWindowBgAlpha(0.55f);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {8, 4});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1, 1});
  if (ImGui::Begin("strip", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs)) {
    double total_ms = 0;
    for (const auto& pass : facts.passes) total_ms += pass.gpu_ms;
    std::string words =
        trf("{}    {:.1f} fps    GPU {:.1f} ms    {} beams", facts.rig, facts.fps, total_ms, facts.live_beams);
    if (facts.has_log)
      words += fmt::format("    {} / {}", time_text(transport.now_ns), time_text(transport.duration_ns));
    if (facts.flashes_harmful || facts.flashes_held) {
      ui_text(kUiRed, flash_words(facts));
      ImGui::SameLine();
    }
    ui_text(words + tr("    H: panel  F1: keys"));
  }
  ImGui::End();
  ImGui::PopStyleVar(2);
}

}  // namespace

void draw_panel(const PreviewFacts& facts, PreviewControls& controls, const LiveLevels* live, HandLevels* hand,
                float scale, const std::function<void()>& menu) {
  if (controls.panel == PanelState::kStrip) draw_strip(facts, controls.transport);
  if (controls.panel != PanelState::kFull) return;
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const float width = kPanelWidth * scale;
  ImGui::SetNextWindowPos({size.x - width, 0});
  ImGui::SetNextWindowSize({width, size.y});
  constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                      ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoNav |
                                      ImGuiWindowFlags_MenuBar | ImGuiWindowFlags_NoBringToFrontOnFocus;
  if (ImGui::Begin("panel", nullptr, kFlags)) {
    if (ImGui::BeginMenuBar()) {
      menu();
      ImGui::EndMenuBar();
    }
    ui_text(kUiAmber, "FOOTLIGHT");
    ui_text(facts.rig);
    ImGui::PushTextWrapPos(0);
    ui_text(kUiDim, facts.device);
    if (facts.flashes_harmful || facts.flashes_held) ui_text(kUiRed, flash_words(facts));
    ImGui::PopTextWrapPos();
    if (facts.has_log) draw_log(controls);
    if (live != nullptr) draw_live(facts, *live);
    if (hand != nullptr) {
      ImGui::BeginDisabled(facts.locked);
      draw_hand(facts, controls, *hand);
      ImGui::EndDisabled();
      tell_lock(facts);
    }
    draw_view(facts, controls);
    draw_quality(facts, controls);
    draw_cost(facts);
    ui_text(kUiDim, tr("F1: keys and mouse"));
  }
  ImGui::End();
}

void draw_progress(const std::string& text) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const ImVec2 needed = ImGui::CalcTextSize(text.c_str());
  const ImVec2 at((size.x - needed.x) / 2, (size.y - needed.y) / 2);
  ImGui::GetForegroundDrawList()->AddText(at, ImGui::GetColorU32(kStageColours.text), text.c_str());
}

}  // namespace footlight::tools
