// Rigs that are edited and saved, by programs that are killed, too.
#include "tools/footlight/edit/rig_file.h"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include <sys/wait.h>
#include <unistd.h>

#include "tests/tools/footlight/edit_rigs.h"
#include "tools/footlight/edit/autosave.h"

namespace footlight::testing {
namespace {

namespace fs = std::filesystem;
using tools::RigFile;
using tools::SaveReport;

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

std::string read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string refused(RigFile& file) {
  const auto report = file.save();
  REQUIRE(!report);
  return report.error().message;
}

TEST_CASE("a rig of another program is saved beside it, with its definitions, and reads back as edited") {
  const TempFolder folder;
  const std::string path = write_show(folder);
  const std::string before = read(path);
  RigFile file = opened_file(path);
  CHECK(file.target() == folder.file("show.toml"));
  REQUIRE(file.rig().fixtures.size() == 4);
  lift(file, {0, 2});
  const SaveReport report = saved(file);
  CHECK(report.path == folder.file("show.toml"));
  CHECK(report.old.empty());
  CHECK(read(path) == before);
  CHECK(fs::exists(folder.file("show_files/B.gdtf")));
  CHECK(read(folder.file("show_files/leg.3ds")) == "mesh");
  const RigFile again = opened_file(folder.file("show.toml"));
  REQUIRE(again.rig().fixtures.size() == 4);
  CHECK(fixtures::position_of(again.rig().fixtures[0]) == glm::dvec3(1, 0, 5.5));
  CHECK(fixtures::position_of(again.rig().fixtures[1]) == glm::dvec3(2, 0, 5));
  CHECK(again.rig().types.front().name == "Bar");

  lift(file, {0});
  CHECK(saved(file).old.empty());  // its own file from before is not kept
  CHECK(fixtures::position_of(opened_file(folder.file("show.toml")).rig().fixtures[0]).z == 6);
  CHECK(!fs::exists(folder.file("show.toml~")));
}

TEST_CASE("a rig file is saved to itself, and the file from before is kept once") {
  const TempFolder folder;
  const std::string path = folder.write("club.toml", kCommentedRig);
  fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
  for (int session = 0; session < 2; ++session) {
    RigFile file = opened_file(path);
    CHECK(file.target() == path);
    lift(file, {0});
    CHECK(saved(file).old == (session == 0 ? path + "~" : ""));
    lift(file, {1});
    CHECK(saved(file).old.empty());
  }
  CHECK(read(path + "~") == kCommentedRig);
  CHECK(fixtures::position_of(opened_file(path).rig().fixtures[1]) == glm::dvec3(1, 0, 6));
  CHECK((fs::status(path).permissions() & fs::perms::others_read) == fs::perms::none);
}

TEST_CASE("a file that others made or changed is not replaced") {
  const TempFolder folder;
  const std::string path = folder.write("club.toml", kCommentedRig);
  RigFile file = opened_file(path);
  lift(file, {0});
  const std::string theirs = std::string(kCommentedRig) + "# theirs\n";
  folder.write("club.toml", theirs);
  CHECK(refused(file) == path + ": was changed by another program since it was read; move it away, then save again");
  CHECK(read(path) == theirs);
  fs::rename(path, folder.file("theirs.toml"));
  saved(file);
  CHECK(fixtures::position_of(opened_file(path).rig().fixtures[0]).z == 5.5);

  RigFile show = opened_file(write_show(folder));
  folder.write("show.toml", kCommentedRig);
  CHECK(refused(show) ==
        folder.file("show.toml") + ": exists already; open it instead, or move it away, then save again");
  CHECK(read(folder.file("show.toml")) == kCommentedRig);
}

TEST_CASE("a file of the folder of definitions that is another one is not replaced") {
  const TempFolder folder;
  RigFile file = opened_file(write_show(folder));
  folder.write("show_files/leg.3ds", "another mesh");
  CHECK(refused(file) ==
        folder.file("show_files/leg.3ds") + ": is another file than the one of the rig; move it away, then try again");
  CHECK(read(folder.file("show_files/leg.3ds")) == "another mesh");
  CHECK(!fs::exists(folder.file("show.toml")));
  folder.write("show_files/leg.3ds", "mesh");
  saved(file);
}

TEST_CASE("links, definitions of one fixture and folders are never written") {
  const TempFolder folder;
  const std::string path = folder.write("club.toml", kCommentedRig);
  fs::create_symlink(path, folder.file("link.toml"));
  RigFile link = opened_file(folder.file("link.toml"));
  lift(link, {0});
  CHECK(contains(refused(link), "link.toml: is a link; open the file that it names"));
  CHECK(read(path) == kCommentedRig);

  const std::string fixture =
      folder.write("head.toml", read(std::string(FOOTLIGHT_SOURCE_DIR) + "/fixtures/builtin/par.toml"));
  RigFile lone = opened_file(fixture);
  CHECK(lone.target() == folder.file("head_rig.toml"));
  const std::string before = read(fixture);
  saved(lone);
  CHECK(read(fixture) == before);
  CHECK(opened_file(folder.file("head_rig.toml")).rig().fixtures.size() == 1);
}

TEST_CASE("fixtures that share slots are saved so that the file can be read again") {
  const TempFolder folder;
  RigFile file = opened_file(folder.write("club.toml", kCommentedRig));
  auto edit = fixtures::patch_fixtures(file.rig(), std::vector{3}, {1, 3});
  REQUIRE(edit);
  edit->apply(file.rig().fixtures);
  CHECK(saved(file).shared == 3);  // it reaches into two others
  CHECK(!file.rig().fixtures[3].shares_address);  // a later edit may end the conflict
  const RigFile again = opened_file(folder.file("club.toml"));
  CHECK(fixtures::text_of_patch(again.rig().fixtures[3]) == "1.3");
  CHECK(again.rig().fixtures[3].shares_address);
}

// Runs `work` in a process of its own, which is killed after this time.
template <class Work>
void killed_after(std::chrono::microseconds time, Work work) {
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    work();
    _exit(0);
  }
  ::usleep(static_cast<useconds_t>(time.count()));
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
}

TEST_CASE("a program that is killed while it saves leaves a whole file from before or after") {
  const TempFolder folder;
  const std::string path = write_show(folder);
  {
    RigFile file = opened_file(path);
    saved(file);
  }
  const std::string target = folder.file("show.toml");
  std::mt19937 random(5);
  double highest = 5;
  for (int round = 0; round < 12; ++round) {
    killed_after(std::chrono::microseconds(100'000 + random() % 200'000), [&] {
      RigFile file = opened_file(target);
      for (;;) {
        lift(file, {0, 1, 2, 3});
        if (!file.save()) _exit(1);
      }
    });
    const RigFile again = opened_file(target);
    REQUIRE(again.rig().fixtures.size() == 4);
    const double height = fixtures::position_of(again.rig().fixtures[0]).z;
    CHECK(height >= highest);
    for (const auto& fixture : again.rig().fixtures) CHECK(fixtures::position_of(fixture).z == height);
    highest = height;
    CHECK(read(folder.file("show_files/leg.3ds")) == "mesh");
  }
  CHECK(highest > 5);
}

TEST_CASE("edits of a program that was killed are found by the next one, and lead to the same file") {
  const TempFolder folder;
  const std::string path = write_show(folder);
  const std::string state = folder.file("state");
  int ready[2] = {-1, -1};
  REQUIRE(pipe(ready) == 0);
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    RigFile file = opened_file(path);
    tools::Autosave copies(file, state);
    lift(file, {1});
    const bool written = copies.write_now(1).has_value();
    if (write(ready[1], written ? "+" : "-", 1) != 1) _exit(1);
    for (;;) pause();
  }
  char word = 0;
  REQUIRE(::read(ready[0], &word, 1) == 1);
  CHECK(word == '+');
  CHECK(!tools::find_lost_edits(state, path));  // the program runs
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  close(ready[0]);
  close(ready[1]);

  CHECK(!tools::find_lost_edits(state, folder.file("other.mvr")));
  auto lost = tools::find_lost_edits(state, path);
  REQUIRE(lost);
  CHECK(lost->written_s > 1'500'000'000);
  auto recovered = tools::open_lost_edits(*lost);
  REQUIRE_MESSAGE(recovered, recovered.error().message);
  CHECK(fixtures::position_of(recovered->rig().fixtures[1]) == glm::dvec3(2, 0, 5.5));
  CHECK(recovered->target() == folder.file("show.toml"));
  {
    tools::Autosave copies(*recovered, state, std::move(lost->claim));
    lift(*recovered, {2});
    CHECK(copies.write_now(1).has_value());  // to the same folder
    saved(*recovered);
    copies.forget();
    lift(*recovered, {3});
    saved(*recovered);  // its definitions can still be read
  }
  CHECK(!tools::find_lost_edits(state, path));
  const RigFile again = opened_file(folder.file("show.toml"));
  for (const std::size_t i : {1u, 2u, 3u}) CHECK(fixtures::position_of(again.rig().fixtures[i]).z == 5.5);
  CHECK(fs::is_empty(state + "/rigs"));
}

}  // namespace
}  // namespace footlight::testing
