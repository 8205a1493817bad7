// A log that plays in a window: what a seek shows, what its time does to the log, and what goes on in a pause.
#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "render/frame.h"
#include "render/passes/step.h"
#include "render/passes/tonemap.h"
#include "tests/sim/dmx_log/support.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/must.h"
#include "tests/tools/footlight/played_stage.h"
#include "tools/footlight/preview/log_player.h"
#include "tools/footlight/preview/log_thumbnails.h"

namespace footlight::tools {
namespace {

using footlight::testing::HeadlessVulkan;
using footlight::testing::kPictureNs;
using footlight::testing::log_of;
using footlight::testing::must;
using footlight::testing::OwnedFrame;
using footlight::testing::SetClock;
using Stage = footlight::testing::PlayedStage;
using footlight::testing::TempFolder;

// Each look is a millisecond after the one before.
class LookedAtClock final : public Clock {
 public:
  TimeNs now_ns() override { return now_ns_ += kNsPerMs; }
  void sleep_until_ns(TimeNs) override {}

 private:
  TimeNs now_ns_ = 0;
};

TEST_CASE("a seek gives the states of a replay from the start, to the bit, from wherever the log has played to") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const bool indexed : {false, true}) {
    CAPTURE(indexed);
    Stage stage(vulkan.device(), 20 * kNsPerS);
    stage.transport.duration_ns = stage.player->duration_ns();
    if (indexed) stage.make_index();
    stage.play(8 * kNsPerS);
    const TimeNs from_ns = stage.player->now_ns();
    REQUIRE(stage.state().heads != stage.replayed(from_ns).heads);  // steps were cut at the times of pictures
    for (const DurationNs by_ns : {300 * kNsPerMs, 5 * kNsPerMs, DurationNs{0}, 5 * kNsPerS, -2 * kNsPerS}) {
      CAPTURE(by_ns);
      const TimeNs until_ns = stage.player->now_ns() + by_ns;
      must(stage.player->seek(until_ns, stage.driven()));
      CHECK(stage.player->now_ns() == until_ns);
      CHECK(stage.exposed_ns == LogPlayer::kExposureNs);
      const render::FrameState state = stage.state();
      const render::FrameState expected = stage.replayed(until_ns);
      CHECK(state.heads == expected.heads);
      CHECK(state.time_ns == expected.time_ns);
    }
  }
}

// A seek that takes many parts: each look at the clock finds a part over.
struct SlowStage : Stage {
  explicit SlowStage(render::vk::Device& device_in) : Stage(device_in, 150 * kNsPerS) {  // no quick log
    player = std::make_unique<LogPlayer>([this] { return Timeline(log.again(), compiled); }, late);
    transport.duration_ns = player->duration_ns();
  }
  class LateClock final : public Clock {
   public:
    TimeNs now_ns() override { return now_ns_ += LogPlayer::kPartNs; }
    void sleep_until_ns(TimeNs) override {}

   private:
    TimeNs now_ns_ = 0;
  };
  LateClock late;
};

TEST_CASE("a long seek takes many turns, with the levels from before it, and ends at the states of a replay") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  SlowStage stage(vulkan.device());
  stage.play(2 * kNsPerS);
  const std::vector<std::uint8_t> before(stage.player->levels().begin(), stage.player->levels().end());
  stage.transport.seek_ns = 40 * kNsPerS;
  int turns = 0;
  TimeNs last_ns = -1;
  for (stage.turn(); stage.transport.seeking; stage.turn()) {
    ++turns;
    CHECK(stage.transport.now_ns == 40 * kNsPerS);
    CHECK(stage.player->now_ns() == 40 * kNsPerS);
    CHECK(stage.transport.seeking->from_ns == 0);
    CHECK(stage.transport.seeking->at_ns > last_ns);
    last_ns = stage.transport.seeking->at_ns;
    CHECK(std::equal(before.begin(), before.end(), stage.player->levels().begin(), stage.player->levels().end()));
    CHECK(!stage.player->can_hold(stage.transport, kPictureNs, stage.driven()));
    must(stage.player->work_at_index(kNsPerS, stage.driven()));  // waits
    CHECK(stage.player->index()->moments().empty());
    if (turns == 50) stage.transport.seek_ns = 45 * kNsPerS;  // another one further on goes on from here
    if (turns >= 50) break;
  }
  CHECK(turns == 50);
  const int restarts = stage.restarts;
  for (stage.turn(); stage.transport.seeking; stage.turn()) ++turns;
  CHECK(stage.restarts == restarts);
  CHECK(turns > 150);  // of a quarter of a second of the log
  CHECK(stage.player->now_ns() == 45 * kNsPerS);
  CHECK(stage.state().heads == stage.replayed(45 * kNsPerS).heads);
  CHECK(!std::equal(before.begin(), before.end(), stage.player->levels().begin(), stage.player->levels().end()));
  CHECK(stage.exposed_ns == LogPlayer::kExposureNs);
  stage.turn();  // the time of the last part, which is not played
  CHECK(stage.player->now_ns() == 45 * kNsPerS);
  stage.turn();
  CHECK(stage.player->now_ns() > 45 * kNsPerS);
}

