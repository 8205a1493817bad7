#include "tools/footlight/vrsl/open_pictures.h"

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "drivers/vrsl/vrsl_options.h"
#include "drivers/vrsl/vrsl_sink.h"
#include "drivers/vrsl/vrsl_source.h"
#include "tools/footlight/vrsl/mock_pictures.h"
#include "tools/footlight/vrsl/png_pictures.h"
#include "tools/footlight/vrsl/v4l2_pictures.h"
#include "tools/footlight/vrsl/video_output.h"
#include "tools/footlight/vrsl/video_reader.h"
#include "tools/footlight/vrsl/vrsl_window.h"

namespace footlight::tools {
namespace {

// A kind of target: the names that it takes, and its factories. nullptr: not in that direction.
struct TargetKind {
  bool (*takes)(std::string_view name);
  Result<std::unique_ptr<drivers::PictureOutput>> (*output)(const drivers::PictureTarget& target);
  Result<std::unique_ptr<drivers::PictureInput>> (*input)(const drivers::PictureTarget& target);
  bool (*writes_files)(const std::string& name);  // so that outputs have the option "overwrite"
  const char* examples;                           // for the message of an unknown target
};

bool is_video_file(const std::string& name) {
  std::error_code ignored;
  return name != "-" && !std::filesystem::is_fifo(name, ignored);
}
bool always(const std::string& /*name*/) { return true; }
bool never(const std::string& /*name*/) { return false; }

constexpr TargetKind kKinds[] = {
    {is_picture_file, open_png_output, open_picture_files, always, "frame_%05d.png, show.png"},
    {is_video_target, open_video_output, open_video_input, is_video_file, "stream.mp4, stream.mkv, -"},
    {is_window_target, open_window_output, nullptr, never, "window"},
    {is_v4l2_target, open_v4l2_output, open_v4l2_input, never, "/dev/video9"},
    {is_mock_target, open_mock_output, open_mock_input, never, "mock"},
};

const TargetKind* kind_of_target(std::string_view name) {
  for (const TargetKind& kind : kKinds) {
    if (kind.takes(name)) return &kind;
  }
  return nullptr;
}

tl::unexpected<Error> unknown_target(const drivers::PictureTarget& target, const char* direction) {
  std::string known;
  for (const TargetKind& kind : kKinds) known += fmt::format("{}{}", known.empty() ? "" : ", ", kind.examples);
  return fail(ErrorCode::kBadInput, "{}: \"{}\" is no {} for pictures of this build; expected one as {}",
              target.endpoint, target.name, direction, known);
}

// Moves the option "overwrite" to target.overwrite.
Status take_overwrite(drivers::PictureTarget& target) {
  const auto found = std::find_if(target.options.begin(), target.options.end(),
                                  [](const EndpointOption& option) { return option.key == "overwrite"; });
  if (found == target.options.end()) return {};
  if (found->value != "yes" && found->value != "no") {
    return fail(ErrorCode::kBadInput, "{}: overwrite={}: expected yes or no", target.endpoint, found->value);
  }
  target.overwrite = target.overwrite || found->value == "yes";
  target.options.erase(found);
  return {};
}

}  // namespace

Result<std::unique_ptr<drivers::PictureOutput>> open_picture_output(const drivers::PictureTarget& target) {
  const TargetKind* kind = kind_of_target(target.name);
  if (kind == nullptr || kind->output == nullptr) return unknown_target(target, "output");
  drivers::PictureTarget its = target;
  if (kind->writes_files(its.name)) FL_TRY(take_overwrite(its));
  return kind->output(its);
}

Result<std::unique_ptr<drivers::PictureInput>> open_picture_input(const drivers::PictureTarget& target) {
  const TargetKind* kind = kind_of_target(target.name);
  if (kind == nullptr || kind->input == nullptr) return unknown_target(target, "input");
  return kind->input(target);
}

Result<std::unique_ptr<Sink>> open_picture_sink(const Endpoint& endpoint, bool overwrite) {
  FL_ASSIGN(drivers::VrslOptions options, drivers::vrsl_out_options(endpoint));
  options.target.overwrite = overwrite;
  FL_ASSIGN(auto output, open_picture_output(options.target));
  FL_ASSIGN(auto sink, drivers::VrslSink::open(options, std::move(output)));
  return std::unique_ptr<Sink>(std::move(sink));
}

Result<std::unique_ptr<Source>> open_picture_source(const Endpoint& endpoint) {
  FL_ASSIGN(const drivers::VrslOptions options, drivers::vrsl_in_options(endpoint));
  FL_ASSIGN(auto input, open_picture_input(options.target));
  FL_ASSIGN(auto source, drivers::VrslSource::open(options, std::move(input)));
  return std::unique_ptr<Source>(std::move(source));
}

}  // namespace footlight::tools
