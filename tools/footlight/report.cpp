// footlight report: error against run time of every approximation, and what the rig left out.
#include <filesystem>
#include <fstream>
#include <memory>
#include <system_error>

#include "fixtures/color.h"
#include "fixtures/import/import_rig.h"
#include "tools/footlight/command.h"
#include "tools/footlight/fixtures_command.h"
#include "tools/footlight/json_lines.h"
#include "tools/footlight/report_parts.h"
#include "tools/footlight/status_text.h"

namespace footlight::tools {
namespace {

Status unwritable(const std::string& path) {
  return fail(ErrorCode::kIo, "{}: cannot be written; choose a folder that exists and is yours", path);
}

struct Options {
  ReportOptions shared;
  std::string optics;
  bool pictures = false;
  bool time = false;
};

// Whether a file can be made there: told before the minutes that the report takes, not after them.
Status try_report_file(const std::string& path) {
  if (path.empty()) return {};
  const std::string part = path + ".part";
  const bool good = std::ofstream(part, std::ios::app).good();
  std::error_code ignored;
  std::filesystem::remove(part, ignored);
  return good ? Status{} : unwritable(path);
}

// Beams and colours of every type of a rig, or of one definition.
Status report_optics(const std::string& path, bool json) {
  FL_ASSIGN(const fixtures::ImportedRig imported, fixtures::import_rig(path));
  for (const fixtures::FixtureType& type : imported.rig.types) {
    const std::string name = printable_utf8(type.manufacturer + (type.manufacturer.empty() ? "" : " ") + type.name);
    if (json) {
      for (const auto& color : fixtures::color_report(type)) fmt::print("{}\n", json_of_color(name, color));
    } else {
      fmt::print("{}\n{}\n", printable_line(name), printable_lines(optics_of_type(type)));
    }
  }
  return {};
}

Result<int> report(const Options& options, const ReportHalf& pictures, const ReportHalf& time) {
  if (!options.optics.empty()) {
    FL_TRY(report_optics(options.optics, options.shared.json));
    return kExitOk;
  }
  FL_TRY(try_report_file(options.shared.csv));
  FL_TRY(try_report_file(options.shared.svg));
  const bool both = options.pictures == options.time;
  if (options.pictures && !pictures) {
    return fail(ErrorCode::kUnsupported,
                "--pictures: this program was built without the renderer; footlight report --time needs none");
  }
  if ((both || options.pictures) && pictures) FL_TRY(pictures(options.shared));
  if (both || options.time) FL_TRY(time(options.shared));
  return kExitOk;
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  const ReportHalf pictures = add_report_pictures(arguments);
  const ReportHalf time = add_report_time(arguments);
  arguments.flag("--pictures", options->pictures, "pictures only");
  arguments.flag("--time", options->time, "time behaviour only: lamps, motors, shutters, filters");
  arguments.option(
      "--optics", options->optics, "FILE",
      "instead: beams, energy and colours of the types of a rig, or of a definition, against what it says");
  arguments.flag("--quick", options->shared.quick, "fewer knobs and scenes");
  arguments.option("--csv", options->shared.csv, "FILE",
                   "rows of pictures as CSV; those of time go beside it, FILE-time");
  arguments.option("--svg,--plot", options->shared.svg, "FILE",
                   "the plot; those of time go beside it, FILE-time-MODEL");
  arguments.flag("--json", options->shared.json, "one JSON object a row");
  arguments.job([=]() -> Result<int> { return report(*options, pictures, time); });
}

}  // namespace

Status write_report_file(const std::string& path, const std::string& text) {
  const std::string part = path + ".part";
  std::ofstream stream(part, std::ios::binary | std::ios::trunc);
  stream << text;
  stream.close();
  std::error_code trouble;
  if (stream) std::filesystem::rename(part, path, trouble);
  if (stream && !trouble) return {};
  std::error_code ignored;
  std::filesystem::remove(part, ignored);
  return unwritable(path);
}

std::string with_report_suffix(const std::string& path, const std::string& suffix) {
  const std::size_t dot = path.rfind('.');
  if (dot == std::string::npos || path.find('/', dot) != std::string::npos) return path + "-" + suffix;
  return path.substr(0, dot) + "-" + suffix + path.substr(dot);
}

extern const CommandInfo report_command{
    .name = "report",
    .help = "How wrong each approximation is, what it costs, and what the rig left out",
    .examples =
        "  footlight report --quick\n"
        "  footlight report rig.toml --log show.dmxlog --at 12.5s --svg beams.svg --csv beams.csv\n"
        "  footlight report --pictures --beams 10000 --size 3840x2160 --judge-size 96x54\n"
        "  footlight report --time --csv time.csv --svg time.svg\n"
        "  footlight report --pictures --fleet 100000        what a step of so many fixtures costs\n"
        "  footlight report --time --worst\n"
        "  footlight report --optics rig.mvr                 colours: CIEDE2000 against spectra in double\n"
        "Without a rig: the demo. Errors are against adaptive quadrature in double, or an event-exact integrator.",
    .add = add,
};

}  // namespace footlight::tools
