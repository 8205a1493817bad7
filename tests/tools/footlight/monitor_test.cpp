// The display as a function of a state, and the command in a terminal whose other end the test holds.
#include <chrono>
#include <csignal>
#include <cstdio>

#include <sys/wait.h>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/drivers/net/private_network.h"
#include "tests/tools/footlight/in_terminal.h"
#include "tests/tools/footlight/run_footlight.h"
#include "tools/footlight/monitor/monitor_state.h"
#include "tools/footlight/monitor/monitor_view.h"
#include "tools/footlight/monitor/terminal.h"
#include "tools/footlight/status/json_lines.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

std::string all(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

// Nine universes. The second has two senders. One of them loses the merge and has a name with terminal sequences.
MonitorState nine_universes() {
  MonitorState state;
  state.title = "sacn:1-9";
  state.now_ns = 100 * kNsPerS;
  state.ports.push_back({.name = "sacn:1-9", .state = "working", .rate_hz = 396.0});
  state.ports.push_back({.name = "enttec-pro:EN1", .is_out = true, .state = "gone", .trouble = "unplugged"});
  for (Universe number = 1; number <= 9; ++number) {
    MonitorUniverse universe;
    universe.universe = number;
    universe.rate_hz = 44.0;
    universe.priority = 100;
    universe.stamp_ns = state.now_ns - 12 * kNsPerMs;
    universe.revision = 5;
    universe.sender_count = 1;
    universe.senders.push_back({.name = "FOH desk", .priority = 100, .rate_hz = 44.0, .wins = true});
    state.universes.push_back(universe);
  }
  state.universes[1].senders.push_back({.name = printable_utf8("\033[2Jbackup \xE7\x81\xAF"), .priority = 90});
  state.universes[1].sender_count = 2;
  state.universes[1].levels[0] = 255;
  state.universes[1].levels[511] = 128;
  state.universes[1].changed_ns[511] = state.now_ns - kNsPerMs;
  state.universes[8].stamp_ns = state.now_ns - 10 * kNsPerS;
  return state;
}

TEST_CASE("with a rig the slot that is chosen is explained, with its level, and marked among the numbers") {
  const MonitorState state = nine_universes();
  MonitorView view;
  view.rows = 45;
  view.columns = 160;
  view.selected = 2;
  view.slot = 511;
  view.meaning = "Spot 7: Dimmer: 50.2 %";
  CHECK(!contains(all(draw_monitor(state, view)), "Spot 7"));
  view.explains = true;
  CHECK(contains(all(draw_monitor(state, view)), " 2.512  128 (50 %)  Spot 7: Dimmer: 50.2 %"));
  view.colour = true;
  CHECK(contains(all(draw_monitor(state, view)), "\033[7m128\033[0m"));
  view.meaning.clear();
  CHECK(contains(all(draw_monitor(state, view)), "no fixture uses this slot"));
  view.filter = "1-3";
  view.selected = 9;  // is not shown: the first one is
  REQUIRE(shown_universe(state, view) != nullptr);
  CHECK(shown_universe(state, view)->universe == 1);
  CHECK(shown_universe({}, view) == nullptr);
}

TEST_CASE("two moments are compared: the slots that differ are counted, named with both levels and marked") {
  MonitorState state = nine_universes();
  state.universes[4].revision = 0;  // has had no frame
  MonitorView view;
  view.selected = 2;
  CHECK(!contains(all(draw_monitor(state, view)), "differ"));
  view.a = keep_moment(state);
  CHECK(view.a->levels.universes == std::vector<Universe>{1, 2, 3, 4, 6, 7, 8, 9});
  CHECK(contains(all(draw_monitor(state, view)), " A 0 ms ago, B now: 0 slots differ\n"));
  state.now_ns += 3 * kNsPerS;
  state.universes[1].levels[0] = 254;
  state.universes[1].levels[16] = 30;
  state.universes[6].levels[511] = 9;
  std::string text = all(draw_monitor(state, view));
  CAPTURE(text);
  CHECK(contains(text, " A 3.0 s ago, B now: 3 slots differ, in 2 universes\n"));
  CHECK(contains(text, "     age diff  sender"));
  CHECK(contains(text, ">      2    44.0   3.0 s    2  FOH desk"));
  CHECK(contains(text, "       7    44.0   3.0 s    1  FOH desk"));
  CHECK(contains(text, " 2:  1 255>254, 17 0>30\n"));
  view.selected = 3;
  CHECK(contains(all(draw_monitor(state, view)), " 3:  no slot differs\n"));
  // B is kept: what comes later changes nothing, and the levels are those of B.
  view.selected = 2;
  view.b = keep_moment(state);
  state.universes[1].levels[16] = 77;
  state.now_ns += 2 * kNsPerS;
  text = all(draw_monitor(state, view));
  CHECK(contains(text, " A 5.0 s ago, B 2.0 s ago: 3 slots differ, in 2 universes\n"));
  CHECK(contains(text, "17 0>30\n"));
  view.columns = 200;
  view.rows = 60;
  CHECK(contains(all(draw_monitor(state, view)), "   1 254   0   0"));
  CHECK(!contains(all(draw_monitor(state, view)), " 77"));
  view.colour = true;
  CHECK(contains(all(draw_monitor(state, view)), "\033[1;31m 30\033[0m"));
}

TEST_CASE("a picture has exactly as many lines as the screen, and none is wider") {
  const MonitorState full = nine_universes();
  const MonitorState empty;
  for (const MonitorState* state : {&full, &empty}) {
    for (int rows = 1; rows <= 70; ++rows) {
      for (int columns = 1; columns <= 220; columns += columns < 24 ? 1 : 13) {
        MonitorView view;
        view.rows = rows;
        view.columns = columns;
        view.selected = 2;
        view.explains = true;
        if (rows % 2 == 0) view.a = MonitorMoment{};  // all levels of now differ
        const auto lines = draw_monitor(*state, view);
        CAPTURE(rows);
        CAPTURE(columns);
        CHECK(lines.size() == static_cast<std::size_t>(rows));
        for (const std::string& line : lines) {
          CAPTURE(line);
          CHECK(columns_of(line) <= columns);
        }
      }
    }
  }
}

TEST_CASE("at 80 x 24 all nine universes, both senders of the selected one and all its levels are visible") {
  MonitorView view;
  view.selected = 2;
  const std::string text = all(draw_monitor(nine_universes(), view));
  CAPTURE(text);
  for (Universe universe = 1; universe <= 9; ++universe)
    CHECK(contains(text, fmt::format("      {}    44.0", universe)));
  CHECK(contains(text, " wins FOH desk"));
  CHECK(contains(text, "backup 灯"));
  CHECK(contains(text, "   1 █·"));
  CHECK(contains(text, "·▅\n"));
  CHECK(contains(text, "enttec-pro:EN1"));
  CHECK(contains(text, "unplugged"));
  CHECK(contains(text, "FOH desk +1"));
  CHECK(contains(text, "12 ms"));
  CHECK(contains(text, "10 s"));
}

TEST_CASE("at 200 x 60 the levels of the selected universe are numbers") {
  MonitorView view;
  view.columns = 200;
  view.rows = 60;
  view.selected = 2;
  const std::string text = all(draw_monitor(nine_universes(), view));
  CHECK(contains(text, "universe 2  2 senders"));
  CHECK(contains(text, "   1 255   0   0"));
  CHECK(contains(text, " 128 \n"));
}

TEST_CASE("a change is marked for one second") {
  MonitorView view;
  view.selected = 2;
  view.colour = true;
  MonitorState state = nine_universes();
  CHECK(contains(all(draw_monitor(state, view)), "\033[1;33m▅"));
  state.now_ns += kNsPerS;
  CHECK_FALSE(contains(all(draw_monitor(state, view)), "\033[1;33m▅"));
}

TEST_CASE("the table scrolls so that the selected universe is visible") {
  MonitorState state = nine_universes();
  for (Universe number = 10; number <= 500; ++number) {
    MonitorUniverse universe = state.universes[0];
    universe.universe = number;
    state.universes.push_back(universe);
  }
  for (const Universe chosen : {1, 2, 250, 499, 500}) {
    MonitorView view;
    view.selected = chosen;
    CHECK(contains(all(draw_monitor(state, view)), fmt::format(">{:>7} ", chosen)));
  }
}

TEST_CASE("a filter is a list of universes, or part of a sender's name") {
  const MonitorState state = nine_universes();
  CHECK(shown_universes(state, "").size() == 9);
  CHECK(shown_universes(state, "2-3,9") == std::vector<Universe>{2, 3, 9});
  CHECK(shown_universes(state, "BACKUP") == std::vector<Universe>{2});
  CHECK(shown_universes(state, "nobody").empty());
  MonitorView view;
  view.filter = "nobody";
  CHECK(contains(all(draw_monitor(state, view)), "no universe passes the filter"));
}

TEST_CASE("names from the network cannot control the terminal") {
  CHECK(printable_utf8("\033[2J") == "\xEF\xBF\xBD[2J");
  CHECK(printable_utf8("a\xC2\x9B"
                       "1m") ==
        "a\xEF\xBF\xBD"
        "1m");                                              // CSI as one character
  CHECK(printable_utf8("\xE2\x80\xAE") == "\xEF\xBF\xBD");  // changes the direction of the following text
  CHECK(printable_utf8("\xC0\x80\xED\xA0\x80\xF5") ==
        "\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD");
  CHECK(printable_utf8("B\xC3\xBChne \xE7\x81\xAF \xF0\x9F\x92\xA1") == "B\xC3\xBChne \xE7\x81\xAF \xF0\x9F\x92\xA1");
  CHECK(printable_utf8("\xE7\x81") == "\xEF\xBF\xBD\xEF\xBF\xBD");  // cut
}

TEST_CASE("a long line keeps its beginning and end, cut between characters, lines keep their ends") {
  CHECK(printable_line("short\n") == "short\xEF\xBF\xBD");
  const std::string as_long = std::string(1900, 'a');
  CHECK(printable_line(as_long) == as_long);
  std::string lights;
  for (int i = 0; i < 1000; ++i) lights += "\xF0\x9F\x92\xA1";
  const std::string cut = printable_line("x" + lights + "y");
  CHECK(cut.size() < 1920);
  CHECK(cut.starts_with("x\xF0\x9F\x92\xA1"));
  CHECK(cut.ends_with("\xF0\x9F\x92\xA1y"));
  CHECK(contains(cut, " [...] "));
  CHECK_FALSE(contains(cut, "\xEF\xBF\xBD"));
  CHECK(printable_lines("a\n" + std::string(5000, 'b') + "\nc").ends_with("b\nc"));
  CHECK(printable_lines("a\n" + std::string(5000, 'b') + "\nc").size() < 2000);
}

TEST_CASE("wide characters take two columns, and a text is cut between characters") {
  CHECK(columns_of("灯灯") == 4);
  CHECK(cut_to("灯灯", 4) == "灯灯");
  CHECK(cut_to("灯灯", 3) == "灯…");
  CHECK(cut_to("灯灯", 2) == "…");
  CHECK(cut_to("abc", 3) == "abc");
  CHECK(cut_to("abcd", 3) == "ab…");
  CHECK(cut_to("abc", 0).empty());
}

TEST_CASE("a sender's losses appear in its line, and a sender without loss shows none") {
  PumpStatus status;
  UniverseStatus universe;
  universe.universe = 3;
  universe.senders = {{.name = "FOH", .id = 1, .losses = {.lost = 41, .late = 7}}, {.name = "backup", .id = 2}};
  status.universes = {universe};
  MonitorState state;
  REQUIRE(take_status(state, json_of_status(status)));
  REQUIRE(state.universes.size() == 1);
  CHECK(state.universes[0].senders[0].lost == 41);
  CHECK(state.universes[0].senders[0].late == 7);
  const std::string picture = all(draw_monitor(state, {.columns = 100, .rows = 40}));
  CHECK(contains(picture, "  41 lost  7 late"));
  CHECK(picture.find("lost") == picture.rfind("lost"));
}

TEST_CASE("invalid and truncated pages are refused, or read as far as they go") {
  MonitorState state;
  for (const char* text : {"", "[]", "null", "{", R"({"event":"ready"})", R"({"event":5})"}) {
    CAPTURE(text);
    CHECK_FALSE(take_status(state, text).has_value());
    CHECK_FALSE(take_levels(state, text).has_value());
  }
  CHECK(take_status(state, R"({"event":"status","ports":{},"universes":[7,{"universe":"x"},{"universe":3}]})")
            .has_value());
  CHECK(state.find(3) != nullptr);
  CHECK(take_levels(state, R"({"event":"levels","universes":[{"universe":3,"levels":"ff"},{"universe":4}]})")
            .has_value());
  CHECK_FALSE(take_levels(state, R"({"event":"levels","universes":[{"universe":3,"levels":")" + std::string(1024, 'g') +
                                     "\"}]}")
                  .has_value());
}

