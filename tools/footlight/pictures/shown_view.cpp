#include "tools/footlight/pictures/shown_view.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

namespace footlight::tools {
namespace {

template <class Value>
Values values_of(const render::RadianceImage& image, const Value& value) {
  Values values{image.width, image.height, {}};
  values.values.reserve(image.rgb.size() / 3);
  for (std::size_t i = 0; i + 2 < image.rgb.size(); i += 3) {
    values.values.push_back(value(image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]));
  }
  return values;
}

void push(render::ScreenImage& screen, const glm::dvec3& color) {
  for (int c = 0; c < 3; ++c) {
    screen.rgba.push_back(static_cast<std::uint8_t>(std::lround(255 * std::clamp(color[c], 0.0, 1.0))));
  }
  screen.rgba.push_back(255);
}

// The colour of a place on the scale, 0 to 1.
glm::dvec3 heat(double at) {
  constexpr std::array<glm::dvec3, 5> kStops{glm::dvec3{0.05, 0.05, 0.45}, glm::dvec3{0.0, 0.5, 0.9},
                                             glm::dvec3{0.1, 0.75, 0.25}, glm::dvec3{1.0, 0.85, 0.1},
                                             glm::dvec3{0.9, 0.1, 0.05}};
  const double place = std::clamp(at, 0.0, 1.0) * (kStops.size() - 1);
  const auto first = std::min(static_cast<std::size_t>(place), kStops.size() - 2);
  return glm::mix(kStops[first], kStops[first + 1], place - static_cast<double>(first));
}

}  // namespace

Result<ShownView> shown_view_of(std::string_view word) {
  constexpr std::pair<std::string_view, ShownView> kWords[] = {{"picture", ShownView::kPicture},
                                                               {"classes", ShownView::kClasses},
                                                               {"hits", ShownView::kHits},
                                                               {"steps", ShownView::kSteps},
                                                               {"lux", ShownView::kLux},
                                                               {"error", ShownView::kError}};
  for (const auto& [name, view] : kWords) {
    if (word == name) return view;
  }
  return fail(ErrorCode::kBadInput, "--show {}: expected picture, classes, hits, steps, lux or error", word);
}

Result<std::pair<int, int>> parse_probe(const std::string& probe) {
  int x = -1;
  int y = -1;
  const char* end = probe.data() + probe.size();
  const auto first = std::from_chars(probe.data(), end, x);
  const bool comma = first.ec == std::errc{} && first.ptr != end && *first.ptr == ',';
  const auto second = comma ? std::from_chars(first.ptr + 1, end, y) : first;
  if (!comma || second.ec != std::errc{} || second.ptr != end || x < 0 || y < 0) {
    return fail(ErrorCode::kBadInput, "--probe {}: expected X,Y in pixels from the top left, as in 640,360", probe);
  }
  return std::pair{x, y};
}

Result<render::FrameView> frame_view_of(ShownView shown, bool has_panes) {
  switch (shown) {
    case ShownView::kClasses:
    case ShownView::kHits: return render::FrameView::kClasses;
    case ShownView::kLux: return render::FrameView::kLux;
    case ShownView::kSteps:
      if (!has_panes) {
        return fail(ErrorCode::kBadInput, "--show steps: no pane; expected a rig with [[pane]], see docs/shafts.md");
      }
      return render::FrameView::kSteps;
    case ShownView::kPicture:
    case ShownView::kError: break;
  }
  return render::FrameView::kPicture;
}

Values hits_of(const render::RadianceImage& classes) {
  return values_of(classes, [](float r, float g, float b) { return r + g + b; });
}

Values lux_of(const render::RadianceImage& lux) {
  return values_of(lux, [](float r, float g, float b) { return 0.2126f * r + 0.7152f * g + 0.0722f * b; });
}

Values error_of(const render::RadianceImage& frame, const render::RadianceImage& reference) {
  double sum = 0;
  for (const float v : reference.rgb) sum += std::abs(v);
  const double floor = 0.01 * sum / static_cast<double>(std::max<std::size_t>(reference.rgb.size(), 1));
  Values errors{frame.width, frame.height, {}};
  errors.values.reserve(frame.rgb.size() / 3);
  for (std::size_t i = 0; i + 2 < frame.rgb.size(); i += 3) {
    double worst = 0;
    for (std::size_t c = i; c < i + 3; ++c) {
      const double difference = std::abs(static_cast<double>(frame.rgb[c]) - reference.rgb[c]);
      if (difference == 0) continue;
      const double error = difference / (std::abs(static_cast<double>(reference.rgb[c])) + floor);
      worst = error > worst || std::isnan(error) ? error : worst;
    }
    errors.values.push_back(static_cast<float>(worst));
  }
  return errors;
}

render::ScreenImage class_picture(const render::RadianceImage& classes) {
  const Values hits = hits_of(classes);
  float most = 1;
  for (const float h : hits.values) most = std::max(most, h);
  render::ScreenImage screen{classes.width, classes.height, {}};
  screen.rgba.reserve(4 * hits.values.size());
  for (std::size_t i = 0; i < hits.values.size(); ++i) {
    const glm::dvec3 counts(classes.rgb[3 * i], classes.rgb[3 * i + 1], classes.rgb[3 * i + 2]);
    const double all = hits.values[i];
    // A single beam shows as well: 0.3 of full.
    const double bright = all > 0.5 ? 0.3 + 0.7 * std::log(all) / std::log(std::max<double>(most, 2)) : 0;
    push(screen, all > 0.5 ? bright * counts / all : glm::dvec3(0));
  }
  return screen;
}

render::ScreenImage heat_picture(const Values& values, double low, double high) {
  render::ScreenImage screen{values.width, values.height, {}};
  screen.rgba.reserve(4 * values.values.size());
  for (const float v : values.values) {
    if (!std::isfinite(v)) {
      push(screen, glm::dvec3(1));
    } else if (!(v >= low)) {
      push(screen, glm::dvec3(0));
    } else {
      push(screen, heat(std::log(v / low) / std::log(high / low)));
    }
  }
  return screen;
}

ClassShares class_shares(const render::RadianceImage& classes) {
  glm::dvec3 sum(0);
  for (std::size_t i = 0; i + 2 < classes.rgb.size(); i += 3) {
    sum += glm::dvec3(classes.rgb[i], classes.rgb[i + 1], classes.rgb[i + 2]);
  }
  const double all = sum.x + sum.y + sum.z;
  if (!(all > 0)) return {};
  return {3 * all / static_cast<double>(classes.rgb.size()), sum.x / all, sum.y / all, sum.z / all};
}

}  // namespace footlight::tools
