// What the preview prints and saves.
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include <imgui/imgui.h>

#include "tools/footlight/pictures/numbered_file.h"
#include "tools/footlight/pictures/picture_file.h"
#include "tools/footlight/preview/preview_window.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

constexpr int kShotsMax = 9999;

struct Times {
  const FrameTimes& pictures;
  const FrameTimes& turns;   // of the user interface
  const FrameTimes& shows;   // of those that changed the window
  const FrameTimes& panels;  // CPU
};

nlohmann::json figures_of(const PreviewFacts& facts, const Times& times, const render::FrameSettings& settings) {
  nlohmann::json passes = nlohmann::json::object();
  double gpu_ms = 0;
  for (const auto& pass : facts.passes) {
    passes[pass.name] = pass.gpu_ms;
    gpu_ms += pass.gpu_ms;
  }
  nlohmann::json line = {{"frames", times.pictures.count()},
                         {"frame_ms_p50", times.pictures.quantile_ms(0.5)},
                         {"frame_ms_p90", times.pictures.quantile_ms(0.9)},
                         {"ui_frames", times.turns.count()},
                         {"ui_frame_ms_p50", times.turns.quantile_ms(0.5)},
                         {"ui_frame_ms_p90", times.turns.quantile_ms(0.9)},
                         {"ui_frame_ms_p99", times.turns.quantile_ms(0.99)},
                         {"ui_frame_ms_max", times.turns.quantile_ms(1)},
                         {"show_frames", times.shows.count()},
                         {"show_ms_p50", times.shows.quantile_ms(0.5)},
                         {"show_ms_p90", times.shows.quantile_ms(0.9)},
                         {"ui_ms_p50", times.panels.quantile_ms(0.5)},
                         {"ui_ms_p90", times.panels.quantile_ms(0.9)},
                         {"gpu_ms", gpu_ms},
                         {"pass_gpu_ms", passes},
                         {"width", settings.width},
                         {"height", settings.height},
                         {"nodes", settings.nodes},
                         {"live", facts.live_beams},
                         {"dark", facts.dark_beams},
                         {"shadows", facts.shadows},
                         {"shadows_lost", facts.shadows_lost}};
  if (facts.error.samples > 0) {
    line["error"] = {{"rel_l2", facts.error.rel_l2},
                     {"low", facts.error.low},
                     {"high", facts.error.high},
                     {"samples", facts.error.samples}};
  }
  if (facts.edit_to_frame_ms >= 0) line["edit_to_frame_ms"] = facts.edit_to_frame_ms;
  if (facts.chosen) line["knobs"] = render::text_of(facts.chosen->knobs);
  if (facts.machines > 0) {
    line["haze_per_m"] = facts.room_haze_per_m + facts.machine_haze_per_m + facts.machine_fog_per_m;
  }
  return line;
}

// Texts may have names of the user, which need not be UTF-8.
void print_event(const nlohmann::json& line) {
  fmt::print("{}\n", line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  std::fflush(stdout);
}

const char* word_of(DoneCommand::How how) {
  switch (how) {
    case DoneCommand::How::kRun: return "run";
    case DoneCommand::How::kUndo: return "undo";
    case DoneCommand::How::kRedo: return "redo";
  }
  return "";
}

}  // namespace

std::vector<std::uint64_t> Preview::view_pictures() const {
  std::vector<std::uint64_t> pictures;
  for (std::size_t i = 0; i < static_cast<std::size_t>(views()); ++i) pictures.push_back(views_[i].pictures);
  return pictures;
}

void Preview::print_message(const std::string& text, bool wrong) {
  print_event({{"event", "message"}, {"text", text}, {"wrong", wrong}});
}

// What was carried out since the last time. A drag is printed at its end.
void Preview::print_commands() {
  if (options_.json && ImGui::IsAnyMouseDown()) return;
  for (const DoneCommand& done : desk_->take_done()) {
    if (options_.json) print_event({{"event", "command"}, {"how", word_of(done.how)}, {"text", done.text}});
  }
}

