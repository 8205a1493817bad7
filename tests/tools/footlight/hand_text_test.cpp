// Commands of the hand as text, and scene files.
#include "tools/footlight/hand/hand_text.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include <doctest/doctest.h>

#include "tests/support/temp_folder.h"
#include "tools/footlight/hand/scene_file.h"

namespace footlight::tools {
namespace {

using testing::TempFolder;

std::vector<HandLevel> levels_of(std::string_view text) {
  std::vector<HandLevel> levels;
  const Status read = parse_slot_assignment(text, levels);
  REQUIRE_MESSAGE(read.has_value(), (read ? "" : read.error().message));
  return levels;
}

TEST_CASE("the parts of a long command are messages that a bridge reads, and have all of its levels") {
  HandCommand command;
  command.action = HandAction::kBlackout;
  for (int i = 0; i < 40'000; ++i) {  // no two in a row, so that no range is shorter
    HandLevel level;
    level.universe = 60'000 - i / 100;
    level.count = 4;
    for (int b = 0; b < 4; ++b)
      level.slots[static_cast<std::size_t>(b)] = static_cast<std::uint16_t>(500 - 5 * (i % 100) + b);
    level.value = 4'000'000'000u;
    command.levels.push_back(level);
  }
  std::vector<HandLevel> levels;
  for (const HandCommand& part : hand_parts(command)) {
    const std::string message = hand_message(part);
    CHECK(message.size() <= kHandMessageBytesMax);
    const auto read = parse_hand_message(message);
    REQUIRE(read.has_value());
    CHECK(read->action == HandAction::kBlackout);
    levels.insert(levels.end(), read->levels.begin(), read->levels.end());
  }
  CHECK(levels == command.levels);
  command.levels.clear();
  CHECK(hand_parts(command).size() == 1);  // everything
}

std::string refusal_of(std::string_view text) {
  std::vector<HandLevel> levels;
  const Status read = parse_slot_assignment(text, levels);
  REQUIRE_FALSE(read.has_value());
  CHECK(levels.empty());
  return read.error().message;
}

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST_CASE("an assignment sets one slot, a range, a list, a universe, or a number of several bytes") {
  CHECK(levels_of("1.17=255") == std::vector<HandLevel>{{.universe = 1, .slots = {16}, .value = 255}});
  CHECK(levels_of("3.1-12=0").size() == 12);
  CHECK(levels_of("3.1-12=0").back() == HandLevel{.universe = 3, .slots = {11}, .value = 0});
  CHECK(levels_of("2.*=9").size() == 512);
  const auto list = levels_of("1.510=1,2,3");
  REQUIRE(list.size() == 3);
  CHECK(list[2] == HandLevel{.universe = 1, .slots = {511}, .value = 3});
  const auto fine = levels_of("1.17+19=30000");
  REQUIRE(fine.size() == 1);
  CHECK(fine[0] == HandLevel{.universe = 1, .count = 2, .slots = {16, 18}, .value = 30000});
  CHECK(levels_of("1.1-2=5,6")[1].value == 6);
}

TEST_CASE("a percentage is the nearest level") {
  CHECK(levels_of("1.1=50%")[0].value == 128);
  CHECK(levels_of("1.1=100%")[0].value == 255);
  CHECK(levels_of("1.1=0.1%")[0].value == 0);
  CHECK(levels_of("1.1+2=50%")[0].value == 32768);
}

TEST_CASE("a wrong assignment is refused with what was expected, and huge ranges are as well") {
  for (const char* text :
       {"", "1", "1.=5", "1.0=5", "1.513=5", "0.1=5", "64000.1=5", "1.12-1=5", "1.1-99999999999=0", "1.1-=0", "1.1+=0",
        "1.1+2+3+4+5=0", "1.-1=5", "1.17+17=5", "99999999999.1=0", " 1.1=5", "1.1 =5"}) {
    CAPTURE(text);
    const std::string message = refusal_of(std::string(text) + (contains(text, "=") ? "" : "=1"));
    CHECK(contains(message, "1.17"));
  }
  CHECK(contains(refusal_of("1.17"), "1.17=255"));
  for (const char* text : {"1.17=256", "1.17=-1", "1.17=1.5", "1.17=", "1.17=x", "1.17=nan", "1.17=101%", "1.17=-1%"}) {
    CAPTURE(text);
    CHECK(contains(refusal_of(text), "0 to 255"));
  }
  CHECK(contains(refusal_of("1.17+18=65536"), "0 to 65535"));
  CHECK(contains(refusal_of("1.511=1,2,3"), "512"));
  CHECK(contains(refusal_of("1.1-3=1,2"), "2 levels for 3 addresses"));
}

TEST_CASE("levels become short texts that read as the same levels") {
  std::vector<HandLevel> levels;
  for (const char* text : {"1.1-12=0", "1.13=1,2,3,3,3,3,4", "1.20+21=30000", "2.*=255", "2.7=5"}) {
    const auto more = levels_of(text);
    levels.insert(levels.end(), more.begin(), more.end());
  }
  const auto texts = assignments_of(levels);
  CHECK(texts == std::vector<std::string>{"1.1-12=0", "1.13=1,2", "1.15-18=3", "1.19=4", "1.20+21=30000", "2.1-512=255",
                                          "2.7=5"});
  std::vector<HandLevel> again;
  for (const std::string& text : texts) REQUIRE(parse_slot_assignment(text, again).has_value());
  CHECK(again == levels);
}

TEST_CASE("a message is read as it was written") {
  HandCommand command;
  command.over_ns = 3 * kNsPerS + 1;
  command.priority = 77;
  command.levels = levels_of("1.1-12=9");
  command.levels.push_back({.universe = 2, .count = 2, .slots = {5, 9}, .value = 4711, .jumps = true});
  for (const HandAction action : {HandAction::kSet, HandAction::kBlackout}) {
    command.action = action;
    const auto read = parse_hand_message(hand_message(command));
    REQUIRE_MESSAGE(read.has_value(), (read ? "" : read.error().message));
    CHECK(*read == command);
  }
  command.action = HandAction::kRelease;
  const auto read = parse_hand_message(hand_message(command));
  REQUIRE(read.has_value());
  CHECK(read->levels.size() == 14);  // without values, the pair as two slots
  for (const double beats : {0.0, 128.25}) {
    const HandCommand tempo{.action = HandAction::kTempo, .levels = {}, .beats_a_minute = beats};
    CHECK(parse_hand_message(hand_message(tempo)).value() == tempo);
  }
}

TEST_CASE("a damaged message is refused with its line") {
  const auto refused = [](std::string_view text) {
    const auto read = parse_hand_message(text);
    REQUIRE_FALSE(read.has_value());
    return read.error();
  };
  CHECK(contains(refused("").message, "line 1"));
  CHECK(contains(refused("GET / HTTP/1.1\n").message, "line 1"));
  CHECK(refused("footlight-hand 2\nset\n1.1=0\n").code == ErrorCode::kUnsupported);
  CHECK(contains(refused("footlight-hand 1\ndance\n").message, "line 2"));
  CHECK(contains(refused("footlight-hand 1\nset\npriority 201\n1.1=0\n").message, "line 3"));
  CHECK(contains(refused("footlight-hand 1\nset\nover -1\n").message, "line 3"));
  CHECK(contains(refused("footlight-hand 1\nset\nbeats 100\n1.1=0\n").message, "line 3"));
  CHECK(contains(refused("footlight-hand 1\ntempo\nbeats nan\n").message, "line 3"));
  CHECK(contains(refused("footlight-hand 1\nset\n1.1=0\n\n").message, "line 4"));
  CHECK(contains(refused("footlight-hand 1\nset\n1.1=0\n1.600=0\n").message, "line 4"));
  std::string flood = "footlight-hand 1\nset\n";
  for (int i = 0; i < 600; ++i) flood += "1.*=0\n";
  CHECK(contains(refused(flood).message, "levels in one command"));
}

constexpr const char* kScenes =
    "# My scenes\n"
    "\n"
    "# For the walk-in\n"
    "[[scene]]\n"
    "name = \"Warm\"\n"
    "levels = [\n"
    "  \"1.1-12=50%\",  # front\n"
    "  \"Mover 3:Tilt=30\",\n"
    "]\n"
    "\n"
    "# The last one\n"
    "[[scene]]\n"
    "name = \"Cold\"\n"
    "levels = [\"1.17=255\"]\n";

TEST_CASE("a scene that is stored or deleted changes only its own lines") {
  const TempFolder folder;
  const std::string path = folder.file("scenes.toml");
  std::ofstream(path) << kScenes;
  REQUIRE(store_scene(path, "New \"one\"", {"2.1=1,2,3"}).has_value());
  CHECK(text_of(path) ==
        std::string(kScenes) + "\n[[scene]]\nname = \"New \\\"one\\\"\"\nlevels = [\n  \"2.1=1,2,3\",\n]\n");
  REQUIRE(delete_scene(path, "New \"one\"").has_value());
  CHECK(text_of(path) == std::string(kScenes) + "\n");
  REQUIRE(delete_scene(path, "Warm").has_value());
  CHECK(text_of(path) ==
        "# My scenes\n\n# For the walk-in\n# The last one\n[[scene]]\nname = \"Cold\"\nlevels = [\"1.17=255\"]\n\n");
  REQUIRE(store_scene(path, "Cold", {"1.17=0"}).has_value());
  const auto file = load_scenes(path);
  REQUIRE(file.has_value());
  REQUIRE(file->scenes.size() == 1);
  CHECK(file->scenes[0].levels[0].text == "1.17=0");
  CHECK(contains(text_of(path), "# The last one"));
}

TEST_CASE("a scene is found by its name for OSC, but deleted by its exact name only") {
  const auto file = parse_scenes("[[scene]]\nname = \"Walk in\"\nlevels = [\"1.1=1\"]\n", "s.toml");
  REQUIRE(file.has_value());
  CHECK(file->find("Walk_in").has_value());
  CHECK(file->find("Walk").error().message.find("there is 'Walk in'") != std::string::npos);
  const auto kept = without_scene(*file, "Walk_in");
  REQUIRE_FALSE(kept.has_value());
  CHECK(kept.error().message.find("there is 'Walk in'") != std::string::npos);
  CHECK(without_scene(*file, "Walk in").has_value());
}

TEST_CASE("a scene file is begun with its folder, and a link to it stays a link") {
  const TempFolder folder;
  const std::string path = folder.file("deep/er/scenes.toml");
  REQUIRE(store_scene(path, "a", {"1.1=1"}).has_value());
  CHECK(load_scenes(path)->scenes.size() == 1);
  const std::string link = folder.file("link.toml");
  std::filesystem::create_symlink(path, link);
  REQUIRE(store_scene(link, "b", {"1.1=1"}).has_value());
  CHECK(std::filesystem::is_symlink(link));
  CHECK(load_scenes(path)->scenes.size() == 2);
}

TEST_CASE("a scene file behind a link is written where the link leads, and a link to itself is refused") {
  namespace fs = std::filesystem;
  const TempFolder folder;
  const std::string link = folder.file("link.toml");
  fs::create_symlink("second.toml", link);
  fs::create_symlink(folder.file("new/scenes.toml"), folder.file("second.toml"));
  REQUIRE(store_scene(link, "a", {"1.1=1"}).has_value());
  CHECK(fs::is_symlink(link));
  CHECK(fs::is_symlink(folder.file("second.toml")));
  CHECK(load_scenes(folder.file("new/scenes.toml"))->scenes.size() == 1);
  const std::string round = folder.file("round.toml");
  fs::create_symlink("round.toml", round);
  const Status refused = store_scene(round, "a", {"1.1=1"});
  REQUIRE_FALSE(refused.has_value());
  CHECK(contains(refused.error().message, round + ": a link that leads to itself"));
  CHECK(fs::is_symlink(round));
}

TEST_CASE("a scene file may be named without a folder") {
  const TempFolder folder;
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder.file(""));
  CHECK(store_scene("plain.toml", "a", {"1.1=1"}).has_value());
  CHECK(store_scene("plain.toml", "b", {"1.1=1"}).has_value());
  std::filesystem::current_path(before);
  CHECK(load_scenes(folder.file("plain.toml"))->scenes.size() == 2);
}

TEST_CASE("errors of a scene file name the file, the line and what was expected") {
  const auto refused = [](const std::string& text) {
    const auto file = parse_scenes(text, "s.toml");
    REQUIRE_FALSE(file.has_value());
    return file.error().message;
  };
  CHECK(contains(refused("[[scene]]\nname = \"a\"\nlevels = [\n \"1.1=0\",\n \"1.600=1\"]\n"), "s.toml:5:2: 1.600"));
  CHECK(contains(refused("[[scene]]\nname = \"a\"\nlevels = [\"Mover 3\"]\n"), "s.toml:3:11: Mover 3: expected"));
  CHECK(contains(refused("[[scene]]\nname = \"a\"\nlevels = [\"Mover 3:Tilt=x\"]\n"), "s.toml:3"));
  CHECK(contains(refused("[[scene]]\nname = \"a\"\nlevels = [5]\n"), "s.toml:3"));
  CHECK(contains(refused("[[scene]]\nname = \"a\"\nlevels = []\n"), "s.toml:3"));
  CHECK(contains(refused("[[scene]]\nname = \"\"\nlevels = [\"1.1=0\"]\n"), "s.toml:2"));
  CHECK(contains(refused("[[scene]]\nlevels = [\"1.1=0\"]\n"), "name"));
  CHECK(contains(refused("[[scene]]\nname = \"a\"\nlevles = [\"1.1=0\"]\n"), "levels"));
  CHECK(contains(
      refused("[[scene]]\nname = \"a\"\nlevels = [\"1.1=0\"]\n[[scene]]\nname = \"a\"\nlevels = [\"1.1=0\"]\n"),
      "s.toml:4:1: there is a scene 'a' already, at line 1"));
  const auto found = parse_scenes(kScenes, "s.toml")->find("warm");
  REQUIRE_FALSE(found.has_value());
  CHECK(contains(found.error().message, "'Warm', 'Cold'"));
}

TEST_CASE("a scene file that cannot be written, is damaged or is written in another form stays as it is") {
  const TempFolder folder;
  const std::string path = folder.file("scenes.toml");
  std::ofstream(path) << "[[scene]\n";
  CHECK_FALSE(store_scene(path, "a", {"1.1=1"}).has_value());
  CHECK(text_of(path) == "[[scene]\n");
  std::ofstream(path) << "scene = [{name = \"a\", levels = [\"1.1=0\"]}]\n";
  const Status inline_one = store_scene(path, "a", {"1.1=1"});
  REQUIRE_FALSE(inline_one.has_value());
  CHECK(contains(inline_one.error().message, "in an editor"));
  CHECK_FALSE(store_scene(path, "line\nbreak", {"1.1=1"}).has_value());
  CHECK_FALSE(store_scene(folder.file("scenes.toml/x.toml"), "a", {"1.1=1"}).has_value());
  CHECK_FALSE(store_scene(folder.file(""), "a", {"1.1=1"}).has_value());
  CHECK_FALSE(delete_scene(folder.file("none.toml"), "a").has_value());
  CHECK_FALSE(std::filesystem::exists(folder.file("none.toml")));
}

TEST_CASE("programs that store scenes at the same time lose none") {
  const TempFolder folder;
  const std::string path = folder.file("scenes.toml");
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] {
      for (int k = 0; k < 5; ++k) (void)store_scene(path, fmt::format("{}-{}", i, k), {"1.1=1"});
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(load_scenes(path)->scenes.size() == 20);
}

}  // namespace
}  // namespace footlight::tools
