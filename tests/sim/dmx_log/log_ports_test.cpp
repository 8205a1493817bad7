#include <algorithm>
#include <chrono>
#include <thread>

#include "sim/dmx_log/log_ports.h"
#include "tests/sim/dmx_log/support.h"
#include "tests/support/fake_clock.h"

using namespace footlight;
using namespace footlight::testing;

namespace {

struct Recorder final : FrameReceiver {
  void receive(const FrameView& frame) override {
    OwnedFrame owned{
        frame.stamp_ns, frame.universe, frame.sender, frame.sequence, frame.priority, frame.terminated, {}};
    owned.slots.assign(frame.slots.begin(), frame.slots.end());
    frames.push_back(owned);
  }
  std::vector<OwnedFrame> frames;  // time_ns is the stamp
};

// Frames every 10 ms, universes 1 and 2 alternately; the level counts frames.
std::vector<OwnedFrame> ticks(int count) {
  std::vector<OwnedFrame> frames;
  for (int i = 0; i < count; ++i) {
    OwnedFrame frame;
    frame.universe = 1 + i % 2;
    frame.time_ns = i * 10 * kNsPerMs;
    frame.sender = 5;
    frame.slots.assign(512, static_cast<std::uint8_t>(i));
    frames.push_back(frame);
  }
  return frames;
}

std::unique_ptr<LogSource> source_of(const std::vector<OwnedFrame>& frames, DurationNs end_ns,
                                     const LogSourceOptions& options = {}) {
  LogWriterOptions writer_options;
  writer_options.block_span_ns = 35 * kNsPerMs;
  writer_options.origin_ns = 999;
  auto source = LogSource::from_reader(open_log(log_bytes(frames, end_ns, writer_options)), "log:a.dmxlog", options);
  REQUIRE_MESSAGE(source, source.error().message);
  return std::move(*source);
}

// Runs like the pump: sleeps until the deadline, polls. Stops after `deadlines` deadlines.
void run(LogSource& source, FakeClock& clock, Recorder& recorder, int deadlines = 100'000) {
  while (source.state() != PortState::kEnded && deadlines-- > 0) {
    REQUIRE(source.next_deadline_ns() != kTimeNever);
    clock.sleep_until_ns(source.next_deadline_ns());
    REQUIRE(source.poll(clock.now_ns(), recorder));
  }
}

std::string error_of(const LogSourceOptions& options) {
  auto source = LogSource::from_reader(open_log(log_bytes(ticks(10), kNsPerS)), "log:a.dmxlog", options);
  REQUIRE(!source);
  CHECK(source.error().code == ErrorCode::kBadInput);
  return source.error().message;
}

}  // namespace

TEST_CASE("a replayed frame is due exactly at its recorded time, and the replay ends when the recording ended") {
  const auto frames = ticks(50);
  auto source = source_of(frames, 700 * kNsPerMs);
  FakeClock clock(123'456'789);
  Recorder recorder;
  run(*source, clock, recorder);
  REQUIRE(recorder.frames.size() == frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    CHECK(recorder.frames[i].time_ns == 123'456'789 + frames[i].time_ns);
    CHECK(recorder.frames[i].slots == frames[i].slots);
  }
  CHECK(clock.now_ns() == 123'456'789 + 700 * kNsPerMs);
  CHECK(source->state() == PortState::kEnded);
  CHECK(source->next_deadline_ns() == kTimeNever);
  CHECK(source->counters().frames == frames.size());
  CHECK(std::vector<Universe>(source->universes().begin(), source->universes().end()) == std::vector<Universe>{1, 2});
}

TEST_CASE("delays do not add up: after late wake-ups the deadlines are the same") {
  const auto frames = ticks(100);
  auto source = source_of(frames, kNsPerS);
  Recorder recorder;
  Random random(4);
  source->start(0);
  TimeNs now_ns = 0;
  while (source->state() != PortState::kEnded) {
    const TimeNs deadline_ns = source->next_deadline_ns();
    CHECK((deadline_ns % (10 * kNsPerMs)) == 0);
    now_ns = std::max(now_ns, deadline_ns) + static_cast<DurationNs>(random.below(4'000'000));
    REQUIRE(source->poll(now_ns, recorder));
  }
  REQUIRE(recorder.frames.size() == frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) CHECK(recorder.frames[i].time_ns == frames[i].time_ns);
  CHECK(now_ns < kNsPerS + 4 * kNsPerMs);
}

