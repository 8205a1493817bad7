// The files of a folder as the dialog of the window lists them.
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <sys/stat.h>
#include <unistd.h>

#include "tests/support/temp_folder.h"
#include "tools/footlight/preview/ui/file_list.h"
#include "tools/footlight/preview/ui/folder_reader.h"
#include "tools/footlight/preview/ui/name_order.h"

namespace footlight::tools {
namespace {

using testing::TempFolder;
using Names = std::vector<std::string>;

Names shown(const FileList& list) {
  Names names;
  for (std::size_t row = 0; row < list.shown(); ++row) names.push_back(list.at(row).name);
  return names;
}

FileEntry file(const std::string& name, std::uint64_t bytes = 1, std::int64_t modified_s = 1) {
  return {name, kind_of_name(name), bytes, modified_s};
}
FileEntry folder(const std::string& name) { return {name, FileKind::kFolder, 0, 1}; }

TEST_CASE("folders come first and numbers in names count as numbers, whatever the parts in which they came") {
  FileList list;
  list.add({file("show 10.dmxlog", 5), file("Show 9.dmxlog", 7, 3), folder("b")});
  list.add({file("a.toml", 900, 2), folder("A"), file("notes.txt"), file(".old.toml")});
  CHECK(shown(list) == Names{"A", "b", "a.toml", "Show 9.dmxlog", "show 10.dmxlog"});
  list.sort(FileColumn::kBytes, true);
  CHECK(shown(list) == Names{"A", "b", "a.toml", "Show 9.dmxlog", "show 10.dmxlog"});
  list.sort(FileColumn::kModified, false);
  CHECK(shown(list) == Names{"A", "b", "show 10.dmxlog", "a.toml", "Show 9.dmxlog"});
  list.sort(FileColumn::kName, true);
  CHECK(shown(list) == Names{"b", "A", "show 10.dmxlog", "Show 9.dmxlog", "a.toml"});
  CHECK(compare_names("a", "a") == 0);
  CHECK(compare_names("a01", "a1") != 0);
  CHECK(compare_names("x2", "x10") < 0);
  CHECK(compare_names("x", "x1") < 0);
  const std::pair<const char*, const char*> pairs[] = {{"x2", "x10"}, {"X", "y"}, {"x", "x1"}, {"a9b", "a10a"}};
  for (const auto& [a, b] : pairs) {
    CHECK(order_key(a) < order_key(b));
    CHECK(compare_names(a, b) < 0);
  }
}

TEST_CASE("a filter, words and hidden files decide what is listed, and a mark stays on its entry") {
  FileList list;
  list.add({file("hall.toml"), file("hall.mvr"), file("spot.gdtf"), file("hall tour.dmxlog"), file("notes.txt"),
            file(".hall.toml"), folder("hall"), folder(".git")});
  CHECK(list.shown() == 5);
  list.mark_name("hall.toml");
  list.add({file("a.toml"), file("b.toml")});
  CHECK(list.at(static_cast<std::size_t>(list.marked())).name == "hall.toml");
  list.set_filter(FileFilter::kRigs);
  CHECK(shown(list) == Names{"hall", "a.toml", "b.toml", "hall.mvr", "hall.toml"});
  CHECK(list.marked() == 4);
  list.set_filter(FileFilter::kLogs);
  CHECK(shown(list) == Names{"hall", "hall tour.dmxlog"});
  CHECK(list.marked() == -1);
  list.set_filter(FileFilter::kAll);
  list.set_words("TOUR hal");
  CHECK(shown(list) == Names{"hall tour.dmxlog"});
  CHECK(list.marked() == 0);
  list.set_words("");
  list.set_hidden(true);
  CHECK(list.shown() == 10);
  list.set_words("no such");
  CHECK(list.marked() == -1);
  list.mark_next(1);
  CHECK(list.marked() == -1);
}

TEST_CASE("a name that is to be marked is marked when it comes, and marks stay within the list") {
  FileList list;
  list.mark_name("b");
  list.add({folder("c"), folder("a")});
  CHECK(list.marked() == -1);
  list.add({folder("b")});
  CHECK(list.marked() == 1);
  list.mark_next(10);
  CHECK(list.marked() == 2);
  list.mark_next(-10);
  CHECK(list.marked() == 0);
  list.mark(7);
  CHECK(list.marked() == -1);
  list.mark_next(-1);
  CHECK(list.marked() == 2);
}

double ms_since(std::chrono::steady_clock::time_point begun) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count();
}

// With FOOTLIGHT_PRINT_COSTS=1 it prints what a part and a search cost.
TEST_CASE("a list of 100,000 files has all of them, in order, and is narrowed by words") {
  FileList list;
  double most_ms = 0;
  for (int part = 0; part < 25; ++part) {
    std::vector<FileEntry> entries;
    for (int i = 0; i < 4000; ++i) {
      entries.push_back(file("log " + std::to_string((part * 4000LL + i) * 7919 % 100'000) + ".dmxlog"));
    }
    const auto begun = std::chrono::steady_clock::now();
    list.add(std::move(entries));
    most_ms = std::max(most_ms, ms_since(begun));
  }
  REQUIRE(list.shown() == 100'000);
  for (const std::size_t row : std::vector<std::size_t>{0, 1, 9, 10, 54321, 99'999}) {
    CHECK(list.at(row).name == "log " + std::to_string(row) + ".dmxlog");
  }
  const auto begun = std::chrono::steady_clock::now();
  list.set_words("99999");
  const double search_ms = ms_since(begun);
  CHECK(shown(list) == Names{"log 99999.dmxlog"});
  if (std::getenv("FOOTLIGHT_PRINT_COSTS") != nullptr) {  // NOLINT(concurrency-mt-unsafe): one thread
    fmt::print("a part of 4,000 names: {:.1f} ms at most; a search {:.1f} ms\n", most_ms, search_ms);
  }
}

TEST_CASE("paths that are typed, folders above and sizes") {
  CHECK(parent_of("/media/usb/") == "/media");
  CHECK(parent_of("/media") == "/");
  CHECK(parent_of("/") == "/");
  CHECK(path_from("/a/b", "../c", "/home/x") == "/a/c");
  CHECK(path_from("/a/b", "/media/usb/", "/home/x") == "/media/usb");
  CHECK(path_from("/a/b", "~/shows", "/home/x") == "/home/x/shows");
  CHECK(path_from("/a/b", "~", "/home/x") == "/home/x");
  CHECK(path_from("/a", "./~/b", "/home/x") == "/a/~/b");
  CHECK(file_size_text(999) == "999 B");
  CHECK(file_size_text(1234) == "1.2 kB");
  CHECK(file_size_text(999'999) == "1.0 MB");
  CHECK(file_size_text(5'600'000'000) == "5.6 GB");
}

TEST_CASE("places are home, the rig's folder, those of recent rigs and mounted media, each once") {
  const std::string mounts =
      "/dev/sda1 / ext4 rw 0 0\n/dev/sdb1 /media/jo/MY\\040SHOWS vfat rw 0 0\n"
      "/dev/sdc1 /run/media/jo/stick ext4 rw 0 0\ntmpfs /run tmpfs rw 0 0\n/dev/sdd1 /mediathek ext4 rw 0 0\nbad\n";
  CHECK(mounted_media(mounts) == Names{"/media/jo/MY SHOWS", "/run/media/jo/stick"});
  const auto places =
      file_places("/home/jo", "/shows/hall.toml", {"/shows/b.toml", "/tour/c.mvr", "/home/jo/d.toml"}, mounts);
  Names paths;
  for (const FilePlace& one : places) paths.push_back(one.path);
  CHECK(paths == Names{"/home/jo", "/shows", "/tour", "/media/jo/MY SHOWS", "/run/media/jo/stick", "/"});
  CHECK(places[2].name == "tour");
}

// All of a folder.
std::vector<FileEntry> read_all(FolderReader& reader) {
  std::vector<FileEntry> all;
  while (!reader.ended()) {
    for (FileEntry& one : reader.take()) all.push_back(std::move(one));
    std::this_thread::yield();
  }
  return all;
}

TEST_CASE("a folder is read in parts, with sizes, folders and links, and without pipes") {
  const TempFolder temp;
  for (int i = 0; i < 6000; ++i) std::ofstream(temp.file(std::to_string(i) + ".toml")) << "12345";
  std::filesystem::create_directory(temp.file("a folder"));
  std::filesystem::create_symlink("a folder", temp.file("link"));
  std::filesystem::create_symlink("nothing", temp.file("broken"));
  REQUIRE(mkfifo(temp.file("pipe").c_str(), 0600) == 0);
  FolderReader reader(temp.path().string());
  std::size_t most = 0;
  std::vector<FileEntry> all;
  while (!reader.ended()) {
    std::vector<FileEntry> part = reader.take();
    most = std::max(most, part.size());
    all.insert(all.end(), part.begin(), part.end());
    std::this_thread::yield();
  }
  CHECK(most <= FolderReader::kPartMax);
  CHECK(all.size() == 6002);
  CHECK(!reader.error());
  int folders = 0;
  for (const FileEntry& one : all) {
    folders += one.kind == FileKind::kFolder ? 1 : 0;
    if (one.kind == FileKind::kRig) CHECK(one.bytes == 5);
    CHECK(one.modified_s > 1'600'000'000);
  }
  CHECK(folders == 2);
}

TEST_CASE("a folder that is missing, no folder or may not be read is an error with its name") {
  const TempFolder temp;
  std::ofstream(temp.file("a.toml")) << "x";
  std::filesystem::create_directory(temp.file("closed"));
  std::filesystem::permissions(temp.file("closed"), std::filesystem::perms::none);
  for (const char* name : {"missing", "a.toml", "closed"}) {
    if (name == std::string("closed") && geteuid() == 0) continue;  // root may read everything
    FolderReader reader(temp.file(name));
    CHECK(read_all(reader).empty());
    REQUIRE(reader.error());
    CHECK(reader.error()->message.starts_with(temp.file(name) + ": "));
  }
  FolderReader left(temp.path().string());  // nobody takes what it reads
}

}  // namespace
}  // namespace footlight::tools
