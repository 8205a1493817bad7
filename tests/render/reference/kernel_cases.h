// The extreme cases of beams: random rays of each kind, rounded to float so that every precision has the same input.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace footlight::render::cases {

// SplitMix64: the same rays with every standard library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform(double from, double to) {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    z ^= z >> 31;
    return from + (to - from) * static_cast<double>(z >> 11) * 0x1.0p-53;
  }
  glm::dvec3 direction() {
    const double z = uniform(-1, 1);
    const double phi = uniform(0, 2 * std::numbers::pi);
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
  }

 private:
  std::uint64_t state_;
};

// A beam, the air and a ray in light space, all exact floats.
struct BeamRay {
  float lens_radius_m;
  float spread;
  float range_m;
  float profile_power;
  float anisotropy;
  float extinction_per_m;
  glm::vec3 origin_m;
  glm::vec3 direction;
  float t_max_m;
};

inline const std::vector<std::string>& names() {
  static const std::vector<std::string> kNames{
      "generic",         "laser",          "cylinder",          "camera at the lens", "camera at the virtual apex",
      "inside the beam", "into the lens",  "along a generator", "1 km away",          "no end",
      "cut by depth",    "wide, 60-75 deg"};
  return kNames;
}

inline std::vector<BeamRay> rays_of(const std::string& name, int count, double profile_power) {
  constexpr double kPi = std::numbers::pi;
  Random random(7 + name.size() * 1000 + static_cast<std::uint64_t>(name[0]));
  std::vector<BeamRay> rays;
  while (rays.size() < static_cast<std::size_t>(count)) {
    double radius = random.uniform(0.03, 0.1);
    double spread = std::tan(random.uniform(1, 25) * kPi / 180);
    double t_max = 200;
    if (name == "laser") {
      radius = 1e-3;
      spread = 1e-6;
    }
    if (name == "cylinder") spread = 0;
    if (name == "wide, 60-75 deg") spread = std::tan(random.uniform(60, 75) * kPi / 180);
    if (name == "no end") t_max = std::numeric_limits<double>::infinity();

    // A point in the beam or close to it, and a camera that is aimed at it.
    const double z = random.uniform(0.1, 25);
    const double rho = 1.05 * std::sqrt(random.uniform(0, 1));
    const double phi = random.uniform(0, 2 * kPi);
    const double w = radius + spread * z;
    const glm::dvec3 target(rho * w * std::cos(phi), rho * w * std::sin(phi), z);
    const double distance = name == "1 km away" ? 1000 : random.uniform(2, 40);
    glm::dvec3 origin = target - distance * random.direction();
    glm::dvec3 direction = target - origin;
    if (name == "1 km away") t_max = 1200;

    if (name == "camera at the lens") {
      origin = glm::dvec3(0);
      direction = target;
    } else if (name == "camera at the virtual apex") {
      origin = glm::dvec3(0, 0, -radius / spread);
      direction = target - origin;
    } else if (name == "inside the beam") {
      const double inside = 0.95 * std::sqrt(random.uniform(0, 1));
      origin = {inside * w * std::cos(phi), inside * w * std::sin(phi), z};
      direction = random.direction();
    } else if (name == "into the lens") {
      origin = {random.uniform(-1e-4, 1e-4), random.uniform(-1e-4, 1e-4), z};
      direction = {0, 0, -1};
    } else if (name == "along a generator") {
      direction = {spread * std::cos(phi), spread * std::sin(phi), 1};
      origin = target - 5.0 * direction;
    } else if (name == "cut by depth") {
      t_max = distance + random.uniform(-1, 1) * w;
    }
    direction = glm::normalize(direction);
    rays.push_back({static_cast<float>(radius), static_cast<float>(spread), 60.0f, static_cast<float>(profile_power),
                    static_cast<float>(random.uniform(0, 0.8)), static_cast<float>(random.uniform(0.005, 0.03)),
                    glm::vec3(origin), glm::vec3(direction), static_cast<float>(t_max)});
  }
  return rays;
}

}  // namespace footlight::render::cases
