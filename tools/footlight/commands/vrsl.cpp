// footlight vrsl: checks pictures and ways of pictures for VR Stage Lighting.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "drivers/vrsl/grid_find.h"
#include "drivers/vrsl/vrsl_options.h"
#include "drivers/vrsl/vrsl_source.h"
#include "tools/footlight/command.h"
#include "tools/footlight/vrsl/png_pictures.h"
#include "tools/footlight/vrsl/round_trip.h"
#include "tools/footlight/vrsl/video_check.h"
#include "tools/footlight/vrsl/video_reader.h"
#include "tools/footlight/vrsl/video_ways.h"
#include "tools/footlight/vrsl/vrsl_reading.h"

namespace footlight::tools {
namespace {

using drivers::GridCodec;
using drivers::GridReading;
using nlohmann::json;

struct CheckOptions {
  std::string file;
  std::string format;  // as after "?" of an endpoint; empty: found
  bool levels = false;
  bool json = false;
};

struct Checked {
  GridCodec codec;
  std::vector<std::string> open;
  GridReading reading;
  std::array<std::uint8_t, std::size_t{9} * kSlotCountMax> levels{};
  std::vector<ChannelRange> unread;  // by VRSL
  VrslSeen seen;
  int differ = 0;  // addresses that VRSL reads as another level
};

Result<Checked> check_picture(const drivers::Picture& picture, const std::string& format) {
  drivers::GridFormat chosen;
  std::vector<std::string> open;
  if (format.empty()) {
    FL_ASSIGN(drivers::GridFinding found, drivers::find_grid(picture.view()));
    chosen = found.format;
    open = std::move(found.open);
  } else {
    FL_ASSIGN(const Endpoint endpoint, parse_endpoint("vrsl:1@picture?" + format, {}));
    FL_ASSIGN(const drivers::VrslOptions options, drivers::vrsl_in_options(endpoint));
    if (options.find || !options.target.options.empty()) {
      return fail(ErrorCode::kBadInput,
                  "--format {}: expected options of the grid with a layout, as in layout=vertical-left&planes=rgb",
                  format);
    }
    chosen = options.format;
    chosen.width = picture.width;
    chosen.height = picture.height;
  }
  FL_ASSIGN(GridCodec codec, GridCodec::make(chosen));
  Checked checked{.codec = std::move(codec), .open = std::move(open)};
  FL_TRY(checked.codec.decode(picture.view(), checked.levels, checked.reading));
  checked.unread = vrsl_unread(chosen);
  checked.seen = seen_by_vrsl(checked.codec, picture.view());
  for (int universe = 1; universe <= checked.codec.universe_count(); ++universe) {
    for (int slot = 0; slot < checked.codec.slot_count(universe); ++slot) {
      const auto at = static_cast<std::size_t>((universe - 1) * kSlotCountMax + slot);
      checked.differ += std::lround(255 * checked.seen.values[at]) != checked.levels[at] ? 1 : 0;
    }
  }
  return checked;
}

json json_of(const Checked& checked, const CheckOptions& options) {
  const drivers::GridFormat& format = checked.codec.format();
  const drivers::GridPlace& place = checked.codec.place();
  json universes = json::array();
  for (int universe = 1; universe <= checked.codec.universe_count(); ++universe) {
    const auto at = static_cast<std::size_t>(universe - 1);
    json one = {{"universe", universe},
                {"addresses", checked.codec.slot_count(universe)},
                {"confidence", checked.reading.confidence[at]}};
    if (options.levels) {
      const auto first = checked.levels.begin() + static_cast<std::ptrdiff_t>(at) * kSlotCountMax;
      one["levels"] = std::vector<int>(first, first + checked.codec.slot_count(universe));
    }
    universes.push_back(std::move(one));
  }
  json unread = json::array();
  for (const ChannelRange& range : checked.unread) {
    unread.push_back({{"universe", range.universe}, {"first", range.first}, {"last", range.last}});
  }
  json result = {{"file", options.file},
                 {"width", format.width},
                 {"height", format.height},
                 {"layout", name_of(format.layout)},
                 {"planes", name_of(format.planes)},
                 {"range", name_of(format.range)},
                 {"transfer", name_of(format.transfer)},
                 {"flipped", format.flipped},
                 {"left", place.left},
                 {"top", place.top},
                 {"cell_px", place.cell_width},
                 {"open", checked.open},
                 {"blank", checked.reading.blank},
                 {"universes", std::move(universes)},
                 {"confidence", checked.reading.lowest(checked.codec.universe_count())},
                 {"unreachable", checked.codec.unreachable_count()},
                 {"vrsl_unread", count_of(checked.unread)},
                 {"vrsl_unread_ranges", std::move(unread)},
                 {"vrsl_guard_tripped", checked.seen.guard_tripped},
                 {"vrsl_differs", checked.differ}};
  if (format.check_row) {
    result["damaged"] = checked.reading.damaged;
    if (checked.reading.sequence) result["sequence"] = *checked.reading.sequence;
  }
  return result;
}

void print(const Checked& checked, const CheckOptions& options) {
  const int universes = checked.codec.universe_count();
  fmt::print("{}: {} x {} pixels\n", options.file, checked.codec.format().width, checked.codec.format().height);
  fmt::print("  grid:       {}\n", drivers::text_of(checked.codec));
  for (const std::string& open : checked.open) fmt::print("  open:       {}\n", open);
  std::string carried;
  for (int universe = 1; universe <= universes; ++universe) {
    const int count = checked.codec.slot_count(universe);
    if (count == 0) continue;
    carried += fmt::format("{}{}", carried.empty() ? "" : ", ", universe);
    if (count < kSlotCountMax) carried += fmt::format(" to address {}", count);
  }
  fmt::print("  universes:  {}\n", carried);
  fmt::print("  confidence: {:.2f}, the lowest of its universes{}\n", checked.reading.lowest(universes),
             checked.reading.blank ? "; all levels are 0" : "");
  if (checked.codec.format().check_row) {
    const std::string number = checked.reading.sequence ? fmt::format("number {}, ", *checked.reading.sequence)
                                                        : std::string("not readable, ");
    fmt::print("  check row:  {}{}\n", number, checked.reading.damaged ? "damaged" : "intact");
  }
  fmt::print("  unreadable: {} addresses here (the layout does not carry them), {} more in VRSL\n",
             checked.codec.unreachable_count(), count_of(checked.unread));
  for (const ChannelRange& range : checked.unread) {
    fmt::print("              universe {}: {} to {}\n", range.universe, range.first, range.last);
  }
  fmt::print("  VRSL:       {} addresses are read as another level than here{}\n", checked.differ,
             checked.seen.guard_tripped ? "; its signal detection shows nothing of this picture" : "");
  if (!options.levels) return;
  for (int universe = 1; universe <= universes; ++universe) {
    for (int slot = 0; slot < checked.codec.slot_count(universe); ++slot) {
      const auto level = checked.levels[static_cast<std::size_t>((universe - 1) * kSlotCountMax + slot)];
      if (level != 0) fmt::print("{}.{} {}\n", universe, slot + 1, level);
    }
  }
}

Result<int> check(const CheckOptions& options) {
  if (options.file.empty()) {
    return fail(ErrorCode::kBadInput, "vrsl check: expected a picture, for example 'footlight vrsl check frame.png'");
  }
  if (is_video_name(options.file)) return check_video(options.file, options.format, options.json);
  drivers::Picture picture;
  if (const Status read = read_picture_file(options.file, picture); !read) {
    const bool damaged = read.error().code == ErrorCode::kProtocol;
    return fail(damaged ? ErrorCode::kBadInput : read.error().code, "{}", read.error().message);
  }
  auto checked = check_picture(picture, options.format);
  if (!checked) return fail(checked.error().code, "{}: {}", options.file, checked.error().message);
  if (options.json) {
    fmt::print("{}\n", json_of(*checked, options).dump(-1, ' ', false, json::error_handler_t::replace));
  } else {
    print(*checked, options);
  }
  const bool certain = checked->reading.lowest(checked->codec.universe_count()) >= drivers::kGridConfidenceMin;
  return certain && !checked->reading.damaged ? kExitOk : kExitFailed;
}

struct TripOptions {
  int pictures = 1;
  std::string way;
  bool json = false;
};

Result<int> round_trip(const TripOptions& options) {
  std::vector<PictureWay> ways = plain_ways();
  auto videos = video_ways();
  if (videos) std::move(videos->begin(), videos->end(), std::back_inserter(ways));
  std::string known;
  for (const PictureWay& way : ways) known += fmt::format("{}{}", known.empty() ? "" : ", ", way.name);
  if (!options.way.empty()) {
    std::erase_if(ways, [&](const PictureWay& way) { return way.name != options.way; });
    if (ways.empty() && !videos && is_video_way(options.way)) {
      return fail(videos.error().code, "--way {}: {}", options.way, videos.error().message);
    }
    if (ways.empty()) return fail(ErrorCode::kBadInput, "--way {}: expected one of {}", options.way, known);
  } else if (!videos) {
    fmt::print(stderr, "without the ways of videos: {}\n", videos.error().message);
  }
  FL_ASSIGN(const std::vector<RoundTripRow> rows, round_trips(ways, options.pictures));
  if (!options.json) {
    fmt::print("{:<10} {:<18} {:<5} {:<8} {:<10} {:>6} {:>9} {:>9} {:>5} {:>10} {}\n", "way", "layout", "plane",
               "range", "transfer", "levels", "addresses", "changed", "error", "confidence", "found");
  }
  for (const RoundTripRow& row : rows) {
    if (options.json) {
      fmt::print("{}\n", json{{"way", row.way},
                              {"layout", name_of(row.format.layout)},
                              {"planes", name_of(row.format.planes)},
                              {"range", name_of(row.format.range)},
                              {"transfer", name_of(row.format.transfer)},
                              {"levels_left", row.levels_left},
                              {"addresses", row.addresses},
                              {"unreachable", row.unreachable},
                              {"pictures", row.pictures},
                              {"changed", row.changed},
                              {"error_max", row.error_max},
                              {"confidence", row.confidence},
                              {"found", row.found}}
                             .dump());
      continue;
    }
    fmt::print("{:<10} {:<18} {:<5} {:<8} {:<10} {:>6} {:>9} {:>9} {:>5} {:>10.2f} {}\n", row.way,
               name_of(row.format.layout), name_of(row.format.planes), name_of(row.format.range),
               name_of(row.format.transfer), row.levels_left, row.addresses * row.pictures, row.changed, row.error_max,
               row.confidence, row.found ? "yes" : "no");
  }
  return kExitOk;
}

Result<int> times(int pictures) {
  const PictureTimes times = picture_times(pictures);
  const auto print_row = [](const char* what, double ms) {
    fmt::print("{:<8} {:>8.3f} ms a picture {:>7.1f} % of a core at 60 pictures a second\n", what, ms, 6 * ms);
  };
  print_row("encode", times.encode_ms);
  print_row("decode", times.decode_ms);
  print_row("find", times.find_ms);
  return kExitOk;
}

void add(Arguments& arguments) {
  Arguments checker =
      arguments.subcommand("check", "Show the grid in a picture, its levels, and what VRSL reads of it",
                           "  footlight vrsl check frame.png\n"
                           "  footlight vrsl check screenshot.jpg --json\n"
                           "  footlight vrsl check club.mp4\n"
                           "  footlight vrsl check frame.png --format 'layout=vertical-left&planes=rgb' --levels\n"
                           "Exit code 0 if a grid was found and is readable, 1 if it is damaged, 3 if there is none.");
  auto check_options = std::make_shared<CheckOptions>();
  checker.word("FILE", check_options->file, "a picture (PNG, JPEG) or a video");
  checker.option("--format", check_options->format, "OPTIONS",
                 "options of the grid, as of a vrsl endpoint; default: what is found in the picture");
  checker.flag("--levels", check_options->levels, "all levels above 0 as well, as UNIVERSE.ADDRESS LEVEL");
  checker.flag("--json", check_options->json, "one JSON object");
  checker.job([check_options]() -> Result<int> { return check(*check_options); });

  Arguments tripper = arguments.subcommand(
      "round-trip", "Show how many levels change in pictures, for each format and each way that pictures take",
      "  footlight vrsl round-trip\n"
      "  footlight vrsl round-trip --way yuv420 --pictures 10 --json\n"
      "The columns: levels of 256 that the format keeps apart, addresses sent, those that arrived as another level,\n"
      "the largest error of a level, the lowest confidence, and whether the grid was found without its format.");
  auto trip_options = std::make_shared<TripOptions>();
  tripper.option("--pictures", trip_options->pictures, 1, 1000, "pictures of random levels for each row");
  tripper.option("--way", trip_options->way, "NAME", "only this way");
  tripper.flag("--json", trip_options->json, "one JSON object a line");
  Arguments timer = arguments.subcommand("times", "Show the processor time for pictures of 1920 x 1080, nine universes",
                                         "  footlight vrsl times --pictures 300\n");
  auto timed = std::make_shared<int>(100);
  timer.option("--pictures", *timed, 1, 100'000, "pictures to take the mean of");
  timer.job([timed]() -> Result<int> { return times(*timed); });
  tripper.job([trip_options]() -> Result<int> { return round_trip(*trip_options); });
}

}  // namespace

extern const CommandInfo vrsl_command{
    .name = "vrsl",
    .help = "Check pictures that carry DMX for VR Stage Lighting",
    .examples =
        "  footlight vrsl check frame.png\n"
        "  footlight vrsl round-trip\n"
        "  footlight vrsl times\n"
        "Pictures are made and read by endpoints: 'footlight run --in sacn:1-9 --out vrsl:1-9@frame_%05d.png'.\n",
    .add = add,
};

}  // namespace footlight::tools
