#include "tools/footlight/preview/ui/messages.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {

void MessageLog::add(std::string text, bool wrong, std::string time, TimeNs now_ns) {
  const TimeNs until_ns = now_ns + (wrong ? kWrongNs : kShownNs);
  if (!messages_.empty() && messages_.back().text == text && messages_.back().wrong == wrong) {
    Message& last = messages_.back();
    ++last.count;
    last.time = std::move(time);
    last.until_ns = until_ns;
    return;
  }
  if (messages_.size() == kKeptMax) messages_.pop_front();
  messages_.push_back({std::move(text), std::move(time), wrong, 1, until_ns});
}

std::vector<const Message*> MessageLog::shown(TimeNs now_ns) const {
  std::vector<const Message*> shown;
  for (auto at = messages_.rbegin(); at != messages_.rend() && shown.size() < kBoxesMax; ++at) {
    if (now_ns < at->until_ns) shown.push_back(&*at);
  }
  std::reverse(shown.begin(), shown.end());
  return shown;
}

std::string text_of(const Message& message) {
  return message.count == 1 ? message.text
                            : trf_n("{} ({} time)", "{} ({} times)", message.count, message.text, message.count);
}

}  // namespace footlight::tools
