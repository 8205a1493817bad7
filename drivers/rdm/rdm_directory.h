// The universes of a running program that end on a line with RDM: devices register their lines, gateways look them up.
// Safe from any thread.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "drivers/rdm/rdm_agent.h"
#include "drivers/rdm/rdm_line.h"
#include "sim/core/dmx.h"

namespace footlight::drivers {

class RdmDirectory {
 public:
  // Waits for the retired agents.
  ~RdmDirectory();
  struct Entry {
    // Changes when another device has taken over.
    std::uint64_t generation = 0;
    // Makes the line, for one user of it at a time.
    std::function<std::unique_ptr<RdmLine>()> make_line;
  };

  // Replaces an earlier entry. `is_gone`: true after the device was closed for good; then find() no longer returns it.
  void put(Universe universe, std::function<std::unique_ptr<RdmLine>()> make_line, std::function<bool()> is_gone);
  // nullopt: the universe has no such line.
  [[nodiscard]] std::optional<Entry> find(Universe universe);
  // Stops an agent and returns at once: for the pump's thread, which must not wait for a busy line.
  void retire(std::unique_ptr<RdmAgent> agent);

 private:
  struct Held {
    Entry entry;
    std::function<bool()> is_gone;
  };
  std::mutex mutex_;
  std::map<Universe, Held> held_;  // guarded by mutex_
  std::uint64_t next_generation_ = 1;
  std::vector<std::unique_ptr<RdmAgent>> retired_;  // guarded by mutex_; ended ones are removed with the next call
};

}  // namespace footlight::drivers