TEST_CASE("after a long stall all due frames arrive at once, oldest first, stamped with their due times") {
  const auto frames = ticks(60);
  auto source = source_of(frames, kNsPerS);
  Recorder recorder;
  source->start(0);
  REQUIRE(source->poll(0, recorder));
  CHECK(recorder.frames.size() == 1);
  REQUIRE(source->poll(5 * kNsPerMs, recorder));  // too early for the next
  CHECK(recorder.frames.size() == 1);
  REQUIRE(source->poll(405 * kNsPerMs, recorder));
  REQUIRE(recorder.frames.size() == 41);
  for (std::size_t i = 0; i < 41; ++i) CHECK(recorder.frames[i].time_ns == frames[i].time_ns);
  CHECK(source->next_deadline_ns() == 410 * kNsPerMs);
}

TEST_CASE("a loop has no gap and no double frame, pass after pass") {
  const auto frames = ticks(20);
  LogSourceOptions options;
  options.loop = true;
  auto source = source_of(frames, 200 * kNsPerMs, options);
  FakeClock clock(1000);
  Recorder recorder;
  run(*source, clock, recorder, 500);
  REQUIRE(recorder.frames.size() > 400);
  for (std::size_t i = 0; i < recorder.frames.size(); ++i) {
    REQUIRE(recorder.frames[i].time_ns == 1000 + static_cast<TimeNs>(i) * 10 * kNsPerMs);
    REQUIRE(recorder.frames[i].slots == frames[i % 20].slots);
  }
  CHECK(source->passes() >= 20);
  CHECK(source->state() == PortState::kWorking);
}

TEST_CASE("a part of a log loops with the snapshot at its start") {
  const auto frames = ticks(20);
  LogSourceOptions options;
  options.loop = true;
  options.start_ns = 55 * kNsPerMs;
  options.stop_ns = 80 * kNsPerMs;
  auto source = source_of(frames, 200 * kNsPerMs, options);
  Recorder recorder;
  source->start(0);
  REQUIRE(source->poll(49 * kNsPerMs, recorder));
  // Two universes in their state at 55 ms, frames 6 and 7 (60 and 70 ms); again after 25 ms. Frame 8 is past the stop.
  std::vector<std::pair<TimeNs, int>> got;
  for (const OwnedFrame& frame : recorder.frames) got.emplace_back(frame.time_ns / 1'000'000, frame.slots[0]);
  CHECK(got ==
        std::vector<std::pair<TimeNs, int>>{{0, 4}, {0, 5}, {5, 6}, {15, 7}, {25, 4}, {25, 5}, {30, 6}, {40, 7}});
}

TEST_CASE("speed scales the deadlines, not the frames") {
  for (const double speed : {0.5, 2.0, 3.0}) {
    CAPTURE(speed);
    const auto frames = ticks(50);
    LogSourceOptions options;
    options.speed = speed;
    auto source = source_of(frames, kNsPerS, options);
    FakeClock clock(0);
    Recorder recorder;
    run(*source, clock, recorder);
    REQUIRE(recorder.frames.size() == 50);
    for (std::size_t i = 0; i < 50; ++i) {
      const double due_ns = static_cast<double>(frames[i].time_ns) / speed;
      CHECK(std::abs(static_cast<double>(recorder.frames[i].time_ns) - due_ns) <= 0.5);
    }
    CHECK(std::abs(static_cast<double>(clock.now_ns()) - 1e9 / speed) <= 0.5);
  }
}

TEST_CASE("universes are renumbered, and with only_renumbered the others are left out") {
  LogSourceOptions options;
  options.renumber = {{2, 17}};
  FakeClock clock(0);
  {
    auto source = source_of(ticks(4), kNsPerS, options);
    CHECK(std::vector<Universe>(source->universes().begin(), source->universes().end()) ==
          std::vector<Universe>{1, 17});
    Recorder recorder;
    run(*source, clock, recorder);
    REQUIRE(recorder.frames.size() == 4);
    CHECK(recorder.frames[1].universe == 17);
  }
  options.only_renumbered = true;
  auto source = source_of(ticks(4), kNsPerS, options);
  Recorder recorder;
  run(*source, clock, recorder);
  REQUIRE(recorder.frames.size() == 2);
  CHECK(recorder.frames[0].universe == 17);
}

