// footlight clip: what a display shows of a video file, and the processor time that it takes.
#include <algorithm>
#include <ctime>
#include <memory>
#include <optional>

#include <nlohmann/json.hpp>

#include "fixtures/model/color.h"
#include "tools/footlight/command.h"
#include "tools/footlight/displays/clip.h"
#include "tools/footlight/displays/picture_light.h"

namespace footlight::tools {
namespace {

struct Options {
  std::string file;
  int pictures = 100;
  std::optional<int> columns;
  std::optional<int> rows;
  double gamma = 0;
  bool json = false;
};

struct Measured {
  int pictures = 0;
  double decode_ms = 0;  // processor time of a picture, with its colours as RGB
  double light_ms = 0;   // with the means of pixels
  glm::dvec3 mean{0};    // share of white
  double least = 1;      // of the means of pictures, of their luminance
  double most = 0;
};

double cpu_ms() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

Result<Measured> measure(Clip& clip, const Options& options, int columns, int rows) {
  const LightCurve256 curve = light_curve(options.gamma);
  fixtures::PaneImage light;
  Measured sum;
  sum.pictures = static_cast<int>(std::min(static_cast<std::size_t>(options.pictures), clip.count()));
  for (int i = 0; i < sum.pictures; ++i) {
    const double start_ms = cpu_ms();
    FL_ASSIGN(const drivers::Picture* const picture, clip.picture(static_cast<std::size_t>(i)));
    const double decoded_ms = cpu_ms();
    set_light(*picture, curve, columns, rows, light);
    sum.light_ms += cpu_ms() - decoded_ms;
    sum.decode_ms += decoded_ms - start_ms;
    glm::dvec3 mean(0);
    for (const glm::vec3& texel : light.texels) mean += glm::dvec3(texel);
    mean /= static_cast<double>(light.texels.size());
    sum.mean += mean;
    const double luminance = fixtures::luminance(mean);
    sum.least = std::min(sum.least, luminance);
    sum.most = std::max(sum.most, luminance);
  }
  sum.decode_ms /= sum.pictures;
  sum.light_ms /= sum.pictures;
  sum.mean /= sum.pictures;
  return sum;
}

void print(const Options& options, const Clip& clip, const Measured& measured, int columns, int rows) {
  const VideoFacts& facts = clip.facts();
  const double seconds = static_cast<double>(clip.duration_ns()) * 1e-9;
  if (options.json) {
    const nlohmann::json line = {{"event", "clip"},
                                 {"file", options.file},
                                 {"container", facts.container},
                                 {"codec", facts.codec},
                                 {"pixel_format", facts.pixel_format},
                                 {"transfer", facts.transfer},
                                 {"width", facts.width},
                                 {"height", facts.height},
                                 {"pictures", clip.count()},
                                 {"duration_s", seconds},
                                 {"replaced", clip.replaced()},
                                 {"measured", measured.pictures},
                                 {"columns", columns},
                                 {"rows", rows},
                                 {"mean", {measured.mean.r, measured.mean.g, measured.mean.b}},
                                 {"least", measured.least},
                                 {"most", measured.most},
                                 {"decode_ms", measured.decode_ms},
                                 {"light_ms", measured.light_ms}};
    fmt::print("{}\n", line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    return;
  }
  fmt::print("{}: {}x{}, {} ({}) in {}, {} pictures in {:.3f} s\n", options.file, facts.width, facts.height,
             facts.codec, facts.pixel_format, facts.container, clip.count(), seconds);
  fmt::print("first {} pictures, as {}x{} pixels of a display:\n", measured.pictures, columns, rows);
  fmt::print("  mean light    {:.4f} {:.4f} {:.4f} of white (red, green, blue); pictures from {:.4f} to {:.4f}\n",
             measured.mean.r, measured.mean.g, measured.mean.b, measured.least, measured.most);
  fmt::print("  damaged       {} of all pictures so far; the last whole one stays in their place\n", clip.replaced());
  fmt::print("  processor     {:.2f} ms to decode a picture, {:.2f} ms for its light\n", measured.decode_ms,
             measured.light_ms);
}

Result<int> show_clip(const Options& options) {
  if (options.file.empty()) {
    return fail(ErrorCode::kBadInput, "clip: expected a video, for example 'footlight clip clip.mp4'");
  }
  FL_ASSIGN(const auto clip, Clip::open(options.file));
  const VideoFacts& facts = clip->facts();
  const int columns = options.columns.value_or(std::min(facts.width, fixtures::kDisplaySideMax));
  const int rows = options.rows.value_or(std::min(facts.height, fixtures::kDisplaySideMax));
  FL_ASSIGN(const Measured measured, measure(*clip, options, columns, rows));
  print(options, *clip, measured, columns, rows);
  return clip->replaced() == 0 ? kExitOk : kExitFailed;
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  arguments.word("FILE", options->file, "a video");
  arguments.option("--pictures", options->pictures, 1, 1'000'000, "the first so many pictures are measured");
  arguments.option("--columns", options->columns, 1, fixtures::kDisplaySideMax,
                   "pixels of the display; default: those of the video");
  arguments.option("--rows", options->rows, 1, fixtures::kDisplaySideMax, "likewise, down");
  arguments.option("--gamma", options->gamma, 0, 4, "light is a code's share of 255 to this power; 0: as sRGB");
  arguments.flag("--json", options->json, "one JSON object");
  arguments.job([options]() -> Result<int> { return show_clip(*options); });
}

}  // namespace

extern const CommandInfo clip_command{
    .name = "clip",
    .help = "Check a video for the displays of a rig: its pictures, their light and the time that they take",
    .examples =
        "  footlight clip clip.mp4\n"
        "  footlight clip clip.mp4 --columns 480 --rows 270 --pictures 1000\n"
        "Exit code 1 if one of the pictures that were read is damaged; --pictures N reads more.\n"
        "A rig names the video: [[display]] video = \"clip.mp4\".\n",
    .add = add,
};

}  // namespace footlight::tools
