// footlight rig: reads rigs, lists assumptions, and converts, exports and prints rigs.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <memory>
#include <set>
#include <string_view>

#include <fmt/chrono.h>
#include <nlohmann/json.hpp>

#include "fixtures/bodies/check_meshes.h"
#include "fixtures/edit/patch_slots.h"
#include "fixtures/files/export/mvr.h"
#include "fixtures/files/export/rig_toml.h"
#include "fixtures/files/export/vrsl_patch_json.h"
#include "fixtures/files/export/write_file.h"
#include "fixtures/files/import/import_rig.h"
#include "fixtures/files/import/text.h"
#include "fixtures/gobos/gobo_images.h"
#include "fixtures/media/media_server.h"
#include "fixtures/paperwork/patch_pdf.h"
#include "fixtures/paperwork/patch_sheet.h"
#include "fixtures/paperwork/plan.h"
#include "sim/core/counted.h"
#include "sim/file_kind.h"
#include "tools/footlight/command.h"
#include "tools/footlight/commands/rig_command.h"
#include "tools/footlight/displays/clip.h"
#include "tools/footlight/monitor/terminal.h"
#include "tools/footlight/progress.h"
#include "tools/footlight/status/json_lines.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;
using fixtures::Diagnostic;
using fixtures::Diagnostics;
using fixtures::ImportedRig;
using fixtures::ImportStatus;
using fixtures::Severity;

struct Options {
  std::vector<std::string> paths;
  std::string path;
  std::string out;
  std::vector<std::string> library;
  std::string paper = "a3";
  bool overwrite = false;
  bool json = false;
};

struct Opened {
  Result<ImportedRig> rig;
  std::vector<Diagnostic> diagnostics;
};

// Adds one diagnostic for each video of displays, projectors and media servers that cannot be shown.
void check_videos(const fixtures::Rig& rig, Diagnostics& diagnostics, const fixtures::GoOn& go_on) {
  std::set<std::string> seen;
  // False: the check was stopped.
  const auto check = [&](const fixtures::Display& shown, std::string_view kind, std::string_view owner) {
    if (!shown.video || shown.image || !seen.insert(shown.video->path).second) return true;
    if (go_on && !go_on(seen.size(), 0)) return false;
    const auto clip = Clip::open(shown.video->path);
    if (clip) return true;
    std::string what = clip.error().message;
    const std::string name = shown.video->path + ": ";
    if (what.starts_with(name)) what.erase(0, name.size());
    diagnostics.add({Severity::kError,
                     "video",
                     {shown.video->path},
                     fmt::format("{} '{}': {}", kind, owner, what),
                     "no picture of the rig can be drawn"});
    return true;
  };
  for (std::size_t i = 0; i < fixtures::shown_count(rig); ++i) {
    const fixtures::Display& display = fixtures::shown_at(rig, i);
    if (!check(display, display.type >= 0 ? "projector" : "display", display.name)) return;
  }
  for (const fixtures::PatchedFixture& fixture : rig.fixtures) {
    if (!fixture.media) continue;
    for (const fixtures::Media& media : fixture.media->media) {
      if (!check(media.content, "media server", fixture.name)) return;
    }
  }
}

// One fader must not be a pixel by mistake: a projector's dimmer would flicker with its own picture.
void check_pixels(const fixtures::Rig& rig, const std::string& path, Diagnostics& diagnostics) {
  for (const fixtures::PixelConflict& conflict : fixtures::pixel_conflicts(rig)) {
    diagnostics.add({Severity::kWarning,
                     "pixel-overlap",
                     {path},
                     text_of(conflict, rig) + "; move one of them, or set shares_address of the fixture",
                     "both use these slots"});
  }
}

// `files`: also reads and draws gobos, and reads the meshes, their images and the videos that the rig names.
Opened open(const std::string& path, const std::vector<std::string>& folders, bool files) {
  Diagnostics diagnostics;
  std::optional<fixtures::Library> library;
  if (!folders.empty()) library = fixtures::Library::open(folders);
  catch_end_signals();
  Progress progress("fixtures and definitions read");
  auto rig = fixtures::import_rig(path, library ? &*library : nullptr, diagnostics, progress.go_on());
  if (rig && files) {
    fixtures::ImageBudget budget;
    for (const fixtures::FixtureType& type : rig->rig.types) fixtures::check_images(type, diagnostics, budget);
    fixtures::check_meshes(rig->rig, diagnostics, progress.go_on());
    check_videos(rig->rig, diagnostics, progress.go_on());
    check_pixels(rig->rig, path, diagnostics);
  }
  diagnostics.finish();
  if (rig) rig->diagnostics = diagnostics.all();
  return {std::move(rig), diagnostics.take()};
}

