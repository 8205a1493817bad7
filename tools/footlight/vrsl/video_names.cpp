// What needs no library: names of targets, and options of videos.
#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

#include "fixtures/files/import/text.h"
#include "sim/file_kind.h"
#include "tools/footlight/vrsl/video_output.h"
#include "tools/footlight/vrsl/video_reader.h"
#include "tools/footlight/vrsl/vrsl_window.h"

namespace footlight::tools {
namespace {

constexpr std::array<std::string_view, 10> kVideoEndings = {".mp4", ".mkv", ".webm", ".mov", ".m4v",
                                                            ".ts",  ".flv", ".avi",  ".mpg", ".h264"};
constexpr std::array<std::string_view, 9> kPresets = {"ultrafast", "superfast", "veryfast", "faster",  "fast",
                                                      "medium",    "slow",      "slower",   "veryslow"};

Result<int> number_option(const drivers::PictureTarget& target, const EndpointOption& option, int min, int max) {
  int number = 0;
  const char* const end = option.value.data() + option.value.size();
  const auto read = std::from_chars(option.value.data(), end, number);
  if (read.ec == std::errc() && read.ptr == end && number >= min && number <= max) return number;
  return fail(ErrorCode::kBadInput, "{}: {}: expected a number from {} to {}, got \"{}\"", target.endpoint, option.key,
              min, max, option.value);
}

// The place of the value among `words`.
template <std::size_t kCount>
Result<std::size_t> word_option(const drivers::PictureTarget& target, const EndpointOption& option,
                                const std::array<std::string_view, kCount>& words) {
  const auto found = std::find(words.begin(), words.end(), option.value);
  if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
  std::string known;
  for (const std::string_view word : words) known += fmt::format("{}{}", known.empty() ? "" : ", ", word);
  return fail(ErrorCode::kBadInput, "{}: {}: expected one of {}, got \"{}\"", target.endpoint, option.key, known,
              option.value);
}

}  // namespace

bool is_video_name(std::string_view name) {
  const std::string lower = fixtures::lower(name);
  return std::any_of(kVideoEndings.begin(), kVideoEndings.end(),
                     [&](std::string_view ending) { return lower.ends_with(ending); });
}

bool is_window_target(std::string_view name) { return name == "window"; }

bool is_video_target(std::string_view name) {
  std::error_code ignored;
  return name == "-" || is_video_name(name) || std::filesystem::is_fifo(name, ignored);
}

Result<VideoSettings> read_video_settings(const drivers::PictureTarget& target) {
  VideoSettings settings;
  bool has_quality = false;
  for (const EndpointOption& option : target.options) {
    if (option.key == "quality") {
      FL_ASSIGN(settings.quality, number_option(target, option, 0, 51));
      has_quality = true;
    } else if (option.key == "bitrate") {
      FL_ASSIGN(settings.bitrate_kbps, number_option(target, option, 10, 200'000));
    } else if (option.key == "lossless") {
      constexpr std::array<std::string_view, 2> kWords = {"no", "yes"};
      FL_ASSIGN(const std::size_t place, word_option(target, option, kWords));
      settings.lossless = place == 1;
    } else if (option.key == "luma") {
      constexpr std::array<std::string_view, 2> kWords = {"limited", "full"};
      FL_ASSIGN(const std::size_t place, word_option(target, option, kWords));
      settings.full_range = place == 1;
    } else if (option.key == "preset") {
      FL_ASSIGN(const std::size_t place, word_option(target, option, kPresets));
      settings.preset = kPresets[place];
    } else {
      return drivers::unused_option(target, option.key);
    }
  }
  if (settings.lossless + has_quality + (settings.bitrate_kbps != 0) > 1) {
    return fail(ErrorCode::kBadInput, "{}: quality, bitrate and lossless exclude each other; name one",
                target.endpoint);
  }
  return settings;
}

}  // namespace footlight::tools
