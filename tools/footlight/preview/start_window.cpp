#include "tools/footlight/preview/start_window.h"

#include <cstdio>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "render/vk/device.h"
#include "sim/system_clock.h"
#include "tools/footlight/paths.h"
#include "tools/footlight/pictures/picture_file.h"
#include "tools/footlight/preview/display_loss.h"
#include "tools/footlight/preview/ui/keys.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/start_screen.h"
#include "tools/footlight/preview/window.h"
#include "tools/footlight/status/printable.h"
#include "tools/footlight/stop_signal.h"

namespace footlight::tools {
namespace {

constexpr double kTurnS = 1.0 / 60;

// As the window's settings have it, or the options.
Result<WindowSettings> settings_of(const PreviewOptions& options) {
  WindowSettings settings;
  if (auto loaded = load_window_settings(window_settings_path(state_folder()))) settings = std::move(*loaded);
  if (!options.theme.empty()) {
    FL_ASSIGN(settings.theme, theme_of(options.theme));
  }
  settings.ui_percent = options.ui_percent.value_or(settings.ui_percent);
  return settings;
}

Status save_picture(Window& window, const std::string& path) {
  FL_ASSIGN(const render::ScreenImage image, window.read_shot());
  if (image.rgba.empty()) {
    return fail(ErrorCode::kUnsupported, "{}: this window system does not let windows be read", path);
  }
  return write_png(path, image);
}

// Keys that act beside fields and dialogs. True: the window is to be closed.
bool take_keys(const Window& window, StartScreen& screen) {
  bool leaves = false;
  for (const KeyPress& key : window.keys()) {
    const auto call = call_of(key);
    if (!call || key.repeated) continue;
    if (call->action == UiAction::kOpen) screen.open_dialog();
    leaves = leaves || call->action == UiAction::kEscape;
  }
  return leaves;
}

}  // namespace

bool needs_start(const PreviewOptions& options) { return options.files.rig.empty() && !options.files.demo; }

Result<StartEnd> run_start_window(const PreviewOptions& options) {
  FL_ASSIGN(const PictureSize size, parse_size(options.size));
  FL_ASSIGN(const WindowSettings settings, settings_of(options));
  StopSignal signal;
  signal.also_hangup();
  SystemClock clock;
  FL_ASSIGN(const std::unique_ptr<Window> window, Window::open("Footlight", size.width, size.height));
  window->set_ui_look(static_cast<float>(settings.ui_percent) / 100, settings.theme);
  render::vk::DeviceOptions wanted;
  wanted.instance_extensions = window->instance_extensions();
  wanted.swapchain = true;
  wanted.name_contains = options.device;
  FL_ASSIGN(const std::unique_ptr<render::vk::Device> device, render::vk::Device::create(wanted));
  const auto detach = [](Window* one) { one->detach(); };  // before the device ends
  const std::unique_ptr<Window, decltype(detach)> attached(window.get(), detach);
  FL_TRY(window->attach(*device));

  StartScreen screen(settings.recent_rigs, settings.recent_logs, options.files.log);
  if (!options.news.empty()) screen.say(printable_utf8(tr_known(options.news)));
  if (options.json) {
    fmt::print("{{\"event\":\"start_screen\"}}\n");
    std::fflush(stdout);
  }
  StartEnd end;
  const TimeNs begun_ns = clock.now_ns();
  bool leaves = false;
  while (!leaves && !end.options) {
    window->poll(kTurnS);
    FL_TRY(check_display());
    end.seconds = static_cast<double>(clock.now_ns() - begun_ns) * 1e-9;
    leaves = signal.came() || window->wants_close() || (options.seconds > 0 && end.seconds >= options.seconds);
    window->begin_ui();
    const bool had_keys = screen.has_keys();
    if (const auto dropped = window->take_drops(); !dropped.empty()) (void)screen.take_files(dropped);
    const auto choice = screen.draw(window->ui_scale());
    if (!had_keys && !screen.has_keys()) leaves = take_keys(*window, screen) || leaves;
    if (leaves) window->keep_shot();
    window->end_ui();
    FL_TRY(window->show({}));
    if (!choice || leaves) continue;
    end.options = options;
    end.options->files.demo = choice->demo;
    end.options->files.rig = choice->rig;
    end.options->files.log = choice->log;
    end.options->news.clear();
  }
  FL_TRY(window->wait_gpu());
  if (leaves && !options.screenshot.empty()) FL_TRY(save_picture(*window, options.screenshot));
  return end;
}

}  // namespace footlight::tools
