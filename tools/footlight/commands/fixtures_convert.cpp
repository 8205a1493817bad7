// footlight fixtures convert: writes any definition as a Footlight fixture file, with its pictures and models.
#include <filesystem>
#include <memory>
#include <set>
#include <system_error>

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

Status write_whole(const fs::path& path, std::string_view bytes) {
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  return fixtures::write_file(path.string(), bytes);
}

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
  int copied = 0;
  if (type.files != nullptr) {
    for (const std::string& name : names_used(type)) {
      const auto bytes = type.files->read(name, kFileBytesMax);
      if (!bytes) {
        fmt::print(stderr, "footlight: {}\n", printable_utf8(bytes.error().message));
        continue;
      }
      FL_TRY(write_whole(folder / name, fixtures::text_of(*bytes)));
      ++copied;
    }
  }
  const std::string text = fixtures::write_full_form(type, copied > 0 ? folder.filename().string() : "");
  FL_TRY(write_whole(options.out, text));
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
