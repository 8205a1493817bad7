// The panels of the window. A panel is one file of this folder and one row of panels(): its key, its entry in the menu
// and its line in the list of keys follow. Panels read plain data and Dear ImGui, and know no Vulkan. A panel that is
// closed does not exist, so it costs nothing.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/dmx.h"
#include "sim/core/result.h"
#include "sim/pump.h"
#include "tools/footlight/preview/light_strips.h"
#include "tools/footlight/preview/ui/inputs_view.h"
#include "tools/footlight/preview/ui/messages.h"
#include "tools/footlight/preview/ui/outputs_view.h"
#include "tools/footlight/preview/ui/picture_shelf.h"
#include "tools/footlight/preview/ui/report_view.h"
#include "tools/footlight/preview/ui/thumbnails.h"
#include "tools/footlight/preview/ui/transport.h"
#include "tools/footlight/preview/ui/ui_desk.h"
#include "tools/footlight/preview/unpatched_levels.h"

namespace footlight::tools {

// What panels show and do not edit; valid during one picture.
struct UiInput {
  std::span<const std::uint8_t> levels;  // that the fixtures get: universes x 512, in the order of the compiled rig
  std::span<const FrameStamp> stamps;    // of live universes, in the same order; else empty
  const PumpStatus* status = nullptr;    // of live inputs; at most two seconds old
  const std::vector<UnpatchedUniverse>* unpatched = nullptr;  // that live inputs receive, too; may be missing
  TimeNs now_ns = 0;                     // on the clock of the stamps
  Transport* transport = nullptr;        // of the log that plays; its second part may be changed
  const LightCurve* curve = nullptr;     // of it; may be missing
  const LightCurve* selected_curve = nullptr;  // of the selected fixtures alone; null: none, or all are
  const LightStrips* strips = nullptr;   // of it; may be missing
  const Thumbnails* thumbnails = nullptr;  // of it; may be missing
  OutputsView* outputs = nullptr;        // to real lamps; its second part may be changed
  InputsView* inputs = nullptr;          // live ones; its second part may be changed
  const MessageLog* messages = nullptr;  // of the window
  ReportView* report = nullptr;          // of the picture; its second part may be changed
  PictureShelf* pictures = nullptr;      // small ones that panels draw; may be missing
  float scale = 1;                       // of the user interface
};

class Panel {
 public:
  Panel() = default;
  Panel(const Panel&) = delete;
  Panel& operator=(const Panel&) = delete;
  virtual ~Panel() = default;
  // Between the begin and end of its window.
  virtual void draw(UiDesk& desk, const UiInput& input) = 0;
  // As Timeline::Step: every step of the fixtures while the panel is open.
  virtual void step(std::span<const std::uint8_t>, std::int64_t, bool) {}
  // The fixtures begin anew, as a log that goes back does.
  virtual void restart() {}
};

// Where a panel opens.
struct PanelPlace {
  float left = 0;   // 0: at the left edge of the stage, 1: at the right one
  float top = 0;    // 0: at its top, 1: at its bottom
  float width = 0;  // units of the user interface at scale 1
  float height = 0;
  float height_share = 1;  // of the stage's height, at most
  bool has_scrollbar = false;  // always, so that nothing moves aside when it is needed
};

struct PanelInfo {
  const char* word;   // of --panels
  const char* title;  // also in the menu
  int key;            // GLFW_KEY_..., opens and closes it
  const char* key_text;
  const char* shows;  // for the list of keys
  PanelPlace place;
  std::unique_ptr<Panel> (*make)(UiDesk& desk);
};
[[nodiscard]] std::span<const PanelInfo> panels();
// The index of the panel of this word, which there is.
[[nodiscard]] std::size_t panel_of(std::string_view word);

[[nodiscard]] std::unique_ptr<Panel> make_universes_panel(UiDesk& desk);
[[nodiscard]] std::unique_ptr<Panel> make_fixtures_panel(UiDesk& desk);
[[nodiscard]] std::unique_ptr<Panel> make_inspector_panel(UiDesk& desk);
[[nodiscard]] std::unique_ptr<Panel> make_timeline_panel(UiDesk& desk);
[[nodiscard]] std::unique_ptr<Panel> make_devices_panel(UiDesk& desk);
[[nodiscard]] std::unique_ptr<Panel> make_library_panel(UiDesk& desk);
[[nodiscard]] std::unique_ptr<Panel> make_messages_panel(UiDesk& desk);
[[nodiscard]] std::unique_ptr<Panel> make_report_panel(UiDesk& desk);
[[nodiscard]] std::unique_ptr<Panel> make_keys_panel(UiDesk& desk);

// Which panels are open.
class UiPanels {
 public:
  UiPanels();
  [[nodiscard]] bool is_open(std::size_t index) const { return open_[index] != nullptr; }
  [[nodiscard]] bool any_open() const;
  void set_open(std::size_t index, bool open, UiDesk& desk);
  // "universes,inspector". kBadInput names the words there are.
  Status open_words(std::string_view words, UiDesk& desk);

  // Over a stage of this size in units of the user interface.
  void draw(UiDesk& desk, const UiInput& input, float stage_width, float stage_height);
  void step(std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure);
  void restart();
  // While the fixtures that move are not those that the panels show: step() does nothing.
  void pause(bool pauses) { pauses_ = pauses; }

 private:
  std::vector<std::unique_ptr<Panel>> open_;  // as panels(); null: closed
  bool pauses_ = false;
};

// Whether the words name panels only; for the command line.
[[nodiscard]] Status check_panel_words(std::string_view words);

}  // namespace footlight::tools
