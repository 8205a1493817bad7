// Cells of displays: computed once a frame, by the first pass that reads them.
#pragma once

#include "render/passes/compute_pass.h"

namespace footlight::render {

class DisplayCells {
 public:
  // The resources must live as long.
  [[nodiscard]] static Result<DisplayCells> create(const PassContext& context);

  // Records nothing if the cells of this frame are there. Those of images are computed once.
  void record(VkCommandBuffer commands);

 private:
  DisplayCells(BoundPipeline pipeline, RigTables& rig);
  void record_jobs(VkCommandBuffer commands, const DisplayJobs& jobs);

  BoundPipeline pipeline_;
  RigTables* rig_;
  DisplayJobs still_;
};

}  // namespace footlight::render
