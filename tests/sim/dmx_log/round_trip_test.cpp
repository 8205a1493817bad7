#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>

#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>

#include "sim/dmx_log/log_input.h"
#include "sim/dmx_log/ola_show.h"
#include "tests/sim/dmx_log/support.h"

using namespace footlight;
using namespace footlight::testing;

namespace {

LogWriterOptions small_blocks(DurationNs span_ns = 50 * kNsPerMs) {
  LogWriterOptions options;
  options.block_span_ns = span_ns;
  return options;
}

}  // namespace

TEST_CASE("a log returns every frame as it was written, for any traffic") {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    CAPTURE(seed);
    const auto frames = random_frames(seed, 400, 1 + static_cast<int>(seed % 9));
    LogWriterOptions options = small_blocks(1 + static_cast<DurationNs>(seed) * 20 * kNsPerMs);
    options.origin_ns = static_cast<TimeNs>(seed) * 1'000'000'007 - 5'000'000'000;
    options.wall_start_unix_ns = 1'700'000'000'123'456'789;
    LogReader reader = open_log(log_bytes(frames, 10 * kNsPerS, options));
    CHECK(all_frames(reader) == frames);
    CHECK(reader.info().damage_count == 0);
    CHECK(reader.info().finished);
    CHECK(reader.info().frames == frames.size());
    CHECK(reader.info().origin_ns == options.origin_ns);
    CHECK(reader.info().wall_start_unix_ns == options.wall_start_unix_ns);
    REQUIRE(reader.rewind());
    CHECK(all_frames(reader) == frames);
  }
}

TEST_CASE("snapshots hold all 512 slots and the changes list exactly the slots that differ") {
  const auto frames = random_frames(77, 600, 3);
  LogReader reader = open_log(log_bytes(frames, 10 * kNsPerS, small_blocks()));
  std::map<Universe, Slots> snapshots;
  LogFrame frame;
  std::size_t at = 0;
  while (*reader.next(frame)) {
    const OwnedFrame& truth = frames[at++];
    Slots& snapshot = snapshots[truth.universe];
    std::vector<bool> changed(512, false);
    for (std::size_t slot = 0; slot < truth.slots.size(); ++slot) {
      changed[slot] = snapshot[slot] != truth.slots[slot];
      snapshot[slot] = truth.slots[slot];
    }
    REQUIRE(frame.levels.size() == 512);
    REQUIRE(std::equal(frame.levels.begin(), frame.levels.end(), snapshot.begin()));
    std::vector<bool> listed(512, false);
    for (const SlotRun& run : frame.changes) {
      for (int slot = run.first; slot < run.first + run.count; ++slot) listed[static_cast<std::size_t>(slot)] = true;
    }
    REQUIRE(listed == changed);
  }
  CHECK(at == frames.size());
}

TEST_CASE("a recording stores its duration to the nanosecond, also if its last frame came before the end") {
  OwnedFrame frame;
  frame.universe = 1;
  frame.time_ns = 59'977'000'001;
  frame.slots = {1, 2, 3};
  CHECK(open_log(log_bytes({frame}, 60 * kNsPerS)).info().duration_ns == 60 * kNsPerS);
  CHECK(open_log(log_bytes({}, 60 * kNsPerS + 1)).info().duration_ns == 60 * kNsPerS + 1);
  // The end is never before the last frame.
  CHECK(open_log(log_bytes({frame}, 1)).info().duration_ns == frame.time_ns);
}

TEST_CASE("another reader of a log begins at its start, and reads the file that was opened whatever its name is now") {
  const TempFolder folder;
  const auto frames = random_frames(7, 500, 5);
  const auto bytes = log_bytes(frames, frames.back().time_ns, small_blocks());
  write_bytes(folder.file("a.dmxlog"), std::string(bytes.begin(), bytes.end()));
  auto opened = LogReader::open(folder.file("a.dmxlog"));
  REQUIRE_MESSAGE(opened, opened.error().message);
  LogFrame frame;
  for (int i = 0; i < 250; ++i) REQUIRE(*opened->next(frame));
  std::filesystem::remove(folder.file("a.dmxlog"));
  LogReader other = opened->again();
  CHECK(other.info().duration_ns == opened->info().duration_ns);
  CHECK(all_frames(other) == frames);
  REQUIRE(other.seek(frames[100].time_ns));  // the first one stays where it is
  REQUIRE(*opened->next(frame));
  CHECK(own(frame) == frames[250]);
}

