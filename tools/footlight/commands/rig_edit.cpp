// footlight rig edit: the edits of the window, without one.
#include <array>
#include <charconv>
#include <cstdio>
#include <memory>
#include <string>
#include <unordered_set>
#include <vector>

#include "fixtures/edit/add_fixtures.h"
#include "fixtures/edit/rig_edits.h"
#include "fixtures/files/definition_list.h"
#include "fixtures/model/names.h"
#include "sim/core/counted.h"
#include "sim/file_kind.h"
#include "tools/footlight/commands/rig_command.h"
#include "tools/footlight/edit/rig_file.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

using fixtures::RigEdit;

constexpr int kLinesMax = 40;  // fixtures that are printed

struct Options {
  std::string path;
  std::string out;
  std::vector<std::string> library;
  std::vector<std::string> select;
  std::string add;
  int count = 1;
  std::optional<int> clone;
  std::string clone_offset;
  bool remove = false;
  std::string mode;
  bool unpatch = false;
  std::string patch;
  int patch_break = 1;
  int patch_step = 0;
  bool free = false;
  bool share = false;
  std::optional<int> number;
  int number_step = 1;
  std::string rename;
  int first = 1;
  std::string place;
  std::string place_step;
  std::string move;
  std::string turn;
  std::string rotate;
  std::string about;
  bool overwrite = false;
};

using Triple = std::array<std::optional<double>, 3>;

// "1,-2.5,0"; with `gaps` "-" for an axis without a value.
Result<Triple> parse_triple(const char* option, const std::string& text, bool gaps) {
  Triple values;
  const char* at = text.data();
  const char* const end = at + text.size();
  bool sound = true;
  for (std::size_t i = 0; sound && i < values.size(); ++i) {
    if (i > 0) sound = at != end && *at++ == ',';
    if (gaps && at != end && *at == '-' && (at + 1 == end || at[1] == ',')) {
      ++at;
      continue;
    }
    double value = 0;
    const auto [next, fault] = std::from_chars(at, end, value, std::chars_format::fixed);
    sound = sound && fault == std::errc();
    values.at(i) = value;
    at = next;
  }
  if (sound && at == end) return values;
  return fail(ErrorCode::kBadInput, "{} '{}': expected three numbers such as 1,-2.5,0{}", option, text,
              gaps ? ", with - for an axis that stays" : "");
}

Result<glm::dvec3> parse_vector(const char* option, const std::string& text) {
  if (text.empty()) return glm::dvec3(0);
  FL_ASSIGN(const Triple values, parse_triple(option, text, false));
  return glm::dvec3(values[0].value_or(0), values[1].value_or(0), values[2].value_or(0));
}

// In the order of the patterns, then of the file; each once.
Result<std::vector<int>> selected(const fixtures::Rig& rig, const std::vector<std::string>& patterns) {
  if (patterns.empty()) {
    return fail(
        ErrorCode::kBadInput,
        "expected --select with the name of fixtures, for example: --select 'Spot *'; or --add with the file of a "
        "definition");
  }
  std::vector<int> which;
  std::unordered_set<int> seen;
  for (const std::string& pattern : patterns) {
    bool any = false;
    for (std::size_t i = 0; i < rig.fixtures.size(); ++i) {
      if (!fixtures::name_matches(pattern, rig.fixtures[i].name)) continue;
      any = true;
      if (seen.insert(static_cast<int>(i)).second) which.push_back(static_cast<int>(i));
    }
    if (!any) {
      return fail(ErrorCode::kNotFound, "--select '{}': no fixture has such a name; 'footlight rig show' lists them",
                  pattern);
    }
  }
  return which;
}

// Applies the options to a rig, and prints what each does.
class Editor {
 public:
  Editor(const Options& options, fixtures::Rig& rig) : options_(options), rig_(rig), before_(rig.fixtures) {}

  Status run() {
    if (!options_.add.empty()) {
      FL_TRY(add());
    } else {
      FL_ASSIGN(which_, selected(rig_, options_.select));
    }
    if (options_.remove) return do_one(fixtures::delete_fixtures(rig_, which_));
    if (options_.clone) {
      fixtures::CloneRow row;
      row.count = *options_.clone;
      FL_ASSIGN(row.offset_m, parse_vector("--offset", options_.clone_offset));
      FL_TRY(do_one(fixtures::clone_fixtures(rig_, which_, row)));
    }
    if (!options_.mode.empty() && options_.add.empty()) FL_TRY(do_one(fixtures::set_mode(rig_, which_, options_.mode)));
    if (options_.unpatch) FL_TRY(do_one(fixtures::unpatch_fixtures(rig_, which_)));
    if (!options_.patch.empty()) FL_TRY(patch());
    if (options_.number) {
      FL_TRY(do_one(fixtures::number_fixtures(rig_, which_, *options_.number, options_.number_step)));
    }
    if (!options_.rename.empty()) {
      FL_TRY(do_one(fixtures::rename_fixtures(rig_, which_, options_.rename, options_.first)));
    }
    return put();
  }

