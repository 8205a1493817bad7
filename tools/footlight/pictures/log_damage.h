// Damage of a log that is played: readers leave damaged parts out, and somebody has to be told.
#pragma once

#include <optional>
#include <string>

#include "sim/dmx_log/dmx_log.h"

namespace footlight::tools {

// One sentence with the file, where its first damaged part is, how many there are and what is left out. Empty: none.
[[nodiscard]] std::string damage_text(const std::string& path, const LogReader::DamageMet& met);

// Follows what all readers of a log have met. One thread; the readers may be used in others.
class DamageWatch {
 public:
  explicit DamageWatch(const LogReader& log) : reader_(log.again()) {}
  // Once, after the first damage.
  [[nodiscard]] std::string take_news();

 private:
  LogReader reader_;
  bool told_ = false;
};

// Prints one line on standard error when the command ends, if its log was damaged where it was read.
class DamageWarning {
 public:
  explicit DamageWarning(const std::optional<LogReader>& log);
  ~DamageWarning();
  DamageWarning(const DamageWarning&) = delete;
  DamageWarning& operator=(const DamageWarning&) = delete;

 private:
  std::optional<DamageWatch> watch_;
};

}  // namespace footlight::tools