TEST_CASE("seeking to any time gives the same snapshot as reading from the start") {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    CAPTURE(seed);
    const auto frames = random_frames(100 + seed, 500, 5);
    const DurationNs last_ns = frames.back().time_ns;
    LogReader reader = open_log(log_bytes(frames, last_ns, small_blocks()));
    Random random(seed);
    for (int trial = 0; trial < 60; ++trial) {
      DurationNs time_ns = static_cast<DurationNs>(random.below(static_cast<std::uint64_t>(last_ns) + 2)) - 1;
      if (trial % 3 == 0) time_ns = frames[random.below(frames.size())].time_ns;
      if (trial == 0) time_ns = -1;
      if (trial == 1) time_ns = kTimeNever;
      CAPTURE(time_ns);
      std::map<Universe, OwnedFrame> newest;
      std::map<Universe, Slots> snapshots;
      std::size_t after = 0;
      for (; after < frames.size() && frames[after].time_ns <= time_ns; ++after) {
        newest[frames[after].universe] = frames[after];
        std::copy(frames[after].slots.begin(), frames[after].slots.end(), snapshots[frames[after].universe].begin());
      }
      REQUIRE(reader.seek(time_ns));
      const auto snapshot = reader.snapshot();
      REQUIRE(snapshot.size() == newest.size());
      auto expected = newest.begin();
      for (const LogSnapshot& universe : snapshot) {
        const OwnedFrame& truth = expected->second;
        CHECK(universe.universe == truth.universe);
        CHECK(universe.time_ns == truth.time_ns);
        CHECK(universe.sender == truth.sender);
        CHECK(universe.sequence == truth.sequence);
        CHECK(universe.priority == truth.priority);
        CHECK(universe.terminated == truth.terminated);
        CHECK(std::equal(universe.levels.begin(), universe.levels.end(), snapshots[truth.universe].begin()));
        ++expected;
      }
      LogFrame frame;
      const bool any = *reader.next(frame);
      REQUIRE(any == (after < frames.size()));
      if (any) CHECK(own(frame) == frames[after]);
    }
  }
}

TEST_CASE("a frame stamped before the previous one takes its time and is counted") {
  const TempFolder folder;
  auto writer = LogWriter::create(folder.file("a.dmxlog"), {.origin_ns = 1000});
  REQUIRE(writer);
  const std::vector<std::uint8_t> slots = {9};
  for (const TimeNs stamp_ns : {5000, 4000, 500, 6000}) {
    FrameView view;
    view.universe = 1;
    view.stamp_ns = stamp_ns;
    view.slots = slots;
    REQUIRE(writer->append(view));
  }
  REQUIRE(writer->close(7000));
  auto reader = LogReader::open(folder.file("a.dmxlog"));
  REQUIRE(reader);
  CHECK(reader->info().late_stamps == 2);
  std::vector<DurationNs> times;
  for (const OwnedFrame& frame : all_frames(*reader)) times.push_back(frame.time_ns);
  CHECK(times == std::vector<DurationNs>{4000, 4000, 4000, 5000});
}

TEST_CASE("without repeats only frames with changes are kept") {
  LogWriterOptions options;
  options.keep_repeats = false;
  OwnedFrame frame;
  frame.universe = 4;
  frame.slots.assign(512, 7);
  std::vector<OwnedFrame> frames;
  for (int i = 0; i < 10; ++i) {
    frame.time_ns = i * kNsPerMs;
    frame.sequence = static_cast<std::uint32_t>(i);
    if (i == 5) frame.slots[511] = 8;
    if (i == 7) frame.priority = 150;
    frames.push_back(frame);
  }
  LogReader reader = open_log(log_bytes(frames, kNsPerS, options));
  CHECK(all_frames(reader) == std::vector<OwnedFrame>{frames[0], frames[5], frames[7]});
}

