// footlight report: error against run time of every approximation, and the features that the rig leaves out.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string_view>
#include <system_error>

#include <unistd.h>

#include "fixtures/files/import/import_rig.h"
#include "fixtures/model/color.h"
#include "sim/file_kind.h"
#include "sim/system_clock.h"
#include "tools/footlight/command.h"
#include "tools/footlight/commands/fixtures_command.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/monitor/terminal.h"
#include "tools/footlight/report/report_parts.h"
#include "tools/footlight/status/json_lines.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

// Shows one line of progress on standard error, if that is a terminal: the finished share and the remaining time, which
// is estimated from the finished parts.
class ReportProgress {
 public:
  ReportProgress() { catch_end_signals(); }
  ~ReportProgress() { clear(); }
  ReportProgress(const ReportProgress&) = delete;
  ReportProgress& operator=(const ReportProgress&) = delete;

  bool go_on(std::string_view what, double done, double all) {
    if (end_signal_came() || unread_) return false;
    const TimeNs now_ns = clock_.now_ns();
    if (what != what_) {
      what_ = what;
      begin_ns_ = now_ns;
    }
    if (!terminal_ || now_ns - shown_ns_ < kEveryNs) return true;
    shown_ns_ = now_ns;
    shown_ = true;
    // No estimate is possible before anything is done.
    const double left_ns = done > 0 ? static_cast<double>(now_ns - begin_ns_) * (all - done) / done : 0;
    fmt::print(stderr, "\rfootlight: {}: {:.0f} of {:.0f}{}\033[K", what_, done, all,
               done > 0 ? fmt::format(", about {} left", show_duration(static_cast<DurationNs>(left_ns))) : "");
    return true;
  }

  void print(const std::string& text) {
    clear();
    fmt::print("{}", text);
    const Result<bool> read_on = flush_output();
    unread_ = !read_on || !*read_on;  // the reader is gone, as with `| head`: end instead of measuring for minutes
  }

  void clear() {
    if (shown_) fmt::print(stderr, "\r\033[K");
    shown_ = false;
  }

 private:
  static constexpr DurationNs kEveryNs = 200 * kNsPerMs;

  SystemClock clock_;
  const bool terminal_ = isatty(STDERR_FILENO) != 0;
  std::string what_;
  TimeNs begin_ns_ = 0;
  TimeNs shown_ns_ = 0;
  bool shown_ = false;
  bool unread_ = false;
};

struct Options {
  ReportOptions shared;
  std::string optics;
  bool pictures = false;
  bool time = false;
};

// Checks that a file can be written there, so that the error comes before minutes of measuring and not after them.
Status try_report_file(const std::string& path) {
  if (path.empty()) return {};
  FL_TRY(refuse_pipe_output(path));
  const std::string part = path + ".part";
  const bool good = std::ofstream(part, std::ios::app).good();
  std::error_code ignored;
  std::filesystem::remove(part, ignored);
  return good ? Status{} : unwritable(path);
}

// Prints beams and colours of every type of a rig, or of one definition, beside those of the definition.
Status report_optics(const std::string& path, bool json) {
  FL_ASSIGN(const fixtures::ImportedRig imported, fixtures::import_rig(path));
  for (const fixtures::FixtureType& type : imported.rig.types) {
    const std::string name = printable_utf8(type.manufacturer + (type.manufacturer.empty() ? "" : " ") + type.name);
    if (json) {
      for (const auto& color : fixtures::color_report(type)) fmt::print("{}\n", json_of_color(name, color));
      for (std::size_t i = 0; i < type.beams.size(); ++i) fmt::print("{}\n", json_of_beam(name, type, i));
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
  ReportProgress progress;
  ReportOptions shared = options.shared;
  shared.go_on = [&](std::string_view what, double done, double all) { return progress.go_on(what, done, all); };
  shared.print = [&](const std::string& text) { progress.print(text); };
  if ((both || options.pictures) && pictures) FL_TRY(pictures(shared));
  if ((both || options.time) && !end_signal_came()) FL_TRY(time(shared));
  progress.clear();
  if (end_signal_came()) {
    fmt::print(stderr, "footlight: ended by a signal; the rows measured so far are printed{}\n",
               shared.csv.empty() && shared.svg.empty() ? "" : " and in the files");
  }
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
      "instead: compare beams, energy and colours of the types of a rig, or of a definition, with the definition");
  arguments.flag("--quick", options->shared.quick, "fewer knobs and scenes");
  arguments.option("--csv", options->shared.csv, "FILE",
                   "write the rows of pictures as CSV, and those of time beside it as FILE-time");
  arguments.option("--svg,--plot", options->shared.svg, "FILE",
                   "write the plot of pictures as SVG, and those of time beside it as FILE-time-MODEL");
  arguments.flag("--json", options->shared.json, "one JSON object per row");
  arguments.job([=]() -> Result<int> { return report(*options, pictures, time); });
}

}  // namespace

extern const CommandInfo report_command{
    .name = "report",
    .help = "How wrong each approximation is, what it costs, and what the rig left out",
    .examples =
        "  footlight report --quick\n"
        "  footlight report rig.toml --log show.dmxlog --at 12.5s --svg beams.svg --csv beams.csv\n"
        "  footlight report hall.mvr --lit --set Tilt=30     a rig without a log\n"
        "  footlight report --pictures --beams 10000 --size 3840x2160 --judge-pixels 5000\n"
        "  footlight report --time --csv time.csv --svg time.svg\n"
        "  footlight report --pictures --fleet 100000        the time of a step of 100,000 fixtures on the GPU\n"
        "  footlight report --time --worst\n"
        "  footlight report --optics rig.mvr                 colours: CIEDE2000 against spectra in double\n"
        "Without a rig: the demo. Errors are against adaptive quadrature in double, or an event-exact integrator.\n"
        "Ctrl-C ends the report: what was measured is printed and in the files, and the exit code is 0.",
    .add = add,
};

}  // namespace footlight::tools
