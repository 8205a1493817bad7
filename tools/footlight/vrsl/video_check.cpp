#include "tools/footlight/vrsl/video_check.h"

#include <cstdio>

#include <nlohmann/json.hpp>

#include "tools/footlight/command.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/vrsl/video_log.h"

namespace footlight::tools {
namespace {

std::uint64_t left_out(const VideoLogReport& report) {
  return report.video.damaged + report.grids.no_grid + report.grids.uncertain + report.grids.damaged;
}

std::uint64_t all_pictures(const VideoLogReport& report) { return report.video.pictures + report.video.damaged; }

double share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

nlohmann::json json_of_video(const std::string& path, const VideoLogReport& report) {
  nlohmann::json universes = nlohmann::json::array();
  for (std::size_t i = 0; i < report.universes.size(); ++i) {
    const UniverseConfidence& one = report.universes[i];
    if (one.frames == 0) continue;
    universes.push_back({{"universe", i + 1},
                         {"frames", one.frames},
                         {"left_out", one.left_out},
                         {"confidence", one.mean},
                         {"confidence_min", one.lowest}});
  }
  const drivers::GridFormat& format = report.codec->format();
  return {{"file", path},
          {"codec", report.facts.codec},
          {"pixels", report.facts.pixel_format},
          {"width", format.width},
          {"height", format.height},
          {"pictures_hz", report.facts.pictures_hz},
          {"luma_range", report.facts.range},
          {"matrix", report.facts.matrix},
          {"transfer_stated", report.facts.transfer},
          {"layout", name_of(format.layout)},
          {"planes", name_of(format.planes)},
          {"range", name_of(format.range)},
          {"transfer", name_of(format.transfer)},
          {"flipped", format.flipped},
          {"universes", std::move(universes)},
          {"pictures", all_pictures(report)},
          {"used", report.grids.used},
          {"repeated", report.grids.repeated},
          {"no_grid", report.grids.no_grid},
          {"uncertain", report.grids.uncertain},
          {"damaged", report.video.damaged + report.grids.damaged},
          {"other_grids", report.other_grids},
          {"damaged_share", share(report.video.damaged + report.grids.damaged, all_pictures(report))},
          {"longest_gap_s", static_cast<double>(report.longest_gap_ns) * 1e-9},
          {"cut_off", report.video.cut_off}};
}

void print_video(const std::string& path, const VideoLogReport& report) {
  const VideoFacts& facts = report.facts;
  fmt::print("{}: {} x {} pixels, {} {}, {:.2f} pictures a second\n", path, facts.width, facts.height, facts.codec,
             facts.pixel_format, facts.pictures_hz);
  fmt::print("  states:     luma range {}, matrix {}, transfer {}\n", facts.range, facts.matrix, facts.transfer);
  fmt::print("  grid:       {}\n", drivers::text_of(*report.codec));
  if (report.other_grids > 0) fmt::print("              {} pictures have another one\n", report.other_grids);
  for (std::size_t i = 0; i < report.universes.size(); ++i) {
    const UniverseConfidence& one = report.universes[i];
    if (one.frames == 0) continue;
    fmt::print("  universe {}: confidence {:.2f} in the mean, {:.2f} at least; {} of {} pictures left out\n", i + 1,
               one.mean, one.lowest, one.left_out, one.frames);
  }
  fmt::print("  pictures:   {}, {} of them used; longest gap {}\n", all_pictures(report), report.grids.used,
             show_duration(report.longest_gap_ns));
  const std::uint64_t damaged = report.video.damaged + report.grids.damaged;
  fmt::print("  damaged:    {} ({:.2f} %), {} without a grid, {} lost by their check rows{}\n", damaged,
             100 * share(damaged, all_pictures(report)), report.grids.no_grid, report.grids.lost,
             report.video.cut_off ? "; the video ends early" : "");
}

}  // namespace

Result<int> check_video(const std::string& path, const std::string& format, bool json) {
  FL_ASSIGN(const std::unique_ptr<VideoLog> video, open_video_log(path, format, "--format"));
  FrameView frame;
  while (true) {
    FL_ASSIGN(const bool more, video->next(frame));
    if (!more) break;
  }
  const VideoLogReport report = video->report();
  if (json) {
    fmt::print("{}\n", json_of_video(path, report).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  } else {
    print_video(path, report);
  }
  bool whole = left_out(report) == 0 && !report.video.cut_off;
  for (const UniverseConfidence& one : report.universes) whole = whole && one.left_out == 0;
  return whole ? kExitOk : kExitFailed;
}

}  // namespace footlight::tools