TEST_CASE("the index has the same frames, changes, slots and times per universe as a full read") {
  const TempFolder folder;
  const std::string path = folder.file("a.dmxlog");
  const auto frames = random_frames(5, 500, 4);
  LogWriterOptions options = small_blocks();
  options.universes = {8, 1, 60'000};
  auto writer = LogWriter::create(path, options);
  REQUIRE(writer);
  for (const OwnedFrame& frame : frames) REQUIRE(writer->append(frame.view()));
  REQUIRE(writer->close(9 * kNsPerS));
  const auto quick = read_log_info(path);
  const auto full = read_log_info(path, true);
  REQUIRE(quick);
  REQUIRE(full);
  CHECK(!quick->checked);
  CHECK(full->checked);
  CHECK(quick->frames == full->frames);
  CHECK(quick->changes == full->changes);
  CHECK(quick->duration_ns == full->duration_ns);
  REQUIRE(quick->universes.size() == 5);
  REQUIRE(full->universes.size() == 5);
  CHECK(quick->universes.back().universe == 60'000);
  CHECK(quick->universes.back().frames == 0);
  for (std::size_t i = 0; i < 5; ++i) {
    CHECK(quick->universes[i].universe == full->universes[i].universe);
    CHECK(quick->universes[i].frames == full->universes[i].frames);
    CHECK(quick->universes[i].changes == full->universes[i].changes);
    CHECK(quick->universes[i].slot_count == full->universes[i].slot_count);
    CHECK(quick->universes[i].first_ns == full->universes[i].first_ns);
    CHECK(quick->universes[i].last_ns == full->universes[i].last_ns);
  }
}

TEST_CASE("a thousand universes and the highest universe number are stored in a log") {
  std::vector<OwnedFrame> frames;
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 1000; ++i) {
      OwnedFrame frame;
      frame.universe = kUniverseMax - i;
      frame.time_ns = round * 25 * kNsPerMs;
      frame.slots.assign(512, static_cast<std::uint8_t>(i + round));
      frames.push_back(frame);
    }
  }
  LogReader reader = open_log(log_bytes(frames, kNsPerS));
  CHECK(all_frames(reader) == frames);
  CHECK(reader.info().universes.size() == 1000);
}

TEST_CASE("a recording in progress has a .part name, can be read, and gets its name when it ends") {
  const TempFolder folder;
  const std::string path = folder.file("show.dmxlog");
  auto writer = LogWriter::create(path, {});
  REQUIRE(writer);
  const auto frames = random_frames(1, 50, 2);
  for (const OwnedFrame& frame : frames) REQUIRE(writer->append(frame.view()));
  REQUIRE(writer->flush());
  CHECK(writer->written_path() == path + ".part");
  {
    auto reader = LogReader::open(path + ".part");
    REQUIRE(reader);
    CHECK(!reader->info().finished);
    CHECK(all_frames(*reader) == frames);
  }
  REQUIRE(writer->close(frames.back().time_ns));
  CHECK(writer->written_path() == path);
  CHECK(!std::filesystem::exists(path + ".part"));
  CHECK(LogReader::open(path)->info().finished);
}

TEST_CASE("a writer destroyed without close leaves its frames in the .part file, which the next one does not touch") {
  const TempFolder folder;
  const std::string path = folder.file("show.dmxlog");
  const auto frames = random_frames(2, 50, 2);
  {
    auto writer = LogWriter::create(path, {});
    REQUIRE(writer);
    for (const OwnedFrame& frame : frames) REQUIRE(writer->append(frame.view()));
  }
  auto next = LogWriter::create(path, {});
  REQUIRE(next);
  CHECK(next->written_path() == path + ".part2");
  REQUIRE(next->close(0));
  auto reader = LogReader::open(path + ".part");
  REQUIRE(reader);
  CHECK(all_frames(*reader) == frames);
  const auto info = read_log_info(path + ".part");
  REQUIRE(info);
  CHECK(info->recovered());
  CHECK(info->duration_ns == frames.back().time_ns);
  CHECK(info->universes.size() == 2);
}

