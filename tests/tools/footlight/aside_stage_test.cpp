// Fixtures of another log and of a kept moment in the frame of the stage.
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "tests/support/headless_vulkan.h"
#include "tests/support/must.h"
#include "tests/tools/footlight/played_stage.h"
#include "tools/footlight/preview/aside_stage.h"
#include "tools/footlight/preview/stage_comparison.h"

namespace footlight::tools {
namespace {

using footlight::testing::HeadlessVulkan;
using footlight::testing::log_of;
using footlight::testing::must;
using footlight::testing::open_log;
using Stage = footlight::testing::PlayedStage;

// As of Preview: nothing else follows the levels.
LogPlayer::Driven aside_of(Stage& stage) {
  return {stage.device, *stage.frame, false,
          [&stage](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
            stage.frame->step(levels, dt_ns, new_exposure);
          },
          [] {}, false};
}

TEST_CASE("another log has the states of a replay of it, and those of the stage come back to the bit") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Stage stage(vulkan.device(), 6 * kNsPerS);
  stage.transport.duration_ns = stage.player->duration_ns();
  Stage other(vulkan.device(), open_log(log_of(6 * kNsPerS, 11)));
  AsideStage aside(other.make_player());
  must(stage.player->seek(2 * kNsPerS, stage.driven()));
  for (const TimeNs at_ns : {2 * kNsPerS, 5 * kNsPerS, kNsPerS, 60 * kNsPerS}) {
    CAPTURE(at_ns);
    const render::FrameState own = stage.state();
    bool there = false;
    while (!there) {
      there = must(aside.enter(at_ns, LogPlayer::kExposureNs, stage.compiled.universes, aside_of(stage)));
      if (there) CHECK(stage.state().heads == other.replayed(std::min(at_ns, 6 * kNsPerS)).heads);
      must(aside.leave(*stage.frame));
      CHECK(stage.state().heads == own.heads);
      CHECK(stage.state().time_ns == own.time_ns);
    }
    CHECK(!aside.entered());
    stage.turn();
  }
  CHECK(aside.bytes() == stage.state().bytes());
}

TEST_CASE("another log plays on while the stage plays, with the exposures of the stage, and stands still with it") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Stage stage(vulkan.device(), 4 * kNsPerS);
  stage.transport.duration_ns = stage.player->duration_ns();
  AsideStage aside(std::make_unique<LogPlayer>([&] { return Timeline(stage.log.again(), stage.compiled); },
                                               stage.clock));  // of the same log
  DurationNs exposed_ns = 0;
  LogPlayer::Driven driven = aside_of(stage);
  driven.step = [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
    exposed_ns = new_exposure ? dt_ns : exposed_ns + dt_ns;
    stage.frame->step(levels, dt_ns, new_exposure);
  };
  const auto states_at = [&](TimeNs at_ns) {
    while (!must(aside.enter(at_ns, stage.exposed_ns, stage.compiled.universes, driven))) {
      must(aside.leave(*stage.frame));
    }
    const render::FrameState states = stage.state();
    must(aside.leave(*stage.frame));
    return states;
  };
  must(stage.player->seek(kNsPerS, stage.driven()));
  CHECK(states_at(kNsPerS).heads == stage.state().heads);
  CHECK(exposed_ns == LogPlayer::kExposureNs);
  for (const DurationNs dt_ns : {25 * kNsPerMs, 3 * kNsPerMs, 17 * kNsPerMs + 123, kNsPerMs / 5, 500 * kNsPerMs}) {
    CAPTURE(dt_ns);
    for (int i = 0; i < 4; ++i) stage.turn(dt_ns);
    CHECK(stage.exposed_ns == std::min(dt_ns, LogPlayer::kExposureNs));
    CHECK(states_at(stage.player->now_ns()).time_ns == stage.state().time_ns);
    CHECK(exposed_ns == stage.exposed_ns);
    CHECK(stage.player->exposed_ns() == stage.exposed_ns);
  }
  const TimeNs now_ns = stage.player->now_ns();
  const render::FrameState first = states_at(now_ns);
  CHECK(first.time_ns == stage.state().time_ns);
  CHECK(states_at(now_ns).heads == first.heads);
}

TEST_CASE("a kept moment has its states, and one of another rig has those that its levels lead to") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Stage stage(vulkan.device(), 4 * kNsPerS);
  stage.transport.duration_ns = stage.player->duration_ns();
  must(stage.player->seek(kNsPerS, stage.driven()));
  const LevelMoment moment{stage.compiled.universes, {stage.player->levels().begin(), stage.player->levels().end()}};
  const render::FrameState kept = stage.state();
  AsideStage aside(moment);
  aside.keep(kept);
  must(stage.player->seek(3 * kNsPerS, stage.driven()));
  const render::FrameState own = stage.state();
  REQUIRE(own.heads != kept.heads);
  const auto entered = [&] {
    CHECK(must(aside.enter(0, 0, stage.compiled.universes, aside_of(stage))));
    render::FrameState states = stage.state();
    must(aside.leave(*stage.frame));
    CHECK(stage.state().heads == own.heads);
    return states;
  };
  CHECK(entered().heads == kept.heads);
  aside.forget_states();
  const auto fresh = stage.make_frame();
  fresh->step(moment.levels, 0, true);
  CHECK(entered().heads == must(fresh->save_state()).heads);
  CHECK(entered().heads == must(fresh->save_state()).heads);
}