Result<ImportedRig> open_or_fail(const Options& options) { return open_rig(options.path, options.library); }

// Makes text from foreign files valid in JSON.
std::string clean(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

nlohmann::json json_of(const fixtures::Assumption& each) {
  return {
      {"code", each.code}, {"requested", each.wanted}, {"used", each.used}, {"why", each.why}, {"count", each.count}};
}

void print_assumptions(const ImportedRig& rig) {
  if (rig.assumptions.empty()) return;
  fmt::print("\nAssumed ({})\n", rig.assumptions.size());
  for (const fixtures::Assumption& each : rig.assumptions) {
    fmt::print("{}", printable_lines(fmt::format("  {:>5} x  {}\n           because {}\n           replaced by {}\n",
                                                 each.count, each.wanted, each.why, each.used)));
  }
}

// Possible rigs below a folder; the path itself if it is a file or an unpacked MVR.
std::vector<std::string> rig_files(const std::string& path) {
  std::error_code trouble;
  if (!fs::is_directory(path, trouble) || fs::exists(fs::path(path) / "GeneralSceneDescription.xml", trouble)) {
    return {path};
  }
  std::vector<std::string> found;
  fs::recursive_directory_iterator at(path, fs::directory_options::skip_permission_denied, trouble), end;
  for (; !trouble && at != end; at.increment(trouble)) {
    const std::string ending = fixtures::lower(at->path().extension().string());
    if ((ending == ".mvr" || ending == ".qxw") && at->is_regular_file(trouble)) found.push_back(at->path().string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

void print(const RigCheck& check, const Opened& opened) {
  for (const Diagnostic& each : check.diagnostics) fmt::print("{}\n", printable_line(fixtures::text(each)));
  std::string line = fmt::format("{}: {}", check.file, fixtures::status_name(check.status));
  if (opened.rig) {
    const fixtures::Rig& rig = opened.rig->rig;
    line += fmt::format(", {} {}: {} fixtures of {} types, {} objects", opened.rig->format, opened.rig->version,
                        rig.fixtures.size(), rig.types.size(), rig.objects.size());
    if (!rig.scenery.empty()) line += ", " + counted(rig.scenery.size(), "piece") + " of scenery";
    if (!rig.panes.empty()) line += ", " + counted(rig.panes.size(), "pane") + " of glass";
    if (!rig.displays.empty()) line += ", " + counted(rig.displays.size(), "display");
  } else {
    line += ": " + opened.rig.error().message;
  }
  fmt::print("{}\n", printable_line(line));
  if (opened.rig) print_assumptions(*opened.rig);
}

Result<int> check(const Options& options) {
  if (options.paths.empty()) {
    return fail(ErrorCode::kBadInput, "expected rigs or folders of rigs, for example: footlight rig check show.mvr");
  }
  catch_end_signals();
  std::vector<std::string> files;
  for (const std::string& path : options.paths) {
    for (std::string& file : rig_files(path)) files.push_back(std::move(file));
  }
  if (files.empty()) return fail(ErrorCode::kNotFound, "no .mvr or .qxw file in {}", options.paths.front());
  std::array<int, 3> counts{};
  std::size_t done = 0;
  for (const std::string& file : files) {
    const Opened opened = open(file, options.library, true);
    if (end_signal_came()) break;
    RigCheck check{file,
                   opened.rig ? opened.rig->format : fixtures::rig_format(file),
                   ImportStatus::kRefused,
                   0,
                   opened.diagnostics,
                   {}};
    if (opened.rig) {
      check.status = opened.rig->status();
      check.fixtures = opened.rig->rig.fixtures.size();
      check.assumptions = opened.rig->assumptions;
    }
    ++counts.at(static_cast<std::size_t>(check.status));
    ++done;
    if (options.json) {
      fmt::print("{}\n", json_of_rig_check(check));
    } else {
      print(check, opened);
    }
    FL_ASSIGN(const bool read_on, flush_output());
    if (!read_on) break;
  }
  const int refused = counts[static_cast<std::size_t>(ImportStatus::kRefused)];
  if (done != 1 || files.size() != 1) {
    fmt::print(stderr, "footlight: {}{} files: {} loaded, {} with warnings, {} refused\n",
               done < files.size() ? fmt::format("stopped after {} of ", done) : "", files.size(),
               counts[static_cast<std::size_t>(ImportStatus::kLoaded)],
               counts[static_cast<std::size_t>(ImportStatus::kWarnings)], refused);
  }
  return refused == 0 ? kExitOk : kExitFailed;
}

std::string cut(const std::string& text, std::size_t letters_max) {
  return printable_utf8(fixtures::shortened(text, letters_max));
}

Result<int> show(const Options& options) {
  FL_ASSIGN(const ImportedRig imported, open_or_fail(options));
  const std::vector<fixtures::PatchRow> rows = fixtures::patch_rows(imported.rig);
  const std::vector<fixtures::UniverseUse> uses = fixtures::universe_use(imported.rig);
  double power_w = 0, weight_kg = 0;
  int unknown_power = 0, unknown_weight = 0;
  for (const fixtures::PatchRow& row : rows) {
    power_w += row.power_w;
    weight_kg += row.weight_kg;
    unknown_power += row.power_w > 0 ? 0 : 1;
    unknown_weight += row.weight_kg > 0 ? 0 : 1;
  }
  if (options.json) {
    nlohmann::json json = {{"file", options.path},      {"format", imported.format}, {"version", imported.version},
                           {"name", imported.rig.name}, {"power_w", power_w},        {"weight_kg", weight_kg}};
    json["fixtures"] = nlohmann::json::array();
    for (const fixtures::PatchRow& row : rows) {
      const auto& fixture = imported.rig.fixtures[static_cast<std::size_t>(row.fixture)];
      nlohmann::json its = {{"name", row.name},
                            {"fixture_id", fixture.labels.fixture_id},
                            {"type", row.type},
                            {"mode", row.mode},
                            {"slots", row.slot_count},
                            {"addresses", row.addresses},
                            {"position_m", {row.position_m.x, row.position_m.y, row.position_m.z}},
                            {"layer", row.layer},
                            {"power_w", row.power_w},
                            {"weight_kg", row.weight_kg}};
      if (!row.wanted.empty()) its["requested"] = row.wanted;
      json["fixtures"].push_back(std::move(its));
    }
    json["universes"] = nlohmann::json::array();
    for (const auto& use : uses) {
      json["universes"].push_back(
          {{"universe", use.universe}, {"fixtures", use.fixture_count}, {"slots", use.slot_count}});
    }
    json["assumptions"] = nlohmann::json::array();
    for (const auto& each : imported.assumptions) json["assumptions"].push_back(json_of(each));
    fmt::print("{}\n", clean(json));
    return kExitOk;
  }

  fmt::print("{}: {} {}{}{}, {}, {}, {}\n\n", printable_utf8(options.path), cut(imported.rig.name, 60), imported.format,
             imported.version.empty() ? "" : " ", cut(imported.version, 20), counted(rows.size(), "fixture"),
             counted(imported.rig.objects.size(), "object"), counted(imported.rig.focus_points.size(), "focus point"));
  if (!imported.rig.scenery.empty()) fmt::print("{} of scenery\n\n", counted(imported.rig.scenery.size(), "piece"));
  fmt::print("{:<10} {:<24} {:<32} {:<18} {:>5}  {:<14} {:>7} {:>7} {:>7}\n", "id", "name", "type", "mode", "slots",
             "address", "x m", "y m", "z m");
  for (const fixtures::PatchRow& row : rows) {
    const auto& labels = imported.rig.fixtures[static_cast<std::size_t>(row.fixture)].labels;
    fmt::print("{:<10} {:<24} {:<32} {:<18} {:>5}  {:<14} {:>7.2f} {:>7.2f} {:>7.2f}\n",
               cut(labels.fixture_id.empty() ? "-" : labels.fixture_id, 10), cut(row.name, 24), cut(row.type, 32),
               cut(row.mode, 18), row.slot_count, cut(row.addresses, 14), row.position_m.x, row.position_m.y,
               row.position_m.z);
  }
  fmt::print("\nUniverses ({})\n", uses.size());
  for (const auto& use : uses) {
    fmt::print("  {:>5}  {}, {} of 512 slots\n", use.universe, counted(use.fixture_count, "fixture"), use.slot_count);
  }
  fmt::print(
      "\nPower {:.1f} kW{}, weight {:.0f} kg{}\n", power_w / 1000,
      unknown_power > 0 ? fmt::format(", without {} of unknown power", counted(unknown_power, "fixture")) : "",
      weight_kg,
      unknown_weight > 0 ? fmt::format(", without {} of unknown weight", counted(unknown_weight, "fixture")) : "");
  print_assumptions(imported);
  return kExitOk;
}

Status expect_ending(const std::string& out, const std::vector<std::string>& endings, const char* example) {
  for (const std::string& ending : endings) {
    if (fixtures::lower(out).ends_with(ending)) return {};
  }
  return fail(ErrorCode::kBadInput, "-o '{}': expected a file name that ends in {}, for example: {}", out,
              fmt::join(endings, " or "), example);
}

void print_report(const std::string& out, const fixtures::ExportReport& report) {
  fmt::print("{}: {}, {}{}, {}\n", printable_utf8(out), counted(report.fixture_count, "fixture"),
             counted(report.definition_count, "definition"),
             report.made_count > 0 ? fmt::format(" ({} written as GDTF)", report.made_count) : "",
             report.mesh_count == 1 ? "1 mesh" : fmt::format("{} meshes", report.mesh_count));
  for (const std::string& note : report.notes) fmt::print(stderr, "footlight: {}\n", printable_utf8(note));
}

Result<int> import_it(const Options& options) {
  FL_TRY(expect_ending(options.out, {".toml"}, "footlight rig import show.mvr -o show.toml"));
  FL_TRY(refuse_existing(options.out, options.overwrite));
  FL_TRY(refuse_existing(fixtures::files_folder_of(options.out), options.overwrite));
  FL_ASSIGN(const ImportedRig imported, open_or_fail(options));
  Progress progress("files written");
  FL_ASSIGN(const auto report, fixtures::export_rig_toml(imported, options.out, progress.go_on()));
  progress.clear();
  print_report(options.out, report);
  print_assumptions(imported);
  return kExitOk;
}

Result<int> export_it(const Options& options) {
  FL_TRY(expect_ending(options.out, {".mvr", ".json"}, "footlight rig export show.toml -o show.mvr"));
  FL_TRY(refuse_existing(options.out, options.overwrite));
  FL_ASSIGN(const ImportedRig imported, open_or_fail(options));
  if (fixtures::lower(options.out).ends_with(".json")) {
    FL_ASSIGN(const auto patch, fixtures::export_vrsl_patch(imported, options.out));
    print_report(options.out, patch);
    return kExitOk;
  }
  Progress progress("files written");
  FL_ASSIGN(const auto report, fixtures::export_mvr(imported, options.out, progress.go_on()));
  progress.clear();
  print_report(options.out, report);
  return kExitOk;
}

fixtures::SheetHead head_of(const Options& options) {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return {fs::path(options.path).filename().string(), fmt::format("{:%Y-%m-%d}", fmt::localtime(now))};
}

Result<int> patch(const Options& options) {
  FL_TRY(expect_ending(options.out, {".pdf", ".html", ".csv"}, "footlight rig patch show.mvr -o patch.pdf"));
  FL_ASSIGN(const ImportedRig imported, open_or_fail(options));
  const std::string ending = fixtures::lower(fs::path(options.out).extension().string());
  std::string bytes;
  if (ending == ".pdf") {
    Progress progress("rows drawn");
    FL_ASSIGN(bytes, fixtures::patch_pdf(imported.rig, head_of(options), progress.go_on()));
  } else {
    bytes = ending == ".csv" ? fixtures::patch_csv(imported.rig) : fixtures::patch_html(imported.rig, head_of(options));
  }
  FL_TRY(fixtures::write_file(options.out, bytes));
  fmt::print("{}: {} fixtures\n", printable_utf8(options.out), imported.rig.fixtures.size());
  return kExitOk;
}

Result<int> plan(const Options& options) {
  FL_TRY(expect_ending(options.out, {".svg"}, "footlight rig plan show.mvr -o plan.svg"));
  const std::string paper = fixtures::lower(options.paper);
  if (paper.size() != 2 || paper[0] != 'a' || paper[1] < '0' || paper[1] > '4') {
    return fail(ErrorCode::kBadInput, "--paper '{}': expected a0, a1, a2, a3 or a4", options.paper);
  }
  constexpr fixtures::PlanPaper kSizes[] = {{1189, 841}, {841, 594}, {594, 420}, {420, 297}, {297, 210}};
  FL_ASSIGN(const ImportedRig imported, open_or_fail(options));
  Progress progress("parts drawn");
  FL_ASSIGN(const std::string drawing,
            fixtures::plan_svg(imported.rig, head_of(options), kSizes[paper[1] - '0'], progress.go_on()));
  progress.clear();
  FL_TRY(fixtures::write_file(options.out, drawing));
  fmt::print("{}: {} fixtures\n", printable_utf8(options.out), imported.rig.fixtures.size());
  return kExitOk;
}

void add(Arguments& arguments) {
  struct Part {
    const char* name;
    const char* help;
    const char* examples;
    Result<int> (*run)(const Options&);
    const char* out;  // help of -o; nullptr: no such option
  };
  static constexpr Part kParts[] = {
      {"check", "Check rigs: errors, their places, and assumptions",
       "  footlight rig check show.mvr\n"
       "  footlight rig check rigs/ --json | jq -r 'select(.status == \"refused\").file'\n"
       "Exit code 1 if a file is refused.",
       check, nullptr},
      {"show", "Show the fixtures, universes, power, weight and assumptions of a rig",
       "  footlight rig show show.mvr\n"
       "  footlight rig show show.qxw --json | jq '.fixtures[].addresses'",
       show, nullptr},
      {"import", "Write a rig as a Footlight rig file, with a folder of its files",
       "  footlight rig import show.mvr -o show.toml\n"
       "The definitions and meshes go to show_files/ in the same folder.",
       import_it, "the rig file, .toml"},
      {"export", "Write a rig as MVR 1.6, or its VRSL fixtures as a patch of VRSL",
       "  footlight rig export show.toml -o show.mvr\n"
       "  footlight rig export club.toml -o club.json\n"
       "MVR: GDTF definitions are copied unchanged; others are written as GDTF.",
       export_it, "the file, .mvr or .json"},
      {"patch", "Write the patch sheet as PDF, HTML or CSV",
       "  footlight rig patch show.mvr -o patch.pdf\n"
       "  footlight rig patch show.mvr -o patch.html\n"
       "  footlight rig patch show.mvr -o patch.csv\n",
       patch, "the sheet, .pdf, .html or .csv"},
      {"plan", "Draw the top view to scale",
       "  footlight rig plan show.mvr -o plan.svg --paper a3\n"
       "  rsvg-convert -f pdf plan.svg -o plan.pdf",
       plan, "the drawing, .svg"},
  };
  for (const Part& part : kParts) {
    auto options = std::make_shared<Options>();
    Arguments its = arguments.subcommand(part.name, part.help, part.examples);
    const bool many = part.run == check;
    if (many) {
      its.words("PATH", options->paths, "rigs, or folders that are searched for .mvr and .qxw");
    } else {
      its.word("FILE", options->path,
               "the rig: .mvr, .qxw, .toml or a patch of VRSL; the content decides, not the name");
    }
    if (part.out != nullptr) its.option("--out,-o", options->out, "FILE", part.out);
    if (part.run == import_it)
      its.flag("--overwrite", options->overwrite, "replace an existing rig file and its folder's files");
    if (part.run == export_it) its.flag("--overwrite", options->overwrite, "replace an existing file");
    if (part.run == plan) its.option("--paper", options->paper, "SIZE", "a0 to a4, landscape [a3]");
    its.list("--library", options->library, "FOLDER",
             "search fixture definitions here, not in the installed libraries");
    if (part.run == check || part.run == show)
      its.flag("--json", options->json, "one JSON object a line for each file");
    its.job([options, run = part.run]() -> Result<int> { return run(*options); });
  }
  add_rig_edit(arguments);
}

}  // namespace

Result<ImportedRig> open_rig(const std::string& path, const std::vector<std::string>& library) {
  if (path.empty()) {
    return fail(ErrorCode::kBadInput,
                "expected a rig (.mvr, .qxw, .toml) or a fixture definition; 'footlight rig --help' has examples");
  }
  Opened opened = open(path, library, false);
  if (!opened.rig) return tl::unexpected<Error>(std::move(opened.rig).error());
  const auto wrong = std::count_if(opened.diagnostics.begin(), opened.diagnostics.end(),
                                   [](const Diagnostic& each) { return each.severity != fixtures::Severity::kNote; });
  if (wrong > 0) {
    const std::string shown = printable_utf8(path);
    fmt::print(stderr, "footlight: {}: {}; 'footlight rig check {}' lists them\n", shown, counted(wrong, "warning"),
               shown);
  }
  return std::move(*opened.rig);
}

extern const CommandInfo rig_command{
    .name = "rig",
    .help = "Check, show, edit, convert and print rigs from MVR, QLC+ and Footlight files",
    .examples =
        "  footlight rig check show.mvr\n"
        "  footlight rig show show.mvr\n"
        "  footlight rig import show.mvr -o show.toml\n"
        "  footlight rig edit show.toml --select 'Spot *' --patch 2.1 -o moved.toml\n"
        "  footlight rig export show.toml -o show.mvr\n"
        "  footlight rig export club.toml -o club.json\n"
        "  footlight rig patch show.mvr -o patch.pdf\n"
        "  footlight rig plan show.mvr -o plan.svg\n",
    .add = add,
};

}  // namespace footlight::tools
