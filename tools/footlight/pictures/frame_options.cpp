#include "tools/footlight/pictures/frame_options.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <iterator>
#include <optional>

#include "fixtures/files/toml/scenery_toml.h"
#include "render/display.h"
#include "render/quality.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

// "agx, filmic, reinhard or linear".
std::string tone_words() {
  std::string words;
  const std::size_t count = std::size(render::kToneCurves);
  for (std::size_t i = 0; i < count; ++i) {
    words += i == 0 ? "" : i + 1 < count ? ", " : " or ";
    words += render::word_of(render::kToneCurves[i]);
  }
  return words;
}

}  // namespace

Result<std::uint32_t> parse_edges(const std::string& text) {
  if (text == "off") return 0u;
  if (text == "4") return 4u;
  if (text == "8") return 8u;
  if (text == "16") return 16u;
  return fail(ErrorCode::kBadInput, "--edges {}: expected off, 4, 8 or 16", printable_utf8(text));
}

Result<bool> parse_switch(const char* option, const std::string& text) {
  if (text == "on") return true;
  if (text == "off") return false;
  return fail(ErrorCode::kBadInput, "{} {}: expected on or off", option, printable_utf8(text));
}

Result<render::PictureStyle> parse_style(const std::string& text,
                                         std::initializer_list<std::pair<const char*, bool>> units) {
  auto style = render::picture_style_of(text);
  if (!style) return fail(ErrorCode::kBadInput, "--style {}", printable_utf8(style.error().message));
  for (const auto& [option, is_given] : units) {
    if (!is_given || *style == render::PictureStyle::kPhysical) continue;
    return fail(ErrorCode::kBadInput, "{} and --style {}: a style has neither units nor a stated error; leave out one",
                option, text);
  }
  return style;
}

std::string with_style(std::string settings, render::PictureStyle style) {
  if (style != render::PictureStyle::kPhysical) settings.insert(1, fmt::format(R"("style":"{}",)", word_of(style)));
  return settings;
}

Status take_shadows(const std::string& text, render::FrameSettings& settings) {
  settings.shadows = text != "off";
  settings.shadow_map_px = text == "exact" ? 0 : text == "maps" ? render::kMapUsualPx : render::kShadowsSuited;
  if (text == "on" || text == "off" || text == "exact" || text == "maps") return {};
  for (std::uint32_t px = render::kMapLeastPx; px <= render::kMapMostPx; px *= 2) {
    settings.shadow_map_px = px;
    if (text == fmt::format("maps:{}", px)) return {};
  }
  return fail(ErrorCode::kBadInput,
              "--shadows {}: expected on, off, exact, maps, or maps:N of 16, 32, 64, 128 or 256 texels a side",
              printable_utf8(text));
}

Status take_penumbra(const std::string& text, render::FrameSettings& settings) {
  if (text != "1" && text != "4" && text != "7") {
    return fail(ErrorCode::kBadInput, "--penumbra {}: expected 1, 4 or 7", printable_utf8(text));
  }
  settings.penumbra = static_cast<std::uint32_t>(text[0] - '0');
  if (settings.penumbra > 1 && settings.shadow_map_px != 0 && settings.shadow_map_px != render::kShadowsSuited) {
    return fail(ErrorCode::kBadInput, "--penumbra {}: shadow maps have hard edges; use --shadows exact", text);
  }
  return {};
}

void warn_of_hard_edges(const render::FrameSettings& frame) {
  if (frame.penumbra == 1 || frame.shadow_map_px == 0 || !frame.shadows) return;
  fmt::print(stderr,
             "footlight: shadows have hard edges, since so many things in so many beams get shadow maps; use --shadows "
             "exact for --penumbra {}\n",
             frame.penumbra);
}

void add_reflection_arguments(Arguments& arguments, ReflectionWords& words) {
  arguments.option("--bounce", words.bounce, "WORD", "on; off: boxes and scenery reflect no light to others [on]");
  arguments.option("--reflections", words.reflections, "WORD",
                   "on; off: shiny materials show lamps alone and mirror nothing else; floors with gloss do [on]");
}

Status take_reflections(const ReflectionWords& words, bool& bounce, bool& probes) {
  FL_ASSIGN(bounce, parse_switch("--bounce", words.bounce));
  FL_ASSIGN(probes, parse_switch("--reflections", words.reflections));
  return {};
}

