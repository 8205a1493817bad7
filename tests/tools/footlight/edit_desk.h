// A desk whose rig can be edited, as the window has it.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "fixtures/files/import/import_rig.h"
#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/edited_scene.h"
#include "tools/footlight/preview/ui/ui_desk.h"

namespace footlight::testing {

struct EditDesk {
  explicit EditDesk(fixtures::Rig rig, bool by_hand = false)
      : scene(taken(tools::EditedScene::make(
            tools::RigFile::made(fixtures::as_imported(std::move(rig), "toml"), "not_written.toml"), {}, 1.5,
            by_hand))),
        desk(scene->scene()->rig, scene->scene()->compiled) {
    desk.let_edit(scene->file().rig(), [this]() -> Status {
      FL_TRY(scene->remake(desk.state().ids, desk.state().revision, shown));
      desk.show(scene->scene()->rig, scene->scene()->compiled);
      return {};
    });
  }
  [[nodiscard]] const fixtures::PatchedFixture& fixture(std::size_t index) const {
    return desk.edited().fixtures[index];
  }
  [[nodiscard]] std::string patch(std::size_t index) const { return fixtures::text_of_patch(fixture(index)); }

  std::unique_ptr<tools::EditedScene> scene;
  tools::UiDesk desk;
  tools::SharedScene shown;  // by the picture; null: there is none
};

}  // namespace footlight::testing