TEST_CASE("a cancelled seek leaves the fixtures, the levels and the time as they were before it") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  SlowStage stage(vulkan.device());
  stage.transport.cancels_seek = true;  // none is under way
  stage.turn();
  CHECK(!stage.transport.cancels_seek);
  stage.play(2 * kNsPerS);
  stage.transport.playing = false;
  must(stage.frame->run_steps());
  const TimeNs at_ns = stage.player->now_ns();
  const render::FrameState before = stage.state();
  const std::vector<std::uint8_t> levels(stage.player->levels().begin(), stage.player->levels().end());
  for (const TimeNs until_ns : {50 * kNsPerS, 20 * kNsPerS}) {
    stage.transport.seek_ns = until_ns;  // the second one while the first one is under way
    for (int i = 0; i < 20; ++i) stage.turn();
    REQUIRE(stage.transport.seeking);
    REQUIRE(stage.state().heads != before.heads);
  }
  stage.transport.cancels_seek = true;
  stage.turn();
  CHECK(!stage.transport.seeking);
  CHECK(stage.transport.now_ns == at_ns);
  CHECK(stage.state().heads == before.heads);
  CHECK(stage.state().time_ns == before.time_ns);
  CHECK(std::equal(levels.begin(), levels.end(), stage.player->levels().begin(), stage.player->levels().end()));
  stage.transport.playing = true;
  stage.turn();
  CHECK(stage.player->now_ns() > at_ns);
  CHECK(stage.player->now_ns() < at_ns + kNsPerS);
}

TEST_CASE("a cancelled seek over a second of the log, and one that took the place of it, put the fixtures back") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  SlowStage stage(vulkan.device());
  stage.play(4 * kNsPerS);
  stage.transport.playing = false;
  must(stage.frame->run_steps());
  const TimeNs at_ns = stage.player->now_ns();
  const render::FrameState before = stage.state();
  stage.transport.seek_ns = 2 * kNsPerS;
  stage.turn();
  stage.transport.seek_ns = 55 * kNsPerS;
  for (int i = 0; i < 5; ++i) stage.turn();
  REQUIRE(stage.transport.seeking);
  stage.transport.cancels_seek = true;
  stage.turn();
  CHECK(stage.transport.now_ns == at_ns);
  CHECK(stage.state().heads == before.heads);
}

TEST_CASE("a log that goes back since it repeats stops when that is cancelled, and does not begin it anew") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  SlowStage stage(vulkan.device());
  must(stage.player->seek(50 * kNsPerS, stage.driven()));
  stage.taken_over = true;  // no moment is known
  stage.transport.repeat_from(40 * kNsPerS);
  stage.transport.repeat_to(51 * kNsPerS);
  while (!stage.transport.seeking) stage.turn(200 * kNsPerMs);
  CHECK(stage.transport.seeking->until_ns < 42 * kNsPerS);
  stage.transport.cancels_seek = true;
  stage.turn();
  stage.turn();
  CHECK(!stage.transport.seeking);
  CHECK(!stage.transport.playing);
  CHECK(stage.transport.now_ns > 49 * kNsPerS);
}

TEST_CASE("a seek that was under way when its frame was replaced begins anew, from states of the new frame") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  SlowStage stage(vulkan.device());
  stage.transport.seek_ns = 40 * kNsPerS;
  for (int i = 0; i < 40; ++i) stage.turn();
  REQUIRE(stage.transport.seeking);
  stage.frame = stage.make_frame();
  must(stage.player->seek(stage.player->now_ns(), stage.driven()));
  CHECK(!stage.player->seeking());
  CHECK(stage.player->now_ns() == 40 * kNsPerS);
  CHECK(stage.state().heads == stage.replayed(40 * kNsPerS).heads);
}