TEST_CASE("a slot counts as changed when its level differs, but not when it is first received") {
  MonitorState state;
  const auto levels = [](int now_ns, const std::string& first) {
    return fmt::format(
        R"({{"event":"levels","now_ns":{},"universes":[{{"universe":3,"revision":1,"levels":"{}{}"}}]}})", now_ns,
        first, std::string(1022, '0'));
  };
  REQUIRE(take_status(state, R"({"event":"status","universes":[{"universe":3}]})").has_value());
  REQUIRE(take_levels(state, levels(10, "ff")).has_value());
  CHECK(state.universes[0].changed_ns[0] == 0);
  REQUIRE(take_levels(state, levels(20, "fe")).has_value());
  REQUIRE(take_levels(state, levels(30, "fe")).has_value());
  REQUIRE(take_status(state, R"({"event":"status","universes":[{"universe":2},{"universe":3}]})").has_value());
  CHECK(state.universes[1].changed_ns[0] == 20);
  CHECK(state.universes[1].changed_ns[1] == 0);
  CHECK(state.universes[1].levels[0] == 0xFE);
}

TEST_CASE("keys are decoded, also if their bytes arrive one by one") {
  std::string typed;
  const auto keys = [&](std::string bytes) {
    std::vector<Key> found;
    std::string pressed;
    for (const char byte : bytes) {
      pressed += byte;
      for (Key key = Key::kNone; (key = take_key(pressed, typed, true)) != Key::kNone;) found.push_back(key);
    }
    while (!pressed.empty()) found.push_back(take_key(pressed, typed, false));
    return found;
  };
  CHECK(keys("\033[A\033OB\033[5~\033[6~") == std::vector{Key::kUp, Key::kDown, Key::kPageUp, Key::kPageDown});
  CHECK(keys("\033[C\033OD") == std::vector{Key::kRight, Key::kLeft});
  CHECK(keys("\033") == std::vector{Key::kEscape});
  CHECK(keys("\r\x7F") == std::vector{Key::kEnter, Key::kBackspace});
  CHECK(keys("\xC3\xBC") == std::vector{Key::kText});
  CHECK(typed == "\xC3\xBC");
}

