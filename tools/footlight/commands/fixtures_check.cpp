// footlight fixtures check: reads definitions and lists their errors.
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "fixtures/builtin/builtin.h"
#include "fixtures/files/import/archive.h"
#include "fixtures/files/import/import.h"
#include "fixtures/gobos/gobo_images.h"
#include "fixtures/model/params.h"
#include "fixtures/simulate/check_decode.h"
#include "tools/footlight/commands/fixtures_command.h"
#include "tools/footlight/monitor/terminal.h"
#include "tools/footlight/progress.h"
#include "tools/footlight/status/json_lines.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;
using fixtures::Diagnostic;
using fixtures::ImportStatus;
using fixtures::Severity;

constexpr int kDepthMax = 16;  // of folders

struct Options {
  std::vector<std::string> paths;
  bool json = false;
  bool notes = false;
  bool sweep = false;
  bool images = false;
};

// The files to read, and the number of files in folders that are not definitions.
struct Selection {
  std::vector<std::string> paths;
  std::size_t passed_over = 0;
};

// Decides by the first bytes alone.
bool is_definition(const std::string& path) {
  fixtures::ImportSource source{path, path, {}, nullptr};
  if (!fixtures::check_is_file(path)) return fixtures::find_import_format(source) != nullptr;
  std::array<char, 4096> head{};
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), head.size());
  const auto* first = reinterpret_cast<const std::byte*>(head.data());
  source.bytes.assign(first, first + file.gcount());
  return fixtures::find_import_format(source) != nullptr;
}

// True for an unpacked archive, which is one definition.
bool is_unpacked(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_regular_file(folder / "description.xml", ignored);
}

Status add_folder(const std::string& path, Selection& selection) {
  if (is_unpacked(path)) {
    selection.paths.push_back(path);
    return {};
  }
  std::vector<std::string> found;
  std::error_code error;
  auto at = fs::recursive_directory_iterator(path, fs::directory_options::skip_permission_denied, error);
  for (; !error && at != fs::recursive_directory_iterator() && !end_signal_came(); at.increment(error)) {
    std::error_code ignored;
    const std::string name = at->path().string();
    if (at->is_directory(ignored)) {
      if (is_unpacked(at->path())) {
        found.push_back(name);
        at.disable_recursion_pending();
      } else if (at.depth() >= kDepthMax) {
        at.disable_recursion_pending();
      }
    } else if (at->is_regular_file(ignored) || !fs::exists(at->path(), ignored)) {  // a broken link
      if (is_definition(name)) {
        found.push_back(name);
      } else {
        ++selection.passed_over;
      }
    }
  }
  if (error) return fail(ErrorCode::kIo, "{}: {}", path, error.message());
  std::sort(found.begin(), found.end());
  selection.paths.insert(selection.paths.end(), found.begin(), found.end());
  return {};
}

Result<Selection> find_selection(const std::vector<std::string>& paths) {
  Selection selection;
  for (const std::string& path : paths) {
    std::error_code error;
    if (fs::is_directory(path, error)) {
      FL_TRY(add_folder(path, selection));
    } else {
      selection.paths.push_back(path);
    }
  }
  return selection;
}

// Every value of every channel decoded: which differ from those that the definition gives.
void add_decoded(const fixtures::FixtureType& type, fixtures::Diagnostics& diagnostics, fixtures::DecodeReport& sum) {
  const fixtures::DecodeReport report = fixtures::check_decode(type);
  for (const fixtures::Remark& fault : report.faults) {
    diagnostics.add({Severity::kError, "decode", fixtures::place_in(type, fault.at), fault.what, ""});
  }
  sum.modes += report.modes;
  sum.values += report.values;
  sum.float_error = std::max(sum.float_error, report.float_error);
}

FixtureCheck check_file(const std::string& path, bool sweeps, bool images, fixtures::DecodeReport& sum) {
  FixtureCheck check{path, "", ImportStatus::kRefused, "", "", 0, {}, ""};
  fixtures::Diagnostics diagnostics;
  auto source = fixtures::open_import_source(path);
  if (!source) {
    if (source.error().code == ErrorCode::kNotFound) check.missing = source.error().message;
    diagnostics.add(fixtures::error_of(source.error().message, path, "read"));
    check.diagnostics = diagnostics.take();
    return check;
  }
  if (const auto* format = fixtures::find_import_format(*source); format != nullptr) check.format = format->name;
  auto type = fixtures::import_fixture(std::move(*source), diagnostics);
  if (type) {
    for (fixtures::Remark& one : fixtures::unsimulated(*type)) {
      diagnostics.add({Severity::kNote, "not-simulated", fixtures::place_in(*type, one.at), std::move(one.what),
                       "it has no effect"});
    }
    if (images) fixtures::check_images(*type, diagnostics);
    if (sweeps) add_decoded(*type, diagnostics, sum);
  }
  diagnostics.finish();
  if (!type) {
    check.diagnostics = diagnostics.take();
    return check;
  }
  const fixtures::Imported imported{std::move(*type), diagnostics.take()};
  check.status = imported.status();
  check.manufacturer = imported.type.manufacturer;
  check.name = imported.type.name;
  check.modes = imported.type.modes.size();
  check.diagnostics = imported.diagnostics;
  return check;
}

// Diagnostics::finish() ends a code with too many entries with "93 more of these".
int count_of(const Diagnostic& one) {
  constexpr std::string_view kMore = " more of these";
  int count = 0;
  if (one.message.ends_with(kMore)) {
    std::from_chars(one.message.data(), one.message.data() + one.message.size() - kMore.size(), count);
  }
  return std::max(count, 1);
}