TEST_CASE("a seek keeps no moment for the next one if something was taken over in one of its parts") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  SlowStage stage(vulkan.device());
  stage.transport.playing = false;
  stage.transport.seek_ns = 30 * kNsPerS;
  for (stage.turn(); stage.transport.seeking; stage.turn()) {
    stage.taken_over = stage.transport.seeking->at_ns > 10 * kNsPerS && stage.transport.seeking->at_ns < 12 * kNsPerS;
  }
  stage.taken_over = false;
  const int restarts = stage.restarts;
  must(stage.player->seek(30 * kNsPerS + kNsPerS / 2, stage.driven()));
  CHECK(stage.restarts == restarts + 1);
  CHECK(stage.state().heads == stage.replayed(30 * kNsPerS + kNsPerS / 2).heads);
}

TEST_CASE("a seek ahead of what is indexed begins at the seek before") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Stage stage(vulkan.device(), 20 * kNsPerS);
  stage.transport.duration_ns = stage.player->duration_ns();
  must(stage.player->show(8 * kNsPerS, stage.driven()));
  stage.play(9 * kNsPerS);
  const int before = stage.steps;
  must(stage.player->seek(9 * kNsPerS + kNsPerS / 2, stage.driven()));
  CHECK(stage.steps - before < 45);  // a change each 70 ms, from 7 s on
  CHECK(stage.state().heads == stage.replayed(stage.player->now_ns()).heads);
  // Not one whose levels were not those of the log alone.
  stage.taken_over = true;
  must(stage.player->seek(15 * kNsPerS, stage.driven()));
  stage.taken_over = false;
  must(stage.player->seek(16 * kNsPerS, stage.driven()));
  CHECK(stage.state().heads == stage.replayed(16 * kNsPerS).heads);
}

TEST_CASE("the first picture of a frame is exposed for 20 ms, also at the end of the log and after an edit") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Stage stage(vulkan.device(), 150 * kNsPerS);
  must(stage.player->show(12 * kNsPerS, stage.driven()));
  CHECK(stage.exposed_ns == LogPlayer::kExposureNs);
  stage.player = stage.make_player();
  must(stage.player->show(1000 * kNsPerS, stage.driven()));
  CHECK(stage.exposed_ns == LogPlayer::kExposureNs);
  CHECK(stage.player->now_ns() == 150 * kNsPerS);

  // In a long log an edit starts two minutes before. Clouds of haze are where they were; a seek makes all exact.
  const TimeNs at_ns = 140 * kNsPerS;
  stage.frame = stage.make_frame();
  stage.player = stage.make_player();
  must(stage.player->show_soon(at_ns, stage.driven()));
  CHECK(stage.exposed_ns == LogPlayer::kExposureNs);
  CHECK(stage.player->now_ns() == at_ns);
  CHECK(stage.state().time_ns == at_ns);
  must(stage.player->seek(at_ns + kNsPerS, stage.driven()));
  CHECK(stage.state().heads == stage.replayed(at_ns + kNsPerS).heads);
}

TEST_CASE("the time that a seek takes is not played") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Stage stage(vulkan.device(), 20 * kNsPerS);
  stage.transport.duration_ns = stage.player->duration_ns();
  stage.jump_ns = 4 * kNsPerS;
  stage.transport.seek_ns = 10 * kNsPerS;
  stage.turn();
  CHECK(!stage.transport.seek_ns);
  stage.turn(stage.jump_ns + kPictureNs);
  CHECK(stage.transport.now_ns == 10 * kNsPerS + kPictureNs);

  // A part that is shorter than the time to go back to its start.
  stage.transport.repeat_from(10 * kNsPerS);
  stage.transport.repeat_to(11 * kNsPerS);
  DurationNs dt_ns = kPictureNs;
  const int before = stage.restarts;
  std::vector<TimeNs> shown;
  for (int i = 0; i < 180; ++i) {
    const TimeNs begun_ns = stage.clock.time_ns;
    stage.turn(dt_ns);
    shown.push_back(stage.player->now_ns());
    dt_ns = stage.clock.time_ns - begun_ns + kPictureNs;
  }
  CHECK(stage.restarts - before == 3);  // in 180 pictures of 17 ms
  CHECK(*std::min_element(shown.begin(), shown.end()) >= 10 * kNsPerS);
  CHECK(*std::max_element(shown.begin(), shown.end()) <= 11 * kNsPerS);
}