TEST_CASE("the terminal is restored when q is pressed") {
  testing::InTerminal monitor({"monitor", "mock:enttec-pro=3"});
  monitor.wait_for(">      3");
  CHECK(contains(monitor.output(), "\033[?1049h"));
  CHECK_FALSE(monitor.is_as_before());
  monitor.type("a");
  monitor.wait_for("0 slots differ");
  monitor.wait_for("B now");
  monitor.type("b");
  monitor.wait_for(" ms ago, B 0 ms ago");
  monitor.type("x");
  monitor.type(" ");
  monitor.wait_for("PAUSED");
  monitor.type("/7");
  monitor.wait_for("filter: 7");
  monitor.type("\r");
  monitor.wait_for("no universe passes");
  monitor.type("q");
  const int status = monitor.end();
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  CHECK(monitor.is_as_before());
  CHECK(contains(monitor.output(), "\033[?1049l"));
}

TEST_CASE("the terminal is restored whatever signal ends the monitor") {
  std::vector<int> numbers = {SIGINT, SIGTERM, SIGHUP, SIGQUIT};
#if !defined(FOOTLIGHT_THREAD_SANITIZER)
  // ThreadSanitizer runs the handler of SIGBUS at once, also where kill() sent it and the thread holds a lock of the
  // sanitizer that the handler needs.
  numbers.push_back(SIGBUS);
#endif
  for (const int number : numbers) {
    CAPTURE(number);
    testing::InTerminal monitor({"monitor", "mock:enttec-pro=3"});
    monitor.wait_for(">      3");
    // ThreadSanitizer sets up a thread's signals in its first call that waits, and loses a signal that comes meanwhile:
    // an answered key proves that this call is over.
    monitor.type("/7");
    monitor.wait_for("filter: 7");
    monitor.signal(number);
    const int status = monitor.end();
    CHECK((number == SIGBUS ? WIFSIGNALED(status) : WIFEXITED(status)));
    CHECK(monitor.is_as_before());
    CHECK(contains(monitor.output(), "\033[?1049l"));
  }
}

