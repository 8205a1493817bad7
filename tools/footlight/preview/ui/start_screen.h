// What the window shows as long as there is no rig: the demo, recent files, a dialog, and a place to drop files. Dear
// ImGui only.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/core/result.h"
#include "tools/footlight/preview/ui/file_dialog.h"

namespace footlight::tools {

struct StartChoice {
  bool demo = false;  // the built-in rig
  std::string rig;    // else a file
  std::string log;    // empty: none; with the demo its own
  bool operator==(const StartChoice&) const = default;
};

class StartScreen {
 public:
  // recent: paths, the newest first. log: plays with whatever rig is opened; empty: none.
  StartScreen(std::vector<std::string> recent_rigs, std::vector<std::string> recent_logs, std::string log);

  // The dialog, at the next draw().
  void open_dialog();
  // Fields and dialogs have the keys.
  [[nodiscard]] bool has_keys() const { return dialog_.is_open(); }
  // Files that were dropped. A rig, or a definition, is the choice; a log waits for a rig. The error of one that is
  // neither is also shown.
  Status take_files(const std::vector<std::string>& paths);
  // A message, in red.
  void say(std::string trouble) { trouble_ = std::move(trouble); }
  // Once a picture, over the whole window, until the user has chosen.
  [[nodiscard]] std::optional<StartChoice> draw(float scale);

  [[nodiscard]] const std::string& log() const { return log_; }

 private:
  void choose_rig(const std::string& path);
  void draw_buttons();
  void draw_recent(const char* title, const std::vector<std::string>& paths, bool rigs);

  std::vector<std::string> recent_rigs_;
  std::vector<std::string> recent_logs_;
  std::string log_;
  std::string trouble_;
  FileDialog dialog_;
  std::optional<StartChoice> chosen_;
};

}  // namespace footlight::tools