TEST_CASE("while a picture is in flight a log plays on by steps that wait in the frame, however many") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Stage stage(vulkan.device(), 200 * kNsPerS);
  stage.transport.duration_ns = stage.player->duration_ns();
  stage.turn();
  must(stage.frame->run_steps());
  stage.in_flight = true;
  const auto can_hold = [&](DurationNs dt_ns) {
    return stage.player->can_hold(stage.transport, dt_ns, stage.driven());
  };
  REQUIRE(can_hold(50 * kNsPerS));
  stage.turn(50 * kNsPerS);  // a change each 70 ms
  CHECK(stage.transport.now_ns == 50 * kNsPerS + kPictureNs);
  CHECK(stage.frame->pending_steps() > render::kStepsHeldMax);
  CHECK(!can_hold(kPictureNs));  // too many wait
  stage.in_flight = false;
  must(stage.frame->run_steps());
  CHECK(can_hold(kPictureNs));
  CHECK(stage.state().heads != stage.replayed(0).heads);

  stage.transport.seek_ns = 10 * kNsPerS;
  CHECK(!can_hold(kPictureNs));
  stage.transport.seek_ns.reset();
  stage.transport.repeat_to(stage.player->now_ns() + kPictureNs);
  CHECK(can_hold(kPictureNs / 2));
  CHECK(!can_hold(2 * kPictureNs));  // back to the start
  stage.transport.playing = false;
  CHECK(can_hold(2 * kPictureNs));
  stage.transport.repeat_all();
  stage.transport.playing = true;
  must(stage.player->work_at_index(kNsPerS, stage.driven()));
  while (!stage.player->index()->done()) must(stage.player->work_at_index(kNsPerS, stage.driven()));
  CHECK(can_hold(kPictureNs));
  CHECK(!can_hold(30 * kNsPerS));  // a moment is nearer
}

TEST_CASE("what is taken over moves in a pause, and at the end of a log that does not repeat") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  for (const DurationNs end_ns : {DurationNs{0}, kNsPerS}) {
    CAPTURE(end_ns);
    Stage stage(vulkan.device(), end_ns);
    stage.transport.duration_ns = end_ns;
    must(stage.player->show(end_ns, stage.driven()));
    for (const bool playing : {true, false}) {
      CAPTURE(playing);
      stage.transport.playing = playing;
      stage.taken_over = false;
      must(stage.player->seek(end_ns, stage.driven()));
      int steps = stage.steps;
      stage.turn();
      CHECK(stage.steps == steps);  // the fixtures stand still
      stage.taken_over = true;
      stage.turn();
      CHECK(stage.steps == ++steps);
      CHECK(stage.exposed_ns == kPictureNs);
      stage.taken_over = false;
      stage.turn();
      CHECK(stage.steps == ++steps);  // back to the levels of the log
    }
  }
}

TEST_CASE("while something is taken over no seek back is quick, and a seek ahead goes on from what is shown") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Stage stage(vulkan.device(), 20 * kNsPerS);
  stage.transport.duration_ns = stage.player->duration_ns();
  stage.transport.playing = false;
  stage.make_index();
  stage.turn();
  CHECK(stage.transport.known_ns == stage.player->duration_ns());
  stage.taken_over = true;
  stage.turn();
  CHECK(stage.transport.known_ns == 0);
  const int restarts = stage.restarts;
  must(stage.player->seek(10 * kNsPerS, stage.driven()));
  CHECK(stage.restarts == restarts);
  CHECK(stage.exposed_ns == LogPlayer::kExposureNs);
  must(stage.player->seek(10 * kNsPerS + kNsPerMs, stage.driven()));
  CHECK(stage.restarts == restarts + 1);
  CHECK(stage.exposed_ns == LogPlayer::kExposureNs);
}

