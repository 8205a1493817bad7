// Live levels: sources on a pump with its own thread, and snapshots for the drawing thread.
//
// take() and the functions that read its result belong to one thread; none of them waits for the pump or an input.
#pragma once

#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/ports.h"
#include "sim/pump.h"
#include "sim/snapshot_trail.h"
#include "sim/universes.h"
#include "tools/footlight/preview/unpatched_levels.h"

namespace footlight::tools {

class LiveLevels {
 public:
  // `universes`: those of a rig, ascending, once each. The clock must be thread-safe and outlive this. Errors:
  // kBadInput if there are no universes; those of the waiter.
  [[nodiscard]] static Result<std::unique_ptr<LiveLevels>> start(std::span<const Universe> universes,
                                                                 std::vector<std::unique_ptr<Source>> sources,
                                                                 Clock& clock);
  // Stops the pump and waits for its thread.
  ~LiveLevels();
  LiveLevels(const LiveLevels&) = delete;
  LiveLevels& operator=(const LiveLevels&) = delete;

  // One more source, while the pump runs.
  void add(std::unique_ptr<Source> source);

  // The pump that runs, for ports that come and go.
  [[nodiscard]] Pump& pump() { return *pump_; }

  // Copies the snapshots that changed since the last call.
  void take();
  // As of the last take(): universes().size() x 512 levels, and a stamp for each.
  [[nodiscard]] std::span<const std::uint8_t> levels() const { return levels_; }
  [[nodiscard]] std::span<const FrameStamp> stamps() const { return stamps_; }
  [[nodiscard]] std::span<const Universe> universes() const { return universes_->numbers(); }
  // True if a source receives this universe.
  [[nodiscard]] bool fed(Universe universe) const;

  // Universes that arrive and are not among universes(): as UnpatchedLevels::take().
  void take_unpatched(std::vector<UnpatchedUniverse>& into) { unpatched_->take(into); }

  // The input of a timeline: every change with its time, on the clock of start(). Only for the thread of take(); valid
  // as long as this object.
  [[nodiscard]] LevelChanges& changes() { return *trail_; }

  // At most two seconds old.
  [[nodiscard]] PumpStatus status() const { return pump_->latest_status(); }
  // Notices since the last call, such as a port lost or back. At most the last 64.
  [[nodiscard]] std::vector<std::string> notices();

 private:
  LiveLevels() = default;
  void keep(std::unique_ptr<Source> source);

  std::unique_ptr<Universes> universes_;
  std::unique_ptr<Waiter> waiter_;
  std::vector<std::unique_ptr<Source>> sources_;
  std::vector<Universe> fed_;  // ascending
  std::vector<const Source*> named_;  // sources_, for the pump's thread
  std::unique_ptr<UnpatchedLevels> unpatched_;
  std::unique_ptr<SnapshotTrail> trail_;
  std::unique_ptr<Pump> pump_;
  std::vector<std::uint8_t> levels_;
  std::vector<FrameStamp> stamps_;
  std::mutex mutex_;
  std::vector<std::string> notices_;  // guarded by mutex_
  std::jthread thread_;
};

}  // namespace footlight::tools