TEST_CASE("a moment keeps the states of when it was kept, and steps that came meanwhile are not lost") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Stage stage(vulkan.device(), 4 * kNsPerS);
  stage.transport.duration_ns = stage.player->duration_ns();
  must(stage.player->seek(kNsPerS, stage.driven()));
  const render::FrameState then = stage.state();
  LevelComparison compared;
  compared.a = keep_levels(stage.compiled.universes, stage.player->levels(), kNsPerS);
  StageComparison both;
  both.follow(compared, [] { return nullptr; });
  CHECK(both.holds_steps());
  // Steps of the next pictures: a picture of the stage is still in flight.
  std::vector<std::uint8_t> levels(stage.player->levels().begin(), stage.player->levels().end());
  const auto reference = stage.make_frame();
  must(reference->load_state(then));
  for (int i = 0; i < 5; ++i) {
    levels[0] = static_cast<std::uint8_t>(40 * i);
    both.hold(levels, 20 * kNsPerMs, true);
    reference->step(levels, 20 * kNsPerMs, true);
  }
  both.follow(compared, [] { return nullptr; });  // the same moment
  must(both.release(*stage.frame));
  CHECK(!both.holds_steps());
  CHECK(stage.state().heads == must(reference->save_state()).heads);
  both.set_mode(StageCompare::kBeside);
  CHECK(both.next_side() == StageComparison::kB);
  CHECK(both.aside(StageComparison::kB) == nullptr);
  AsideStage* const aside = both.aside(StageComparison::kA);
  REQUIRE(aside != nullptr);
  CHECK(must(aside->enter(0, 0, stage.compiled.universes, aside_of(stage))));
  CHECK(both.inside() == aside);
  CHECK(stage.state().heads == then.heads);
  must(aside->leave(*stage.frame));
  CHECK(both.inside() == nullptr);
  compared.a.reset();
  both.follow(compared, [] { return nullptr; });
  CHECK(!both.on());
}

double ms_since(std::chrono::steady_clock::time_point begun) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count();
}

// With FOOTLIGHT_PRINT_COSTS=1 it prints what states and differences cost: the least of five times.
TEST_CASE("the states of a moment are as many bytes as those of the frame, and come back for any number of heads") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const bool prints = std::getenv("FOOTLIGHT_PRINT_COSTS") != nullptr;  // NOLINT(concurrency-mt-unsafe): one thread
  for (const int heads : prints ? std::vector<int>{24, 1000, 10'000} : std::vector<int>{24}) {
    std::string text = "[rig]\nname = \"r\"\n";
    for (int i = 0; i < heads; ++i) {
      text += fmt::format("[[fixture]]\nname = \"A{}\"\ntype = \"generic/profile\"\nuniverse = {}\naddress = {}\n"
                          "position = [{}, 0, 5]\n", i, i / 32 + 1, i % 32 * 16 + 1, i % 100);
    }
    const fixtures::Rig rig = must(fixtures::parse_rig(text, "r.toml"));
    const fixtures::CompiledRig compiled = must(fixtures::compile(rig));
    const auto frame = must(render::Frame::create(vulkan.device(), rig, compiled, {.width = 16, .height = 16},
                                                  {&render::kStepPass, &render::kTonemapPass}));
    std::vector<std::uint8_t> levels(compiled.universes.size() * kSlotCountMax, 90);
    frame->step(levels, 0, true);
    AsideStage aside(LevelMoment{compiled.universes, levels});
    aside.keep(must(frame->save_state()));
    std::fill(levels.begin(), levels.end(), std::uint8_t{30});
    frame->step(levels, 500 * kNsPerMs, true);
    const render::FrameState own = must(frame->save_state());
    const LogPlayer::Driven driven{vulkan.device(), *frame, false, {}, [] {}, false};
    double least_ms = 1e9;
    for (int i = 0; i < 5; ++i) {
      const auto begun = std::chrono::steady_clock::now();
      must(aside.enter(0, 0, compiled.universes, driven));
      must(aside.leave(*frame));
      least_ms = std::min(least_ms, ms_since(begun));
    }
    CHECK(must(frame->save_state()).heads == own.heads);
    CHECK(aside.bytes() == own.bytes());
    if (prints) fmt::print("{} heads: {} bytes, there and back {:.2f} ms\n", heads, aside.bytes(), least_ms);
  }
  if (!prints) return;
  for (const auto& [width, height] : {std::pair(1280, 720), std::pair(3840, 2160)}) {
    std::vector<std::uint8_t> a(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4, 10);
    std::vector<std::uint8_t> made;
    double least_ms = 1e9;
    for (int i = 0; i < 5; ++i) {
      const auto begun = std::chrono::steady_clock::now();
      (void)difference_of({a, width, height}, {a, width, height}, made);
      least_ms = std::min(least_ms, ms_since(begun));
    }
    fmt::print("difference of {} x {}: {:.2f} ms\n", width, height, least_ms);
  }
}

}  // namespace
}  // namespace footlight::tools
