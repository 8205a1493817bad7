// footlight fixtures list: the installed definitions with their modes.
#include <algorithm>
#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "fixtures/files/definition_list.h"
#include "sim/core/counted.h"
#include "tools/footlight/commands/fixtures_command.h"
#include "tools/footlight/monitor/terminal.h"
#include "tools/footlight/progress.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

struct Options {
  std::vector<std::string> words;
  std::vector<std::string> folders;
  std::string rig;
  bool json = false;
};

std::string text_of(const fixtures::Definition& one) {
  std::string line = fmt::format("{:<5}  {:<24} {:<32} ", one.file.format, one.file.manufacturer, one.file.model);
  if (!one.error.empty()) return line + "cannot be read: " + one.error;
  line += fmt::format("{:<17} ", one.kind);
  std::string modes;
  for (const auto& mode : one.modes)
    modes += fmt::format("{}{} ({})", modes.empty() ? "" : ", ", mode.name, mode.slots);
  return fmt::format("{}{}  {}", line, modes, one.file.path);
}

std::string json_of(const fixtures::Definition& one) {
  nlohmann::json line = {
      {"file", one.file.path},           {"format", one.file.format}, {"manufacturer", one.file.manufacturer},
      {"model", one.file.model},         {"kind", one.kind},          {"gobos", one.gobos},
      {"modes", nlohmann::json::array()}};
  for (const auto& mode : one.modes) {
    line["modes"].push_back({{"name", mode.name}, {"slots", mode.slots}, {"channels", mode.channels}});
  }
  if (!one.error.empty()) line["error"] = one.error;
  return line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Result<int> list(const Options& options) {
  catch_end_signals();
  Progress progress("files");
  const auto folders = fixtures::definition_folders(options.folders, options.rig);
  std::vector<fixtures::Definition> read;
  const auto notes = fixtures::read_definitions(
      folders, [&](fixtures::Definition one) { read.push_back(std::move(one)); }, progress.go_on());
  progress.clear();
  const std::size_t broken = static_cast<std::size_t>(
      std::count_if(read.begin(), read.end(), [](const auto& one) { return !one.error.empty(); }));
  fixtures::DefinitionList definitions;
  definitions.add(std::move(read));
  for (const std::string& line : notes) fmt::print(stderr, "footlight: {}\n", printable_utf8(line));
  std::string words;
  for (const std::string& word : options.words) words += (words.empty() ? "" : " ") + word;
  const std::vector<int> found = definitions.search(words);
  for (const int index : found) {
    const fixtures::Definition& one = definitions.at(index);
    fmt::print("{}\n", options.json ? json_of(one) : printable_line(text_of(one)));
  }
  FL_TRY(flush_output());
  if (end_signal_came()) fmt::print(stderr, "footlight: stopped before all files were read\n");
  fmt::print(stderr, "footlight: {} of {}{}\n", found.size(), counted(definitions.size(), "definition"),
             broken > 0 ? fmt::format("; {} cannot be read", broken) : "");
  if (!found.empty()) return kExitOk;
  std::string names;
  for (const auto& folder : folders) names += (names.empty() ? "" : ", ") + folder.path;
  return fail(
      ErrorCode::kNotFound,
      "no definition has all words of '{}'; searched in {}. 'footlight fixtures find' tolerates spelling errors; "
      "--library names another folder",
      words, names);
}

}  // namespace

void add_fixtures_list(Arguments& arguments) {
  Arguments its = arguments.subcommand(
      "list", "List the definitions on this machine with their modes, as the window's library does",
      "  footlight fixtures list                        # all of them\n"
      "  footlight fixtures list robe spot 16           # those that have all three words, in any order\n"
      "  footlight fixtures list wash --rig show.toml --json\n"
      "Reads every file: built-in types, --library, the folder of --rig, $FOOTLIGHT_FIXTURES, footlight/fixtures "
      "below\n"
      "the XDG data folders, and QLC+'s definitions. Words are looked for in manufacturer, model, kind and modes. "
      "Files\n"
      "that cannot be read are listed with their error. The number behind a mode is that of its slots. Exit code 3 if\n"
      "nothing is found.\n");
  auto options = std::make_shared<Options>();
  its.words("WORD", options->words, "words that a definition must have");
  its.list("--library", options->folders, "FOLDER", "list these, too; may be given several times");
  its.option("--rig", options->rig, "FILE", "list what is beside this rig, too");
  its.flag("--json", options->json, "one JSON object a line for each definition");
  its.job([options] { return list(*options); });
}

}  // namespace footlight::tools
