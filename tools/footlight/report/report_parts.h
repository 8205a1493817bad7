// The two halves of `footlight report`. That of pictures is there in builds with the renderer only.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "tools/footlight/command.h"

namespace footlight::tools {

// What both halves are asked with.
struct ReportOptions {
  std::string csv;  // paths; empty: none
  std::string svg;
  bool quick = false;
  bool json = false;
  // Shows on a terminal how far the half is: `done` of `all` parts of `what`. False once a signal to end has come.
  std::function<bool(std::string_view what, double done, double all)> go_on;
  // Prints rows to standard output at once, with the line of go_on() out of the way.
  std::function<void(const std::string& text)> print;
};

// Prints its half of the report row by row, and writes the files that are asked for. Ended by a signal, it prints and
// writes what it has.
using ReportHalf = std::function<Status(const ReportOptions&)>;

// Declares the options of pictures. Empty in a build without the renderer: then there are neither.
[[nodiscard]] ReportHalf add_report_pictures(Arguments& arguments);
// Declares the options of time behaviour.
[[nodiscard]] ReportHalf add_report_time(Arguments& arguments);

// Replaces a file by this text, or leaves it alone.
[[nodiscard]] Status write_report_file(const std::string& path, const std::string& text);
// "plot.svg" and "time" give "plot-time.svg".
[[nodiscard]] std::string with_report_suffix(const std::string& path, const std::string& suffix);

}  // namespace footlight::tools