TEST_CASE("discover shows the remaining seconds on a terminal") {
  if (!testing::enter_private_network()) return;
  testing::InTerminal discover({"discover", "--for", "1500ms"});
  discover.wait_for("footlight: 2 s left, 0 found");
  discover.wait_for("footlight: 1 s left, 0 found");
  CHECK(WEXITSTATUS(discover.end()) == 3);
}

TEST_CASE("a running bridge is monitored through its socket, and reported as gone when it ends") {
  const testing::TempFolder folder;
  const std::string socket = folder.file("b.sock");
  testing::Footlight bridge(
      {"run", "--in", "mock:enttec-pro=5", "--out", "mock:enttec-pro=5", "--json", "--socket", socket});
  bridge.wait_for(R"("frames":1)");  // 1 or more: it has received levels
  const auto once = testing::footlight({"monitor", "--socket", socket, "--once", "--json"});
  REQUIRE(once.exit_code == 0);
  const auto json = nlohmann::json::parse(once.out);
  CHECK(json["event"] == "monitor");
  CHECK(json["ports"].size() == 2);
  CHECK(json["universes"][0]["universe"] == 5);
  CHECK(json["universes"][0]["levels"].size() == 512);
  testing::InTerminal monitor({"monitor", "--socket", socket});
  monitor.wait_for(">      5");
  bridge.signal(SIGTERM);
  CHECK(bridge.wait().exit_code == 0);
  monitor.wait_for("No such file");
  monitor.type("q");
  CHECK(WEXITSTATUS(monitor.end()) == 0);
}

