// Levels by hand through the real program: commands on the socket of a running bridge, clients that misbehave, and
// bridges and holders that are killed.
#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "sim/system_clock.h"
#include "tests/tools/footlight/in_terminal.h"
#include "tests/tools/footlight/run_footlight.h"
#include "tools/footlight/status/http_server.h"

namespace footlight::testing {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

json page(const std::string& socket, const std::string& path) {
  const auto answer = tools::http_request(socket, "GET", path, 30 * kNsPerS);  // a loaded machine is slow
  REQUIRE_MESSAGE(answer.has_value(), (answer ? "" : answer.error().message));
  REQUIRE(answer->status == 200);
  return json::parse(answer->body);
}

int level(const std::string& socket, int universe, int address) {
  const json levels = page(socket, "/levels");
  for (const json& each : levels["universes"]) {
    if (each["universe"] != universe) continue;
    const std::string digits = each["levels"];
    return std::stoi(digits.substr(static_cast<std::size_t>(2 * (address - 1)), 2), nullptr, 16);
  }
  return -1;
}

// Until the condition holds, for at most 30 s.
template <class Condition>
bool eventually(Condition condition) {
  for (int i = 0; i < 3'000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

// A bridge on a socket in a folder of the test, and commands to it.
class Bridge {
 public:
  explicit Bridge(const std::string& path, Words more = {"--out", "mock:enttec-pro"}) : socket(path) {
    Words words = {"run", "--json", "--no-realtime", "--socket", path};
    words.insert(words.end(), more.begin(), more.end());
    run = std::make_unique<Footlight>(words);
    run->wait_for("\"ready\"");
  }
  [[nodiscard]] Outcome say(Words words) const {
    words.insert(words.end(), {"--socket", socket});
    return footlight(words);
  }
  void must(const Words& words) const {
    const Outcome outcome = say(words);
    CAPTURE(words[0]);
    CHECK(outcome.err == "");
    REQUIRE(outcome.exit_code == 0);
  }
  [[nodiscard]] int at(int address, int universe = 1) const { return level(socket, universe, address); }
  [[nodiscard]] bool shows(int address, int value, int universe = 1) const {
    return eventually([&] { return at(address, universe) == value; });
  }

  std::string socket;
  std::unique_ptr<Footlight> run;
};

class Connection {
 public:
  explicit Connection(const std::string& path) : fd_(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address = {};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    REQUIRE(connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  }
  ~Connection() { close(fd_); }
  Connection(Connection&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  void write(const std::string& text) const { (void)!send(fd_, text.data(), text.size(), MSG_NOSIGNAL); }

 private:
  int fd_;
};

TEST_CASE("levels are set, faded, released and blacked out in a running bridge, and the monitor names the hand") {
  const TempFolder folder;
  const Bridge bridge(folder.file("s"), {"--in", "mock:enttec-pro=2", "--out", "mock:enttec-pro/out"});
  // The hand is not there before it is used. The first period's status comes after "ready".
  CHECK(eventually([&] { return !page(bridge.socket, "/status")["ports"].empty(); }));
  CHECK(page(bridge.socket, "/status")["ports"].size() == 2);
  bridge.must({"set", "1.17=255", "1.1-3=50%", "1.20+21=258"});
  CHECK(bridge.shows(17, 255));
  CHECK(bridge.at(2) == 128);
  CHECK(bridge.at(20) == 1);
  CHECK(bridge.at(21) == 2);
  // The monitor's status is that of the last period or the one before.
  const auto monitor_names = [&](std::string_view sender) {
    return eventually([&] { return contains(bridge.say({"monitor", "--once", "--columns", "100"}).out, sender); });
  };
  CHECK(monitor_names("by hand"));
  const Outcome list = bridge.say({"set", "--list"});
  CHECK(json::parse(list.out)["held"][0] == json{{"priority", 150}, {"levels", {"1.1-3=128", "1.17=255", "1.20=1,2"}}});

  bridge.must({"fade", "1.17=0", "--over", "300ms"});
  CHECK(bridge.shows(17, 0));
  bridge.must({"blackout"});
  CHECK(bridge.shows(2, 0));
  CHECK(monitor_names("blackout"));
  bridge.must({"blackout", "off"});
  CHECK(bridge.shows(2, 128));
  bridge.must({"release", "1.1-2"});
  CHECK(json::parse(bridge.say({"set", "--list"}).out)["held"][0]["levels"] == json{"1.3=128", "1.17=0", "1.20=1,2"});
  bridge.must({"release", "--all"});
  CHECK(json::parse(bridge.say({"set", "--list"}).out)["held"].empty());
  bridge.run->signal(SIGTERM);
  CHECK(bridge.run->wait().exit_code == 0);
}

TEST_CASE("fixtures are set by name and attribute, through the rig of the bridge or of the command") {
  const TempFolder folder;
  REQUIRE(footlight({"samples", folder.file("a")}).exit_code == 0);
  std::ofstream(folder.file("rig.toml"))
      << "[rig]\nname = \"r\"\n[[fixture]]\nname = \"Mover 1\"\ntype = \"generic/profile\"\nposition = "
         "[0, 0, 5]\nuniverse = 1\naddress = 1\n"
         "[[fixture]]\nname = \"Mover 2\"\ntype = \"generic/profile\"\nposition = "
         "[1, 0, 5]\nuniverse = 1\naddress = 101\n";
  const Bridge bridge(folder.file("s"), {"--out", "mock:enttec-pro", "--rig", folder.file("rig.toml")});
  bridge.must({"set", "Mover 1:Dimmer=100%", "Mover 2:Dimmer=0.5"});
  const json held = json::parse(bridge.say({"set", "--list"}).out)["held"][0]["levels"];
  CAPTURE(held.dump());
  CHECK(held.size() >= 2);
  bridge.must({"set", "Mover *:Tilt=30"});
  bridge.must({"blackout", "on", "--rig", folder.file("rig.toml")});
  bridge.must({"blackout", "off"});
  bridge.must({"release", "Mover 1", "Mover *:Tilt"});
  bridge.must({"release", "Mover 2:Dimmer"});
  CHECK(json::parse(bridge.say({"set", "--list"}).out)["held"].empty());
  for (const auto& [word, part] :
       std::vector<std::pair<std::string, std::string>>{{"Mover 9:Tilt=30", "there are Mover 1, Mover 2"},
                                                        {"Mover 1:Tlt=30", "no channel for this attribute"},
                                                        {"Mover 1:Gobo1=50%", "wheel"},
                                                        {"Mover 1:Tilt=x", "expected a number"},
                                                        {"Mover 1=30", "FIXTURE:ATTRIBUTE=VALUE"}}) {
    const Outcome refused = bridge.say({"set", word});
    CAPTURE(word);
    CAPTURE(refused.err);
    CHECK(refused.exit_code >= 2);
    CHECK(contains(refused.err, part));
  }
}

TEST_CASE("a command without a bridge, with a wrong universe or without a rig says what to do") {
  const TempFolder folder;
  const Outcome none = footlight({"set", "1.17=255", "--socket", folder.file("none")});
  CHECK(none.exit_code == 3);
  CHECK(contains(none.err, "check that 'footlight run' is running"));
  const Bridge bridge(folder.file("s"));
  const auto refused = [&](const Words& words, std::string_view part) {
    const Outcome outcome = bridge.say(words);
    CAPTURE(outcome.err);
    CHECK(outcome.exit_code == 2);
    CHECK(contains(outcome.err, part));
  };
  refused({"set", "7.1=255"}, "universe 7 is not part of this bridge, which has 1");
  refused({"set", "1.1-99999=0"}, "1 to 512");
  refused({"set", "Mover 3:Tilt=30"}, "--rig FILE");
  refused({"set"}, "1.17=255");
  refused({"fade"}, "--over");
  refused({"release"}, "--all");
  refused({"release", "1.1", "--all"}, "--all");
  refused({"blackout", "maybe"}, "on, off or hold");
}

TEST_CASE("two bridges: a command without --socket lists both and changes neither") {
  const TempFolder folder;
  const std::map<std::string, std::string> place = {{"XDG_RUNTIME_DIR", folder.file("")}, {"RUNTIME_DIRECTORY", ""}};
  const Words words = {"run", "--json", "--no-realtime", "--out", "mock:enttec-pro"};
  Footlight one(words, place);
  one.wait_for("\"ready\"");
  Words of_two = words;
  of_two.back() = "mock:enttec-pro/two";
  Footlight two(of_two, place);
  two.wait_for("\"ready\"");
  Footlight setting({"set", "1.17=255"}, place);
  const Outcome outcome = setting.wait();
  CHECK(outcome.exit_code == 2);
  CHECK(contains(outcome.err, "footlight set --socket"));
}

TEST_CASE("damaged, oversized and unfinished commands are refused, and delay no one") {
  const TempFolder folder;
  const Bridge bridge(folder.file("s"));
  for (const std::string& body :
       {std::string(), std::string("footlight-hand 9\nset\n1.1=1\n"), std::string("footlight-hand 1\nset\n1.600=1\n"),
        std::string(1'000, '\0'), std::string("footlight-hand 1\nhold\nover 1\n")}) {
    const auto answer = tools::http_request(bridge.socket, "POST", "/hand", 2 * kNsPerS, body);
    REQUIRE(answer.has_value());
    CHECK(answer->status == 422);
  }
  std::string large = "footlight-hand 1\nset\n";
  while (large.size() < 300'000) large += "1.1=1\n";
  const auto refused = tools::http_request(bridge.socket, "POST", "/hand", 2 * kNsPerS, large);
  CHECK((!refused.has_value() || refused->status != 200));
  std::vector<Connection> stuck;
  for (int i = 0; i < 15; ++i) {
    stuck.emplace_back(bridge.socket);
    stuck.back().write("POST /hand HTTP/1.1\r\nHost: x\r\nContent-Length: 100000\r\n\r\nfootlight-hand 1\n");
  }
  bridge.must({"set", "1.17=9"});
  CHECK(bridge.shows(17, 9));
  CHECK(page(bridge.socket, "/hand")["held"].size() == 1);
}

TEST_CASE("a bridge that is killed during a blackout starts dark, until blackout is switched off") {
  const TempFolder folder;
  const std::string socket = folder.file("s");
  {
    const Bridge bridge(socket);
    bridge.must({"set", "1.17=255"});
    bridge.must({"blackout"});
    bridge.run->signal(SIGKILL);
    (void)bridge.run->wait();
  }
  const Bridge again(socket, {"--demo", "--out", "mock:enttec-pro", "--out", "mock:enttec-pro/b=2"});
  again.run->wait_for("starts-dark");
  CHECK(page(socket, "/hand")["blackout"] == true);
  CHECK(again.say({"scene", "store", "x", "--file", folder.file("scenes.toml")}).exit_code == 2);
  again.must({"blackout", "off"});
  CHECK(page(socket, "/hand")["blackout"] == false);
  again.run->signal(SIGTERM);
  (void)again.run->wait();
  CHECK(std::distance(std::filesystem::directory_iterator(folder.file("")), {}) == 0);
}

TEST_CASE("when the command that holds the dead man's switch is killed, blackout is on") {
  const TempFolder folder;
  const Bridge bridge(folder.file("s"));
  bridge.must({"set", "1.17=255"});
  Footlight holder({"blackout", "hold", "--within", "400ms", "--socket", bridge.socket});
  REQUIRE(eventually([&] { return page(bridge.socket, "/hand")["hold"] == true; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(900));  // longer than the hold lasts by itself
  CHECK(bridge.at(17) == 255);
  holder.signal(SIGKILL);
  CHECK(bridge.shows(17, 0));
  bridge.must({"blackout", "off"});
  CHECK(bridge.shows(17, 255));

  Footlight polite({"blackout", "hold", "--socket", bridge.socket});
  REQUIRE(eventually([&] { return page(bridge.socket, "/hand")["hold"] == true; }));
  bridge.must({"blackout", "off"});
  const Outcome ended = polite.wait();
  CHECK(ended.exit_code == 0);
  CHECK(contains(ended.err, "there is no hold"));
  CHECK(bridge.at(17) == 255);
}

TEST_CASE("a hold for an hour ends at once when its command is interrupted, and a second one is refused meanwhile") {
  const TempFolder folder;
  const Bridge bridge(folder.file("s"));
  bridge.must({"set", "1.17=255"});
  Footlight holder({"blackout", "hold", "--within", "1h", "--socket", bridge.socket});
  REQUIRE(eventually([&] { return page(bridge.socket, "/hand")["hold"] == true; }));
  const Outcome second = bridge.say({"blackout", "hold"});
  CHECK(second.exit_code == 2);
  CHECK(contains(second.err, "another 'footlight blackout hold'"));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // until the command sleeps
  holder.signal(SIGINT);
  CHECK(bridge.shows(17, 0));  // gives up after 30 s
  CHECK(holder.wait().exit_code == 0);
}

TEST_CASE("a reload that adds a universe during a blackout adds it dark") {
  const TempFolder folder;
  const std::string show = folder.file("show.toml");
  const auto ports = [&](const std::string& more) {
    std::ofstream(show) << "[[in]]\nendpoint = \"mock:enttec-pro=1\"\n[[out]]\nendpoint = \"mock:enttec-pro/o=1\"\n"
                        << more;
  };
  ports("");
  const Bridge bridge(folder.file("s"), {show});
  CHECK(eventually([&] { return bridge.at(1) > 0; }));
  bridge.must({"blackout"});
  CHECK(bridge.shows(1, 0));
  ports("[[in]]\nendpoint = \"mock:enttec-pro/second=2\"\n");
  bridge.must({"reload"});
  REQUIRE(eventually([&] { return bridge.at(1, 2) >= 0; }));
  for (int i = 0; i < 20; ++i) {
    CHECK(bridge.at(1, 2) == 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  bridge.must({"blackout", "off"});
  CHECK(eventually([&] { return bridge.at(1, 2) > 0; }));
  bridge.must({"set", "2.9=77"});
  CHECK(bridge.shows(9, 77, 2));
}

TEST_CASE("a scene is what the bridge merged, recalled, it is set by hand") {
  const TempFolder folder;
  const Bridge bridge(folder.file("s"));
  const std::string file = folder.file("scenes.toml");
  CHECK(bridge.say({"scene", "store", "Warm", "--file", file}).exit_code == 3);  // nothing was sent yet
  bridge.must({"set", "1.1-12=200", "1.17=9"});
  bridge.must({"scene", "store", "Warm", "1.1-12", "1.17", "--file", file});
  bridge.must({"scene", "store", "All", "--file", file});
  bridge.must({"set", "1.1-20=0"});
  bridge.must({"scene", "recall", "Warm", "--over", "100ms", "--file", file});
  CHECK(bridge.shows(12, 200));
  CHECK(bridge.shows(17, 9));
  CHECK(bridge.at(13) == 0);
  CHECK(footlight({"scene", "list", "--file", file}).out == "Warm\nAll\n");
  const Outcome unknown = bridge.say({"scene", "recall", "Cold", "--file", file});
  CHECK(unknown.exit_code == 3);
  CHECK(contains(unknown.err, "'Warm', 'All'"));
  REQUIRE(footlight({"scene", "delete", "Warm", "--file", file}).exit_code == 0);
  CHECK(footlight({"scene", "list", "--file", file}).out == "All\n");
  std::ofstream(file) << "[[scene]]\nname = \"Bad\"\nlevels = [\"Mover 3:Tilt=30\"]\n";
  const Outcome no_rig = bridge.say({"scene", "recall", "Bad", "--file", file});
  CHECK(no_rig.exit_code == 2);
  CHECK(contains(no_rig.err, file + ":3:11: "));
  const Outcome unwritable = bridge.say({"scene", "store", "x", "--file", "/proc/footlight/scenes.toml"});
  CHECK(unwritable.exit_code == 1);
  CHECK(contains(unwritable.err, "/proc/footlight"));
}

TEST_CASE("a bridge that does not answer is named, and not taken for none") {
  const TempFolder folder;
  const std::map<std::string, std::string> place = {{"XDG_RUNTIME_DIR", folder.file("")}, {"RUNTIME_DIRECTORY", ""}};
  Footlight bridge({"run", "--json", "--no-realtime", "--out", "mock:enttec-pro"}, place);
  bridge.wait_for("\"ready\"");
  bridge.signal(SIGSTOP);
  const Outcome outcome = Footlight({"set", "1.17=255"}, place).wait();
  bridge.signal(SIGCONT);
  CHECK(outcome.exit_code == 1);
  CHECK(contains(outcome.err, "run.sock: the program that has this socket does not answer"));
}

TEST_CASE("in a terminal a command of the hand names the slots that it changed, and a blackout that hides them") {
  const TempFolder folder;
  const Bridge bridge(folder.file("s"));
  const std::string file = folder.file("scenes.toml");
  const auto shown = [&](Words words) {
    words.insert(words.end(), {"--socket", bridge.socket});
    InTerminal terminal(words);
    CHECK(WEXITSTATUS(terminal.end()) == 0);
    return terminal.output();
  };
  CHECK(contains(shown({"set", "1.1-12=50%", "1.12=9", "1.20+21=300"}),
                 "footlight: set by hand: 14 slots of universe 1\r\n"));
  CHECK(contains(shown({"fade", "1.17=255", "--over", "10s"}), "fading over 10.00 s: 1 slot of universe 1"));
  CHECK(contains(shown({"scene", "store", "Warm", "1.1-12", "--file", file}),
                 "scene Warm: 12 slots of universe 1 stored in " + file));
  CHECK(contains(shown({"scene", "recall", "Warm", "--file", file}), "scene Warm: set by hand: 12 slots"));
  CHECK(contains(shown({"blackout"}), "blackout is on; 'footlight blackout off' ends it"));
  CHECK(contains(shown({"set", "1.1=255"}), "a blackout is on: it shows after 'footlight blackout off'"));
  CHECK(contains(shown({"blackout", "off"}), "blackout is off"));
  CHECK(contains(shown({"release", "1.17", "1.20"}), "given back: 2 slots of universe 1"));
  CHECK(contains(shown({"release", "--all"}), "given back: all slots that were set by hand"));
}

}  // namespace
}  // namespace footlight::testing
