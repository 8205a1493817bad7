// Questions of the window: before it closes with unsaved edits, and about edits of a session that was lost. Dear ImGui
// only.
#pragma once

#include <optional>
#include <string>

namespace footlight::tools {

// Of a modal question that is open: in the middle of the window and within it, whatever its text. What does not fit
// scrolls. As ImGui::BeginPopupModal().
[[nodiscard]] bool begin_question(const char* title);

enum class CloseAnswer { kSave, kDiscard, kStay };

// In the middle of the window, over everything else, from the first call of draw() until an answer. Esc means to stay.
class CloseQuestion {
 public:
  // target: where the rig would be saved. error: why it could not be; else empty.
  [[nodiscard]] std::optional<CloseAnswer> draw(const std::string& target, const std::string& error);

 private:
  bool open_ = false;
};

enum class OpenAnswer { kOpen, kCompare, kStay };

// Whether another rig or log is opened instead, from the first call of draw() until an answer. Esc means to stay.
class OpenQuestion {
 public:
  // what: "Open show.mvr?". then: what happens with a yes. compares: it is a log, which may be compared with.
  [[nodiscard]] std::optional<OpenAnswer> draw(const std::string& what, const std::string& then, bool compares);

 private:
  bool open_ = false;
};

enum class RecordedAnswer { kPlay, kClose };
// A line at the top of the window, after a recording has ended. name: of its file.
[[nodiscard]] std::optional<RecordedAnswer> draw_recorded(const std::string& name, float scale);

enum class LostAnswer { kRecover, kKeep, kDiscard };
// A line at the top of the window. when: "12:31, 26 November". older: the file was saved or changed since.
[[nodiscard]] std::optional<LostAnswer> draw_lost_edits(const std::string& when, bool older, float scale);

}  // namespace footlight::tools
