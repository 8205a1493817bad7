// footlight fixtures find: searches the definitions on this machine by name.
#include <algorithm>
#include <memory>

#include <nlohmann/json.hpp>

#include "fixtures/files/library.h"
#include "tools/footlight/commands/fixtures_command.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

struct Options {
  std::vector<std::string> words;
  std::vector<std::string> folders;
  int count = 20;
  bool json = false;
};

Result<int> find(const Options& options) {
  std::string words;
  for (const std::string& word : options.words) words += word + " ";
  if (words.find_first_not_of(' ') == std::string::npos) {
    return fail(ErrorCode::kBadInput,
                "fixtures find: expected words of a manufacturer's or model's name, for example 'robe pointe'");
  }
  std::vector<std::string> folders = options.folders;
  for (std::string& folder : fixtures::library_folders()) folders.push_back(std::move(folder));
  fixtures::Library library = fixtures::Library::open(folders);
  library.add_builtin_types();
  for (const std::string& line : library.notes()) fmt::print(stderr, "footlight: {}\n", printable_utf8(line));
  const auto hits = library.search(words, static_cast<std::size_t>(options.count));
  for (const fixtures::LibraryHit& hit : hits) {
    if (options.json) {
      const nlohmann::json line = {{"file", hit.entry.path},
                                   {"format", hit.entry.format},
                                   {"manufacturer", hit.entry.manufacturer},
                                   {"model", hit.entry.model},
                                   {"score", hit.score}};
      fmt::print("{}\n", line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    } else {
      fmt::print("{}\n", printable_line(fmt::format("{:<5}  {:<24} {:<32} {}", hit.entry.format, hit.entry.manufacturer,
                                                    hit.entry.model, hit.entry.path)));
    }
  }
  if (!hits.empty()) return kExitOk;
  std::string list;
  for (const std::string& folder : folders) list += (list.empty() ? "" : ", ") + folder;
  return fail(ErrorCode::kNotFound,
              "no definition matches '{}' among {}; searched in {}. QLC+'s are in Debian's package qlcplus-data; "
              "--library names another folder",
              words.substr(0, words.size() - 1), library.entries().size(), list);
}

}  // namespace

void add_fixtures_find(Arguments& arguments) {
  Arguments find_arguments = arguments.subcommand(
      "find", "Search definitions on this machine by name: GDTF, Open Fixture Library, QLC+ and TOML",
      "  footlight fixtures find robe pointe\n"
      "  footlight fixtures find mac aura --library ~/gdtf --json\n"
      "Searches $FOOTLIGHT_FIXTURES, footlight/fixtures below the XDG data folders, QLC+'s definitions, and the "
      "built-in\n"
      "types. Exit code 3 if nothing matches.\n");
  auto options = std::make_shared<Options>();
  find_arguments.words("WORD", options->words, "words of the name; spelling errors are tolerated");
  find_arguments.list("--library", options->folders, "FOLDER", "search here first; may be given several times");
  find_arguments.option("--count", options->count, 1, 1000, "the most results to print");
  find_arguments.flag("--json", options->json, "one JSON object a line for each definition");
  find_arguments.job([options] { return find(*options); });
}

}  // namespace footlight::tools