TEST_CASE("a recording whose .part was deleted has all its frames under its name, or under the .part if that exists") {
  const TempFolder folder;
  const std::string path = folder.file("show.dmxlog");
  const auto frames = random_frames(1, 2000, 2);
  for (const bool exists : {false, true}) {
    CAPTURE(exists);
    std::filesystem::remove(path);
    auto writer = LogWriter::create(path, {});
    REQUIRE(writer);
    for (const OwnedFrame& frame : frames) REQUIRE(writer->append(frame.view()));
    REQUIRE(std::filesystem::remove(path + ".part"));
    if (exists) std::ofstream(path) << "mine";
    CHECK(writer->close(frames.back().time_ns).has_value() == !exists);
    CHECK(std::filesystem::exists(path + ".part") == exists);
    if (exists) CHECK(std::filesystem::file_size(path) == 4);
    auto reader = LogReader::open(exists ? path + ".part" : path);
    REQUIRE(reader);
    CHECK(reader->info().finished);
    CHECK(all_frames(*reader) == frames);
  }
}

TEST_CASE("a recording whose .part was replaced is whole, and the other file stays") {
  const TempFolder folder;
  const std::string path = folder.file("show.dmxlog");
  auto writer = LogWriter::create(path, {});
  REQUIRE(writer);
  const auto frames = random_frames(1, 50, 2);
  for (const OwnedFrame& frame : frames) REQUIRE(writer->append(frame.view()));
  REQUIRE(std::filesystem::remove(path + ".part"));
  std::ofstream(path + ".part") << "mine";
  REQUIRE(writer->close(frames.back().time_ns));
  auto reader = LogReader::open(path);
  REQUIRE(reader);
  CHECK(all_frames(*reader) == frames);
  CHECK(std::filesystem::file_size(path + ".part") == 4);
  CHECK(!std::filesystem::exists(path + ".part2"));
}

TEST_CASE("a recording whose .part was renamed stays there, and the message says so") {
  const TempFolder folder;
  const std::string path = folder.file("show.dmxlog");
  auto writer = LogWriter::create(path, {});
  REQUIRE(writer);
  const auto frames = random_frames(1, 50, 2);
  for (const OwnedFrame& frame : frames) REQUIRE(writer->append(frame.view()));
  std::filesystem::rename(path + ".part", folder.file("mine"));
  const auto closed = writer->close(frames.back().time_ns);
  REQUIRE(!closed);
  CHECK(closed.error().message.find(".part: was renamed while it was recorded; the recording is complete under its") !=
        std::string::npos);
  CHECK(!std::filesystem::exists(path));
  auto reader = LogReader::open(folder.file("mine"));
  REQUIRE(reader);
  CHECK(all_frames(*reader) == frames);
}

TEST_CASE("The error for a missing log names the .part file that was written last, whatever numbers are missing") {
  const TempFolder folder;
  const std::string path = folder.file("show.dmxlog");
  const auto write = [&](const std::string& part, int age_s) {
    write_bytes(part, "x");
    const auto now = std::filesystem::file_time_type::clock::now();
    std::filesystem::last_write_time(part, now - std::chrono::seconds(age_s));
  };
  const auto named = [&] {
    const auto missing = LogReader::open(path);
    REQUIRE(!missing);
    CHECK(missing.error().code == ErrorCode::kNotFound);
    const std::string& message = missing.error().message;
    const std::size_t at = message.find("no such file, but ");
    if (at == std::string::npos) return std::string("none");
    const std::size_t begin = at + std::string_view("no such file, but ").size();
    return message.substr(begin, message.find(" is there") - begin);
  };
  CHECK(named() == "none");
  write(path + ".part2", 60);  // .part was converted and removed
  CHECK(named() == path + ".part2");
  write(path + ".part", 10);  // the next recording took the lowest free name
  CHECK(named() == path + ".part");
  write(path + ".part1000", 5);
  CHECK(named() == path + ".part1000");
  std::filesystem::create_directory(path + ".part7");  // newest, but not a recording
  CHECK(named() == path + ".part1000");
}