TEST_CASE("a log that cannot be read to its end loses its index with a message, and plays on where it is") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TempFolder folder;
  const std::string path = folder.file("a.dmxlog.part");
  const auto bytes = log_of(20 * kNsPerS);
  testing::write_bytes(path, std::string(bytes.begin(), bytes.end()));
  Stage stage(vulkan.device(), must(LogReader::open(path)));
  stage.transport.duration_ns = stage.player->duration_ns();
  stage.play(kNsPerS);
  std::filesystem::rename(path, folder.file("a.dmxlog"));
  must(stage.player->seek(kNsPerS / 2, stage.driven()));  // from the start
  CHECK(stage.state().heads == stage.replayed(kNsPerS / 2).heads);

  std::filesystem::resize_file(folder.file("a.dmxlog"), bytes.size() / 2);
  const render::FrameState before = stage.state();
  for (int i = 0; i < 1000 && stage.player->index() != nullptr; ++i) {
    must(stage.player->work_at_index(kNsPerMs, stage.driven()));
  }
  CHECK(stage.player->index() == nullptr);
  const std::string news = stage.player->take_news();
  CHECK(news.find(path + ": ") == 0);
  CHECK(news.find("start of the log") != std::string::npos);
  CHECK(stage.state().heads == before.heads);
  CHECK(stage.state().time_ns == before.time_ns);
  stage.turn();
  CHECK(stage.player->now_ns() == kNsPerS / 2 + kPictureNs);
  CHECK(stage.transport.known_ns == 0);
  must(stage.player->seek(kNsPerS, stage.driven()));
  CHECK(stage.state().heads == stage.replayed(kNsPerS).heads);
}

TEST_CASE("the automatic exposure begins anew after a seek, and goes on while the log plays") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Stage stage(vulkan.device(), 5 * kNsPerS);
  stage.transport.duration_ns = stage.player->duration_ns();
  must(vulkan.device().run_once([&](VkCommandBuffer commands) {
    constexpr float kLuminance = 8;
    vkCmdUpdateBuffer(commands, stage.frame->resources().rig.meter.handle, 0, sizeof(kLuminance), &kLuminance);
  }));
  const double metered_ev = must(stage.frame->read_exposure_ev());
  REQUIRE(metered_ev != 0);
  stage.play(kNsPerS);
  CHECK(must(stage.frame->read_exposure_ev()) == metered_ev);
  must(stage.player->seek(3 * kNsPerS, stage.driven()));
  CHECK(must(stage.frame->read_exposure_ev()) == 0);  // that of pictures before the first light
}

// A frame with all passes, of a floor in haze as well.
std::unique_ptr<render::Frame> whole_frame(const Stage& stage, int width, int height) {
  render::FrameSettings settings{.width = width, .height = height};
  settings.edge_samples = 0;
  return must(render::Frame::create(stage.device, stage.rig, stage.compiled, settings));
}

// Where the light of the head comes down.
fixtures::Camera stage_camera() {
  fixtures::Camera camera;
  camera.position_m = {0, -12, 3};
  camera.target_m = {0, 0, 2};
  camera.exposure_ev = 0;
  return camera;
}

std::vector<std::uint8_t> drawn(render::Frame& frame) {
  must(frame.draw(render::view_of(stage_camera()), stage_camera().exposure_ev));
  return must(frame.read_screen()).rgba;
}

// As `footlight render --at` makes it.
std::vector<std::uint8_t> rendered(const Stage& stage, TimeNs at_ns, int width, int height) {
  const auto frame = whole_frame(stage, width, height);
  Timeline timeline(stage.log.again(), stage.compiled);
  must(advance_frame(timeline, *frame, at_ns, LogPlayer::kExposureNs,
                     [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
                       frame->step(levels, dt_ns, new_exposure);
                     }));
  return drawn(*frame);
}

