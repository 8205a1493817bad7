// When automatic copies are written, with an injected time.
#include "tools/footlight/edit/autosave.h"

#include <filesystem>

#include "fixtures/edit/add_fixtures.h"
#include "fixtures/files/definition_list.h"
#include "tests/support/definition_files.h"
#include "tests/tools/footlight/edit_rigs.h"

namespace footlight::testing {
namespace {

namespace fs = std::filesystem;
using tools::Autosave;
using tools::RigFile;

// Calls step() until it has begun and finished what is due, at a time that stands still.
void settle(Autosave& copies, TimeNs now_ns, std::uint64_t revision) {
  CHECK(!copies.step(now_ns, revision, true));
  CHECK(copies.write_now(revision).has_value());
}

std::size_t copy_count(const std::string& state) {
  std::size_t count = 0;
  if (!fs::exists(state)) return 0;
  for (const auto& entry : fs::recursive_directory_iterator(state)) count += entry.path().filename() == "rig.toml";
  return count;
}

TEST_CASE("a change is copied three seconds later, also if changes do not end") {
  const TempFolder folder;
  const std::string state = folder.file("state");
  RigFile file = opened_file(folder.write("club.toml", kCommentedRig));
  Autosave copies(file, state);
  constexpr TimeNs kStep = kNsPerS / 10;
  TimeNs now_ns = kNsPerS;
  for (; now_ns < 60 * kNsPerS; now_ns += kStep) CHECK(!copies.step(now_ns, 0, false));
  CHECK(!fs::exists(state));
  std::uint64_t revision = 0;
  const TimeNs begun_ns = now_ns;
  for (; now_ns - begun_ns < Autosave::kAfterNs; now_ns += kStep) {
    lift(file, {0});
    CHECK(!copies.step(now_ns, ++revision, true));
    CHECK(copy_count(state) == 0);
  }
  CHECK(!copies.step(now_ns, revision, true));  // begins
  CHECK(fs::exists(state));
  settle(copies, now_ns, revision);
  CHECK(copy_count(state) == 1);
}

TEST_CASE("undone to what is saved, or saved, there is no copy, and none is left at the end") {
  const TempFolder folder;
  const std::string state = folder.file("state");
  RigFile file = opened_file(folder.write("club.toml", kCommentedRig));
  {
    Autosave copies(file, state);
    CHECK(copies.write_now(1).has_value());
    CHECK(copy_count(state) == 1);
    CHECK(!copies.step(0, 0, false));
    CHECK(copy_count(state) == 0);
    CHECK(copies.write_now(2).has_value());
    saved(file);
    copies.forget();
    CHECK(copy_count(state) == 0);
  }
  CHECK(fs::is_empty(state + "/rigs"));
  {
    Autosave copies(file, state);
    CHECK(copies.write_now(3).has_value());
  }
  CHECK(copy_count(state) == 1);  // as after a signal
  const auto lost = tools::find_lost_edits(state, file.path());
  REQUIRE(lost);
  CHECK(lost->target == file.target());
  CHECK(lost->known == file.known());
}

TEST_CASE("a copy has the types that were added since the copy before, and not those that were undone") {
  const TempFolder folder;
  const std::string state = folder.file("state");
  const std::string path = folder.write("club.toml", kCommentedRig);
  const auto add = [&](RigFile& file, const std::string& definition) {
    fixtures::NewFixtures row;
    row.type = std::make_shared<const fixtures::FixtureType>(*fixtures::open_definition(definition));
    auto edit = fixtures::add_fixtures(file.rig(), row);
    REQUIRE(edit);
    edit->apply(file.rig());
    fixtures::follow_types(file.imported());
    return std::move(*edit);
  };
  const auto copied = [&] {
    auto lost = tools::find_lost_edits(state, path);
    REQUIRE(lost);
    auto file = tools::open_lost_edits(*lost);
    REQUIRE_MESSAGE(file, file.error().message);
    return fixtures::type_of(file->rig(), file->rig().fixtures.back()).name;
  };
  const std::string one = folder.write("a/head.qxf", qxf_head("Robe", "One", {{"m", 4}}));
  const std::string two = folder.write("b/head.qxf", qxf_head("Robe", "Two", {{"m", 3}}));
  RigFile file = opened_file(path);
  {
    Autosave copies(file, state);
    CHECK(copies.write_now(1).has_value());
    const fixtures::RigEdit edit = add(file, one);
    CHECK(copies.write_now(2).has_value());
    edit.undo(file.rig());
    fixtures::follow_types(file.imported());
    add(file, two);  // another file of the same name
    CHECK(copies.write_now(3).has_value());
  }
  CHECK(copied() == "Two");
}

TEST_CASE("two windows with one rig have a copy each, and a lost one is not overwritten") {
  const TempFolder folder;
  const std::string state = folder.file("state");
  RigFile file = opened_file(folder.write("club.toml", kCommentedRig));
  RigFile other = opened_file(file.path());
  {
    Autosave lost(file, state);
    lift(file, {0});
    CHECK(lost.write_now(1).has_value());
  }
  Autosave a(other, state);
  Autosave b(other, state);
  CHECK(a.write_now(1).has_value());
  CHECK(b.write_now(1).has_value());
  CHECK(copy_count(state) == 3);
  const auto found = tools::find_lost_edits(state, file.path());
  REQUIRE(found);
  const auto recovered = tools::open_lost_edits(*found);
  REQUIRE(recovered);
  CHECK(fixtures::position_of(recovered->rig().fixtures[0]).z == 5.5);
}

TEST_CASE("lost edits of a rig that is in no file are found, and discarded only while they are the same copy") {
  const TempFolder folder;
  const std::string state = folder.file("state");
  {
    RigFile demo =
        RigFile::made(opened_file(folder.write("club.toml", kCommentedRig)).imported(), folder.file("demo.toml"));
    Autosave copies(demo, state);
    lift(demo, {0});
    CHECK(copies.write_now(1).has_value());
  }
  auto lost = tools::find_lost_edits(state, "");
  REQUIRE(lost);
  CHECK(lost->path.empty());
  CHECK(!lost->older);
  const auto recovered = tools::open_lost_edits(*lost);
  REQUIRE(recovered);
  CHECK(fixtures::position_of(recovered->rig().fixtures[0]).z == 5.5);
  lost->claim.release();
  tools::LostEdits before{*tools::FolderClaim::take(folder.file("other")), lost->written_s - 1, {}, {}, {}, false};
  before.claim = *tools::FolderClaim::take(lost->claim.folder());
  before.claim.release();
  tools::discard_lost_edits(before);
  CHECK(copy_count(state) == 1);
  tools::discard_lost_edits(*lost);
  CHECK(copy_count(state) == 0);
}

TEST_CASE("a copy is older if the file was saved after it") {
  const TempFolder folder;
  const std::string state = folder.file("state");
  RigFile file = opened_file(folder.write("club.toml", kCommentedRig));
  {
    Autosave copies(file, state);
    lift(file, {0});
    CHECK(copies.write_now(1).has_value());
  }
  CHECK(!tools::find_lost_edits(state, file.path())->older);
  saved(file);
  CHECK(tools::find_lost_edits(state, file.path())->older);
}

TEST_CASE("a copy of an imported rig is not older than a rig file that was there before, which is another's") {
  const TempFolder folder;
  const std::string state = folder.file("state");
  const std::string head = folder.write("head.qxf", qxf_head("Robe", "One", {{"m", 4}}));
  folder.write("head.toml", kCommentedRig);
  RigFile file = opened_file(head);
  REQUIRE(file.target() == folder.file("head.toml"));
  {
    Autosave copies(file, state);
    lift(file, {0});
    CHECK(!file.save());  // refused: it was not opened here
    CHECK(copies.write_now(1).has_value());
  }
  CHECK(!tools::find_lost_edits(state, file.path())->older);
  CHECK(tools::find_lost_edits(state, file.path())->others);
}

TEST_CASE("a copy that cannot be written is told once, and tried again") {
  const TempFolder folder;
  RigFile file = opened_file(folder.write("club.toml", kCommentedRig));
  const std::string state = folder.write("state", "a file, no folder");
  Autosave copies(file, state);
  int told = 0;
  TimeNs now_ns = 0;
  for (int i = 0; i < 200; ++i) told += copies.step(now_ns += kNsPerS / 10, 1, true).has_value() ? 1 : 0;
  CHECK(told == 1);
  fs::remove(state);
  for (int i = 0; i < 50; ++i) told += copies.step(now_ns += kNsPerS / 10, 1, true).has_value() ? 1 : 0;
  CHECK(copies.write_now(1).has_value());
  CHECK(copy_count(state) == 1);
  CHECK(told == 1);
}

TEST_CASE("without a folder for state nothing is written") {
  const TempFolder folder;
  RigFile file = opened_file(folder.write("club.toml", kCommentedRig));
  Autosave copies(file, "");
  CHECK(!copies.step(0, 1, true));
  CHECK(!copies.step(100 * kNsPerS, 1, true));
  CHECK(copies.write_now(1).has_value());
  CHECK(!tools::find_lost_edits("", file.path()));
}

}  // namespace
}  // namespace footlight::testing
