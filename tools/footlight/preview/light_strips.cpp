#include "tools/footlight/preview/light_strips.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <variant>

namespace footlight::tools {
namespace {

// The mean light of a head since the last step, as linear RGB.
glm::vec3 light_of(const TraceRow& row) {
  float light = 0;
  glm::vec3 rgb(1);
  for (const auto& [column, value] : row) {
    const float* number = std::get_if<float>(&value);
    if (number == nullptr) continue;
    const std::string_view name(column);
    if (name == "light") light = *number;
    if (name == "red") rgb.r = *number;
    if (name == "green") rgb.g = *number;
    if (name == "blue") rgb.b = *number;
  }
  return glm::clamp(light * rgb, glm::vec3(0), glm::vec3(1));
}

// At most `most` of the values, evenly spread.
std::vector<std::size_t> some_of(const std::vector<std::size_t>& all, std::size_t most) {
  if (all.size() <= most) return all;
  std::vector<std::size_t> some;
  for (std::size_t i = 0; i < most; ++i) some.push_back(all[i * all.size() / most]);
  return some;
}

}  // namespace

LightStrips::LightStrips(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled) : trace_(rig, compiled) {
  std::vector<Strip> all(rig.types.size());
  for (std::size_t i = 0; i < rig.fixtures.size(); ++i) {
    const fixtures::PatchedFixture& fixture = rig.fixtures[i];
    Strip& strip = all[static_cast<std::size_t>(fixture.type)];
    strip.name = fixtures::type_of(rig, fixture).name;
    ++strip.fixtures;
    for (std::size_t head = compiled.head_first[i]; head < compiled.head_first[i + 1]; ++head) {
      strip.heads.push_back(head);
    }
  }
  std::erase_if(all, [](const Strip& strip) { return strip.heads.empty(); });
  std::stable_sort(all.begin(), all.end(), [](const Strip& a, const Strip& b) { return a.fixtures > b.fixtures; });
  if (all.size() > kStripsMax) all.resize(kStripsMax);
  std::vector<std::size_t> followed;
  for (Strip& strip : all) {
    strip.heads = some_of(strip.heads, kHeadsMax);
    followed.insert(followed.end(), strip.heads.begin(), strip.heads.end());
  }
  std::sort(followed.begin(), followed.end());
  trace_.follow(std::move(followed));
  strips_ = std::move(all);
}

void LightStrips::add(TimeNs at_ns, std::span<const std::uint8_t> levels) {
  if (!times_.empty() && at_ns <= times_.back()) return;
  trace_.step(levels, times_.empty() ? 0 : at_ns - times_.back(), true);
  times_.push_back(at_ns);
  for (Strip& strip : strips_) {
    glm::vec3 sum(0);
    for (const std::size_t head : strip.heads) sum += light_of(trace_.row(head, at_ns));
    strip.colours.push_back(sum / static_cast<float>(strip.heads.size()));
  }
}

}  // namespace footlight::tools
