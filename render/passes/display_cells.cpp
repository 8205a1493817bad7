#include "render/passes/display_cells.h"

#include <algorithm>
#include <utility>

#include "shaders/displaycells.comp.h"

namespace footlight::render {
namespace {

constexpr std::uint32_t kGroupsMost = 65'535;  // of a dispatch, on any device with Vulkan

}  // namespace

Result<DisplayCells> DisplayCells::create(const PassContext& context) {
  FL_ASSIGN(BoundPipeline pipeline, BoundPipeline::compute(context, kDisplaycellsComp, {}));
  return DisplayCells(std::move(pipeline), context.resources.rig);
}

DisplayCells::DisplayCells(BoundPipeline pipeline, RigTables& rig)
    : pipeline_(std::move(pipeline)), rig_(&rig), still_(rig.display_still) {}

void DisplayCells::record(VkCommandBuffer commands) {
  if (std::exchange(rig_->display_cells_fresh, true)) return;
  record_jobs(commands, still_);
  still_.clear();  // images stay
  if (std::exchange(rig_->display_films_new, false)) record_jobs(commands, rig_->display_film);
  record_jobs(commands, rig_->display_live);
}

// Each level that is stored is made of the one below.
void DisplayCells::record_jobs(VkCommandBuffer commands, const DisplayJobs& jobs) {
  for (const DisplayJobRange& range : jobs) {
    pipeline_.bind(commands);
    for (std::uint32_t done = 0; done < range.count; done += kGroupsMost) {
      const std::uint32_t first = range.first + done;
      pipeline_.pipeline->push(commands, std::as_bytes(std::span(&first, 1)));
      vkCmdDispatch(commands, std::min(range.count - done, kGroupsMost), 1, 1);
    }
    vk::full_barrier(commands);
  }
}

}  // namespace footlight::render
