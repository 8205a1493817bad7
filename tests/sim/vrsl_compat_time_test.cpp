// VRSL's behaviour in time, with its faults, compared with figures derived from its shaders.
#include <doctest/doctest.h>

#include <cmath>
#include <memory>

#include "sim/vrsl_compat_time.h"

namespace footlight {
namespace {

VrslValues all(float value) {
  VrslValues values;
  values.fill(value);
  return values;
}
float code(int level) { return static_cast<float>(level) / 255.0f; }

// Seconds until channel 1 has gone `share` of the way from 0 to 1, at `fps` and a speed in column 13.
double movement_s(double share, double fps, float speed) {
  const auto movement = std::make_unique<VrslMovement>(VrslSettings());
  const auto dt = static_cast<float>(1 / fps);
  VrslValues raw = all(0);
  raw[12] = speed;
  movement->step(raw, 3.5f);  // past the start delay
  raw[0] = 1;
  for (int frame = 1; frame < 100'000; ++frame) {
    if (static_cast<double>(movement->step(raw, dt)[0]) >= share) return frame / fps;
  }
  return 1e9;
}

TEST_CASE("slow movement takes 2.05 s to 90 percent and 4.1 s to 99, at any frame rate") {
  for (const double fps : {15.0, 60.0, 240.0}) {
    CHECK(movement_s(0.9, fps, 0) == doctest::Approx(2.05).epsilon(0.04));
    CHECK(movement_s(0.99, fps, 0) == doctest::Approx(4.1).epsilon(0.03));
  }
}

TEST_CASE("fast movement depends on the frame rate: 1.40 s at 15 fps to 99 percent, 0.17 s at 240") {
  CHECK(movement_s(0.99, 15, 1) == doctest::Approx(1.40).epsilon(0.05));
  CHECK(movement_s(0.99, 60, 1) == doctest::Approx(0.57).epsilon(0.03));
  CHECK(movement_s(0.99, 144, 1) == doctest::Approx(0.28).epsilon(0.03));
  CHECK(movement_s(0.99, 240, 1) == doctest::Approx(0.17).epsilon(0.05));
  CHECK(movement_s(0.9, 60, 1) == doctest::Approx(0.283).epsilon(0.02));
}

TEST_CASE("the speed is that of column 13 of the row, even if that is another fixture's byte") {
  const auto movement = std::make_unique<VrslMovement>(VrslSettings());
  VrslValues raw = all(0);
  movement->step(raw, 3.5f);
  raw[5] = raw[14] = 1;  // two fixtures that do not start at column 1: in rows 0 and 1
  raw[25] = 1;           // column 13 of row 1
  const VrslValues& out = movement->step(raw, 1 / 60.0f);
  CHECK(out[14] > 3 * out[5]);
}

TEST_CASE("colours reach 99 percent in four pictures of any length") {
  for (const float fps : {15.0f, 60.0f, 144.0f}) {
    const auto color = std::make_unique<VrslColor>(VrslSettings());
    color->step(all(0), 3.5f);
    int frames = 0;
    while (color->step(all(1), 1 / fps)[0] < 0.99f) ++frames;
    CHECK(frames + 1 == 4);
  }
}

TEST_CASE("for the first three seconds values pass unchanged") {
  const auto movement = std::make_unique<VrslMovement>(VrslSettings());
  const auto color = std::make_unique<VrslColor>(VrslSettings());
  CHECK(movement->step(all(0.7f), 1)[0] == 0.7f);
  CHECK(color->step(all(0.7f), 1)[0] == 0.7f);
}

TEST_CASE("code 51 is solid and code 52 strobes, so that the low tier is never seen") {
  const auto strobe = std::make_unique<VrslStrobe>(VrslSettings());
  const auto open_share = [&](int level) {
    int open = 0;
    for (int frame = 0; frame < 6000; ++frame) open += strobe->step(all(code(level)), all(code(level)), 0.001f)[0] > 0;
    return open / 6000.0;
  };
  CHECK(open_share(51) == 1);
  CHECK(open_share(52) == doctest::Approx(0.5).epsilon(0.02));
}

TEST_CASE("the tiers flash 7.16 and 10.35 times a second, dynamic strobes 29.4 and 6.0") {
  const auto flashes = [&](const VrslSettings& settings, int level) {
    const auto strobe = std::make_unique<VrslStrobe>(settings);
    int count = 0;
    float before = 1;
    for (int frame = 0; frame < 22'000; ++frame) {
      const float now = strobe->step(all(code(level)), all(code(level)), 0.0005f)[0];
      if (frame >= 2000) count += now > before;
      before = now;
    }
    return count / 10.0;
  };
  CHECK(flashes(VrslSettings(), 100) == doctest::Approx(7.16).epsilon(0.02));
  CHECK(flashes(VrslSettings(), 255) == doctest::Approx(10.35).epsilon(0.02));
  VrslSettings dynamic;
  dynamic.static_strobe = false;
  CHECK(flashes(dynamic, 255) == doctest::Approx(29.4).epsilon(0.02));
  CHECK(flashes(dynamic, 52) == doctest::Approx(6.0).epsilon(0.02));
}

TEST_CASE("below 29.4 pictures a second a full dynamic strobe leaks and is dark for ever after 4.7 hours") {
  VrslSettings settings;
  settings.static_strobe = false;
  const auto strobe = std::make_unique<VrslStrobe>(settings);
  VrslValues raw = all(0);
  raw[0] = 1;
  int lit = 0;
  const int pictures = static_cast<int>(4.75 * 3600 * 20);
  for (int frame = 0; frame < pictures; ++frame) {
    const float gate = strobe->step(raw, raw, 0.05f)[0];
    if (frame == pictures / 2) CHECK((gate == 0 || gate == 1));
  }
  for (int frame = 0; frame < 200; ++frame) lit += strobe->step(raw, raw, 0.05f)[0] > 0;
  CHECK(lit == 0);
}

TEST_CASE("after three days a sixth of the static strobe's pictures are wrong, after a week two fifths") {
  const auto wrong = [](double hours) {
    const auto strobe = std::make_unique<VrslStrobe>(VrslSettings());
    strobe->set_uptime(hours * 3600);
    int count = 0;
    for (int frame = 1; frame <= 20'000; ++frame) {
      const float gate = strobe->step(all(1), all(1), 1 / 60.0f)[0];
      const double exact = std::sin((hours * 3600 + frame * static_cast<double>(1 / 60.0f)) * 65);
      count += (gate > 0) != (exact > 0);
    }
    return count / 20'000.0;
  };
  CHECK(wrong(1) < 0.01);
  CHECK(wrong(24) == doctest::Approx(0.045).epsilon(0.5));
  CHECK(wrong(72) == doctest::Approx(0.165).epsilon(0.25));
  CHECK(wrong(168) == doctest::Approx(0.42).epsilon(0.25));
}

TEST_CASE("spin turns by 1.992 rad/s at code 127, backwards by 0.0078 at 128 and by 2.0 at 255") {
  const auto rate = [](int level) {
    const auto spin = std::make_unique<VrslSpin>();
    spin->step(all(0), 1.5f);
    const float before = spin->step(all(code(level)), 0)[0];
    return (spin->step(all(code(level)), 1)[0] - before);
  };
  CHECK(rate(127) == doctest::Approx(1.992).epsilon(1e-3));
  CHECK(rate(128) == doctest::Approx(-0.00784).epsilon(1e-2));
  CHECK(rate(255) == doctest::Approx(-2.0).epsilon(1e-3));
}

TEST_CASE("a spin jumps by eight phases when its sign changes, and restarts below code 3") {
  const auto spin = std::make_unique<VrslSpin>();
  spin->step(all(0), 1.5f);
  const float before = spin->step(all(code(127)), 10)[0];
  const float after = spin->step(all(code(128)), 0)[0];
  CHECK(after - before == doctest::Approx(-2 * before));
  CHECK(spin->step(all(code(2)), 1)[0] == 0);
}

TEST_CASE("a spin is 6 percent slow after 6 hours, 88 percent fast after 96, and stops after a week") {
  const auto pace = [](double hours) {
    const auto spin = std::make_unique<VrslSpin>();
    spin->step(all(0), 1.5f);
    const float begin = spin->step(all(code(127)), static_cast<float>(hours * 3600))[0];
    float angle = begin;
    for (int frame = 0; frame < 600; ++frame) angle = spin->step(all(code(127)), 1 / 60.0f)[0];
    return static_cast<double>(angle - begin) / (600 / 60.0 * 4 * 127 / 255);
  };
  CHECK(pace(0.01) == doctest::Approx(1).epsilon(1e-3));
  CHECK(pace(6) == doctest::Approx(0.94).epsilon(0.02));
  CHECK(pace(96) == doctest::Approx(1.88).epsilon(0.02));
  CHECK(pace(168) == 0);
}

TEST_CASE("below code 3 a spin of a nine-universe grid keeps its phase, of three universes restarts") {
  VrslSpin three;
  VrslSpin nine(true);
  VrslValues raw{};
  for (VrslSpin* spin : {&three, &nine}) {
    raw[10] = 0.5f;
    for (int i = 0; i < 300; ++i) spin->step(raw, 0.01f);
    raw[10] = 2.0f / 255;
    spin->step(raw, 0.01f);
  }
  CHECK(three.step(raw, 0.01f)[10] == 0);
  CHECK(nine.step(raw, 0.01f)[10] > 4);
}

TEST_CASE("in nine-universe mode universes 4 to 9 strobe with 1 to 3") {
  CHECK(vrsl_strobe_universe(1) == 1);
  CHECK(vrsl_strobe_universe(4) == 1);
  CHECK(vrsl_strobe_universe(8) == 2);
  CHECK(vrsl_strobe_universe(9) == 3);
  CHECK(vrsl_strobe_universe(0) == 0);
  CHECK(vrsl_strobe_universe(10) == 0);
}

TEST_CASE("codes select gobos by the decoder's rounding") {
  for (int level = 0; level < 256; ++level) {
    if (level % 30 == 15) continue;  // ties: the shader's rounding mode decides
    const int expected = level < 45    ? 1
                         : level < 75  ? 2
                         : level < 105 ? 3
                         : level < 135 ? 4
                         : level < 165 ? 5
                         : level < 195 ? 6
                         : level < 225 ? 7
                                       : 8;
    CAPTURE(level);
    CHECK(vrsl_gobo(static_cast<std::uint8_t>(level)) == expected);
  }
}

TEST_CASE("pan and tilt codes 0, 127, 128 and 255 are -90, -0.353, 0.353 and 90 degrees of 180") {
  CHECK(vrsl_angle_deg(0, 180) == -90);
  CHECK(vrsl_angle_deg(127, 180) == doctest::Approx(-0.353).epsilon(1e-2));
  CHECK(vrsl_angle_deg(128, 180) == doctest::Approx(0.353).epsilon(1e-2));
  CHECK(vrsl_angle_deg(255, 180) == 90);
  CHECK(vrsl_angle_deg(0, -180) == 90);  // tilt
}

TEST_CASE("invalid steps change nothing, and invalid levels are dark") {
  const auto movement = std::make_unique<VrslMovement>(VrslSettings());
  const auto color = std::make_unique<VrslColor>(VrslSettings());
  const auto strobe = std::make_unique<VrslStrobe>(VrslSettings());
  const auto spin = std::make_unique<VrslSpin>();
  for (const float bad : {std::nanf(""), -1.0f, HUGE_VALF}) {
    CHECK(movement->step(all(1), bad)[0] == 0);
    CHECK(color->step(all(1), bad)[0] == 0);
    CHECK(strobe->step(all(1), all(1), bad)[0] == 0);
    CHECK(spin->step(all(1), bad)[0] == 0);
  }
  CHECK(movement->step(all(std::nanf("")), 1)[0] == 0);
  CHECK(color->step(all(HUGE_VALF), 1)[0] == 1);
}

}  // namespace
}  // namespace footlight