TEST_CASE("senders stay distinct and differ from those of other logs") {
  auto frames = ticks(4);
  frames[2].sender = 6;
  auto source = source_of(frames, kNsPerS);
  FakeClock clock(0);
  Recorder recorder;
  run(*source, clock, recorder);
  CHECK(recorder.frames[0].sender == recorder.frames[1].sender);
  CHECK(recorder.frames[0].sender != recorder.frames[2].sender);
  CHECK(recorder.frames[0].sender > 1000);
}

TEST_CASE("invalid playback options are refused with the reason") {
  LogSourceOptions late;
  late.start_ns = 2 * kNsPerS;
  CHECK(error_of(late) == "log:a.dmxlog: cannot start at 2.000 s; the log lasts 1.000 s");
  LogSourceOptions backwards;
  backwards.start_ns = 500 * kNsPerMs;
  backwards.stop_ns = 400 * kNsPerMs;
  CHECK(error_of(backwards).find("no time between the start at 0.500 s") != std::string::npos);
  LogSourceOptions empty_loop;
  empty_loop.loop = true;
  empty_loop.start_ns = kNsPerS;
  CHECK(error_of(empty_loop).find("no time between") != std::string::npos);
  for (const double speed : {0.0, -1.0, 1e9, std::nan("")}) {
    LogSourceOptions bad_speed;
    bad_speed.speed = speed;
    CHECK(error_of(bad_speed).find("expected a speed from 0.001 to 1000") != std::string::npos);
  }
  LogSourceOptions collision;
  collision.renumber = {{1, 2}};
  CHECK(error_of(collision).find("two universes of the log would both become universe 2") != std::string::npos);
  LogSourceOptions twice;
  twice.renumber = {{1, 3}, {1, 4}};
  CHECK(error_of(twice).find("universe 1 is renumbered twice") != std::string::npos);
  LogSourceOptions outside;
  outside.renumber = {{1, 0}};
  CHECK(error_of(outside).find("expected universes from 1 to 63999, got 1 to 0") != std::string::npos);
}

TEST_CASE("an OLA Show plays like a log") {
  const TempFolder folder;
  write_bytes(folder.file("a.show"), "OLA Show\n1 1\n20\n2 5\n30\n1 2\n50\n");
  auto input = open_log_input(folder.file("a.show"));
  REQUIRE(input);
  auto reader = read_into_memory(**input);
  REQUIRE(reader);
  auto source = LogSource::from_reader(std::move(*reader), "log:a.show");
  REQUIRE_MESSAGE(source, source.error().message);
  FakeClock clock(0);
  Recorder recorder;
  run(**source, clock, recorder);
  REQUIRE(recorder.frames.size() == 3);
  CHECK(recorder.frames[2].time_ns == 50 * kNsPerMs);
  CHECK(clock.now_ns() == 100 * kNsPerMs);
  CHECK(!open_log_input(folder.file("none.dmxlog")));
}

TEST_CASE("the sink records every frame with its stamp, and the end passed to close()") {
  const TempFolder folder;
  const std::string path = folder.file("a.dmxlog");
  LogSinkOptions options;
  options.universes = {2, 1};
  options.start_ns = kNsPerS;
  options.writer.block_span_ns = 100 * kNsPerMs;
  auto sink = LogSink::create(path, options);
  REQUIRE_MESSAGE(sink, sink.error().message);
  const auto frames = ticks(300);
  for (const OwnedFrame& frame : frames) {
    FrameView batch[2] = {frame.view(kNsPerS), frame.view(kNsPerS)};
    batch[1].universe = 9;  // not recorded
    FrameView priorities = frame.view(kNsPerS);
    priorities.start_code = kStartCodePriorities;
    REQUIRE((*sink)->send(priorities.stamp_ns, {&priorities, 1}));
    const TimeNs now_ns = batch[0].stamp_ns + 123'456;  // later than the stamp
    REQUIRE((*sink)->send(now_ns, batch));
    if ((*sink)->next_deadline_ns() <= now_ns) REQUIRE((*sink)->poll(now_ns));
  }
  CHECK((*sink)->state() == PortState::kWorking);
  (*sink)->close(kNsPerS + 60 * kNsPerS);
  CHECK((*sink)->state() == PortState::kEnded);
  CHECK((*sink)->trouble().empty());
  CHECK((*sink)->counters().frames == 300);
  CHECK((*sink)->counters().dropped == 0);
  CHECK((*sink)->stats().frames == 300);
  CHECK((*sink)->stats().not_levels == 300);
  auto reader = LogReader::open(path);
  REQUIRE(reader);
  CHECK(reader->info().duration_ns == 60 * kNsPerS);
  CHECK(reader->info().origin_ns == kNsPerS);
  CHECK(all_frames(*reader) == frames);
}

