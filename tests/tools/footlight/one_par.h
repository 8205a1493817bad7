// A rig with one lamp over a floor, on a universe that the demo log does not have.
#pragma once

namespace footlight::testing {

inline constexpr const char* kOnePar = R"([rig]
name = "One par"
[haze]
scattering_per_m = 0.02
[[fixture]]
name = "Par"
type = "generic/par"
universe = 3
address = 1
position = [0, 0, 5]
[[box]]
name = "Floor"
min = [-4, -4, -0.1]
max = [4, 4, 0]
)";
inline constexpr const char* kFrontCamera = R"([[camera]]
name = "front"
position = [0, -9, 2]
target = [0, 0, 2]
)";

}  // namespace footlight::testing
