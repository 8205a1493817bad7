// Levels from the wire: sources on a pump with a thread of its own, and snapshots for whoever draws.
//
// take() and the readers beside it belong to one thread; none of them waits for the pump or for the wire.
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

namespace footlight::tools {

class LiveLevels {
 public:
  // `universes`: those of a rig, ascending, once each. The clock may be asked from any thread and outlives this.
  // kBadInput where there is no universe to listen to; the waiter's errors.
  [[nodiscard]] static Result<std::unique_ptr<LiveLevels>> start(std::span<const Universe> universes,
                                                                 std::vector<std::unique_ptr<Source>> sources,
                                                                 Clock& clock);
  // Stops the pump and waits for its thread.
  ~LiveLevels();
  LiveLevels(const LiveLevels&) = delete;
  LiveLevels& operator=(const LiveLevels&) = delete;

  // Copies out what was written since the last call.
  void take();
  // As of the last take(): universes().size() x 512 levels, and a stamp for each.
  [[nodiscard]] std::span<const std::uint8_t> levels() const { return levels_; }
  [[nodiscard]] std::span<const FrameStamp> stamps() const { return stamps_; }
  [[nodiscard]] std::span<const Universe> universes() const { return universes_->numbers(); }
  // Whether a source brings this universe at all.
  [[nodiscard]] bool fed(Universe universe) const;

  // What a timeline of pictures reads: every change with its time, on the clock of start(). Its reader is the thread
  // of take(); it ends with this.
  [[nodiscard]] LevelChanges& changes() { return *trail_; }

  // One or two seconds old.
  [[nodiscard]] PumpStatus status() const { return pump_->latest_status(); }
  // What has happened since the last call: a port lost or back. At most the last 64.
  [[nodiscard]] std::vector<std::string> notices();

 private:
  LiveLevels() = default;

  std::unique_ptr<Universes> universes_;
  std::unique_ptr<Waiter> waiter_;
  std::vector<std::unique_ptr<Source>> sources_;
  std::vector<Universe> fed_;  // ascending
  std::unique_ptr<SnapshotTrail> trail_;
  std::unique_ptr<Pump> pump_;
  std::vector<std::uint8_t> levels_;
  std::vector<FrameStamp> stamps_;
  std::mutex mutex_;
  std::vector<std::string> notices_;  // guarded by mutex_
  std::jthread thread_;
};

}  // namespace footlight::tools
