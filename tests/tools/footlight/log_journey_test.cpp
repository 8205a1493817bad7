// Logs through the commands: recorded, shown, converted, replayed. Every level must stay the same.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "sim/dmx_log/dmx_log.h"
#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {
namespace {

using Json = nlohmann::json;

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

struct Frame {
  DurationNs time_ns = 0;
  Universe universe = 0;
  std::uint8_t priority = 0;
  std::vector<std::uint8_t> slots;
  bool operator==(const Frame&) const = default;
};

// Two universes every 20 ms, with changing and unchanged slots, and frames of different lengths.
std::vector<Frame> pattern() {
  std::vector<Frame> frames;
  for (int step = 0; step < 25; ++step) {
    for (const Universe universe : {1, 7}) {
      Frame frame;
      frame.time_ns = step * 20 * kNsPerMs + universe * kNsPerUs;
      frame.universe = universe;
      frame.priority = universe == 1 ? 100 : 150;
      frame.slots.resize(universe == 1 ? 512 : 24);
      for (std::size_t slot = 0; slot < frame.slots.size(); ++slot) {
        frame.slots[slot] = static_cast<std::uint8_t>(slot % 3 == 0 ? slot : slot * static_cast<std::size_t>(step));
      }
      frames.push_back(frame);
    }
  }
  return frames;
}

// Without `finish` it leaves the .part file of a killed recorder.
void write_log(const std::string& path, const std::vector<Frame>& frames, bool finish = true) {
  LogWriterOptions options;
  options.origin_ns = 1'000'000'000;
  options.universes = {1, 7};
  auto writer = LogWriter::create(path, options);
  REQUIRE(writer.has_value());
  for (const Frame& frame : frames) {
    FrameView view;
    view.universe = frame.universe;
    view.stamp_ns = options.origin_ns + frame.time_ns;
    view.sender = static_cast<SenderId>(frame.universe);
    view.priority = frame.priority;
    view.slots = frame.slots;
    REQUIRE(writer->append(view).has_value());
  }
  if (finish) REQUIRE(writer->close(options.origin_ns + 500 * kNsPerMs).has_value());
}

std::vector<Frame> read_log(const std::string& path) {
  auto reader = LogReader::open(path);
  REQUIRE_MESSAGE(reader.has_value(), (reader ? "" : reader.error().message));
  std::vector<Frame> frames;
  LogFrame frame;
  while (true) {
    const auto more = reader->next(frame);
    REQUIRE(more.has_value());
    if (!*more) break;
    if (frame.terminated) continue;
    const auto slots = frame.slots();
    frames.push_back({frame.time_ns, frame.universe, frame.priority, {slots.begin(), slots.end()}});
  }
  return frames;
}

// All levels, as far as they were sent, of the last frame of a universe.
std::vector<std::uint8_t> last_snapshot(const std::vector<Frame>& frames, Universe universe) {
  const auto last =
      std::find_if(frames.rbegin(), frames.rend(), [&](const Frame& f) { return f.universe == universe; });
  REQUIRE(last != frames.rend());
  return last->slots;
}

void check_done(const Outcome& outcome) {
  CAPTURE(outcome.err);
  CHECK(outcome.exit_code == 0);
}

TEST_CASE("a log that is recorded again keeps every frame, level, priority and interval") {
  const TempFolder folder;
  write_log(folder.file("a.dmxlog"), pattern());
  const Outcome recorded =
      footlight({"record", "--in", "log:" + folder.file("a.dmxlog"), "-o", folder.file("b.dmxlog")});
  check_done(recorded);
  CAPTURE(recorded.err);
  CHECK(contains(recorded.err, "b.dmxlog: 50 frames, "));  // of the bridge's summary and of the log itself
  CHECK_FALSE(contains(recorded.err, " 0 frames"));
  auto copy = read_log(folder.file("b.dmxlog"));
  const auto original = pattern();
  REQUIRE(copy.size() == original.size());
  const DurationNs shift_ns =
      copy.front().time_ns - original.front().time_ns;  // the recording started a little earlier
  for (Frame& frame : copy) frame.time_ns -= shift_ns;
  CHECK(copy == original);
}

TEST_CASE("a log replayed into another log keeps its levels") {
  const TempFolder folder;
  write_log(folder.file("a.dmxlog"), pattern());
  check_done(footlight(
      {"replay", folder.file("a.dmxlog"), "--out", "log:" + folder.file("b.dmxlog"), "--out", "mock:enttec-pro"}));
  const auto original = pattern();
  const auto copy = read_log(folder.file("b.dmxlog"));
  CHECK(last_snapshot(copy, 1) == last_snapshot(original, 1));
  for (const Frame& frame : copy) {
    // A frame may be missing if the machine stalled; none may be added.
    CHECK(std::any_of(original.begin(), original.end(), [&](const Frame& one) {
      return one.universe == frame.universe && std::equal(one.slots.begin(), one.slots.end(), frame.slots.begin());
    }));
  }
}

TEST_CASE("info prints the counts of a log, as text and as JSON") {
  const TempFolder folder;
  const std::string log = folder.file("a.dmxlog");
  write_log(log, pattern());
  const Outcome text = footlight({"log", "info", log});
  check_done(text);
  CHECK(contains(text.out, "length:   500 ms"));
  CHECK(contains(text.out, "universe 7: 25 frames, 50.00/s, 24 slots"));
  const Outcome machine = footlight({"log", "info", "--check", "--json", log});
  check_done(machine);
  const Json info = Json::parse(machine.out);
  CHECK(info["frames"] == 50);
  CHECK(info["duration_ns"] == 500'000'000);
  CHECK(info["finished"] == true);
  CHECK(info["checked"] == true);
  CHECK(info["universes"].size() == 2);
  CHECK(info["universes"][1]["universe"] == 7);
}

TEST_CASE("through an OLA show file and back, levels stay and times are rounded to a millisecond") {
  const TempFolder folder;
  write_log(folder.file("a.dmxlog"), pattern());
  check_done(footlight({"log", "convert", folder.file("a.dmxlog"), folder.file("a.show")}));
  check_done(footlight({"log", "convert", folder.file("a.show"), folder.file("b.dmxlog")}));
  const auto original = pattern();
  const auto copy = read_log(folder.file("b.dmxlog"));
  REQUIRE(copy.size() == original.size());
  for (std::size_t i = 0; i < copy.size(); ++i) {
    CHECK(copy[i].universe == original[i].universe);
    CHECK(copy[i].slots == original[i].slots);
    CHECK(std::abs((copy[i].time_ns - copy[0].time_ns) - (original[i].time_ns - original[0].time_ns)) <= kNsPerMs);
  }
  const Outcome again = footlight({"log", "convert", folder.file("a.show"), folder.file("b.dmxlog")});
  CHECK(again.exit_code != 0);  // an existing file is not replaced
  CHECK(contains(again.err, "b.dmxlog"));
  check_done(footlight({"log", "convert", "--overwrite", folder.file("a.show"), folder.file("b.dmxlog")}));
}

TEST_CASE("a truncated OLA show file has exit code 1, and the line at which it is cut off is named") {
  const TempFolder folder;
  const std::string show = folder.write("cut.show", "OLA Show\n1 0,255,7\n20\n1 0,25");
  const Outcome info = footlight({"log", "info", "--check", show});
  CHECK(info.exit_code == 1);
  CHECK(contains(info.out, "cut.show:4: the last line has no line end"));
  CHECK(contains(info.err, "the recording was not finished"));
  CHECK(contains(info.err, "footlight log convert " + show + " whole.dmxlog"));
  const Outcome converted = footlight({"log", "convert", show, folder.file("whole.dmxlog")});
  CHECK(converted.exit_code == 0);
  CHECK(contains(converted.out, "cut.show:4: the last line has no line end"));
}

TEST_CASE("a truncated log is shown up to its end, with exit code 1 and the command that saves the rest") {
  const TempFolder folder;
  auto frames = pattern();
  const std::size_t count = frames.size();
  for (std::size_t i = 0; i < count; ++i) {  // long enough for several blocks
    Frame frame = frames[i];
    frame.time_ns += 60 * kNsPerS;
    frames.push_back(frame);
  }
  std::sort(frames.begin(), frames.end(), [](const Frame& a, const Frame& b) { return a.time_ns < b.time_ns; });
  {
    LogWriterOptions options;
    auto writer = LogWriter::create(folder.file("a.dmxlog"), options);
    REQUIRE(writer.has_value());
    for (const Frame& frame : frames) {
      FrameView view;
      view.universe = frame.universe;
      view.stamp_ns = frame.time_ns;
      view.slots = frame.slots;
      REQUIRE(writer->append(view).has_value());
    }
    REQUIRE(writer->close(61 * kNsPerS).has_value());
  }
  std::ifstream file(folder.file("a.dmxlog"), std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  std::ofstream(folder.file("cut.dmxlog"), std::ios::binary) << bytes.substr(0, bytes.size() * 2 / 3);

  const Outcome outcome = footlight({"log", "info", folder.file("cut.dmxlog")});
  CHECK(outcome.exit_code == 1);
  CHECK(contains(outcome.out, "universe 1:"));
  CHECK(contains(outcome.err, "cut.dmxlog"));
  CHECK(contains(outcome.err, "footlight log convert"));
  (void)footlight({"log", "convert", folder.file("cut.dmxlog"), folder.file("whole.dmxlog")});
  check_done(footlight({"log", "info", "--check", folder.file("whole.dmxlog")}));
  CHECK(read_log(folder.file("whole.dmxlog")).size() >= count);

  const Outcome headless = [&] {
    std::ofstream(folder.file("head.dmxlog"), std::ios::binary) << bytes.substr(0, 6);
    return footlight({"log", "info", folder.file("head.dmxlog")});
  }();
  CHECK(headless.exit_code == 2);
  CHECK(contains(headless.err, "head.dmxlog"));
}

TEST_CASE("if only the .part file of a killed recorder exists, every command names it and reads it") {
  const TempFolder folder;
  const std::string log = folder.file("a.dmxlog");
  const std::string part = log + ".part";
  write_log(log, pattern(), false);
  write_log(log, pattern(), false);  // a later recording of that name: .part2

  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"log", "info", log},
                                             {"log", "convert", log, folder.file("b.dmxlog")},
                                             {"log", "diff", log, log},
                                             {"log", "timing", log},
                                             {"replay", log, "--out", "mock:enttec-pro"},
                                             {"run", "--in", "log:" + log, "--out", "mock:enttec-pro"},
                                             {"record", "--in", "log:" + log, "-o", folder.file("c.dmxlog")}}) {
    CAPTURE(words[1]);
    const Outcome missing = footlight(words);
    CAPTURE(missing.err);
    CHECK(missing.exit_code == 3);
    CHECK(contains(missing.err, "no such file, but " + part + "2 is there"));
    CHECK(contains(missing.err, "footlight log convert " + part + "2 " + log));
  }

  const Outcome shown = footlight({"log", "info", part});
  CHECK(shown.exit_code == 1);
  CHECK(contains(shown.out, "frames:   50,"));
  check_done(footlight({"replay", part, "--out", "mock:enttec-pro"}));
  (void)footlight({"log", "convert", part, log});
  check_done(footlight({"log", "info", "--check", log}));
  CHECK(read_log(log).size() == pattern().size());
}