TEST_CASE("a finished log is replaced only with the overwrite option") {
  const TempFolder folder;
  const std::string path = folder.file("show.dmxlog");
  REQUIRE(LogWriter::create(path, {})->close(1));
  const auto refused = LogWriter::create(path, {});
  REQUIRE(!refused);
  CHECK(refused.error().message.find("show.dmxlog: exists") != std::string::npos);
  LogWriterOptions options;
  options.overwrite = true;
  auto writer = LogWriter::create(path, options);
  REQUIRE(writer);
  REQUIRE(writer->close(2));
  CHECK(LogReader::open(path)->info().duration_ns == 2);
}

TEST_CASE("a full disk gives an error that names the file, and the log stays readable") {
  const TempFolder folder;
  const std::string path = folder.file("full.dmxlog");
  // A limit on the size of files makes writes fail like a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
  auto writer = LogWriter::create(path, small_blocks());
  REQUIRE(writer);
  const rlimit tight{20'000, before.rlim_max};
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &tight) == 0);
  Random random(1);
  Status status;
  OwnedFrame frame;
  frame.universe = 1;
  frame.slots.resize(512);
  for (int i = 0; i < 1000 && status; ++i) {
    frame.time_ns = i * 10 * kNsPerMs;
    for (auto& slot : frame.slots) slot = random.byte();
    status = writer->append(frame.view());
  }
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &before) == 0);
  REQUIRE(!status);
  CHECK(status.error().code == ErrorCode::kIo);
  CHECK(status.error().message.find("full.dmxlog.part: cannot write") != std::string::npos);
  CHECK(!writer->append(frame.view()));
  CHECK(!writer->close(kNsPerS));
  auto reader = LogReader::open(path + ".part");
  REQUIRE(reader);
  CHECK(reader->info().damage_count == 0);  // it ends after a whole block
  CHECK(all_frames(*reader).size() > 10);
}

TEST_CASE("invalid options are refused with the reason") {
  const TempFolder folder;
  const std::string path = folder.file("a.dmxlog");
  LogWriterOptions bad_span;
  bad_span.block_span_ns = 0;
  CHECK(!LogWriter::create(path, bad_span));
  LogWriterOptions bad_level;
  bad_level.compression_level = 40;
  CHECK(!LogWriter::create(path, bad_level));
  LogWriterOptions bad_universe;
  bad_universe.universes = {1, 64'000};
  const auto refused = LogWriter::create(path, bad_universe);
  REQUIRE(!refused);
  CHECK(refused.error().message.find("64000") != std::string::npos);
  CHECK(!std::filesystem::exists(path + ".part"));
  const auto nowhere = LogWriter::create(folder.file("no/such/folder.dmxlog"), {});
  REQUIRE(!nowhere);
  CHECK(nowhere.error().code == ErrorCode::kNotFound);
}

TEST_CASE("a pipe in the place of a log is refused at once, to read and to write, and stays a pipe") {
  const TempFolder folder;
  const std::string pipe = folder.file("pipe");
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  const auto check_refused = [&](const auto& result) {
    REQUIRE(!result);
    CHECK(result.error().code == ErrorCode::kBadInput);
    CHECK(result.error().message.find("is a pipe or a device") != std::string::npos);
    CHECK(std::filesystem::is_fifo(pipe));
  };
  LogWriterOptions overwrite;
  overwrite.overwrite = true;
  check_refused(LogWriter::create(pipe, overwrite));
  check_refused(LogWriter::create(pipe, {}));
  check_refused(OlaShowWriter::create(pipe, true));
  check_refused(LogReader::open(pipe));
  check_refused(OlaShowReader::open(pipe, 0));
  check_refused(detect_log_format(pipe));
}
