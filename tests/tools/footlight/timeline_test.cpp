// The levels of a log over time, and picture files.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "fixtures/simulate/walker.h"
#include "sim/snapshot_trail.h"
#include "tests/sim/dmx_log/support.h"
#include "tools/footlight/pictures/picture_file.h"
#include "tools/footlight/pictures/timeline.h"

namespace footlight::tools {
namespace {

using footlight::testing::OwnedFrame;
using footlight::testing::Random;
using footlight::testing::TempFolder;

constexpr DurationNs kMs = 1'000'000;

// A rig on universes 2 and 5.
fixtures::CompiledRig rig_of_two() {
  fixtures::CompiledRig compiled;
  compiled.universes = {2, 5};
  return compiled;
}

OwnedFrame frame_of(DurationNs time_ns, Universe universe, std::uint8_t level) {
  OwnedFrame frame;
  frame.time_ns = time_ns;
  frame.universe = universe;
  frame.slots.assign(512, level);
  return frame;
}

Timeline timeline_of(const std::vector<OwnedFrame>& frames, DurationNs end_ns) {
  return Timeline(testing::open_log(testing::log_bytes(frames, end_ns)), rig_of_two());
}

// The steps as levels and the time they were held; touching pieces of equal levels are joined.
struct Held {
  std::vector<std::uint8_t> levels;
  DurationNs held_ns = 0;
  bool operator==(const Held&) const = default;
};

struct RecordedSteps {
  std::vector<Held> held;
  DurationNs total_ns = 0;
  DurationNs exposed_ns = 0;  // since the last step that began an exposure
  int steps = 0;
  int exposures = 0;
  int backward = 0;

