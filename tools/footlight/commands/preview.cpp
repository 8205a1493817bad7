// footlight preview: shows a rig in a window.
#include "tools/footlight/preview/preview.h"

#include <memory>
#include <optional>
#include <string>

#include "tools/footlight/command.h"
#include "tools/footlight/pictures/frame_options.h"
#include "tools/footlight/preview/stage_comparison.h"
#include "tools/footlight/preview/ui/stage_views.h"

namespace footlight::tools {
namespace {

void add_compare(Arguments& arguments, PreviewOptions& options) {
  arguments.option("--compare", options.compare, "LOG",
                   "show the levels of this log beside those of the window, at the same time, with the differences");
  arguments.option("--compare-stage", options.compare_stage, "WORD",
                   "A and B of the comparison on the stage: beside or difference; without --compare A is the first "
                   "moment [off]");
}

// What matters while lamps follow the window.
void add_live(Arguments& arguments, PreviewOptions& options) {
  arguments.list("--output", options.outputs, "ENDPOINT",
                 "output of the picture's levels to real lamps, which sends nothing until it is armed in the window "
                 "(F6); may be given several times");
  arguments.flag("--hold-to-live", options.hold_to_live,
                 "a dead man's switch: armed outputs are live only while the key End is held in the window");
  arguments.flag("--lock", options.locked,
                 "nothing in the window edits the rig or sets levels until Ctrl+Shift+L unlocks it");
}

void add(Arguments& arguments) {
  auto options = std::make_shared<PreviewOptions>();
  auto flashes = std::make_shared<std::string>("warn");
  auto edges = std::make_shared<std::string>();
  auto shadows = std::make_shared<std::string>("on");
  auto penumbra = std::make_shared<std::string>("1");
  auto reflections = std::make_shared<ReflectionWords>();
  auto camera_words = std::make_shared<CameraWords>();
  auto error = std::make_shared<std::string>();
  auto ms = std::make_shared<std::string>();
  auto nodes = std::make_shared<std::optional<int>>();
  auto tile_error = std::make_shared<std::optional<double>>();
  auto body_error = std::make_shared<std::optional<double>>();
  add_scene_arguments(arguments, options->files);
  arguments.list("--in,-i", options->ins, "ENDPOINT", "live input for the rig; may be given several times");
  arguments.option("--socket", options->socket, "FILE",
                   "socket for 'footlight set', fade, blackout and scene: a file, auto or none [auto]");
  arguments.option("--record", options->record, "FILE",
                   "record what the fixtures get to this log, from the first picture on (Ctrl+R ends it)");
  add_compare(arguments, *options);
  arguments.option("--recordings", options->recordings, "FOLDER",
                   "where Ctrl+R puts recordings; default: the folder of the rig's file");
  add_live(arguments, *options);
  arguments.duration("--at", options->at_ns, "start time in the log [0]");
  arguments.option("--camera", options->camera, "NAME", "a camera of the rig; default: its first one");
  arguments.option("--panels", options->panels, "WORDS",
                   "panels that are open at the start: universes, fixtures, inspector, timeline, devices, library, "
                   "messages, keys");
  arguments.list("--library", options->library, "FOLDER", "definitions of fixtures that can be added, too");
  arguments.option("--select", options->select, "NAME", "fixtures that are selected at the start; * for any text");
  arguments.option("--theme", options->theme, "WORD", "dark or light; default: as it was set in the window last");
  arguments.option("--language", options->language, "WORD",
                   "language of the window's words, as de; en: English; default: that of LANGUAGE or LANG");
  arguments.option("--ui-scale", options->ui_percent, kUiPercentMin, kUiPercentMax,
                   "size of panels and text in per cent; default: as it was set in the window last");
  arguments.option("--views", options->views, 1, 4,
                   "views of the stage: 1, 2 or 4; default: as it was set in the window last");
  arguments.flag("--handles", options->handles, "show the handles that move and aim selected fixtures (key G)");
  arguments.option("--work-light", options->work_light_lx, 0, 1e6,
                   "lx on every surface, key W turns it off and on; default without input: 150 or more");
  arguments.option("--flashes", *flashes, "WORD",
                   "harmful flashes (more than three a second): warn, limit (holds the last picture) or off [warn]");
  arguments.option("--size", options->size, "WxH", "size of the window in pixels");
  arguments.option(
      "--error", *error, "SHARE",
      "relative L2 error of the light, as in 0.1%: the cheapest knobs by what this machine was measured to "
      "need (seconds, the first time)");
  arguments.option("--ms", *ms, "MS",
                   "GPU time of a picture, as in 8: the best knobs that keep it, adapted all the time");
  arguments.option("--nodes", *nodes, 1, 8, "Gauss nodes per beam and pixel, see footlight report [3]");
  arguments.option("--tile-error", *tile_error, 0, 1,
                   "error that taking beams together for tiles may add, as a share of the light; 0: pixel by pixel "
                   "[0.004]");
  arguments.option("--body-error", *body_error, 0, 1000,
                   "error of fixture bodies in pixels, for fewer triangles; 0: whole models [0.5]");
  arguments.option("--edges", *edges, "WORD",
                   "samples of each pixel that shows the edge of something solid: 4, 8 or 16; off: jagged edges; "
                   "default: 16 on a GPU, 4 on a CPU");
  arguments.option("--shadows", *shadows, "WORD", kShadowsHelp);
  arguments.option("--penumbra", *penumbra, "POINTS", kPenumbraHelp);
  add_reflection_arguments(arguments, *reflections);
  add_camera_arguments(arguments, *camera_words);
  arguments.option("--device", options->device, "TEXT", "the Vulkan device whose name contains this text");
  arguments.option("--seconds", options->seconds, 0, 1e6, "close after this time; 0: stay open");
  arguments.option("--screenshot", options->screenshot, "FILE", "write the last frame as PNG when closing");
  arguments.flag("--recover", options->recover, "open the edits of this rig that a session lost when it was killed");
  arguments.flag("--json", options->json, "frame times as JSON, one object a second and a summary");
  arguments.duration("--period", options->json_period_ns, "--json: time between two objects, 100ms to 1h [1s]");
  arguments.job([=]() -> Result<int> {
    if (options->json_period_ns < kNsPerS / 10 || options->json_period_ns > 3600 * kNsPerS) {
      return fail(ErrorCode::kBadInput, "--period: expected 100ms to 1h");
    }
    if (!edges->empty()) {
      FL_ASSIGN(options->edge_samples, parse_edges(*edges));
    }
    if (options->views && !is_view_count(*options->views)) {
      return fail(ErrorCode::kBadInput, "--views {}: expected 1, 2 or 4", *options->views);
    }
    FL_TRY(stage_compare_of(options->compare_stage));
    FL_TRY(take_shadows(*shadows, options->display));
    FL_ASSIGN(options->style, parse_style(camera_words->style, {{"--error", !error->empty()}, {"--ms", !ms->empty()}}));
    FL_TRY(take_penumbra(*penumbra, options->display));
    FL_TRY(take_reflections(*reflections, options->bounce, options->probes));
    FL_TRY(take_camera_words(*camera_words, options->display));
    FL_TRY(parse_f_stop(camera_words->f_stop));
    options->camera_words = *camera_words;
    FL_ASSIGN(options->flashes, flash_mode_of(*flashes));
    FL_ASSIGN(options->quality, render::parse_quality(*error, *ms));
    if ((!error->empty() || !ms->empty()) && (*nodes || *tile_error || *body_error)) {
      return fail(ErrorCode::kBadInput, "{} and {}: expected one of them; {} sets it",
                  error->empty() ? "--ms" : "--error",
                  *nodes ? "--nodes" : (*tile_error ? "--tile-error" : "--body-error"),
                  error->empty() ? "--ms" : "--error");
    }
    options->nodes = nodes->value_or(options->nodes);
    options->tile_error = tile_error->value_or(options->tile_error);
    options->body_error_px = body_error->value_or(options->body_error_px);
    return run_preview(*options);
  });
}

}  // namespace

extern const CommandInfo preview_command{
    .name = "preview",
    .help = "Show a rig in a window: from a log, live from the network or a device, or with faders",
    .examples =
        "  footlight preview                                   a start screen: the demo, recent rigs, a file\n"
        "  footlight preview --demo\n"
        "  footlight preview rig.toml --log show.dmxlog --at 12.5s\n"
        "  footlight preview rig.toml --in sacn:1-9            live\n"
        "  footlight preview rig.toml --in sacn:1-9 --ms 8     as exact as 8 ms of the GPU allow\n"
        "  footlight preview rig.toml --in enttec-pro --in artnet:2-9\n"
        "  footlight preview rig.toml --in sacn:1-9 --output enttec-pro    F6 arms it for real lamps\n"
        "  footlight preview show.mvr                          with faders\n"
        "  footlight preview head.gdtf                         one fixture alone\n"
        "  footlight preview --demo --panels universes,inspector --select 'Spot 1'\n"
        "Click selects a fixture, left drag orbits, right drag pans, the wheel zooms. Keys: F1 lists them all, F2 the\n"
        "universes, F3 the fixtures, F4 the inspector, F6 inputs and outputs, F7 the library, Ctrl+P finds actions,\n"
        "B is the blackout of outputs, 1-9 cameras, F frames what is selected, Ctrl+Z undoes, H hides the side\n"
        "panel, Esc closes. docs/window.md says more. Without a display use footlight render.",
    .add = add,
};

}  // namespace footlight::tools
