// Another log whose levels the window compares with its own, time by time. Needs no window. One thread.
#pragma once

#include <string>
#include <vector>

#include "sim/dmx_log/dmx_log.h"
#include "tools/footlight/monitor/level_moment.h"

namespace footlight::tools {

class ComparedLog {
 public:
  // log: of `path`, which read_level_log() reads in any format. universes: those of the rig, ascending; others are left
  // out. Those that were made up for faders do not belong here: nobody sends them.
  [[nodiscard]] static Result<ComparedLog> open(LogReader log, const std::string& path,
                                                std::vector<Universe> universes);

  // To the levels at any time of this log; before its start and after its end they are those there. Quick if the times
  // of calls ascend by seconds at most. Errors name the file; the moment is then some mixture.
  Status go_to(TimeNs time_ns);
  [[nodiscard]] const LevelMoment& moment() const { return moment_; }

  // After an edit of the rig.
  Status set_universes(std::vector<Universe> universes);

  [[nodiscard]] const std::string& name() const { return name_; }  // of the file, without its folder
  [[nodiscard]] DurationNs duration_ns() const { return info().duration_ns; }
  [[nodiscard]] const LogInfo& info() const { return reader_.info(); }
  [[nodiscard]] LogReader again() const { return reader_.again(); }  // another reader of it, at its start

 private:
  ComparedLog(LogReader reader, std::string name, std::vector<Universe> universes);
  void take(Universe universe, std::span<const std::uint8_t> levels);

  LogReader reader_;
  std::string name_;
  LevelMoment moment_;
  TimeNs now_ns_ = -1;    // of moment_; -1: nothing was read
  LogFrame next_;         // if has_next_: a frame that was read ahead
  bool has_next_ = false;
  bool at_end_ = false;  // there is no further frame
};

}  // namespace footlight::tools
