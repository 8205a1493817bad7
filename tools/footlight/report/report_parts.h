// The two parts of `footlight report`: pictures and time behaviour. Builds without the renderer have no pictures.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "tools/footlight/command.h"

namespace footlight::tools {

// Options of both parts.
struct ReportOptions {
  std::string csv;  // paths; empty: none
  std::string svg;
  bool quick = false;
  bool json = false;
  // Shows the progress on a terminal: `done` of `all` steps of `what`. Returns false after a signal to end.
  std::function<bool(std::string_view what, double done, double all)> go_on;
  // Clears the progress line and prints rows to standard output at once.
  std::function<void(const std::string& text)> print;
};

// Prints its part of the report row by row and writes the requested files. After a signal to end, prints and writes the
// rows so far.
using ReportHalf = std::function<Status(const ReportOptions&)>;

// Declares the options of pictures. In a build without the renderer, declares none and returns an empty function.
[[nodiscard]] ReportHalf add_report_pictures(Arguments& arguments);
// Declares the options of time behaviour.
[[nodiscard]] ReportHalf add_report_time(Arguments& arguments);

// Writes the text to a file. If that fails, the old file stays unchanged.
[[nodiscard]] Status write_report_file(const std::string& path, const std::string& text);
// The error of a file that cannot be written.
[[nodiscard]] Status unwritable(const std::string& path);
// "plot.svg" and "time" give "plot-time.svg".
[[nodiscard]] std::string with_report_suffix(const std::string& path, const std::string& suffix);

}  // namespace footlight::tools
