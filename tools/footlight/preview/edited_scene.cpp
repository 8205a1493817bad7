#include "tools/footlight/preview/edited_scene.h"

#include <algorithm>
#include <utility>

#include "fixtures/edit/patch_slots.h"
#include "fixtures/simulate/vrsl_compat.h"
#include "tools/footlight/pictures/start_view.h"
#include "tools/footlight/preview/hand_levels.h"

namespace footlight::tools {

Result<std::unique_ptr<EditedScene>> EditedScene::make(RigFile file, const SceneFiles& files, double aspect,
                                                       bool by_hand) {
  std::unique_ptr<EditedScene> edited(new EditedScene(std::move(file)));
  edited->by_hand_ = by_hand;
  edited->base_ = edited->file_.rig();
  FL_TRY(adjust_scene_rig(edited->base_, files));
  add_start_view(edited->base_, aspect, true);
  FL_TRY(edited->remake());
  return edited;
}

Status EditedScene::remake() {
  const auto free = std::find_if(held_.begin(), held_.end(),
                                 [](const SharedScene& each) { return each.use_count() == 1 && !each->written; });
  SharedScene next = free != held_.end() ? *free : std::make_shared<PreviewScene>(PreviewScene{base_, {}, {}});
  next->rig.fixtures = file_.rig().fixtures;
  fixtures::share_conflicting_addresses(next->rig);
  if (by_hand_) give_hand_addresses(next->rig);
  if (scene_ && !scene_->written) next->rig.heard = scene_->compiled.universes;
  if (next->rig.vrsl && !by_hand_) next->written = std::exchange(next->rig, fixtures::vrsl_shown(next->rig));
  FL_ASSIGN(next->compiled, fixtures::compile(next->rig));
  if (free == held_.end()) held_.push_back(next);
  scene_ = std::move(next);
  // Those that somebody held for longer are not needed any more.
  if (scene_->written) held_.clear();
  return {};
}

}  // namespace footlight::tools
