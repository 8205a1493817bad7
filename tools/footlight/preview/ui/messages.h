// What the window says: notices and errors. The newest ones are short-lived boxes over the stage; the panel of messages
// has the last of them. Knows neither a window nor Dear ImGui.
#pragma once

#include <cstddef>
#include <deque>
#include <string>
#include <vector>

#include "sim/core/clock.h"

namespace footlight::tools {

struct Message {
  std::string text;
  std::string time;     // of day, of the newest of its kind: "20:15:07"
  bool wrong = false;   // an error: the user may have to act
  int count = 1;        // the same again, one after the other
  TimeNs until_ns = 0;  // its box is over the stage
};

class MessageLog {
 public:
  static constexpr std::size_t kKeptMax = 200;
  static constexpr std::size_t kBoxesMax = 4;
  static constexpr DurationNs kShownNs = 4 * kNsPerS;
  static constexpr DurationNs kWrongNs = 10 * kNsPerS;  // errors stay longer

  // The same text as the last message only counts it, and shows it anew.
  void add(std::string text, bool wrong, std::string time, TimeNs now_ns);
  // Those whose box is shown now, oldest first.
  [[nodiscard]] std::vector<const Message*> shown(TimeNs now_ns) const;
  [[nodiscard]] const std::deque<Message>& all() const { return messages_; }  // oldest first

 private:
  std::deque<Message> messages_;
};

// "nothing to undo (3 times)".
[[nodiscard]] std::string text_of(const Message& message);

}  // namespace footlight::tools
