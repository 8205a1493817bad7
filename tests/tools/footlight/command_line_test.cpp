// The command line: help and messages for wrong arguments. Nothing here needs a network or a
// device.
#include <algorithm>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {
namespace {

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

// The first column of the list of subcommands.
std::vector<std::string> commands_of(const std::string& help) {
  std::vector<std::string> commands;
  const std::size_t at = help.find("Subcommands:");
  REQUIRE(at != std::string::npos);
  const std::string list = help.substr(at, help.find("\n\n", at) - at);
  const std::regex line(R"(\n  ([a-z]+)  )");
  for (auto match = std::sregex_iterator(list.begin(), list.end(), line); match != std::sregex_iterator(); ++match) {
    commands.push_back((*match)[1]);
  }
  return commands;
}

TEST_CASE("help names every command, the endpoints and the exit codes") {
  const Outcome outcome = footlight({"--help"});
  CHECK(outcome.exit_code == 0);
  for (const char* command : {"devices", "discover", "run", "record", "replay", "log", "trace"}) {
    const auto commands = commands_of(outcome.out);
    CHECK(std::find(commands.begin(), commands.end(), command) != commands.end());
  }
  CHECK(contains(outcome.out, "sacn:1-9@10.0.0.7"));
  CHECK(contains(outcome.out, "Exit codes: 0 done"));
}

TEST_CASE("the help of every command has examples that begin with its name") {
  for (const std::string& command : commands_of(footlight({"--help"}).out)) {
    CAPTURE(command);
    const Outcome outcome = footlight({command, "--help"});
    CHECK(outcome.exit_code == 0);
    CHECK(contains(outcome.out, "Examples:"));
    CHECK(contains(outcome.out, "\n  footlight " + command));
  }
  for (const char* command : {"info", "convert", "compare"}) {
    const Outcome outcome = footlight({"log", command, "--help"});
    CHECK(outcome.exit_code == 0);
    CHECK(contains(outcome.out, std::string("\n  footlight log ") + command));
  }
}

TEST_CASE("the commands in the README exist") {
  const auto commands = commands_of(footlight({"--help"}).out);
  std::ifstream readme(FOOTLIGHT_SOURCE_DIR "/README.md");
  REQUIRE(readme.is_open());
  const std::regex call(R"((?:^|[ `/])footlight ([a-z]+)( |$|`))");
  // A build without Vulkan has no commands that make pictures.
  const std::regex picture_call(R"(footlight (render|preview) )");
  bool in_code = false;
  for (std::string line; std::getline(readme, line);) {
    if (line.rfind("```", 0) == 0) in_code = !in_code;
    std::smatch match;
    if (!in_code || !std::regex_search(line, match, call)) continue;
    if (FOOTLIGHT_HAS_PICTURES == 0 && std::regex_search(line, picture_call)) continue;
    CAPTURE(line);
    CHECK(std::find(commands.begin(), commands.end(), match[1].str()) != commands.end());
  }
}

TEST_CASE("the version is one line") {
  const Outcome outcome = footlight({"--version"});
  CHECK(outcome.exit_code == 0);
  CHECK(std::regex_match(outcome.out, std::regex("footlight [0-9]+\\.[0-9]+\\.[0-9]+\n")));
}

// Wrong arguments, the expected exit code, and text that the message must contain.
struct Wrong {
  std::vector<std::string> arguments;
  int exit_code;
  std::vector<std::string> named;
};

TEST_CASE("arguments that are not expected are quoted in messages, and no control character reaches the terminal") {
  CHECK(contains(footlight({"tap", ""}).err, "this argument was not expected: ''"));
  CHECK(contains(footlight({"tap", "a b", "::"}).err, "these arguments were not expected: 'a b' '::'"));
  for (const auto& words : {std::vector<std::string>{"tap", "\x1b[2J"}, {"clip", "a.mkv", "--rows", "\x1b[2J"}}) {
    const Outcome outcome = footlight(words);
    CHECK(outcome.exit_code == 2);
    CHECK(contains(outcome.err, "\xEF\xBF\xBD[2J"));
    CHECK_FALSE(contains(outcome.err, "\x1b"));
  }
}

TEST_CASE("wrong arguments end with an exit code and a message that names the thing and the next step") {
  const TempFolder folder;
  const std::string missing = folder.file("missing.dmxlog");
  std::ofstream(folder.file("text.dmxlog")) << "this is no log\n";
  std::ofstream(folder.file("broken.show")) << "OLA Show\n1 0,300\n";
  std::ofstream(folder.file("empty.toml")).close();
  std::ofstream(folder.file("wrong.toml"))
      << "[[in]]\nendpoint = \"sacn:1-9\"\npriorty = 3\n[[out]]\nendpoint = \"artnet:1\"\n";

  const std::vector<Wrong> wrongs = {
      {{}, 2, {"--help"}},
      {{"rum"}, 2, {"rum", "run", "--help"}},
      {{"run", "--in", "sacn:1-9"}, 2, {"--out"}},
      {{"run", "--out", "mock:enttec-pro", "--rig", missing}, 3, {"--rig", missing}},
      {{"run", "--in", "osc:0", "--out", "mock:enttec-pro"}, 2, {"osc:0", "osc:8000"}},
      {{"run", "--in", "midi:mock", "--out", "mock:enttec-pro"}, 2, {"midi:mock", "midi:mock=1.1"}},
      {{"run", "--in", "midi:" + folder.file("wrong.toml"), "--out", "mock:enttec-pro"}, 2, {"wrong.toml"}},
      {{"run", "--in", "mock:enttec-pro", "--out", "osc:8000"}, 2, {"osc:8000", "--in"}},
      {{"record", "--in", "osc:8000", "-o", folder.file("o.dmxlog")}, 2, {"osc:8000", "footlight run"}},
      {{"learn"}, 2, {"midi:nanoKONTROL2"}},
      {{"learn", "sacn:1"}, 2, {"sacn:1", "osc:PORT"}},
      {{"set"}, 2, {"1.17=255", "--list"}},
      {{"set", "1.17=255", "--socket", missing}, 3, {missing, "footlight run"}},
      {{"set", "1.17=255", "--priority", "201"}, 2, {"--priority"}},
      {{"fade", "--over", "3s"}, 2, {"footlight fade 1.17=255"}},
      {{"fade", "1.17=255", "--over", "25h"}, 2, {"24h"}},
      {{"release"}, 2, {"--all", "1.17"}},
      {{"blackout", "maybe"}, 2, {"maybe", "on, off or hold"}},
      {{"blackout", "hold", "--within", "1ms", "--socket", missing}, 2, {"200ms"}},
      {{"scene", "recall", "--file", missing}, 2, {"recall", "name"}},
      {{"scene", "list", "--file", missing}, 3, {missing}},
      {{"render", "--demo", "--at", "1s", "--style", "VRSL", "-o", "a.png"}, 2, {"--style VRSL", "vrsl or card"}},
      {{"render", "--demo", "--at", "1s", "--style", "vrsl", "--show", "lux", "-o", "a.png"}, 2, {"--show", "style"}},
      {{"render", "--demo", "--at", "1s", "--style", "card", "--error", "1%", "-o", "a.png"}, 2, {"--error", "style"}},
      {{"scene", "list", "--file", folder.file("empty.toml")}, 3, {"empty.toml", "has no scene", "scene store"}},
      {{"scene", "delete", "Warm", "--file", missing}, 3, {missing}},
      {{"run", "--in", "sacn:0-9", "--out", "mock:enttec-pro"}, 2, {"sacn:0-9", "universe 0", "1 to 63999"}},
      {{"run", "--in", "sacn:64000", "--out", "mock:enttec-pro"}, 2, {"sacn:64000", "universe 64000"}},
      {{"run", "--in", "audio:mock", "--out", "mock:enttec-pro"}, 2, {"audio:mock", "audio:mock=1.25"}},
      {{"run", "--in", "audio:mock=1.1", "--out", "vrsl:1@mock?quality=2"}, 2, {"\"quality\" is not an option"}},
      {{"run", "--in", "audio:mock=1.1", "--out", "vrsl:1@a.mkv?overwrite=maybe"}, 2, {"overwrite=maybe", "yes or no"}},
      {{"log", "convert", "audio:mock=1.1", "a.dmxlog"}, 2, {"a device, which has no end", "record --in"}},
      {{"rig", "export", "no.toml", "-o", "a.txt"}, 2, {".mvr or .json"}},
      {{"rig", "export", "no.toml", "-o", "a.json"}, 3, {"no.toml"}},
      {{"run", "--in", "vrsl-osc:10", "--out", "mock:enttec-pro"}, 2, {"vrsl-osc:10", "1 to 9"}},
      {{"run", "--in", "mock:enttec-pro", "--out", "vrsl-osc:1%lo"}, 2, {"vrsl-osc:1%lo", "leave out"}},
      {{"run", "--in", "scan:1", "--out", "mock:enttec-pro"}, 2, {"scan:1", "unknown scheme", "sacn, artnet"}},
      {{"run", "--in", "sacn:1@10.0.0.300", "--out", "mock:enttec-pro"}, 2, {"10.0.0.300", "IPv4", "@10.0.0.7"}},
      {{"run", "--in", "sacn:1%nosuch0", "--out", "mock:enttec-pro"}, 3, {"sacn:1%nosuch0", "nosuch0"}},
      {{"run", "--in", "gpio:gpiochip0/17", "--out", "mock:enttec-pro"}, 2, {"gpio:gpiochip0/17", "=1.25"}},
      {{"run", "--in", "gpio:mock/61=1.25", "--out", "mock:enttec-pro"}, 3, {"gpio:mock/61=1.25", "0 to 60"}},
      {{"run", "--in", "mock:enttec-pro", "--out", "gpio:mock/2=1.25"}, 2, {"gpio:mock/2=1.25", "inputs", "--in"}},
      {{"run", "--in", "mock:enttec-pro", "--out", "mock:nothing"}, 2, {"mock:nothing", "enttec-pro"}},
      {{"run", "--in", "mock:enttec-pro", "--out", "enttec-pro:NOSUCH"}, 3, {"enttec-pro:NOSUCH"}},
      {{"run", "--in", "mock:enttec-pro", "--out", "mock:enttec-pro", "--for", "soon"}, 2, {"--for", "soon", "1m30s"}},
      {{"run", folder.file("none.toml")}, 3, {"none.toml", "footlight run"}},
      {{"run", folder.file("wrong.toml")}, 2, {"wrong.toml:3", "priorty"}},
      {{"record", "--in", "sacn:1"}, 2, {"-o", "footlight record"}},
      {{"record", "--in", "mock:enttec-pro", "-o", folder.file("no/such/folder.dmxlog"), "--for", "0s"},
       3,
       {"no/such"}},
      {{"replay"}, 2, {"--demo", "footlight replay"}},
      {{"replay", missing, "--out", "mock:enttec-pro"}, 3, {"missing.dmxlog"}},
      {{"replay", missing, "--demo", "--out", "mock:enttec-pro"}, 2, {"--demo"}},
      {{"replay", folder.file("text.dmxlog"), "--out", "mock:enttec-pro"}, 2, {"text.dmxlog"}},
      {{"replay", "--demo", "--out", "mock:enttec-pro", "--speed", "0"}, 2, {"--speed"}},
      {{"replay", "--demo", "--out", "mock:enttec-pro", "--universes", "0-3"}, 2, {"--universes", "universe 0"}},
      {{"laser"}, 2, {"footlight laser --help"}},
      {{"laser", "check"}, 2, {"logo.ild"}},
      {{"laser", "safety", "club.toml", "--at", "1,2"}, 2, {"--at 1,2", "X,Y,Z"}},
      {{"laser", "safety", "club.toml", "--at", "nan,0,0"}, 2, {"--at nan,0,0", "X,Y,Z"}},
      {{"rdm"}, 2, {"footlight rdm --help"}},
      {{"rdm", "list"}, 2, {"--port", "mock:enttec-pro"}},
      {{"rdm", "list", "--port", "sacn:1"}, 2, {"sacn:1", "does not support RDM", "artnet:1@10.0.0.7"}},
      {{"rdm", "list", "--port", "artnet:1-4@127.0.0.1"}, 2, {"artnet:1-4@127.0.0.1", "one universe"}},
      {{"rdm", "list", "--port", "enttec-pro:NOSUCH"}, 3, {"enttec-pro:NOSUCH"}},
      {{"rdm", "get", "--port", "mock:enttec-pro"}, 2, {"UID", "DEVICE_INFO"}},
      {{"rdm", "get", "7FF0", "DEVICE_INFO", "--port", "mock:enttec-pro"}, 2, {"7FF0", "02B0:00012345"}},
      {{"rdm", "get", "7FF0:00000001", "LABEL", "--port", "mock:enttec-pro"}, 2, {"LABEL", "DEVICE_LABEL"}},
      {{"rdm", "get", "7FF0:00000099", "DEVICE_LABEL", "--port", "mock:enttec-pro"}, 1, {"7FF0:00000099", "no answer"}},
      {{"rdm", "set", "7FF0:00000001", "DMX_START_ADDRESS", "600", "--port", "mock:enttec-pro"},
       2,
       {"7FF0:00000001", "DMX_START_ADDRESS", "data out of range"}},
      {{"rdm", "set", "7FF0:00000001", "DEVICE_INFO", "1", "--port", "mock:enttec-pro"}, 2, {"read-only"}},
      {{"fixtures"}, 2, {"footlight fixtures --help"}},
      {{"fixtures", "check"}, 2, {"footlight fixtures check"}},
      {{"fixtures", "check", missing}, 3, {"missing.dmxlog"}},
      {{"fixtures", "find"}, 2, {"fixtures find", "words"}},
      {{"fixtures", "find", "qqqzzzxxx"}, 3, {"qqqzzzxxx", "--library"}},
      {{"fixtures", "list", "qqqzzzxxx"}, 3, {"qqqzzzxxx", "--library"}},
      {{"fixtures", "convert"}, 2, {"fixtures convert", "FILE"}},
      {{"fixtures", "convert", missing, "-o", "x.txt"}, 2, {"x.txt", ".toml"}},
      {{"fixtures", "convert", missing, "-o", "x.toml"}, 3, {"missing.dmxlog"}},
      {{"fixtures", "show"}, 2, {"footlight fixtures show"}},
      {{"fixtures", "show", missing}, 3, {"missing.dmxlog"}},
      {{"fixtures", "show", folder.file("text.dmxlog")}, 2, {"text.dmxlog", "gdtf"}},
      {{"log"}, 2, {"footlight log --help"}},
      {{"log", "inform"}, 2, {"inform", "info, convert"}},
      {{"log", "info"}, 2, {"footlight log info"}},
      {{"log", "info", missing}, 3, {"missing.dmxlog"}},
      {{"log", "info", folder.file("text.dmxlog")}, 2, {"text.dmxlog"}},
      {{"log", "info", folder.file("broken.show")}, 2, {"broken.show:2", "300"}},
      {{"log", "convert", missing}, 2, {"two files"}},
      {{"log", "convert", missing, folder.file("out.dmxlog")}, 3, {"missing.dmxlog"}},
  };
  for (const Wrong& wrong : wrongs) {
    std::string line = "footlight";
    for (const std::string& argument : wrong.arguments) line += " " + argument;
    CAPTURE(line);
    const Outcome outcome = footlight(wrong.arguments);
    CAPTURE(outcome.err);
    CHECK(outcome.exit_code == wrong.exit_code);
    CHECK(outcome.err.rfind("footlight: ", 0) == 0);
    for (const std::string& name : wrong.named) CHECK_MESSAGE(contains(outcome.err, name), name);
  }
}

TEST_CASE("a rig in the place of a log, a focus without an aperture, and a bridge without a socket are refused") {
  const TempFolder folder;
  const std::string rig = folder.file("rig.toml");
  std::ofstream(rig) << "[rig]\nname = \"Hall\"\n[[fixture]]\nname = \"A\"\ntype = \"generic/par\"\nuniverse = 1\n"
                        "address = 1\nposition = [0, 0, 4]\n";
  const std::vector<std::string> is_rig = {"rig.toml: is a rig", ".dmxlog", "RIG --log LOG"};
  std::vector<Wrong> wrongs = {
      {{"monitor", "--socket", "none"}, 2, {"--socket none", "--socket auto", "monitor sacn:1-9"}},
      {{"trace", rig, "--log", rig, "--at", "0s"}, 2, is_rig},
  };
  if (FOOTLIGHT_HAS_PICTURES != 0) {
    const std::string png = folder.file("a.png");
    const auto render = [&](std::vector<std::string> more) {
      std::vector<std::string> all{"render", rig, "--lit", "--at", "0s", "-o", png};
      all.insert(all.end(), more.begin(), more.end());
      return all;
    };
    wrongs.push_back({{"render", rig, "--log", rig, "--at", "0s", "-o", png}, 2, is_rig});
    wrongs.push_back({render({"--focus", "5"}), 2, {"--focus 5", "has no f_stop", "--f-stop 2.8"}});
    wrongs.push_back({render({"--focus", "5", "--f-stop", "off"}), 2, {"--focus 5", "--f-stop is off"}});
    for (const char* number : {"nan", "inf", "10001", "0.09", "near"}) {
      wrongs.push_back({render({"--f-stop", "2", "--focus", number}), 2, {"--focus", "0.1 to 10000", number}});
    }
    if (footlight({"preview", "--help"}).exit_code == 0) {
      wrongs.push_back({{"preview", rig, "--compare", rig}, 2, is_rig});
    }
  }
  for (const Wrong& wrong : wrongs) {
    const Outcome outcome = footlight(wrong.arguments);
    CAPTURE(outcome.err);
    CHECK(outcome.exit_code == wrong.exit_code);
    for (const std::string& name : wrong.named) CHECK_MESSAGE(contains(outcome.err, name), name);
  }
}

TEST_CASE("discover names a missing interface, and finds nothing on a silent one") {
  const Outcome wrong = footlight({"discover", "--interface", "eht7"});
  CHECK(wrong.exit_code == 3);
  CHECK(contains(wrong.err, "no network interface is called \"eht7\""));
  const Outcome silent = footlight({"discover", "--for", "10ms", "--interface", "lo", "--json"});
  CHECK(silent.exit_code == 3);
  CHECK(silent.out.empty());
  CHECK(contains(silent.err, "no sender or node answered"));
}

TEST_CASE("the devices behind a modelled widget are listed, one JSON object each, and get returns the listed values") {
  const Outcome listed = footlight({"rdm", "list", "--port", "mock:enttec-pro", "--json"});
  CAPTURE(listed.err);
  REQUIRE(listed.exit_code == 0);
  std::vector<nlohmann::json> devices;
  std::istringstream lines(listed.out);
  for (std::string line; std::getline(lines, line);) devices.push_back(nlohmann::json::parse(line));
  REQUIRE(devices.size() == 3);
  CHECK(devices[1]["label"] == "Spot stage left");
  CHECK(devices[2]["is_proxied"] == true);
  const std::string uid = devices[1]["uid"];
  const Outcome got = footlight({"rdm", "get", uid, "DEVICE_INFO", "--port", "mock:enttec-pro", "--json"});
  REQUIRE(got.exit_code == 0);
  const auto info = nlohmann::json::parse(got.out);
  CHECK(info["values"]["start address"] == devices[1]["start_address"]);
  CHECK(info["values"]["footprint"] == devices[1]["footprint"]);
  CHECK(footlight({"rdm", "get", uid, "0x8001", "--port", "mock:enttec-pro"}).out == "50\n");
  const Outcome set = footlight({"rdm", "set", uid, "DEVICE_LABEL", "Followspot", "--port", "mock:enttec-pro"});
  CHECK(set.exit_code == 0);  // the model ends with its program; rdm_enttec_pro_test.cpp tests the effect of a set
  CHECK(set.err.empty());
}

TEST_CASE("devices prints JSON objects or reports that there are none, and never fails otherwise") {
  const Outcome outcome = footlight({"devices", "--json"});
  if (outcome.exit_code == 0) {
    CHECK(contains(outcome.out, "\"endpoint\""));
  } else {
    CHECK(outcome.exit_code == 3);
    CHECK(outcome.out.empty());
    CHECK(contains(outcome.err, "mock:enttec-pro"));
  }
}

}  // namespace
}  // namespace footlight::testing
