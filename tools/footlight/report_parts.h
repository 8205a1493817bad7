// The two halves of `footlight report`. That of pictures is there in builds with the renderer only.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "tools/footlight/command.h"

namespace footlight::tools {

// What both halves are asked with.
struct ReportOptions {
  std::string csv;  // paths; empty: none
  std::string svg;
  bool quick = false;
  bool json = false;
};

// Prints its half of the report, and writes the files that are asked for.
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
