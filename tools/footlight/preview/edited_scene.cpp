#include "tools/footlight/preview/edited_scene.h"

#include <algorithm>
#include <iterator>
#include <unordered_map>
#include <utility>

#include "fixtures/displays/pixel_slots.h"
#include "fixtures/displays/screens.h"
#include "fixtures/edit/patch_slots.h"
#include "fixtures/simulate/vrsl_compat.h"
#include "tools/footlight/pictures/start_view.h"
#include "tools/footlight/preview/ui/rig_index.h"

namespace footlight::tools {
namespace {

// Ascending, each once.
std::vector<Universe> used_universes(const fixtures::Rig& rig) {
  std::vector<Universe> used;
  for (const fixtures::PatchedFixture& fixture : rig.fixtures) {
    if (!fixture.patched) continue;
    used.push_back(fixture.universe);
    for (const auto& further : fixture.further_addresses) used.push_back(further.universe);
  }
  for (const fixtures::PixelSlots& pixels : fixtures::pixel_slots(rig)) used.push_back(pixels.universe);
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  return used;
}

}  // namespace

std::vector<Universe> logged_universes(const PreviewScene& scene) {
  if (scene.written) return scene.compiled.universes;  // addresses are those that VRSL listens to
  std::vector<Universe> logged;
  std::set_intersection(scene.compiled.universes.begin(), scene.compiled.universes.end(), scene.own_universes.begin(),
                        scene.own_universes.end(), std::back_inserter(logged));
  return logged;
}

Result<std::unique_ptr<EditedScene>> EditedScene::make(RigFile file, const SceneFiles& files, double aspect,
                                                       bool by_hand) {
  std::unique_ptr<EditedScene> edited(new EditedScene(std::move(file), files));
  edited->by_hand_ = by_hand;
  edited->base_ = edited->file_.rig();
  FL_TRY(adjust_scene_rig(edited->base_, files));
  add_start_view(edited->base_, aspect, true);
  FL_TRY(edited->remake());
  return edited;
}

std::vector<int> fixture_moves(const PreviewScene& from, const PreviewScene& to) {
  std::unordered_map<int, int> index_of;
  for (std::size_t i = 0; i < to.ids.size(); ++i) index_of[to.ids[i]] = static_cast<int>(i);
  std::vector<int> moves;
  moves.reserve(from.ids.size());
  for (const int id : from.ids) {
    const auto at = index_of.find(id);
    moves.push_back(at == index_of.end() ? -1 : at->second);
  }
  return moves;
}

void darken_deleted(const PreviewScene& from, const PreviewScene& to, std::span<std::uint8_t> levels) {
  const std::vector<int> moves = fixture_moves(from, to);
  if (std::find(moves.begin(), moves.end(), -1) == moves.end()) return;
  const RigIndex slots(from.rig, from.compiled);
  const std::vector<std::uint8_t> before(levels.begin(), levels.end());
  const auto for_channels = [&](bool deleted, auto act) {
    for (std::size_t i = 0; i < moves.size(); ++i) {
      if ((moves[i] < 0) != deleted) continue;
      const auto channels = fixtures::mode_of(from.rig, from.rig.fixtures[i]).channels.size();
      for (std::size_t c = 0; c < channels; ++c) {
        const ChannelKey key{static_cast<int>(i), static_cast<int>(c)};
        if (slots.place(key)) act(key);
      }
    }
  };
  for_channels(true, [&](ChannelKey key) { slots.write(key, 0, levels); });
  for_channels(false, [&](ChannelKey key) { slots.write(key, slots.read(key, before), levels); });
}

std::unique_ptr<HandLevels> moved_hand(const HandLevels& hand, const PreviewScene& from, const PreviewScene& to) {
  auto next = std::make_unique<HandLevels>(to.rig, to.compiled);
  const HandLevels untouched(from.rig, from.compiled);
  const std::vector<int> moves = fixture_moves(from, to);
  for (std::size_t i = 0; i < moves.size(); ++i) {
    if (moves[i] < 0) continue;
    const auto usual = untouched.faders(i);
    const auto faders = hand.faders(i);
    for (std::size_t f = 0; f < faders.size(); ++f) {
      if (faders[f].value == usual[f].value) continue;
      next->set(static_cast<std::size_t>(moves[i]), faders[f].attribute, faders[f].value);
    }
  }
  return next;
}

// After an edit that added types to the rig or took them back.
Status EditedScene::follow_types() {
  fixtures::follow_types(file_.imported());
  const auto& types = file_.rig().types;
  if (types.size() == base_.types.size()) return {};
  ++types_;
  if (types.size() < base_.types.size()) {
    base_.types.resize(types.size());
    return {};
  }
  fixtures::Rig added;
  added.types.assign(types.begin() + static_cast<std::ptrdiff_t>(base_.types.size()), types.end());
  FL_TRY(adjust_scene_rig(added, files_));
  for (fixtures::FixtureType& type : added.types) base_.types.push_back(std::move(type));
  return {};
}

Status EditedScene::remake(std::vector<int> ids, std::uint64_t revision, const SharedScene& shown) {
  FL_TRY(follow_types());
  if (shown && shown->revision == revision) {
    scene_ = shown;
    return {};
  }
  const auto free = std::find_if(held_.begin(), held_.end(),
                                 [](const SharedScene& each) { return each.use_count() == 1 && !each->written; });
  SharedScene next =
      free != held_.end() ? *free : std::make_shared<PreviewScene>(PreviewScene{base_, {}, {}, types_, 0, {}, {}});
  next->rig.fixtures = file_.rig().fixtures;
  if (std::exchange(next->types, types_) != types_) next->rig.types = base_.types;
  fixtures::place_screens(next->rig);
  next->revision = revision;
  next->ids = std::move(ids);
  for (std::size_t i = next->ids.size(); i < next->rig.fixtures.size(); ++i) next->ids.push_back(static_cast<int>(i));
  fixtures::share_conflicting_addresses(next->rig);
  next->own_universes = used_universes(next->rig);
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