void Preview::print_second() {
  nlohmann::json line = figures_of(facts_, {times_, turn_times_, show_times_, ui_times_}, frame_->settings());
  line["event"] = "frames";
  line["fps"] = facts_.fps;
  line["view"] = active_view();
  line["view_pictures"] = view_pictures();
  line["selected"] = desk_->state().selection.fixtures.size();
  line["taken_over"] = desk_->state().taken.size();
  line["fixtures"] = desk_->rig().fixtures.size();
  line["unsaved"] = unsaved();
  line["inputs"] = ins_;
  line["outputs_live"] = outputs_view_.live_count();
  line["blackout"] = outputs_view_.darkness != Darkness::kNone;
  if (player_) line["time_ns"] = player_->now_ns();
  if (player_) line["stands"] = !controls_.transport.playing && !controls_.transport.seek_ns && !player_->seeking();
  if (player_) line["thumbnails"] = thumbnails_.pictures().all().size();
  if (player_) line["thumbnail_ms"] = static_cast<double>(thumbnails_.took_ns()) * 1e-6;
  if (player_ && player_->index() != nullptr) line["indexed_ns"] = player_->index()->known_ns();
  // Names of inputs are the user's, and need not be UTF-8.
  fmt::print("{}\n", line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  std::fflush(stdout);
}

void Preview::print_summary() {
  nlohmann::json line = figures_of(facts_, {times_, turn_times_, show_times_, ui_times_}, frame_->settings());
  const double elapsed_s = static_cast<double>(clock_.now_ns() - start_ns_) * 1e-9;
  line["event"] = "summary";
  line["device"] = device_->name();
  line["seconds"] = elapsed_s;
  line["first_text_ms"] = static_cast<double>(progress_ns_) * 1e-6;
  line["first_picture_ms"] = static_cast<double>(picture_ns_) * 1e-6;
  line["first_whole_picture_ms"] = static_cast<double>(whole_ns_) * 1e-6;
  nlohmann::json start = nlohmann::json::object();
  for (const auto& [ended, ms] : start_marks_) start[ended] = ms;
  line["start_ms"] = start;
  line["fps"] = elapsed_s > 0 ? static_cast<double>(times_.count()) / elapsed_s : 0;
  line["ui_fps"] = elapsed_s > 0 ? static_cast<double>(turn_times_.count()) / elapsed_s : 0;
  line["view_pictures"] = view_pictures();
  if (both_.on()) line["compare_stage"] = word_of(both_.mode());
  if (both_.difference()) {
    line["difference_largest"] = both_.difference()->largest;
    line["difference_mean"] = both_.difference()->mean;
  }
  line["ui_scale"] = window_->ui_scale();
  line["validation_messages"] = validation_messages();
  fmt::print("{}\n", line.dump());
}

// The window as shown; only the picture of a single view if the window system does not allow reading the window.
Status Preview::write_shot() {
  FL_ASSIGN(render::ScreenImage image, window_->read_shot());
  if (image.rgba.empty() && (views() > 1 || both_.on())) {
    return fail(ErrorCode::kUnsupported,
                "{}: this window system does not let windows be read; --views 1 saves one view", options_.screenshot);
  }
  if (image.rgba.empty()) {
    FL_ASSIGN(image, frame_->read_screen());
  }
  return write_png(options_.screenshot, image);
}

// Of key F12: the window as a file of the current folder that did not exist.
void Preview::write_own_shot() {
  const auto write = [&]() -> Result<std::string> {
    FL_ASSIGN(const render::ScreenImage image, window_->read_shot());
    if (image.rgba.empty()) return fail(ErrorCode::kUnsupported, "this window system does not let windows be read");
    for (int number = 1; number <= kShotsMax; ++number) {
      FL_ASSIGN(std::string path, numbered_path("footlight_%04d.png", number));
      std::FILE* file = std::fopen(path.c_str(), "wx");  // fails where the file exists
      if (file == nullptr && errno == EEXIST) continue;
      if (file == nullptr) return fail(ErrorCode::kIo, "{}: {}", path, std::strerror(errno));
      std::fclose(file);
      FL_TRY(write_png(path, image));
      return path;
    }
    return fail(ErrorCode::kIo, "there are {} screenshots in this folder; move some of them", kShotsMax);
  };
  const Result<std::string> path = write();
  if (!path) return tell(path.error());
  tell(trf("saved {}", (std::filesystem::current_path() / *path).string()));
}

}  // namespace footlight::tools
