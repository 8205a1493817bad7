#include "drivers/vrsl/vrsl_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <span>
#include <type_traits>

namespace footlight::drivers {
namespace {

constexpr double kPicturesHzMin = 0.1, kPicturesHzMax = 240;

std::optional<double> whole_number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

// The numbers between `mark`s, if there are `count` of them.
std::optional<std::vector<double>> numbers_of(std::string_view text, char mark, std::size_t count) {
  std::vector<double> numbers;
  while (true) {
    const std::size_t end = text.find(mark);
    const auto number = whole_number(text.substr(0, end));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    if (end == std::string_view::npos) break;
    text.remove_prefix(end + 1);
  }
  if (numbers.size() != count) return std::nullopt;
  return numbers;
}

// One option after the other; what no call took belongs to the target.
class Taker {
 public:
  explicit Taker(const Endpoint& endpoint) : endpoint_(endpoint), left_(endpoint.options) {}

  std::optional<std::string> take(std::string_view key) {
    const auto found =
        std::find_if(left_.begin(), left_.end(), [&](const EndpointOption& option) { return option.key == key; });
    if (found == left_.end()) return std::nullopt;
    std::string value = found->value;
    left_.erase(found);
    return value;
  }

  template <class Value>
  Status choose(std::string_view key, std::span<const std::type_identity_t<Value>> values, Value& into) {
    const auto text = take(key);
    if (!text) return {};
    std::string known;
    for (const Value value : values) {
      if (name_of(value) == *text) {
        into = value;
        return {};
      }
      known += fmt::format("{}{}", known.empty() ? "" : ", ", name_of(value));
    }
    return wrong(key, *text, known);
  }

  Status choose(std::string_view key, bool& into) {
    const auto text = take(key);
    if (!text) return {};
    if (*text != "yes" && *text != "no") return wrong(key, *text, "yes or no");
    into = *text == "yes";
    return {};
  }

  [[nodiscard]] tl::unexpected<Error> wrong(std::string_view key, std::string_view text,
                                            std::string_view expected) const {
    return fail(ErrorCode::kBadInput, "{}: {}={}: expected {}", endpoint_.text, key, text, expected);
  }

  [[nodiscard]] std::vector<EndpointOption> rest() { return std::move(left_); }

 private:
  const Endpoint& endpoint_;
  std::vector<EndpointOption> left_;
};

constexpr GridLayout kLayouts[] = {GridLayout::kHorizontalBottom, GridLayout::kHorizontalTop, GridLayout::kVerticalLeft,
                                   GridLayout::kVerticalRight};
constexpr GridPlanes kPlanes[] = {GridPlanes::kLuma, GridPlanes::kRgb};
constexpr GridRange kRanges[] = {GridRange::kFull, GridRange::kLimited};
constexpr GridTransfer kTransfers[] = {GridTransfer::kLinear, GridTransfer::kFromSrgb, GridTransfer::kToSrgb};

Status take_size(Taker& taker, GridFormat& format, bool& given) {
  const auto text = taker.take("size");
  if (!text) return {};
  const auto size = numbers_of(*text, 'x', 2);
  const auto is_pixels = [](double number) {
    return number >= 1 && number <= kGridSizeMaxPx && number == std::floor(number);
  };
  if (!size || !is_pixels((*size)[0]) || !is_pixels((*size)[1])) {
    return taker.wrong("size", *text, fmt::format("WIDTHxHEIGHT of at most {}, as in 1920x1080", kGridSizeMaxPx));
  }
  format.width = static_cast<int>((*size)[0]);
  format.height = static_cast<int>((*size)[1]);
  given = true;
  return {};
}

Result<VrslOptions> options_of(const Endpoint& endpoint, bool is_input) {
  VrslOptions options;
  options.universes = endpoint.universes;
  options.target.endpoint = endpoint.text;
  options.target.name = endpoint.target;
  GridFormat& format = options.format;
  const auto above_three = [](const WireUniverse& universe) { return universe.wire > kGridPlaneUniverses; };
  const bool needs_rgb = std::any_of(endpoint.universes.begin(), endpoint.universes.end(), above_three);
  if (needs_rgb) format.planes = GridPlanes::kRgb;

  Taker taker(endpoint);
  const auto layout = taker.take("layout");
  options.find = is_input && layout.value_or("auto") == "auto";
  if (layout && !options.find) {
    const auto found =
        std::find_if(std::begin(kLayouts), std::end(kLayouts), [&](GridLayout one) { return name_of(one) == *layout; });
    if (found == std::end(kLayouts)) {
      return taker.wrong("layout", *layout,
                         fmt::format("horizontal-bottom, horizontal-top, vertical-left, vertical-right{}",
                                     is_input ? " or auto" : ""));
    }
    format.layout = *found;
  }
  FL_TRY(taker.choose("check", format.check_row));
  if (const auto text = taker.take("fps")) {
    const auto rate = whole_number(*text);
    if (!rate || *rate < kPicturesHzMin || *rate > kPicturesHzMax) {
      return taker.wrong("fps", *text, fmt::format("pictures a second, {} to {}", kPicturesHzMin, kPicturesHzMax));
    }
    options.target.pictures_hz = *rate;
  }
  if (options.find) {
    for (const char* const key : {"planes", "range", "transfer", "flip", "size", "place"}) {
      if (const auto value = taker.take(key)) {
        return fail(ErrorCode::kBadInput,
                    "{}: {}={} needs a layout as well, as in layout=horizontal-bottom; without "
                    "one they are searched for",
                    endpoint.text, key, *value);
      }
    }
  } else {
    FL_TRY(taker.choose("planes", std::span(kPlanes), format.planes));
    if (needs_rgb && format.planes == GridPlanes::kLuma) {
      return fail(ErrorCode::kBadInput, "{}: planes=luma carries universes 1 to 3; use planes=rgb for 4 to 9",
                  endpoint.text);
    }
    FL_TRY(taker.choose("range", std::span(kRanges), format.range));
    FL_TRY(taker.choose("transfer", std::span(kTransfers), format.transfer));
    FL_TRY(taker.choose("flip", format.flipped));
    bool sized = false;
    FL_TRY(take_size(taker, format, sized));
    options.any_size = !sized;
    if (const auto text = taker.take("place")) {
      const auto place = numbers_of(*text, ',', 3);
      if (!place) return taker.wrong("place", *text, "LEFT,TOP,CELL in pixels, as in 0,872,16");
      format.place = GridPlace{(*place)[0], (*place)[1], (*place)[2], (*place)[2]};
    }
  }
  options.target.options = taker.rest();
  options.target.grid = format;
  return options;
}

}  // namespace

Result<VrslOptions> vrsl_out_options(const Endpoint& endpoint) {
  FL_ASSIGN(VrslOptions options, options_of(endpoint, false));
  auto codec = GridCodec::make(options.format);
  if (!codec) return fail(ErrorCode::kBadInput, "{}: {}", endpoint.text, codec.error().message);
  for (const WireUniverse& universe : options.universes) {
    if (codec->carries(universe.wire, 1)) continue;
    return fail(ErrorCode::kBadInput,
                "{}: a {} grid does not show universe {}; it ends with address 351 of the second universe of each "
                "colour; use a horizontal layout",
                endpoint.text, name_of(options.format.layout), universe.wire);
  }
  options.target.width = options.format.width;
  options.target.height = options.format.height;
  return options;
}

Result<VrslOptions> vrsl_in_options(const Endpoint& endpoint) { return options_of(endpoint, true); }

}  // namespace footlight::drivers