Result<double> parse_glare(const std::string& text) {
  if (text == "off") return 0.0;
  const std::optional<double> share = render::share_of(text);
  if (share && *share >= 0 && *share <= 1) return *share;
  return fail(ErrorCode::kBadInput, "--glare {}: expected off or a share of the light up to 100%, as in 1%",
              printable_utf8(text));
}

Result<double> parse_white_balance(const std::string& text) {
  if (text == "off") return 0.0;
  std::string_view number = text;
  if (number.ends_with('K') || number.ends_with('k')) number.remove_suffix(1);
  double white_k = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), white_k);
  if (error == std::errc{} && end == number.data() + number.size() && white_k >= render::kWhiteMinK &&
      white_k <= render::kWhiteMaxK) {
    return white_k;
  }
  return fail(ErrorCode::kBadInput, "--white-balance {}: expected off or {:g}K to {:g}K, as in 3200K or 5600K",
              printable_utf8(text), render::kWhiteMinK, render::kWhiteMaxK);
}

Result<render::ToneCurve> parse_tone(const std::string& text) {
  if (const auto tone = render::tone_of(text)) return *tone;
  return fail(ErrorCode::kBadInput, "--tone {}: expected {}", printable_utf8(text), tone_words());
}

void add_camera_arguments(Arguments& arguments, CameraWords& words) {
  arguments.option("--glare", words.glare, "SHARE",
                   "share of the light that the camera's lens scatters, as in 1%, or off [1%]");
  arguments.option("--white-balance", words.white_balance, "KELVIN",
                   "light of this colour temperature is shown as white, as in 3200K or 5600K; off: daylight of 6500 K "
                   "is [off]");
  arguments.option("--style", words.style, "WORD", kStyleHelp);
  arguments.option("--tone", words.tone, "WORD", "tone curve: " + tone_words() + " [agx]");
  arguments.option("--f-stop", words.f_stop, "N",
                   "depth of field: focal length over aperture, as in 2.8, of a lens before a sensor 24 mm high; off: "
                   "all is sharp; camera: as the rig's camera says [camera]");
  arguments.option("--focus", words.focus_m, fixtures::kFocusMinM, fixtures::kRigPositionMaxM,
                   "metres from the camera to what is sharp with --f-stop; default: the camera's own");
  arguments.flag("--auto-exposure", words.auto_exposure,
                 "the exposure follows the light (time constant 1 s): 1 % of the pixels are brighter than 1.2 x 2^EV "
                 "cd/m2");
}

Result<std::optional<double>> parse_f_stop(const std::string& text) {
  if (text == "camera") return std::nullopt;
  if (text == "off") return 0.0;
  double f_stop = 0;
  const char* const end = text.data() + text.size();
  const auto [read, error] = std::from_chars(text.data(), end, f_stop);
  if (error == std::errc{} && read == end && f_stop >= fixtures::kFStopMin && f_stop <= fixtures::kFStopMax) {
    return f_stop;
  }
  return fail(ErrorCode::kBadInput, "--f-stop {}: expected camera, off or {} to {}, as in 2.8", printable_utf8(text),
              fixtures::kFStopMin, fixtures::kFStopMax);
}

Status take_lens(const CameraWords& words, const fixtures::Camera& camera, render::FrameSettings& settings) {
  FL_ASSIGN(const std::optional<double> f_stop, parse_f_stop(words.f_stop));
  settings.f_stop = f_stop.value_or(camera.f_stop);
  if (words.focus_m && settings.f_stop == 0) {
    return fail(ErrorCode::kBadInput, "--focus {}: {}, so nothing is out of focus; add --f-stop 2.8", *words.focus_m,
                f_stop ? "--f-stop is off" : fmt::format("the camera {} has no f_stop", printable_utf8(camera.name)));
  }
  const double target_m = glm::distance(camera.position_m, camera.target_m);
  settings.focus_m = std::max(words.focus_m.value_or(camera.focus_m > 0 ? camera.focus_m : target_m),
                              fixtures::kFocusMinM);
  return {};
}

Status take_camera_words(const CameraWords& words, render::FrameSettings& settings) {
  FL_ASSIGN(settings.glare, parse_glare(words.glare));
  FL_ASSIGN(settings.white_k, parse_white_balance(words.white_balance));
  FL_ASSIGN(settings.tone, parse_tone(words.tone));
  settings.auto_exposure = words.auto_exposure;
  return {};
}

}  // namespace footlight::tools
