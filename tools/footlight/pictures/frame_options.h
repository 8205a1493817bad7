// Options of a frame that `render` and `preview` share. kBadInput names the option and what is expected.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>

#include "fixtures/model/rig.h"
#include "render/rivals/picture_style.h"
#include "render/settings.h"
#include "sim/core/result.h"
#include "tools/footlight/command.h"

namespace footlight::tools {

// true of "on", false of "off". option: as the command line has it.
[[nodiscard]] Result<bool> parse_switch(const char* option, const std::string& text);
// FrameSettings::edge_samples of "off", "4", "8" or "16".
[[nodiscard]] Result<std::uint32_t> parse_edges(const std::string& text);
// FrameSettings::shadows and shadow_map_px of "on", "off", "exact", "maps" or "maps:N".
Status take_shadows(const std::string& text, render::FrameSettings& settings);
inline constexpr const char* kShadowsHelp =
    "exact: cut at the edges of what hides light; maps or maps:N: by shadow maps of 64 or N texels a side, whose time "
    "grows little with the number of things; on: as suits the rig, and in a window without a GPU maps; off: beams pass "
    "through boxes and fixtures, what they reflect does not [on]";
// "physical", "vrsl" or "card". The latter two fail if one of `units` is given: options that need units or an error.
[[nodiscard]] Result<render::PictureStyle> parse_style(const std::string& text,
                                                       std::initializer_list<std::pair<const char*, bool>> units = {});
// The JSON object of render::json_of(), with the style if that is not physical.
[[nodiscard]] std::string with_style(std::string settings, render::PictureStyle style);
inline constexpr const char* kStyleHelp =
    "physical; vrsl: cones and spots by the formulas of VR Stage Lighting, without shadows; card: a flat fan of light "
    "for each beam; the latter two have no unit and no stated error [physical]";
// FrameSettings::penumbra of "1", "4" or "7". After take_shadows(): fails where that chose shadow maps and the edges
// are not hard.
Status take_penumbra(const std::string& text, render::FrameSettings& settings);
// Writes a warning to standard error where a frame has shadow maps, so that soft edges were not made.
void warn_of_hard_edges(const render::FrameSettings& frame);
inline constexpr const char* kPenumbraHelp =
    "points of each lens from which shadows are cast: 4 or 7 give soft edges in about 4 or 7 times the time of "
    "shadows; 1: hard edges [1]";
// FrameSettings::bounce and probes, "on" or "off".
struct ReflectionWords {
  std::string bounce = "on";
  std::string reflections = "on";
};
void add_reflection_arguments(Arguments& arguments, ReflectionWords& words);
[[nodiscard]] Status take_reflections(const ReflectionWords& words, bool& bounce, bool& probes);
// FrameSettings::glare of "off", "1%" or "0.01".
[[nodiscard]] Result<double> parse_glare(const std::string& text);

// FrameSettings::white_k of "off", "5600K" or "5600".
[[nodiscard]] Result<double> parse_white_balance(const std::string& text);
// FrameSettings::tone of the word of a curve.
[[nodiscard]] Result<render::ToneCurve> parse_tone(const std::string& text);

// What the camera makes of light, as words of the command line: glare, white balance, tone curve, automatic exposure.
struct CameraWords {
  std::string glare = "1%";
  std::string white_balance = "off";
  std::string tone = "agx";
  bool auto_exposure = false;
  std::string style = "physical";
  std::string f_stop = "camera";
  std::optional<double> focus_m;
};
void add_camera_arguments(Arguments& arguments, CameraWords& words);
Status take_camera_words(const CameraWords& words, render::FrameSettings& settings);
// Of "off", which is 0, or "2.8"; nothing of "camera", whose own it is.
[[nodiscard]] Result<std::optional<double>> parse_f_stop(const std::string& text);
// Depth of field of the words, or else of the camera. kBadInput for a word that is no f-stop, and for a focus without
// one.
Status take_lens(const CameraWords& words, const fixtures::Camera& camera, render::FrameSettings& settings);

}  // namespace footlight::tools