TEST_CASE("the demo show can be replayed from any time, faster and for a limited time") {
  const Outcome outcome = footlight(
      {"replay", "--demo", "--at", "1s", "--until", "11s", "--speed", "1000", "--out", "mock:enttec-pro", "--json"});
  check_done(outcome);
  CHECK(contains(outcome.out, R"("event":"summary")"));
}

// A UDP port that was free a moment ago.
int free_udp_port() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  REQUIRE(fd >= 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  REQUIRE(bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  socklen_t size = sizeof address;
  REQUIRE(getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) == 0);
  close(fd);
  return ntohs(address.sin_port);
}

TEST_CASE("levels that one program replays over sACN equal those that another program records") {
  const TempFolder folder;
  write_log(folder.file("a.dmxlog"), pattern());
  const std::string wire = "@127.0.0.1:" + std::to_string(free_udp_port());
  Footlight recorder({"record", "--in", "sacn:101,107=1,7" + wire, "-o", folder.file("b.dmxlog"), "--json"});
  recorder.wait_for(R"("event":"ready")");
  check_done(footlight({"replay", folder.file("a.dmxlog"), "--out", "sacn:101,107=1,7" + wire}));
  recorder.signal(SIGTERM);
  check_done(recorder.wait());
  const auto original = pattern();
  const auto copy = read_log(folder.file("b.dmxlog"));
  CHECK(last_snapshot(copy, 1) == last_snapshot(original, 1));
  auto short_snapshot = last_snapshot(copy, 7);
  short_snapshot.resize(24);  // the network carries whole universes
  CHECK(short_snapshot == last_snapshot(original, 7));
}

