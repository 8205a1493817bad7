// footlight fixtures convert: writes any definition as a Footlight fixture file, with its pictures and models.
#include <filesystem>
#include <memory>
#include <set>
#include <system_error>
#include <vector>

#include "fixtures/files/export/rig_toml.h"
#include "fixtures/files/export/write_file.h"
#include "fixtures/files/import/archive.h"
#include "fixtures/files/import/import.h"
#include "fixtures/files/import/text.h"
#include "fixtures/files/toml/fixture_toml_full.h"
#include "sim/core/counted.h"
#include "sim/file_kind.h"
#include "tools/footlight/commands/fixtures_command.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kFileBytesMax = 64u << 20;

struct Options {
  std::string file;
  std::string out;
  bool overwrite = false;
};

// Files that belong together. Those that were new, and their new folders, are removed again unless all are written.
class NewFiles {
 public:
  NewFiles() = default;
  ~NewFiles() {
    std::error_code ignored;
    for (auto made = made_.rbegin(); made != made_.rend(); ++made) fs::remove(*made, ignored);  // empty folders only
  }
  NewFiles(const NewFiles&) = delete;
  NewFiles& operator=(const NewFiles&) = delete;

  Status write(const fs::path& path, std::string_view bytes) {
    make_folder(path.parent_path());
    std::error_code ignored;
    const bool is_new = !fs::exists(path, ignored);
    FL_TRY(fixtures::write_file(path.string(), bytes));
    if (is_new) made_.push_back(path);
    return {};
  }
  void keep() { made_.clear(); }

 private:
  void make_folder(const fs::path& folder) {
    std::error_code trouble;
    if (folder.empty() || fs::exists(folder, trouble)) return;
    make_folder(folder.parent_path());
    if (fs::create_directory(folder, trouble)) made_.push_back(folder);
  }

  std::vector<fs::path> made_;
};

std::set<std::string> names_used(const fixtures::FixtureType& type) {
  std::set<std::string> names;
  for (const fixtures::Wheel& wheel : type.wheels) {
    for (const fixtures::WheelSlot& slot : wheel.slots) names.insert(slot.image);
  }
  for (const fixtures::Model& model : type.models) names.insert({model.file, model.file_low, model.file_high});
  for (const fixtures::Beam& beam : type.beams) names.insert(beam.photometry);
  names.erase("");
  std::erase_if(names, [](const std::string& name) { return name.starts_with("builtin:"); });
  return names;
}

Result<int> convert(const Options& options) {
  if (options.file.empty())
    return fail(ErrorCode::kBadInput, "fixtures convert: expected FILE, the definition to read");
  if (!options.out.ends_with(".toml")) {
    return fail(ErrorCode::kBadInput, "fixtures convert: expected -o NAME.toml, got '{}'", options.out);
  }
  // The files that it uses go into a folder beside it.
  const fs::path folder = fixtures::files_folder_of(options.out);
  FL_TRY(refuse_existing(options.out, options.overwrite));
  FL_TRY(refuse_existing(folder.string(), options.overwrite));
  FL_ASSIGN(const fixtures::Imported imported, fixtures::import_fixture(options.file));
  const fixtures::FixtureType& type = imported.type;
  NewFiles files;
  int copied = 0;
  if (type.files != nullptr) {
    for (const std::string& name : names_used(type)) {
      const auto bytes = type.files->read(name, kFileBytesMax);
      if (!bytes) {
        fmt::print(stderr, "footlight: {}\n", printable_utf8(bytes.error().message));
        continue;
      }
      FL_TRY(files.write(folder / name, fixtures::text_of(*bytes)));
      ++copied;
    }
  }
  const std::string text = fixtures::write_full_form(type, copied > 0 ? folder.filename().string() : "");
  FL_TRY(files.write(options.out, text));
  files.keep();
  std::size_t warnings = 0;
  for (const fixtures::Diagnostic& diagnostic : imported.diagnostics) {
    if (diagnostic.severity == fixtures::Severity::kNote) continue;
    fmt::print(stderr, "{}\n", printable_line(fixtures::text(diagnostic)));
    ++warnings;
  }
  const std::string line =
      fmt::format("{}: {} {}, {}, {} bytes{}{}", options.out, fixtures::shortened(type.manufacturer),
                  fixtures::shortened(type.name), counted(type.modes.size(), "mode"), text.size(),
                  copied > 0 ? fmt::format(", {} in {}", counted(copied, "file"), folder.filename().string()) : "",
                  warnings > 0 ? fmt::format("; {}", counted(warnings, "warning")) : "");
  fmt::print("{}\n", printable_utf8(line));
  return kExitOk;
}

}  // namespace

void add_fixtures_convert(Arguments& arguments) {
  Arguments convert_arguments = arguments.subcommand(
      "convert", "Write any definition as a Footlight fixture file",
      "  footlight fixtures convert head.gdtf -o head.toml\n"
      "  footlight fixtures convert /usr/share/qlcplus/fixtures/Robe/Robe-Pointe.qxf -o pointe.toml\n"
      "Its pictures and models are copied to a folder beside the file. docs/rig.md describes the format.\n");
  auto options = std::make_shared<Options>();
  convert_arguments.word("FILE", options->file, "a definition of any supported format");
  convert_arguments.option("--out,-o", options->out, "NAME.toml", "the file to write");
  convert_arguments.flag("--overwrite", options->overwrite, "replace an existing file and its folder's files");
  convert_arguments.job([options] { return convert(*options); });
}

}  // namespace footlight::tools