  // What became of each fixture.
  void print_changes() const {
    int lines = 0;
    const auto line = [&](const std::string& text) {
      if (++lines <= kLinesMax) fmt::print("  {}\n", printable_line(text));
    };
    for (const int fixture : removed_) line(before_[static_cast<std::size_t>(fixture)].name + ": deleted");
    for (std::size_t i = 0; removed_.empty() && i < rig_.fixtures.size(); ++i) {
      const fixtures::PatchedFixture& now = rig_.fixtures[i];
      if (i >= before_.size()) {
        line(fmt::format("{}: new, address {}", now.name, fixtures::text_of_patch(now)));
        continue;
      }
      const std::string change = fixtures::text_of_change(rig_, before_[i], now);
      if (!change.empty()) line(fmt::format("{}: {}", before_[i].name, change));
    }
    if (lines > kLinesMax) fmt::print("  and {} more\n", lines - kLinesMax);
    if (lines == 0) fmt::print("  nothing is different\n");
  }

 private:
  Status do_one(Result<RigEdit> edit) {
    if (!edit) return tl::unexpected<Error>(std::move(edit).error());
    fmt::print("{}\n", printable_line(edit->text));
    edit->apply(rig_);
    for (const RigEdit::Entry& entry : edit->removed) removed_.push_back(entry.fixture);
    if (edit->added.empty()) return {};
    which_.clear();  // what follows acts on the copies
    for (const RigEdit::Entry& entry : edit->added) which_.push_back(entry.fixture);
    return {};
  }

  // In their mode, at the first free addresses: --patch moves them from there.
  Status add() {
    if (!options_.select.empty() || options_.clone || options_.remove) {
      return fail(
          ErrorCode::kBadInput,
          "--add: it makes the fixtures that the other options act on; leave out --select, --clone and --delete");
    }
    fixtures::NewFixtures row;
    auto type = fixtures::open_definition(options_.add);
    if (!type && type.error().code == ErrorCode::kNotFound) {
      return fail(ErrorCode::kNotFound,
                  "--add '{}': expected the file of a definition or the name of a built-in type; 'footlight fixtures "
                  "list {}' searches them",
                  options_.add, options_.add);
    }
    if (!type) return tl::unexpected<Error>(std::move(type).error());
    row.type = std::make_shared<const fixtures::FixtureType>(std::move(*type));
    if (!options_.mode.empty()) {
      FL_ASSIGN(row.mode, fixtures::find_mode(*row.type, options_.mode));
    }
    row.count = options_.count;
    if (!options_.clone_offset.empty()) {
      FL_ASSIGN(row.step_m, parse_vector("--offset", options_.clone_offset));
    }
    return do_one(fixtures::add_fixtures(rig_, row));
  }

  Status patch() {
    fixtures::PatchStart start;
    FL_ASSIGN(const auto place, fixtures::parse_patch(options_.patch, 1));
    start.universe = place.universe;
    start.address = place.address;
    start.dmx_break = options_.patch_break;
    start.step = options_.patch_step;
    start.only_free = options_.free;
    return do_one(fixtures::patch_fixtures(rig_, which_, start));
  }

  Status put() {
    if (!options_.place.empty()) {
      fixtures::PlaceAt at;
      FL_ASSIGN(at.position_m, parse_triple("--place", options_.place, true));
      FL_ASSIGN(at.step_m, parse_vector("--place-step", options_.place_step));
      FL_TRY(do_one(fixtures::place_fixtures(rig_, which_, at)));
    }
    if (!options_.move.empty()) {
      FL_ASSIGN(const glm::dvec3 by_m, parse_vector("--move", options_.move));
      FL_TRY(do_one(fixtures::move_fixtures(rig_, which_, by_m)));
    }
    if (!options_.turn.empty()) {
      FL_ASSIGN(const Triple rotation_deg, parse_triple("--turn", options_.turn, true));
      FL_TRY(do_one(fixtures::turn_fixtures(rig_, which_, rotation_deg)));
    }
    if (!options_.rotate.empty()) {
      FL_ASSIGN(const glm::dvec3 by_deg, parse_vector("--rotate", options_.rotate));
      std::optional<glm::dvec3> about_m;
      if (!options_.about.empty()) {
        FL_ASSIGN(about_m, parse_vector("--about", options_.about));
      }
      FL_TRY(do_one(fixtures::rotate_fixtures(rig_, which_, by_deg, about_m)));
    }
    return {};
  }

  const Options& options_;
  fixtures::Rig& rig_;
  const std::vector<fixtures::PatchedFixture> before_;
  std::vector<int> which_;
  std::vector<int> removed_;
};

Status refuse_shared(const fixtures::Rig& rig) {
  int shared = 0;
  std::string first;
  for (const fixtures::PatchConflict& conflict : fixtures::patch_conflicts(rig)) {
    if (conflict.meant) continue;
    if (shared++ == 0) first = fixtures::text_of(conflict, rig);
  }
  if (shared == 0) return {};
  return fail(ErrorCode::kBadInput, "{}{}; choose another address, --free, or --share to let them", first,
              shared > 2 ? fmt::format(" ({} fixtures in all)", shared) : "");
}

