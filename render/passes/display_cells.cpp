#include "render/passes/display_cells.h"

#include <utility>

#include "shaders/displaycells.comp.h"

namespace footlight::render {

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

// Each level is made of the one below.
void DisplayCells::record_jobs(VkCommandBuffer commands, const DisplayJobs& jobs) {
  for (const DisplayJobRange& range : jobs) {
    pipeline_.bind(commands);
    pipeline_.pipeline->push(commands, std::as_bytes(std::span(&range.first, 1)));
    vkCmdDispatch(commands, range.count, 1, 1);
    vk::full_barrier(commands);
  }
}

}  // namespace footlight::render
