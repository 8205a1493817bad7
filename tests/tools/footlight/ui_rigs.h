// Rigs for the tests and the benchmark of the window's panels.
#pragma once

#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>

#include "fixtures/model/rig.h"

namespace footlight::testing {

// Three profiles and a par in universe 1, a par in universe 2, over a floor and before a wall.
inline constexpr const char* kUiRig = R"([rig]
name = "Panels"
[[fixture]]
name = "Spot {}"
type = "generic/profile"
universe = 1
address = 1
count = 3
position = [-3, 0, 5]
position_step = [3, 0, 0]
[[fixture]]
name = "Par"
type = "generic/par"
universe = 1
address = 301
position = [0, 2, 4]
[[fixture]]
name = "Far par"
type = "generic/par"
universe = 2
address = 508
position = [0, 20, 2]
[[box]]
name = "Wall"
min = [-20, 10, 0]
max = [20, 10.2, 8]
)";

struct UiRig {
  fixtures::Rig rig;
  fixtures::CompiledRig compiled;
};

// What these rigs are made of is right, or a test or benchmark is wrong.
template <class Value>
Value taken(Result<Value> result) {
  if (!result) {
    fmt::print(stderr, "{}\n", result.error().message);
    std::abort();
  }
  return std::move(*result);
}

inline UiRig compiled_rig(fixtures::Rig rig) {
  fixtures::CompiledRig compiled = taken(fixtures::compile(rig));
  return {std::move(rig), std::move(compiled)};
}

inline fixtures::Rig parsed_rig(const char* text) {
  return taken(fixtures::parse_rig(text, "ui.toml"));
}
// kUiRig with two cameras of its own.
inline fixtures::Rig rig_with_cameras() {
  fixtures::Rig made = parsed_rig(kUiRig);
  made.cameras.resize(2);
  made.cameras[0].name = "stalls";
  made.cameras[1].name = "wings";
  return made;
}

inline int slots_of(const fixtures::Rig& rig, std::size_t fixture) {
  return fixtures::mode_of(rig, rig.fixtures[fixture]).slot_count;
}

// `count` profiles side by side, as many in a universe as fit.
inline UiRig many_fixtures(int count) {
  fixtures::Rig rig = parsed_rig(kUiRig);
  const fixtures::PatchedFixture first = rig.fixtures[0];
  const int slots = slots_of(rig, 0);
  rig.fixtures.clear();
  const int fit = kSlotCountMax / slots;
  for (int i = 0; i < count; ++i) {
    fixtures::PatchedFixture one = first;
    one.name = fmt::format("Spot {}", i + 1);
    one.universe = 1 + i / fit;
    one.address = 1 + i % fit * slots;
    one.position_m = {i % 100, i / 100, 5};
    rig.fixtures.push_back(std::move(one));
  }
  return compiled_rig(std::move(rig));
}

}  // namespace footlight::testing
