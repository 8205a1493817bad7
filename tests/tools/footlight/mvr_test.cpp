// Rigs over the network: the program beside itself, and beside stations of the test.
#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>
#include <fcntl.h>
#include <poll.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include "drivers/net/mvr_xchange_tcp.h"
#include "fixtures/files/export/write_file.h"
#include "sim/system_clock.h"
#include "tests/support/must.h"
#include "tests/support/zip_bytes.h"
#include "tests/tools/footlight/desk_thread.h"
#include "tests/tools/footlight/run_footlight.h"
#include "tools/footlight/mvr/mvr_lines.h"
#include "tools/footlight/mvr/received_file.h"
#include "tools/footlight/mvr/shared_file.h"

namespace footlight::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// No message bus: nothing that a test shares is announced in a real network.
const std::map<std::string, std::string> kNoBus = {{"DBUS_SYSTEM_BUS_ADDRESS", "unix:path=/nonexistent"}};

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// A rig of one fixture, with a mesh-like file of random bytes to make it large.
std::string rig_bytes(const std::string& fixture, std::size_t padding = 0) {
  std::string noise(padding, '\0');
  std::uint32_t state = 1;
  for (char& byte : noise) byte = static_cast<char>((state = state * 1'664'525u + 1'013'904'223u) >> 24);
  return make_zip({{"noise.bin", noise},  // first, as programs write it that do not sort
                   {"GeneralSceneDescription.xml",
                    "<GeneralSceneDescription verMajor=\"1\" verMinor=\"6\"><Scene><Layers><Layer name=\"L\" "
                    "uuid=\"00000000-0000-4000-8000-000000000001\"><ChildList><Fixture name=\"" +
                        fixture +
                        "\" uuid=\"00000000-0000-4000-8000-000000000002\"><GDTFSpec>Par.gdtf</GDTFSpec><Addresses>"
                        "<Address break=\"0\">1</Address></Addresses></Fixture></ChildList></Layer></Layers></Scene>"
                        "</GeneralSceneDescription>"}});
}

// Of a station that puts a control character into the terminal.
drivers::MvrCommit coloured_commit() {
  drivers::MvrCommit commit;
  commit.comment = "from the desk\x1B[31m";
  return commit;
}

TEST_CASE("a file that is shared is listed, is received byte for byte, and again when it changes") {
  const TempFolder folder;
  const std::string rig = folder.write("tour.mvr", rig_bytes("Par 1", 3'000'000));
  Footlight sharing({"mvr", "share", rig, "--comment", "truss 2", "--name", "View", "--json"}, kNoBus);
  sharing.wait_for("\"started\"");
  const Json first = Json::parse(sharing.last_line());
  const std::string address = fmt::format("127.0.0.1:{}", first["port"].get<int>());
  CHECK(first["group"] == "Default");

  const Outcome listed = footlight({"mvr", "stations", "--station", address, "--json"});
  CHECK(listed.exit_code == 0);
  const Json station = Json::parse(listed.out);
  CHECK(station["name"] == "View");
  CHECK(station["provider"] == "Footlight");
  CHECK(station["files"][0]["file_name"] == "tour.mvr");
  CHECK(station["files"][0]["comment"] == "truss 2");
  CHECK(station["files"][0]["bytes"] == fs::file_size(rig));

  const std::string out = folder.file("got.mvr");
  const Outcome got = footlight({"mvr", "get", address, "-o", out});
  CHECK(got.exit_code == 0);
  CHECK(contains(got.out, "1 fixture"));
  CHECK(read_file(out) == read_file(rig));
  sharing.wait_for("\"left\"");

  (void)folder.write("tour.mvr", rig_bytes("Par 2"));
  std::string second;
  SystemClock clock;
  for (const TimeNs end_ns = clock.now_ns() + 60 * kNsPerS; clock.now_ns() < end_ns;) {
    const Outcome again = footlight({"mvr", "stations", "--station", address, "--json"});
    const Json files = Json::parse(again.out)["files"];
    if (files.size() < 2) continue;
    CHECK(files[0] == station["files"][0]);
    second = files[1]["file_uuid"];
    break;
  }
  REQUIRE(!second.empty());
  CHECK(footlight({"mvr", "get", address, "-o", out}).exit_code == 2);  // exists
  CHECK(footlight({"mvr", "get", address, "-o", out, "--overwrite"}).exit_code == 0);
  CHECK(read_file(out) == read_file(rig));
  CHECK(footlight({"mvr", "get", address, "-o", out, "--overwrite", "--file", "no"}).exit_code == 3);
  sharing.signal(SIGINT);
  CHECK(sharing.wait().exit_code == 0);
  CHECK(footlight({"mvr", "get", address, "-o", folder.file("late.mvr")}).exit_code == 3);
  CHECK(!fs::exists(folder.file("late.mvr")));
}

TEST_CASE("a file that is no rig is neither shared nor written, and nothing is left beside it") {
  const TempFolder folder;
  const std::string text = folder.write("text.mvr", "no zip");
  const Outcome shared = footlight({"mvr", "share", text});
  CHECK(shared.exit_code == 2);
  CHECK(contains(shared.err, "text.mvr"));
  for (const std::string& content :
       {std::string("no zip"), std::string(), make_zip({{"other.xml", "<a/>"}}), rig_bytes("Par 1").substr(0, 200)}) {
    DeskThread desk(content, coloured_commit());
    const std::string out = folder.file("got.mvr");
    const Outcome got = footlight({"mvr", "get", desk.address(), "-o", out});
    CAPTURE(got.err);
    CHECK(got.exit_code == 2);
    CHECK(contains(got.err, "got.mvr"));
    CHECK(std::distance(fs::directory_iterator(folder.path()), {}) == 1);
    const auto events = desk.end();
    REQUIRE(events.size() == 3);  // joined, sent, left: also after an error
    CHECK(events[2].kind == drivers::MvrEvent::Kind::kLeft);
  }
}

TEST_CASE("stations of which one has a file need no name, and texts of others are printed without escapes") {
  const TempFolder folder;
  DeskThread desk(rig_bytes("Par 1"), coloured_commit());
  const std::string out = folder.file("got.mvr");
  const std::vector<std::string> named = {"--station", desk.address(), "--station", "127.0.0.1:9"};
  std::vector<std::string> words = {"mvr", "stations"};
  words.insert(words.end(), named.begin(), named.end());
  const Outcome listed = footlight(words);
  CHECK(listed.exit_code == 0);
  CHECK(contains(listed.out, "Desk  " + desk.address()));
  CHECK(contains(listed.out, "from the desk"));
  CHECK(!contains(listed.out, "\x1B"));
  CHECK(contains(listed.out, "cannot connect"));
  words = {"mvr", "get", "-o", out};
  words.insert(words.end(), named.begin(), named.end());
  CHECK(footlight(words).exit_code == 0);
  CHECK(fs::exists(out));
  words = {"mvr", "get", "Somebody", "-o", folder.file("x.mvr"), "--station", desk.address()};
  const Outcome unknown = footlight(words);
  CHECK(unknown.exit_code == 3);
  CHECK(contains(unknown.err, "'Desk'"));
  CHECK(footlight({"mvr", "get"}).exit_code == 2);
}

TEST_CASE("of stations with one name a UUID, an address or a file selects one, and the error lists them") {
  const TempFolder folder;
  const std::string rig = rig_bytes("Par 1");
  const std::string second = "a7669ff9-bd61-4486-aea6-c190f8ba6b8c";
  DeskThread one(rig, coloured_commit());
  DeskThread two(rig, coloured_commit(), second.c_str());
  const auto get = [&](std::vector<std::string> words, const char* out) {
    words.insert(words.begin(), {"mvr", "get"});
    words.insert(words.end(), {"-o", folder.file(out), "--station", one.address(), "--station", two.address(),
                               "--station", "127.0.0.1:9"});
    return footlight(words);
  };
  const Outcome both = get({"Desk"}, "a.mvr");
  CHECK(both.exit_code == 2);
  for (const std::string& part : {one.address(), two.address(), second, std::string("127.0.0.1:9")}) {
    CAPTURE(both.err);
    CHECK(contains(both.err, part));
  }
  CHECK(get({second}, "b.mvr").exit_code == 0);
  CHECK(get({"--file", "11111111-2222-4333-8444-555555555555"}, "c.mvr").exit_code == 0);
  const Outcome none = get({"--file", "22222222-2222-4333-8444-555555555555"}, "d.mvr");
  CHECK(none.exit_code == 3);
  CHECK(contains(none.err, "cannot connect"));
  CHECK(two.end().size() >= 2);
}

TEST_CASE("a station whose host has no address is an error that names the host, without a search") {
  const TempFolder folder;
  const std::string host(64, 'x');  // no server of names is asked for a label that is too long
  const Outcome got = footlight({"mvr", "get", host + ":4711", "-o", folder.file("x.mvr")});
  CHECK(got.exit_code == 3);
  CHECK(contains(got.err, host + " has no IPv4 address"));
}

TEST_CASE("a file that appeared while another was received stays, unless it may be overwritten") {
  const TempFolder folder;
  const std::string path = folder.file("rig.mvr");
  const std::string rig = rig_bytes("Par 1");
  const std::span<const std::uint8_t> bytes(reinterpret_cast<const std::uint8_t*>(rig.data()), rig.size());
  for (const bool overwrite : {false, true}) {
    tools::ReceivedFile file(path, {.overwrite = overwrite});
    must(file.open());
    must(file.write(bytes, bytes.size()));
    (void)folder.write("rig.mvr", "mine");
    const auto line = file.finish();
    CHECK(line.has_value() == overwrite);
    CHECK(read_file(path) == (overwrite ? rig : "mine"));
    if (!line) CHECK(contains(line.error().message, "exists"));
  }
  CHECK(std::distance(fs::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("a received file shows in a terminal how far it is, but only where this is asked for") {
  const TempFolder folder;
  const std::vector<std::uint8_t> bytes(100);
  for (const bool shows : {false, true}) {
    const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    REQUIRE(terminal >= 0);
    REQUIRE(::grantpt(terminal) == 0);
    REQUIRE(::unlockpt(terminal) == 0);
    const int other = ::open(::ptsname(terminal), O_RDWR | O_NOCTTY);
    const int errors = ::dup(STDERR_FILENO);
    ::dup2(other, STDERR_FILENO);
    tools::ReceivedFile file(folder.file("rig.mvr"), {.shows = shows});
    must(file.open());
    must(file.write(bytes, 2 * bytes.size()));
    ::dup2(errors, STDERR_FILENO);
    std::array<char, 256> text{};
    const ssize_t length = ::read(terminal, text.data(), text.size());
    CHECK((length > 0) == shows);
    for (const int each : {terminal, other, errors}) ::close(each);
  }
}

TEST_CASE("a part of a program that was killed does not stop the next one with its process number") {
  const TempFolder folder;
  const std::string path = folder.file("rig.mvr");
  const std::string last = fixtures::part_name(path);  // "...-N.part"
  const std::size_t dash = last.rfind('-');
  const int next = std::stoi(last.substr(dash + 1)) + 1;
  const std::string left = fmt::format("{}-{}.part.mvr", last.substr(0, dash), next);
  std::ofstream(left) << "left over";
  tools::ReceivedFile file(path, {});
  CHECK(file.open().has_value());
  CHECK(fs::file_size(left) == 0);
}

TEST_CASE("the command for a new file holds no text of a station but a UUID") {
  drivers::MvrEvent event;
  event.kind = drivers::MvrEvent::Kind::kCommitted;
  event.station_name = "Desk";
  event.commit.file_uuid = "{2E6F1D60-0c4b-4A8D-9E57-3A35E2B90B4D}";
  CHECK(contains(tools::event_text(event), "footlight mvr get --file {2E6F1D60-0c4b-4A8D-9E57-3A35E2B90B4D} -o FILE"));
  for (const char* uuid : {"1;reboot", "$(reboot)", "1 2", "1\n2"}) {
    event.commit.file_uuid = uuid;
    CHECK(!contains(tools::event_text(event), "footlight"));
  }
}

TEST_CASE("a station that watches prints the files of others, at first and when new ones come") {
  const TempFolder folder;
  const std::string rig = folder.write("tour.mvr", rig_bytes("Par 1"));
  Footlight watching({"mvr", "watch", "--name", "Watch", "--json"}, kNoBus);
  watching.wait_for("\"started\"");
  const int port = Json::parse(watching.last_line())["port"];
  Footlight sharing({"mvr", "share", rig, "--name", "View", "--station", fmt::format("127.0.0.1:{}", port)}, kNoBus);
  sharing.wait_for("Watch  127.0.0.1:");  // has joined it
  watching.wait_for("\"joined\"");
  (void)folder.write("tour.mvr", rig_bytes("Par 2"));
  watching.wait_for("\"committed\"");
  const Json commit = Json::parse(watching.last_line());
  CHECK(commit["station"] == "View");
  CHECK(commit["file"]["file_name"] == "tour.mvr");
  sharing.signal(SIGTERM);
  CHECK(sharing.wait().exit_code == 0);
  watching.wait_for("\"left\"");
  watching.signal(SIGINT);
  CHECK(watching.wait().exit_code == 0);
}

TEST_CASE("a shared file is read again a second after its last change, and not if only its time changed") {
  const TempFolder folder;
  const std::string path = folder.write("rig.mvr", rig_bytes("Par 1"));
  tools::SharedFile file = must(tools::SharedFile::open(path, "c"));
  TimeNs now_ns = 100 * kNsPerS;
  const auto later = [&](DurationNs by_ns) {
    now_ns += by_ns;
    return file.poll(now_ns);
  };
  CHECK(!must(later(0)));
  (void)folder.write("rig.mvr", rig_bytes("Par 10"));
  CHECK(!must(later(kNsPerS)));
  (void)folder.write("rig.mvr", rig_bytes("Par 100"));
  CHECK(!must(later(kNsPerS)));  // still changing
  const auto revision = must(later(kNsPerS));
  REQUIRE(revision.has_value());
  CHECK(revision->commit.file_uuid != file.first().commit.file_uuid);
  CHECK(revision->bytes->size() == fs::file_size(path));
  CHECK(!must(later(kNsPerS)));
  fs::last_write_time(path, fs::last_write_time(path) + std::chrono::seconds(5));
  CHECK(!must(later(kNsPerS)));
  CHECK(!must(later(kNsPerS)));
  (void)folder.write("rig.mvr", "half");
  CHECK(!must(later(kNsPerS)));
  CHECK(!later(kNsPerS));        // is no rig
  CHECK(!must(later(kNsPerS)));  // and that is said once
  (void)folder.write("rig.mvr", rig_bytes("Par 1"));
  CHECK(!must(later(kNsPerS)));
  const auto back = must(later(kNsPerS));
  REQUIRE(back.has_value());
  CHECK(back->commit.file_uuid == file.first().commit.file_uuid);  // the same content
}

}  // namespace
}  // namespace footlight::testing
