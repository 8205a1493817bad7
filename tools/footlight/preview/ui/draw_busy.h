// Shows over the stage why the picture waits, once that has lasted for half a second. Dear ImGui only.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "sim/core/clock.h"
#include "tools/footlight/preview/ui/transport.h"

namespace footlight::tools {

enum class BusyWith { kNothing, kSeek, kEdit, kKnobs, kShaders, kLog };

struct Busy {
  BusyWith with = BusyWith::kNothing;
  std::string words;            // of a line
  std::optional<double> share;  // 0 to 1, of it that is done; nothing: not known
  bool can_cancel = false;      // by the button and by Esc
};

// What other threads and the log's player are doing.
struct BusyWork {
  std::optional<double> knobs_share;  // 0 to 1: curves of knobs are being measured
  bool makes_frame = false;           // of an edited rig
  bool undone = false;                // the rig is again the one that the picture shows
  bool can_undo = false;              // the edit is the newest command
  std::optional<Transport::Seeking> seeking;
  bool compiles = false;  // what a frame of other settings needs
  std::optional<std::string> reads_log;  // the path of a log to compare with
};
// What is shown of it, and cancelled: a measurement and edits come first, since fixtures and a seek stand still
// meanwhile.
[[nodiscard]] Busy busy_of(const BusyWork& work);
// The picture waits for a seek through a log.
[[nodiscard]] Busy busy_with(const Transport::Seeking& seeking);

// Before the first picture of the stage, in its middle and under all panels: that shaders are compiled. pictures: that
// are done; with one there is nothing. waited_ns: since the frame is there. How many shaders are left is not known:
// drivers compile some of them only while the first picture is drawn.
void draw_first_wait(std::uint64_t pictures, DurationNs waited_ns, float stage_width);

class BusyMark {
 public:
  static constexpr DurationNs kPatienceNs = kNsPerS / 2;

  // Draws it at the top of the stage, below y, or nothing yet. True: the user presses the button that cancels.
  [[nodiscard]] bool draw(const Busy& busy, TimeNs now_ns, float stage_width, float y, float scale);
  // Something is drawn that Esc cancels.
  [[nodiscard]] bool can_cancel() const { return can_cancel_; }

 private:
  BusyWith with_ = BusyWith::kNothing;
  TimeNs since_ns_ = 0;
  bool can_cancel_ = false;
};

}  // namespace footlight::tools
