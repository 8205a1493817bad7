#include "drivers/rdm/rdm_directory.h"

#include <utility>

namespace footlight::drivers {

RdmDirectory::~RdmDirectory() = default;

void RdmDirectory::retire(std::unique_ptr<RdmAgent> agent) {
  agent->request_stop();
  const std::lock_guard lock(mutex_);
  std::erase_if(retired_, [](const auto& one) { return one->has_ended(); });
  retired_.push_back(std::move(agent));
}

void RdmDirectory::put(Universe universe, std::function<std::unique_ptr<RdmLine>()> make_line,
                       std::function<bool()> is_gone) {
  const std::lock_guard lock(mutex_);
  held_[universe] = {{next_generation_++, std::move(make_line)}, std::move(is_gone)};
}

std::optional<RdmDirectory::Entry> RdmDirectory::find(Universe universe) {
  const std::lock_guard lock(mutex_);
  const auto found = held_.find(universe);
  if (found == held_.end()) return std::nullopt;
  if (!found->second.is_gone()) return found->second.entry;
  held_.erase(found);
  return std::nullopt;
}

}  // namespace footlight::drivers