TEST_CASE("a monitor finds the only running bridge, and lists the sockets if there are two") {
  const testing::TempFolder folder;
  const std::map<std::string, std::string> environment = {{"XDG_RUNTIME_DIR", folder.file("")}};
  const auto monitor = [&] {
    testing::Footlight program({"monitor", "--once", "--json"}, environment);
    return program.wait();
  };
  CHECK(monitor().exit_code == 3);
  const std::vector<std::string> run = {"run", "--in", "mock:enttec-pro", "--out", "mock:enttec-pro", "--json"};
  testing::Footlight first(run, environment);
  first.wait_for(R"("event":"ready")");
  CHECK(monitor().exit_code == 0);
  testing::Footlight second(run, environment);
  second.wait_for(R"("event":"ready")");
  const auto outcome = monitor();
  CHECK(outcome.exit_code == 2);
  CHECK(contains(outcome.err, "--socket " + folder.file("") + "/footlight/run.sock"));
}

TEST_CASE("a slot without a rig, and a rig for levels as JSON, are refused before anything is opened") {
  const auto slot = testing::footlight({"monitor", "mock:enttec-pro", "--once", "--slot", "17"});
  CHECK(slot.exit_code == 2);
  CHECK(contains(slot.err, "--slot 17"));
  CHECK(contains(slot.err, "add --rig FILE"));
  const auto rig = testing::footlight({"monitor", "mock:enttec-pro", "--json", "--once", "--rig", "none.toml"});
  CHECK(rig.exit_code == 2);
  CHECK(contains(rig.err, "--rig none.toml"));
  CHECK(contains(rig.err, "--json"));
}

TEST_CASE("a monitor without a terminal is refused with the options that need none") {
  const auto outcome = testing::footlight({"monitor", "mock:enttec-pro"});
  CHECK(outcome.exit_code == 1);
  CHECK(contains(outcome.err, "--once"));
  CHECK(contains(outcome.err, "--json"));
}

}  // namespace
}  // namespace footlight::tools
