// The options of a scene that change its rig.
#include <algorithm>

#include "fixtures/model/lamp.h"
#include "fixtures/model/smoothing.h"
#include "tools/footlight/pictures/scene_files.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {

Status adjust_scene_rig(fixtures::Rig& rig, const SceneFiles& files) {
  if (files.vrsl && !files.demo && !rig.vrsl) rig.vrsl.emplace();
  rig.haze.scattering_per_m = files.haze_per_m.value_or(rig.haze.scattering_per_m);
  if (files.haze_noise) {
    constexpr glm::dvec3 kDraught{0.2, 0.05, 0.02};
    rig.haze.noise = *files.haze_noise;
    if (rig.haze.wind_m_s == glm::dvec3(0)) rig.haze.wind_m_s = kDraught;
  }
  if (!files.plumes.empty() && files.plumes != "on" && files.plumes != "off") {
    return fail(ErrorCode::kBadInput, "--plumes {}: expected on or off", printable_utf8(files.plumes));
  }
  if (!files.plumes.empty()) rig.room.plumes = files.plumes == "on";
  rig.room.volume_m3 = files.volume_m3.value_or(rig.room.volume_m3);
  if (!files.smooth.empty()) {
    FL_ASSIGN(const auto smoothing, fixtures::parse_smoothing(files.smooth));
    for (auto& type : rig.types) type.smoothing = smoothing;
  }
  if (!files.dimmer_law.empty()) {
    const auto& words = fixtures::dimmer_law_words();
    const auto table = words.end() - 1;
    const auto word = std::find(words.begin(), table, files.dimmer_law);
    if (word == table) {
      return fail(ErrorCode::kBadInput, "--dimmer-law '{}': expected {}, {}, {} or {}", files.dimmer_law, words[0],
                  words[1], words[2], words[3]);
    }
    for (auto& type : rig.types) type.dimmer_law = static_cast<fixtures::DimmerLaw>(word - words.begin());
  }
  return {};
}

}  // namespace footlight::tools