TEST_CASE("a bridge whose recording failed exits with 1 and names the log") {
  const TempFolder folder;
  const std::string played = folder.file("played.dmxlog");
  const std::string full = folder.file("full.dmxlog");
  write_log(played, pattern());
  // A limit on the size of files makes writes fail like a full disk. The program inherits both.
  rlimit before{};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit tight{512, before.rlim_max};
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &tight) == 0);
  const Outcome replay = footlight({"replay", played, "--out", "log:" + full});
  const Outcome run = footlight({"run", "--in", "log:" + played, "--out", "log:" + full + "2", "--for", "1s"});
  const std::string pictures = "vrsl:1-7@" + folder.file("p_%05d.png");
  const Outcome drawn = footlight({"replay", played, "--out", pictures});
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &before) == 0);
  std::signal(SIGXFSZ, previous);
  for (const Outcome& outcome : {replay, run}) {
    CAPTURE(outcome.err);
    CHECK(outcome.exit_code == 1);
    CHECK(contains(outcome.err, "log:" + full));
    CHECK(contains(outcome.err, "the recording is incomplete"));
    CHECK(contains(outcome.err, "cannot write any more; what is in it so far can be read"));
  }
  CAPTURE(drawn.err);
  CHECK(drawn.exit_code == 1);
  CHECK(contains(drawn.err, pictures + ": the recording is incomplete"));
}

TEST_CASE("a recording ends when its disk is full, keeps what was written, and does not go on when space comes back") {
  const TempFolder folder;
  const std::string path = folder.file("full.dmxlog");
  rlimit before{};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit tight{20'000, before.rlim_max};
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &tight) == 0);
  const auto start = std::chrono::steady_clock::now();
  const Outcome outcome = footlight({"record", "--in", "mock:sine=1-4", "-o", path, "--for", "60s"});
  const auto took = std::chrono::steady_clock::now() - start;
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &before) == 0);
  std::signal(SIGXFSZ, previous);
  INFO(outcome.err);
  CHECK(outcome.exit_code == 1);
  CHECK(took < std::chrono::seconds(40));
  CHECK(contains(outcome.err, path + ": the recording ended early, after "));
  CHECK(contains(outcome.err, path + ".part: cannot write any more; what is in it so far can be read"));
  CHECK_FALSE(std::filesystem::exists(path));
  auto reader = LogReader::open(path + ".part");
  REQUIRE(reader.has_value());
  LogFrame frame;
  const auto first = reader->next(frame);
  CHECK((first.has_value() && *first));
  CHECK(reader->info().damage_count == 0);
}

}  // namespace
}  // namespace footlight::testing