TEST_CASE("after a minute and after an hour a replay matches the recording to the nanosecond") {
  for (const DurationNs length_ns : {60 * kNsPerS, 3'600 * kNsPerS}) {
    CAPTURE(length_ns);
    const TempFolder folder;
    const std::string path = folder.file("a.dmxlog");
    constexpr TimeNs kRecordedFromNs = 987'654'321'012'345;
    LogSinkOptions options;
    options.universes = {1};
    options.start_ns = kRecordedFromNs;
    options.waiting_bytes_max = 1u << 30;  // the simulated hour takes no time, so the disk cannot keep up
    auto sink = LogSink::create(path, options);
    REQUIRE(sink);
    FakeClock clock(kRecordedFromNs);
    Random random(77);
    std::vector<DurationNs> times;
    std::vector<std::uint8_t> slots(24);
    // 22.727272 ms, which no rounding divides
    for (DurationNs due_ns = 0; due_ns < length_ns; due_ns += kNsPerS / 44) {
      clock.sleep_until_ns(kRecordedFromNs + due_ns + static_cast<DurationNs>(random.below(300'000)));
      slots[random.below(slots.size())] = random.byte();
      FrameView frame;
      frame.universe = 1;
      frame.stamp_ns = clock.now_ns();
      frame.slots = slots;
      times.push_back(frame.stamp_ns - kRecordedFromNs);
      REQUIRE((*sink)->send(clock.now_ns(), {&frame, 1}));
      if ((*sink)->next_deadline_ns() <= clock.now_ns()) REQUIRE((*sink)->poll(clock.now_ns()));
    }
    clock.sleep_until_ns(kRecordedFromNs + length_ns);
    (*sink)->close(clock.now_ns());
    REQUIRE((*sink)->counters().dropped == 0);

    auto reader = LogReader::open(path);
    REQUIRE(reader);
    auto source = LogSource::from_reader(std::move(*reader), "log:a.dmxlog");
    REQUIRE(source);
    FakeClock player(5'000);
    struct Times final : FrameReceiver {
      void receive(const FrameView& frame) override { stamps.push_back(frame.stamp_ns); }
      std::vector<TimeNs> stamps;
    } played;
    while ((*source)->state() != PortState::kEnded) {
      player.sleep_until_ns((*source)->next_deadline_ns() + static_cast<DurationNs>(random.below(80'000)));  // late
      REQUIRE((*source)->poll(player.now_ns(), played));
    }
    const TimeNs started_ns = played.stamps.front() - times.front();
    REQUIRE(played.stamps.size() == times.size());
    bool exact = true;
    for (std::size_t i = 0; i < times.size(); ++i) exact = exact && played.stamps[i] == started_ns + times[i];
    CHECK(exact);
    CHECK(player.now_ns() - started_ns >= length_ns);
    CHECK(player.now_ns() - started_ns < length_ns + kNsPerMs);
  }
}

TEST_CASE("a sink destroyed without close leaves all its frames in an unfinished log") {
  const TempFolder folder;
  const std::string path = folder.file("a.dmxlog");
  const auto frames = ticks(30);
  {
    LogSinkOptions options;
    options.universes = {1, 2};
    auto sink = LogSink::create(path, options);
    REQUIRE(sink);
    for (const OwnedFrame& frame : frames) {
      const FrameView view = frame.view();
      REQUIRE((*sink)->send(frame.time_ns, {&view, 1}));
    }
  }
  auto reader = LogReader::open(path + ".part");
  REQUIRE(reader);
  CHECK(!reader->info().finished);
  CHECK(all_frames(*reader) == frames);
}

TEST_CASE("a recorder killed at any moment leaves a log with every frame older than a second") {
  const TempFolder folder;
  const std::string path = folder.file("a.dmxlog");
  // 44 Hz, then one frame after a second and a half, then silence; at last frames without a pause of 2 ms.
  std::vector<DurationNs> times;
  for (int i = 0; i < 120; ++i) times.push_back(DurationNs{i} * kNsPerS / 44);
  times.push_back(times.back() + 1'500 * kNsPerMs);
  for (int i = 0; i < 700; ++i) times.push_back(6 * kNsPerS + DurationNs{i} * 1'900 * kNsPerUs);
  LogSinkOptions options;
  options.universes = {1};
  auto sink = LogSink::create(path, options);
  REQUIRE(sink);
  FakeClock clock(0);
  std::vector<OwnedFrame> frames;
  // The file as the kernel has it now: a kill loses only what was not written.
  const auto holds = [&](std::size_t count) {
    auto reader = LogReader::open(path + ".part");
    if (!reader) return count == 0;
    const auto got = all_frames(*reader);
    return got.size() >= count && got.size() <= frames.size() && std::equal(got.begin(), got.end(), frames.begin());
  };
  std::size_t next = 0;
  std::size_t held = 0;
  while (clock.now_ns() < 9 * kNsPerS) {
    const TimeNs frame_ns = next < times.size() ? times[next] : kTimeNever;
    clock.sleep_until_ns(std::min(frame_ns, (*sink)->next_deadline_ns()));
    if (clock.now_ns() == frame_ns) {
      OwnedFrame frame;
      frame.universe = 1;
      frame.time_ns = frame_ns;
      frame.sequence = static_cast<std::uint32_t>(next);
      frame.slots.assign(512, static_cast<std::uint8_t>(next));
      frames.push_back(frame);
      const FrameView view = frames.back().view();
      REQUIRE((*sink)->send(frame_ns, {&view, 1}));
      ++next;
    }
    if ((*sink)->next_deadline_ns() <= clock.now_ns()) REQUIRE((*sink)->poll(clock.now_ns()));
    std::size_t old = held;
    while (old < frames.size() && frames[old].time_ns <= clock.now_ns() - kNsPerS) ++old;
    const bool burst = frames.size() > 200 && old < times.size();
    if (old == held || (burst && old % 8 != 0)) continue;
    // The clock stands still meanwhile; the writing thread needs no further call.
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!holds(old) && std::chrono::steady_clock::now() < give_up) std::this_thread::yield();
    CAPTURE(clock.now_ns());
    REQUIRE(holds(old));
    held = old;
  }
  CHECK(held == times.size());
}

TEST_CASE("frames without room are counted as dropped") {
  const TempFolder folder;
  LogSinkOptions options;
  options.universes = {1, 2};
  options.waiting_bytes_max = 100;  // less than one frame
  auto sink = LogSink::create(folder.file("a.dmxlog"), options);
  REQUIRE(sink);
  const auto frames = ticks(3);
  for (const OwnedFrame& frame : frames) {
    const FrameView view = frame.view();
    REQUIRE((*sink)->send(frame.time_ns, {&view, 1}));
  }
  CHECK((*sink)->counters().dropped == 3);
  CHECK((*sink)->counters().frames == 0);
}

TEST_CASE("a disk error makes a sink kGone with the reason") {
  const TempFolder folder;
  const std::string path = folder.file("a.dmxlog");
  LogSinkOptions options;
  options.universes = {1};
  auto sink = LogSink::create(path, options);
  REQUIRE(sink);
  write_bytes(path, "another program's");  // takes the name meanwhile
  (*sink)->close(kNsPerS);
  CHECK((*sink)->state() == PortState::kGone);
  CHECK((*sink)->trouble().find("a.dmxlog: exists; the recording is complete under the name") != std::string::npos);
  CHECK((*sink)->counters().errors == 1);
  CHECK(LogReader::open(path + ".part")->info().finished);

  LogSinkOptions none;
  CHECK(!LogSink::create(folder.file("b.dmxlog"), none));
  none.universes = {0};
  CHECK(!LogSink::create(folder.file("b.dmxlog"), none));
}
