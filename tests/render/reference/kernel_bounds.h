// The allowed errors of the kernels in the extreme cases.
#pragma once

#include <array>

namespace footlight::render::cases {

// Largest relL2 of n Gauss nodes, n = 2, 3, 4, 5, 8, for the profiles m = 1 and m = 4: the value measured in double
// plus a tenth, because the rays are fixed and only rounding can change it. `rounding`: the additional error of float,
// measured, times 3, because compilers round differently. `soft`: 5 nodes, the worst of m = 1/2, 1/3 and 1/4.
struct Bound {
  const char* name;
  double rounding;
  std::array<double, 5> smooth;
  std::array<double, 5> flat;
  double soft;
};

// In the order of names(): case, rounding; m = 1; m = 4; soft.
inline constexpr Bound kBounds[] = {
    {"generic", 3.6e-6, {6.0e-3, 3.7e-4, 8.7e-5, 1.1e-5, 2.0e-6}, {1.1e-1, 3.3e-2, 3.7e-3, 3.8e-5, 2.4e-6}, 1.3e-4},
    {"laser", 3.3e-4, {4.7e-9, 1.0e-9, 1.0e-9, 1.0e-9, 1.0e-9}, {1.3e-1, 3.2e-2, 3.9e-3, 1.0e-9, 1.0e-9}, 3.0e-8},
    {"cylinder", 7.5e-6, {4.1e-5, 4.2e-8, 1.0e-9, 1.0e-9, 1.0e-9}, {1.3e-1, 4.3e-2, 5.8e-3, 2.4e-8, 1.0e-9}, 6.1e-8},
    {"camera at the lens",
     3.3e-7,
     {1.5e-2, 6.6e-3, 3.5e-3, 2.0e-3, 5.0e-4},
     {3.1e-2, 8.2e-3, 4.2e-3, 2.4e-3, 6.0e-4},
     1.8e-3},
    {"camera at the virtual apex",
     6.6e-7,
     {2.7e-2, 1.1e-2, 5.4e-3, 3.0e-3, 7.3e-4},
     {2.8e-2, 1.1e-2, 5.4e-3, 3.0e-3, 7.3e-4},
     3.1e-3},
    {"inside the beam",
     9.6e-6,
     {2.7e-3, 1.7e-4, 5.8e-5, 3.1e-5, 7.1e-6},
     {4.1e-2, 7.1e-3, 6.2e-4, 2.7e-5, 5.1e-6},
     6.1e-5},
    {"into the lens",
     3.9e-6,
     {1.0e-9, 1.0e-9, 1.0e-9, 1.0e-9, 1.0e-9},
     {1.0e-9, 1.0e-9, 1.0e-9, 1.0e-9, 1.0e-9},
     1.0e-9},
    {"along a generator",
     1.2e-6,
     {8.2e-3, 2.2e-3, 6.8e-4, 2.2e-4, 2.2e-5},
     {3.9e-2, 1.1e-2, 2.1e-3, 7.7e-4, 6.8e-5},
     5.0e-5},
    {"1 km away", 3.9e-5, {4.1e-3, 7.4e-5, 1.4e-5, 4.7e-6, 2.8e-7}, {1.3e-1, 2.9e-2, 2.6e-3, 3.1e-5, 1.8e-7}, 1.7e-4},
    {"no end", 5.7e-6, {2.9e-2, 2.0e-3, 2.7e-4, 8.1e-5, 1.3e-5}, {1.3e-1, 4.1e-2, 5.8e-3, 2.6e-4, 9.9e-6}, 7.1e-4},
    {"cut by depth",
     6.3e-6,
     {2.2e-3, 1.8e-4, 3.9e-6, 1.1e-7, 1.0e-9},
     {1.1e-1, 3.8e-2, 4.7e-3, 3.3e-6, 1.0e-9},
     6.8e-5},
    {"wide, 60-75 deg",
     8.1e-6,
     {2.7e-1, 6.0e-2, 3.0e-2, 9.6e-3, 1.3e-3},
     {1.9e-1, 5.3e-2, 2.4e-2, 8.0e-3, 9.9e-4},
     1.9e-2},
};

// Relative error of beam_flux_factor: measured, plus a tenth.
inline constexpr double kFluxBound = 6.7e-7;
inline constexpr double kFluxStageBound = 1e-12;

}  // namespace footlight::render::cases
