// Which universes of a running program end on a line that carries RDM: devices put their lines in, gateways take them
// out. Safe from any thread.
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
  // Waits for the agents that were retired.
  ~RdmDirectory();
  struct Entry {
    // Another number where another device has taken over.
    std::uint64_t generation = 0;
    // The line, for one user of it at a time.
    std::function<std::unique_ptr<RdmLine>()> make_line;
  };

  // Replaces what was there. `is_gone`: the device has been closed for good; then nobody finds it any more.
  void put(Universe universe, std::function<std::unique_ptr<RdmLine>()> make_line, std::function<bool()> is_gone);
  // nullopt: the universe has no such line.
  [[nodiscard]] std::optional<Entry> find(Universe universe);
  // Stops an agent and returns at once: for the pump's thread, which must not wait for a line that is busy.
  void retire(std::unique_ptr<RdmAgent> agent);

 private:
  struct Held {
    Entry entry;
    std::function<bool()> is_gone;
  };
  std::mutex mutex_;
  std::map<Universe, Held> held_;  // guarded by mutex_
  std::uint64_t next_generation_ = 1;
  std::vector<std::unique_ptr<RdmAgent>> retired_;  // guarded by mutex_; those that have ended go with the next one
};

}  // namespace footlight::drivers