// "9 warnings (image-file 8, range)": the number of each code, in the order of first appearance.
std::string counts_of(const std::vector<Diagnostic>& diagnostics, Severity severity) {
  std::vector<std::pair<std::string, int>> codes;
  int all = 0;
  for (const Diagnostic& one : diagnostics) {
    if (one.severity != severity) continue;
    const int count = count_of(one);
    all += count;
    const auto at = std::find_if(codes.begin(), codes.end(), [&](const auto& code) { return code.first == one.code; });
    if (at == codes.end()) {
      codes.emplace_back(one.code, count);
    } else {
      at->second += count;
    }
  }
  if (all == 0) return "";
  std::string list;
  for (const auto& [code, count] : codes) {
    list += fmt::format("{}{}{}", list.empty() ? "" : ", ", code, count > 1 ? fmt::format(" {}", count) : "");
  }
  return fmt::format("{} {}{} ({})", all, severity_name(severity), all == 1 ? "" : "s", list);
}

// One line a file, and its errors; with `notes` every diagnostic.
std::string text_of(const FixtureCheck& check, bool notes) {
  std::string line = fmt::format("{:<8}  {}", status_name(check.status), check.file);
  if (check.status != ImportStatus::kRefused) {
    line += fmt::format(": {}{}{}, {} {}", check.manufacturer, check.manufacturer.empty() ? "" : " ", check.name,
                        check.modes, check.modes == 1 ? "mode" : "modes");
  }
  if (!notes && check.status != ImportStatus::kRefused) {
    for (const Severity severity : {Severity::kError, Severity::kWarning}) {
      const std::string counts = counts_of(check.diagnostics, severity);
      if (!counts.empty()) line += "; " + counts;
    }
  }
  std::string lines = printable_line(line) + "\n";
  for (const Diagnostic& one : check.diagnostics) {
    if (notes || one.severity == Severity::kError) lines += "  " + printable_line(fixtures::text(one)) + "\n";
  }
  return lines;
}

Result<int> run_check(const Options& options) {
  if (options.paths.empty())
    return fail(ErrorCode::kBadInput, "nothing to check; name files or folders: 'footlight fixtures check head.gdtf'");
  catch_end_signals();
  Progress progress("files");
  FL_ASSIGN(const Selection selection, find_selection(options.paths));
  std::array<std::size_t, 3> counts{};
  std::size_t done = 0;
  std::size_t missing = 0;
  std::string missing_first;
  fixtures::DecodeReport decoded;
  std::string files;  // in text: the summary goes before them
  for (const std::string& path : selection.paths) {
    if (end_signal_came()) break;
    progress.show(done, selection.paths.size());
    const FixtureCheck check = check_file(path, options.sweep, options.images, decoded);
    progress.clear();
    ++counts.at(static_cast<std::size_t>(check.status));
    ++done;
    if (!check.missing.empty() && ++missing == 1) missing_first = check.missing;
    if (options.json) {
      fmt::print("{}\n", json_of_fixture_check(check));
    } else {
      files += text_of(check, options.notes);
    }
    FL_ASSIGN(const bool read_on, flush_output());
    if (!read_on) break;
  }
  progress.clear();
  const std::size_t refused = counts[static_cast<std::size_t>(ImportStatus::kRefused)];
  const std::size_t warned = counts[static_cast<std::size_t>(ImportStatus::kWarnings)];
  std::string summary =
      fmt::format("{}{} files: {} loaded, {} with warnings, {} refused",
                  done < selection.paths.size() ? fmt::format("stopped after {} of ", done) : "",
                  selection.paths.size(), counts[static_cast<std::size_t>(ImportStatus::kLoaded)], warned, refused);
  if (selection.passed_over > 0) {
    summary += fmt::format("; {} other files are not fixture definitions", selection.passed_over);
  }
  if (options.json) {
    fmt::print(stderr, "footlight: {}\n", summary);
  } else {
    fmt::print("{}{}\n{}", summary, !options.notes && warned > 0 ? "; --notes lists the warnings" : "", files);
    FL_TRY(flush_output());
  }
  if (options.sweep) {
    fmt::print(stderr, "footlight: {} values of channels of {} modes decoded; float is within {:.1e} of double\n",
               decoded.values, decoded.modes, decoded.float_error);
  }
  if (selection.paths.empty()) return kExitNotFound;
  if (missing == selection.paths.size()) return fail(ErrorCode::kNotFound, "{}", missing_first);
  return refused > 0 ? kExitFailed : kExitOk;
}

}  // namespace

void add_fixtures_check(Arguments& arguments) {
  Arguments check = arguments.subcommand(
      "check", "Check fixture definitions: which load, their errors, and assumptions",
      "  footlight fixtures check head.gdtf\n"
      "  footlight fixtures check ~/gdtf /usr/share/qlcplus/fixtures --json\n"
      "  footlight fixtures check head.gdtf --sweep\n"
      "Prints a summary, then one line a file with the number of each warning code. Errors are always "
      "listed. Folders are searched with their subfolders. Exit code 0 if no file is refused, 1 if one "
      "is, 3 if there is none.");
  auto options = std::make_shared<Options>();
  check.words("PATH", options->paths, "files and folders");
  check.flag("--notes", options->notes, "list every diagnostic: warnings, and assumptions about undefined values");
  check.flag("--images", options->images, "also read and draw every gobo's picture");
  check.flag("--sweep", options->sweep,
             "also decode every value of every channel of every mode and compare it with the definition");
  check.flag("--json", options->json, "one JSON object a line for each file");
  check.job([options]() -> Result<int> { return run_check(*options); });
}

}  // namespace footlight::tools