TEST_CASE("the picture after a seek is that of render at this time to the byte, and playing there shows the same") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Stage stage(vulkan.device(), 8 * kNsPerS);
  stage.frame = whole_frame(stage, 64, 36);
  stage.transport.duration_ns = stage.player->duration_ns();
  stage.make_index();
  std::ptrdiff_t lit = 0;
  for (const TimeNs at_ns : {5 * kNsPerS, 2300 * kNsPerMs}) {
    CAPTURE(at_ns);
    must(stage.player->seek(at_ns, stage.driven()));
    const std::vector<std::uint8_t> sought = drawn(*stage.frame);
    CHECK(sought == rendered(stage, at_ns, 64, 36));
    lit += std::count_if(sought.begin(), sought.end(), [](std::uint8_t level) { return level > 20 && level < 255; });
    // Steps of a log that plays are cut at pictures: states differ in their last bits, and bytes by one at most.
    Stage playing(vulkan.device(), 8 * kNsPerS);
    playing.frame = whole_frame(playing, 64, 36);
    playing.transport.duration_ns = playing.player->duration_ns();
    while (playing.player->now_ns() < at_ns) {
      playing.turn(std::min<DurationNs>(20 * kNsPerMs, at_ns - playing.player->now_ns()));
    }
    const std::vector<std::uint8_t> played = drawn(*playing.frame);
    int worst = 0;
    for (std::size_t i = 0; i < played.size(); ++i) worst = std::max(worst, std::abs(int{played[i]} - int{sought[i]}));
    CHECK(worst <= 1);
  }
  CHECK(lit > 100);
}

TEST_CASE("small pictures show the moments of the log, and the pictures of the stage go on as if there were none") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  Stage stage(vulkan.device(), 8 * kNsPerS);
  stage.frame = whole_frame(stage, 64, 36);
  stage.transport.duration_ns = stage.player->duration_ns();
  LogThumbnails small;
  CHECK(!small.is_due(0, nullptr, stage.player->duration_ns(), false));
  stage.make_index();
  stage.play(3 * kNsPerS);
  const render::FrameState before = stage.state();
  const std::vector<std::uint8_t> shown = drawn(*stage.frame);
  const SeekIndex& index = *stage.player->index();
  const DurationNs duration_ns = stage.player->duration_ns();
  TimeNs now_ns = 0;
  while (small.is_due(now_ns, &index, duration_ns, false)) {
    must(small.begin(now_ns, stage.device, *stage.frame, index, duration_ns, {stage_camera(), 0}));
    if (!small.in_flight()) continue;  // no other moment for this part of the log
    CHECK(must(small.done(StagePicture::kForeverNs)));
    must(small.finish(now_ns + 50 * kNsPerMs, *stage.frame));
    CHECK(!small.is_due(now_ns + 800 * kNsPerMs, &index, duration_ns, false));  // at most 6 % of the time
    CHECK(small.took_ns() == 50 * kNsPerMs);
    now_ns += 900 * kNsPerMs;
  }
  CHECK(stage.state().heads == before.heads);
  CHECK(drawn(*stage.frame) == shown);
  REQUIRE(small.pictures().all().size() == index.moments().size());
  Thumbnails expected;
  const auto other = whole_frame(stage, Thumbnails::kWidth, Thumbnails::kHeight);
  for (const SeekIndex::Moment& moment : index.moments()) {
    must(other->load_state(moment.state));
    other->step(moment.position.levels, 20 * kNsPerMs, true);
    expected.add(moment.position.now_ns, drawn(*other));
    const Thumbnails::Picture* made = small.pictures().nearest(moment.position.now_ns, 0);
    REQUIRE(made != nullptr);
    CHECK(made->pixels == expected.all().back().pixels);
  }
  CHECK(expected.all().front().pixels != expected.all().back().pixels);
}

TEST_CASE("the curve of a log has every moment, also after every other one was dropped") {
  const fixtures::Rig rig = must(fixtures::parse_rig(Stage::kRig, "r.toml"));
  const fixtures::CompiledRig compiled = must(fixtures::compile(rig));
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const Stage stage(vulkan.device(), 40 * kNsPerS);
  const auto timeline = [&] { return Timeline(stage.log.again(), compiled); };
  LookedAtClock clock;
  SeekIndex whole(timeline());
  while (!whole.done()) must(whole.work(*stage.frame, clock, kNsPerS));
  SeekIndex index(timeline(), whole.bytes() / 2);
  LightCurve curve(rig, RigIndex(rig, compiled));
  while (!index.done()) {
    must(index.work(*stage.frame, clock, 6 * kNsPerMs));  // some moments
    extend(curve, index);
    for (const SeekIndex::Moment& moment : index.moments()) {
      CHECK(std::any_of(curve.points().begin(), curve.points().end(),
                        [&](const LightCurve::Point& point) { return point.at_ns == moment.position.now_ns; }));
    }
  }
}

}  // namespace
}  // namespace footlight::tools