  Timeline::Step recorder() {
    return [this](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
      ++steps;
      exposures += new_exposure;
      backward += dt_ns < 0;
      total_ns += dt_ns;
      exposed_ns = new_exposure ? dt_ns : exposed_ns + dt_ns;
      std::vector<std::uint8_t> now(levels.begin(), levels.end());
      if (held.empty() || held.back().levels != now) {
        if (dt_ns > 0) held.push_back({std::move(now), dt_ns});
      } else {
        held.back().held_ns += dt_ns;
      }
    };
  }
};

TEST_CASE("a timeline makes the steps again that it made after a position, and can start within a log") {
  std::vector<OwnedFrame> frames;
  Random random(5);
  DurationNs at_ns = 0;
  for (int i = 0; i < 300; ++i) {
    at_ns += random.below(3) * kMs;  // some at the same time
    frames.push_back(frame_of(at_ns, random.below(2) == 0 ? 2 : 5, static_cast<std::uint8_t>(random.below(4))));
  }
  const DurationNs end_ns = at_ns + 20 * kMs;
  RecordedSteps whole;
  Timeline played = timeline_of(frames, end_ns);
  REQUIRE(played.advance(end_ns, 0, whole.recorder()));

  Timeline other = timeline_of(frames, end_ns);
  for (const DurationNs stop_ns : {0 * kMs, 1 * kMs, at_ns / 3, at_ns / 2, at_ns}) {
    CAPTURE(stop_ns);
    Timeline stopped = timeline_of(frames, end_ns);
    RecordedSteps parts;
    while (stopped.now_ns() < stop_ns) {
      const auto more = stopped.advance_to_change(stopped.now_ns() + 1, end_ns, parts.recorder());
      REQUIRE(more);
      if (!*more) break;
    }
    REQUIRE(other.go_to(stopped.position()));
    REQUIRE(other.advance(end_ns, 0, parts.recorder()));
    CHECK(parts.held == whole.held);
    CHECK(parts.steps == whole.steps);
    CHECK(parts.total_ns == end_ns);

    RecordedSteps rest;
    REQUIRE(other.start_at(stop_ns));
    REQUIRE(other.advance(end_ns, 0, rest.recorder()));
    CHECK(rest.total_ns == end_ns - stop_ns);
    REQUIRE(!rest.held.empty());
    CHECK(rest.held.back().levels == whole.held.back().levels);
  }
}

TEST_CASE("levels are held from the moment they arrived, and universes that are not in the rig split nothing") {
  Timeline timeline = timeline_of({frame_of(0, 2, 10), frame_of(5 * kMs, 3, 99), frame_of(10 * kMs, 5, 20),
                                   frame_of(10 * kMs, 2, 11), frame_of(12 * kMs, 2, 11), frame_of(30 * kMs, 2, 12)},
                                  50 * kMs);
  RecordedSteps recorded;
  REQUIRE(timeline.advance(40 * kMs, 0, recorded.recorder()));
  CHECK(timeline.now_ns() == 40 * kMs);
  CHECK(timeline.duration_ns() == 50 * kMs);
  REQUIRE(recorded.held.size() == 3);
  CHECK(recorded.held[0].held_ns == 10 * kMs);
  CHECK(recorded.held[0].levels[0] == 10);
  CHECK(recorded.held[0].levels[511] == 10);
  CHECK(recorded.held[0].levels[512] == 0);  // universe 5 has not been received
  CHECK(recorded.held[1].held_ns == 20 * kMs);
  CHECK(recorded.held[1].levels[0] == 11);
  CHECK(recorded.held[1].levels[512] == 20);
  CHECK(recorded.held[2].held_ns == 10 * kMs);
  CHECK(recorded.held[2].levels[0] == 12);
}

TEST_CASE("one long advance and many short ones hold the same levels for the same times") {
  // Random traffic over universes 1, 8, 15, ..., moved to those of the rig and one that is not in it.
  std::vector<OwnedFrame> frames = testing::random_frames(3, 400, 3);
  for (OwnedFrame& frame : frames) frame.universe = frame.universe == 1 ? 2 : frame.universe == 8 ? 5 : 9;
  const DurationNs end_ns = frames.back().time_ns + 7 * kMs;
  RecordedSteps whole;
  Timeline in_one_go = timeline_of(frames, end_ns);
  REQUIRE(in_one_go.advance(end_ns, 0, whole.recorder()));
  CHECK(whole.total_ns == end_ns);
  CHECK(whole.held.size() > 100);

  Random random(4);
  for (const DurationNs longest_ns : {1 * kMs, 20 * kMs, 400 * kMs}) {
    CAPTURE(longest_ns);
    RecordedSteps pieces;
    Timeline timeline = timeline_of(frames, end_ns);
    DurationNs at_ns = 0;
    while (at_ns < end_ns) {
      at_ns = std::min(at_ns + static_cast<DurationNs>(random.below(static_cast<std::uint64_t>(longest_ns))), end_ns);
      REQUIRE(timeline.advance(at_ns, static_cast<DurationNs>(random.below(30'000'000)), pieces.recorder()));
      REQUIRE(timeline.now_ns() == at_ns);
    }
    CHECK(pieces.backward == 0);
    CHECK(pieces.total_ns == end_ns);
    CHECK(pieces.held == whole.held);
  }
}

TEST_CASE("the last part of an advance is one exposure of the given length") {
  std::vector<OwnedFrame> frames;
  for (int i = 0; i < 100; ++i) frames.push_back(frame_of(i * 3 * kMs, 2, static_cast<std::uint8_t>(i)));
  Timeline timeline = timeline_of(frames, 300 * kMs);
  for (const DurationNs at_ns : {100 * kMs, 140 * kMs, 180 * kMs, 299 * kMs}) {
    RecordedSteps recorded;
    REQUIRE(timeline.advance(at_ns, 20 * kMs, recorded.recorder()));
    CHECK(recorded.exposed_ns == 20 * kMs);
    CHECK(recorded.exposures == 2);  // one before the shutter opens, one of the picture
  }
  // An exposure longer than the advance is all of it.
  RecordedSteps recorded;
  REQUIRE(timeline.advance(305 * kMs, 20 * kMs, recorded.recorder()));
  CHECK(recorded.exposed_ns == 6 * kMs);
  CHECK(recorded.exposures == 1);
}

TEST_CASE("after the end of the log the last levels are held") {
  Timeline timeline = timeline_of({frame_of(0, 2, 7), frame_of(10 * kMs, 2, 200)}, 20 * kMs);
  RecordedSteps recorded;
  REQUIRE(timeline.advance(3'600'000 * kMs, 0, recorded.recorder()));
  REQUIRE(timeline.advance(7'200'000 * kMs, 40 * kMs, recorded.recorder()));
  CHECK(timeline.now_ns() == 7'200'000 * kMs);
  REQUIRE(recorded.held.size() == 2);
  CHECK(recorded.held[1].levels[0] == 200);
  CHECK(recorded.held[1].held_ns == 7'199'990 * kMs);
}

TEST_CASE("a picture at time 0 has one step of length 0 with the levels of time 0") {
  Timeline timeline = timeline_of({frame_of(0, 2, 7), frame_of(10 * kMs, 2, 200)}, 20 * kMs);
  std::vector<std::uint8_t> first_levels;
  int steps = 0;
  REQUIRE(timeline.advance(0, 20 * kMs, [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool) {
    ++steps;
    CHECK(dt_ns == 0);
    first_levels.assign(levels.begin(), levels.end());
  }));
  CHECK(steps == 1);
  REQUIRE(first_levels.size() == 1024);
  CHECK(first_levels[0] == 7);
}

TEST_CASE("a log without a frame for the rig is dark for any length") {
  Timeline timeline = timeline_of({frame_of(5 * kMs, 77, 255)}, 20 * kMs);
  RecordedSteps recorded;
  REQUIRE(timeline.advance(20 * kMs, 0, recorded.recorder()));
  REQUIRE(recorded.held.size() == 1);
  CHECK(recorded.held[0].held_ns == 20 * kMs);
  CHECK(std::all_of(recorded.held[0].levels.begin(), recorded.held[0].levels.end(),
                    [](auto level) { return level == 0; }));
}

TEST_CASE("changes that are passed over make no step, and the next step has them") {
  const auto with_two = [](std::vector<bool> passed_over) {
    Timeline timeline = timeline_of({frame_of(0, 2, 1), frame_of(0, 5, 10), frame_of(4 * kMs, 5, 20),
                                     frame_of(10 * kMs, 2, 2), frame_of(14 * kMs, 5, 30)},
                                    30 * kMs);
    timeline.pass_over(std::move(passed_over));
    return timeline;
  };
  const auto steps_of = [](Timeline timeline) {
    RecordedSteps recorded;
    REQUIRE(timeline.advance(20 * kMs, 0, recorded.recorder()));
    CHECK(recorded.total_ns == 20 * kMs);
    CHECK(recorded.held.back().levels.back() == 30);
    return recorded.steps;
  };
  CHECK(steps_of(with_two({false, false})) == 4);
  CHECK(steps_of(with_two({false, true})) == 2);
  CHECK(steps_of(with_two({true, true})) == 4);  // nothing but pixels: none is passed over
  Timeline timeline = with_two({false, true});
  RecordedSteps recorded;
  const auto more = timeline.advance_to_change(1, 30 * kMs, recorded.recorder());
  REQUIRE(more.has_value());
  CHECK(timeline.now_ns() == 10 * kMs);
}

TEST_CASE("a live flash is as long as its time stamps state, at any time between pictures") {
  const auto rig = fixtures::parse_rig(
      "[rig]\nname = \"r\"\n[[fixture]]\nname = \"A\"\ntype = \"generic/par\"\nuniverse = 2\naddress = 1\n"
      "position = [0, 0, 5]\n",
      "r.toml");
  REQUIRE_MESSAGE(rig, rig.error().message);
  const auto compiled = fixtures::compile(*rig);
  REQUIRE(compiled);
  Random random(12);
  for (const DurationNs flash_ns : {kMs / 5, kMs, 7 * kMs, 40 * kMs}) {
    for (int trial = 0; trial < 20; ++trial) {
      const Universes universes(compiled->universes);
      SnapshotTrail trail(universes);
      const TimeNs start_ns = 1'000'000 * kMs;
      Timeline timeline(trail, *compiled, std::nullopt, start_ns);
      fixtures::f64::Walker walker(*compiled);
      const TimeNs on_ns = start_ns + 30 * kMs + static_cast<DurationNs>(random.below(20'000'000));
      const auto send = [&](std::uint8_t level, TimeNs stamp_ns) {
        Slots slots;
        slots.fill(255);
        slots[0] = level;
        slots[1] = 0;
        FrameView frame;
        frame.universe = 2;
        frame.stamp_ns = stamp_ns;
        frame.slots = slots;
        REQUIRE(trail.send(kTimeNever, {&frame, 1}));
      };
      double light_s = 0;
      const auto picture = [&](TimeNs until_ns) {
        const DurationNs dt_ns = until_ns - timeline.now_ns();
        REQUIRE(timeline.advance(until_ns, dt_ns, [&](auto levels, std::int64_t step_ns, bool new_exposure) {
          walker.step(levels, step_ns, new_exposure);
        }));
        light_s += walker.states[0].red * static_cast<double>(dt_ns) * 1e-9;
      };
      send(0, start_ns);
      bool is_on = false;
      bool is_over = false;
      TimeNs now_ns = start_ns;
      while (now_ns < start_ns + 200 * kMs) {
        now_ns += kMs + static_cast<DurationNs>(random.below(25'000'000));
        // Everything before `now_ns` has arrived. Pictures are 2 ms late.
        if (!is_on && on_ns <= now_ns) send(255, on_ns), is_on = true;
        if (!is_over && on_ns + flash_ns <= now_ns) send(0, on_ns + flash_ns), is_over = true;
        picture(std::max(now_ns - 2 * kMs, timeline.now_ns()));
      }
      CHECK(is_over);
      fixtures::f64::Walker full(*compiled);
      std::vector<std::uint8_t> levels(kSlotCountMax, 255);
      levels[1] = 0;
      full.step(levels, 0);
      full.step(levels, 10'000 * kMs);
      REQUIRE(full.states[0].red > 0);
      CHECK(light_s / full.states[0].red == doctest::Approx(static_cast<double>(flash_ns) * 1e-9).epsilon(1e-9));
    }
  }
}

TEST_CASE("a recorded VRSL show replays to the same states, whatever pictures are rendered") {
  const auto rig = fixtures::parse_rig(
      "[rig]\nname = \"r\"\n[vrsl]\n[[fixture]]\nname = \"A{}\"\ntype = \"vrsl/spot\"\nuniverse = 2\naddress = 1\n"
      "position = [0, 0, 5]\ncount = 3\n",
      "r.toml");
  REQUIRE_MESSAGE(rig, rig.error().message);
  const auto compiled = fixtures::compile(fixtures::vrsl_shown(*rig));
  REQUIRE(compiled);
  std::vector<OwnedFrame> frames;
  for (int i = 0; i < 200; ++i) {
    OwnedFrame frame = frame_of(i * 41 * kMs + 7, 2, static_cast<std::uint8_t>(i));
    for (std::size_t slot = 0; slot < frame.slots.size(); ++slot) {
      frame.slots[slot] = static_cast<std::uint8_t>(slot % 13 * 19 + static_cast<std::size_t>(i) * (slot % 5));
    }
    frames.push_back(frame);
  }
  const auto states_after = [&](DurationNs every_ns, DurationNs exposure_ns) {
    Timeline timeline(testing::open_log(testing::log_bytes(frames, 9'000 * kMs)), *compiled,
                      fixtures::VrslReplay(*rig, *compiled));
    fixtures::f32::Walker walker(*compiled);
    DurationNs total_ns = 0;
    for (DurationNs at_ns = every_ns; at_ns <= 8'000 * kMs; at_ns += every_ns) {
      REQUIRE(timeline.advance(at_ns, exposure_ns, [&](auto levels, std::int64_t dt_ns, bool new_exposure) {
        walker.step(levels, dt_ns, new_exposure);
        total_ns += dt_ns;
      }));
    }
    CHECK(total_ns == 8'000 * kMs);
    return std::pair(walker.states, walker.optics_states);
  };
  const auto [once, optics_once] = states_after(8'000 * kMs, 20 * kMs);
  for (const DurationNs every_ns : {16 * kMs, 40 * kMs, 1'000 * kMs}) {
    const auto [often, optics_often] = states_after(every_ns, 20 * kMs);
    for (std::size_t i = 0; i < once.size(); ++i) {
      CHECK(once[i].pan == often[i].pan);
      CHECK(once[i].tilt == often[i].tilt);
      CHECK(once[i].zoom == often[i].zoom);
      CHECK(optics_once[i].image_1 == optics_often[i].image_1);
      CHECK(optics_once[i].angle_1 == optics_often[i].angle_1);
    }
  }
  CHECK(once[0].pan != once[1].pan);
}

TEST_CASE("a picture's number replaces the placeholder, padded as written") {
  CHECK(is_numbered("frame_%04d.png"));
  CHECK(is_numbered("%d"));
  CHECK(*numbered_path("frame_%04d.png", 7) == "frame_0007.png");
  CHECK(*numbered_path("frame_%04d.png", 123456) == "frame_123456.png");
  CHECK(*numbered_path("out/%d.png", 12) == "out/12.png");
  CHECK(*numbered_path("%3d", 5) == "005");  // spaces in names are not useful
}

TEST_CASE("a name without exactly one placeholder is refused by name") {
  for (const char* path : {"frame.png", "frame_%d_%d.png", "100%.png", "%s.png", "%04", "%", "", "%x%d"}) {
    CAPTURE(path);
    CHECK(!is_numbered(path));
    const auto numbered = numbered_path(path, 1);
    REQUIRE(!numbered);
    CHECK(numbered.error().code == ErrorCode::kBadInput);
    CHECK(numbered.error().message.find(std::string(path) + ": ") == 0);
    CHECK(numbered.error().message.find("frame_%04d.png") != std::string::npos);
  }
}

TEST_CASE("a PNG into a missing folder is an error that names the file, and no file is left behind") {
  const TempFolder folder;
  const render::ScreenImage image{2, 1, {255, 0, 0, 255, 0, 255, 0, 255}};
  const std::string path = folder.file("missing/frame.png");
  const Status status = write_png(path, image);
  REQUIRE(!status);
  CHECK(status.error().code == ErrorCode::kIo);
  CHECK(status.error().message.find(path) == 0);
  CHECK(status.error().message.find("folder") != std::string::npos);

  const std::string good = folder.file("frame.png");
  REQUIRE(write_png(good, image));
  const auto bytes = testing::read_bytes(good);
  REQUIRE(bytes.size() > 8);
  CHECK(std::string(bytes.begin() + 1, bytes.begin() + 4) == "PNG");
  CHECK(!std::filesystem::exists(good + ".part"));
  // It cannot replace a folder; the folder stays.
  std::filesystem::create_directory(folder.file("taken.png"));
  const Status taken = write_png(folder.file("taken.png"), image);
  REQUIRE(!taken);
  CHECK(std::filesystem::is_directory(folder.file("taken.png")));
}

}  // namespace
}  // namespace footlight::tools
