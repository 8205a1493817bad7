#include "tools/footlight/pictures/log_damage.h"

#include <cstdio>

#include "sim/core/counted.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {

std::string damage_text(const std::string& path, const LogReader::DamageMet& met) {
  if (met.count == 0) return "";
  const char* const more = met.count == kLogDamageCountedMax ? " or more" : "";
  return fmt::format(
      "{}: damaged at byte {}: {}{} of {} bytes left out, where levels stay as they were; 'footlight log "
      "info {}' lists them",
      path, met.first.front().offset, counted(met.count, "part"), more, met.bytes, path);
}

std::string DamageWatch::take_news() {
  if (told_) return "";
  std::string text = damage_text(reader_.info().path, reader_.damage_met());
  told_ = !text.empty();
  return text;
}

DamageWarning::DamageWarning(const std::optional<LogReader>& log) {
  if (log) watch_.emplace(*log);
}

DamageWarning::~DamageWarning() {
  if (!watch_) return;
  const std::string text = watch_->take_news();
  if (!text.empty()) std::fputs(("footlight: " + printable_line(text) + "\n").c_str(), stderr);
}

}  // namespace footlight::tools