Result<int> edit(const Options& options) {
  if (!options.out.empty()) {
    if (!options.out.ends_with(".toml")) {
      return fail(ErrorCode::kBadInput, "-o '{}': expected a file name that ends in .toml", options.out);
    }
    FL_TRY(refuse_existing(options.out, options.overwrite));
  }
  const auto known = options.out.empty() ? std::nullopt : mark_of_file(options.out);
  FL_ASSIGN(fixtures::ImportedRig imported, open_rig(options.path, options.library));
  Editor editor(options, imported.rig);
  FL_TRY(editor.run());
  editor.print_changes();
  if (!options.share) FL_TRY(refuse_shared(imported.rig));
  if (options.out.empty()) {
    fmt::print("nothing is written; -o FILE.toml writes the edited rig\n");
    return kExitOk;
  }
  RigFile file = RigFile::recovered(std::move(imported), options.path, options.out, known);
  FL_ASSIGN(const SaveReport report, file.save());
  fmt::print("{}: {}\n", printable_utf8(report.path), counted(file.rig().fixtures.size(), "fixture"));
  if (report.shared > 0) fmt::print("{} share slots\n", counted(report.shared, "fixture"));
  if (!report.old.empty()) fmt::print("{}: the file from before\n", printable_utf8(report.old));
  return kExitOk;
}

}  // namespace

void add_rig_edit(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  Arguments its = arguments.subcommand(
      "edit", "Add fixtures, edit their patch, names and places, and write a rig file",
      "  footlight rig edit show.mvr --select 'Mover *' --patch 2.1 --move 0,0,0.5 -o show.toml\n"
      "  footlight rig edit rig.toml --select 'Spot *' --patch 3.1 --free -o rig.toml --overwrite\n"
      "  footlight rig edit rig.toml --select 'Par 1' --clone 7 --offset 0.5,0,0 -o row.toml\n"
      "  footlight rig edit rig.toml --add generic/wash --count 4 --place -3,2,6 --place-step 2,0,0 -o more.toml\n"
      "  footlight rig edit rig.toml --select 'Spot *' --rename 'LX1 {}' --number 101    # only prints it\n"
      "Edits are made in the order of this list; after --add and --clone they act on the new fixtures. Without -o "
      "nothing is written.\n"
      "A file with comments that is replaced is kept as NAME.toml~. docs/rigs.md says more.");
  its.word("FILE", options->path, "the rig: .mvr, .qxw, .toml or a patch of VRSL");
  its.list("--select,-s", options->select, "NAME",
           "the fixtures, with * for any text; several patterns give the order of the selection");
  its.flag("--delete", options->remove, "delete them; other edits are not made");
  its.option("--add", options->add, "TYPE",
             "add fixtures of this definition, a file or a built-in type; what follows acts on them");
  its.option("--count", options->count, 1, fixtures::kRigFixturesMax, "how many --add adds");
  its.option("--clone", options->clone, 1, fixtures::kRigFixturesMax,
             "so many copies of each, with the next names and free addresses");
  its.option("--offset", options->clone_offset, "X,Y,Z",
             "metres from copy to copy [0,0,0], or from new fixture to new fixture [1,0,0]");
  its.option("--mode", options->mode, "NAME", "their mode");
  its.flag("--unpatch", options->unpatch, "take their addresses away");
  its.option("--patch", options->patch, "U.A",
             "universe and address of the first; the others follow, in the next universe where one is full");
  its.option("--break", options->patch_break, 1, fixtures::kBreakMax, "that --patch sets, of definitions with several");
  its.option("--step", options->patch_step, 0, kSlotCountMax,
             "addresses from fixture to fixture; 0: as many as it has slots");
  its.flag("--free", options->free, "--patch skips slots that other fixtures use");
  its.flag("--share", options->share, "fixtures may share slots");
  its.option("--number", options->number, 1, 1'000'000'000, "fixture id and number of the first; the others follow");
  its.option("--number-step", options->number_step, -1000, 1000, "from fixture to fixture");
  its.option("--rename", options->rename, "NAME", "their name; {} is a number that counts up");
  its.option("--first", options->first, 0, 999'999'999, "the first number of --rename");
  its.option("--place", options->place, "X,Y,Z", "position in metres; - for an axis that stays: -,-,6");
  its.option("--place-step", options->place_step, "X,Y,Z", "from fixture to fixture");
  its.option("--move", options->move, "X,Y,Z", "by metres");
  its.option("--turn", options->turn, "X,Y,Z", "to a rotation in degrees about X, then Y, then Z; - as for --place");
  its.option("--rotate", options->rotate, "X,Y,Z", "by degrees, each about its hanging point");
  its.option("--about", options->about, "X,Y,Z", "--rotate all together about this point");
  its.option("--out,-o", options->out, "FILE", "the rig file, .toml; its folder of definitions is beside it");
  its.flag("--overwrite", options->overwrite, "replace an existing rig file");
  its.list("--library", options->library, "FOLDER", "search fixture definitions here, not in the installed libraries");
  its.job([options]() -> Result<int> { return edit(*options); });
}

}  // namespace footlight::tools
