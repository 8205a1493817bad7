#include "render/reference/report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>
#include <variant>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace footlight::render {
namespace {

// A row as names and values. Every writer uses this list, so all outputs have the same fields.
using Value = std::variant<std::string, double, std::int64_t>;
using Fields = std::vector<std::pair<const char*, Value>>;

Fields fields_of(const PictureRow& row) {
  return {{"scene", row.scene},
          {"method", row.method},
          {"knob", row.knob},
          {"hits_per_px", row.hits_per_px},
          {"ms_p10", row.ms_p10},
          {"ms_p50", row.ms_p50},
          {"ms_p90", row.ms_p90},
          {"own_ms", row.own_ms},
          {"rel_l2", row.rel_l2},
          {"rel_l2_low", row.rel_l2_low},
          {"rel_l2_high", row.rel_l2_high},
          {"rel_mse", row.rel_mse},
          {"p999", row.p999},
          {"max", row.max},
          {"flip", row.flip},
          {"nonfinite", row.nonfinite},
          {"bytes", row.bytes}};
}

Fields fields_of(const TimeRow& row) {
  return {{"model", row.model},
          {"method", row.method},
          {"knob", row.knob},
          {"tau_ms", row.tau_ms},
          {"fps", row.fps},
          {"seconds", row.seconds},
          {"error_max", row.error_max},
          {"unit", row.unit},
          {"rel_l2", row.rel_l2},
          {"ns_p10", row.ns_p10},
          {"ns_p50", row.ns_p50},
          {"ns_p90", row.ns_p90},
          {"clock", std::string(row.ns_p50 > 0 ? is_unstable(row) ? "unstable" : "steady" : "-")},
          {"outcome", std::string(word_of(row.outcome))}};
}

struct ToText {
  std::string operator()(const std::string& v) const { return v; }
  std::string operator()(double v) const { return std::isnan(v) ? "-" : fmt::format("{:.4g}", v); }
  std::string operator()(std::int64_t v) const { return fmt::format("{}", v); }
};

template <class Row>
std::string table(std::span<const Row> rows) {
  const Fields names = fields_of(Row{});
  std::vector<std::vector<std::string>> cells(1);
  for (const auto& [name, value] : names) cells[0].emplace_back(name);
  for (const Row& row : rows) {
    auto& line = cells.emplace_back();
    for (const auto& [name, value] : fields_of(row)) line.push_back(std::visit(ToText{}, value));
  }
  std::vector<std::size_t> widths(names.size(), 0);
  for (const auto& line : cells) {
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], line[c].size());
  }
  std::string text;
  for (const auto& line : cells) {
    std::string out;
    for (std::size_t c = 0; c < line.size(); ++c) {
      const std::size_t width = widths[c];
      const bool words = std::holds_alternative<std::string>(names[c].second);
      if (c > 0) out += "  ";
      out += words ? fmt::format("{:<{}}", line[c], width) : fmt::format("{:>{}}", line[c], width);
    }
    out.erase(out.find_last_not_of(' ') + 1);
    text += out + "\n";
  }
  return text;
}

// A line of a table whose other rows are not known yet: numbers have ten characters, counts twelve, texts as many as
// they need.
std::string fixed_line(const PictureRow& row, bool names) {
  constexpr std::size_t kNumberWidth = 10, kCountWidth = 12, kWordWidth = 9;
  std::string text;
  for (const auto& [name, value] : fields_of(row)) {
    const std::string cell = std::visit(ToText{}, value);
    const std::string shown = names ? name : cell;
    if (!text.empty()) text += "  ";
    text += std::holds_alternative<std::string>(value)
                ? fmt::format("{:<{}}", shown, std::max({kWordWidth, cell.size(), std::string_view(name).size()}))
                : fmt::format("{:>{}}", shown,
                              std::max(std::holds_alternative<double>(value) ? kNumberWidth : kCountWidth,
                                       std::string_view(name).size()));
  }
  return text + "\n";
}

template <class Row>
std::string json_lines(std::span<const Row> rows) {
  std::string text;
  for (const Row& row : rows) {
    nlohmann::ordered_json object;
    for (const auto& [name, value] : fields_of(row)) {
      std::visit([&, key = name](const auto& v) { object[key] = v; }, value);  // NaN and infinity dump as null
    }
    text += object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  }
  return text;
}

struct ToCsv {
  std::string operator()(const std::string& v) const {
    if (v.find_first_of(",\"\r\n") == std::string::npos) return v;
    std::string quoted = "\"";
    for (const char c : v) {
      quoted += c;
      if (c == '"') quoted += c;
    }
    return quoted + "\"";
  }
  // Empty where nothing was measured: tables read "nan" as a word.
  std::string operator()(double v) const { return std::isnan(v) ? "" : fmt::format("{}", v); }
  std::string operator()(std::int64_t v) const { return fmt::format("{}", v); }
};

template <class Row>
std::string csv(std::span<const Row> rows) {
  std::string text;
  const auto add_line = [&](const std::vector<std::string>& cells) {
    for (std::size_t c = 0; c < cells.size(); ++c) text += (c > 0 ? "," : "") + cells[c];
    text += "\r\n";
  };
  std::vector<std::string> cells;
  for (const auto& [name, value] : fields_of(Row{})) cells.emplace_back(name);
  add_line(cells);
  for (const Row& row : rows) {
    cells.clear();
    for (const auto& [name, value] : fields_of(row)) cells.push_back(std::visit(ToCsv{}, value));
    add_line(cells);
  }
  return text;
}

Curve& curve_named(std::vector<Curve>& curves, const std::string& name) {
  for (Curve& curve : curves) {
    if (curve.name == name) return curve;
  }
  return curves.emplace_back(Curve{name, {}});
}

bool is_point(const CurvePoint& point) {
  return std::isfinite(point.cost) && std::isfinite(point.error) && point.cost > 0 && point.error > 0;
}

// The points of positive finite cost and error, cheapest first.
std::vector<CurvePoint> by_cost(const Curve& curve) {
  std::vector<CurvePoint> points;
  std::copy_if(curve.points.begin(), curve.points.end(), std::back_inserter(points), is_point);
  std::stable_sort(points.begin(), points.end(),
                   [](const CurvePoint& a, const CurvePoint& b) { return a.cost < b.cost; });
  return points;
}

// y at x on the straight line through both points in log-log scale.
double log_interpolated(double x0, double y0, double x1, double y1, double x) {
  if (x0 == x1) return std::min(y0, y1);
  const double share = (std::log(x) - std::log(x0)) / (std::log(x1) - std::log(x0));
  return std::exp(std::log(y0) + share * (std::log(y1) - std::log(y0)));
}

// ---- Plot ----

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += c;
    }
  }
  return out;
}

// Colours that colour-blind readers can distinguish and that stay distinct on paper. Each method also has its own
// shape; colours that come again have another one.
constexpr std::array<const char*, 8> kColours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                              "#e69f00", "#56b4e9", "#444444", "#8a6d00"};

std::string marker(std::size_t index, double x, double y, const char* colour) {
  switch ((index + index / kColours.size()) % 4) {
    case 0: return fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='4' fill='{}'/>\n", x, y, colour);
    case 1:
      return fmt::format("<rect x='{:.1f}' y='{:.1f}' width='7' height='7' fill='{}'/>\n", x - 3.5, y - 3.5, colour);
    case 2: return fmt::format("<path d='M{:.1f} {:.1f}l4.6 8h-9.2z' fill='{}'/>\n", x, y - 5, colour);
    default:
      return fmt::format("<path d='M{:.1f} {:.1f}l4.8 4.8l-4.8 4.8l-4.8-4.8z' fill='{}'/>\n", x, y - 4.8, colour);
  }
}

// A power of ten as a label: small ones as plain numbers, others with a raised exponent.
std::string decade_label(int exponent) {
  switch (exponent) {
    case 0: return "1";
    case 1: return "10";
    case 2: return "100";
    case 3: return "1000";
    case -1: return "0.1";
    default:
      return fmt::format("10<tspan dy='-5' font-size='9'>{}{}</tspan>", exponent < 0 ? "−" : "", std::abs(exponent));
  }
}

struct LogScale {
  int from = 0;  // exponents of the ends
  int to = 1;
  double start_px = 0;
  double end_px = 1;

  double operator()(double value) const { return at_log(std::log10(value)); }
  double at_log(double exponent) const { return start_px + (exponent - from) / (to - from) * (end_px - start_px); }
};

LogScale scale_over(double low, double high, double start_px, double end_px) {
  LogScale scale{0, 1, start_px, end_px};
  if (low > high) return scale;
  scale.from = static_cast<int>(std::floor(std::log10(low) + 1e-9));
  scale.to = static_cast<int>(std::ceil(std::log10(high) - 1e-9));
  if (scale.to <= scale.from) scale.to = scale.from + 1;
  return scale;
}

}  // namespace

const char* word_of(TimeOutcome outcome) {
  switch (outcome) {
    case TimeOutcome::kOk: return "ok";
    case TimeOutcome::kUseless: return "useless";
    case TimeOutcome::kDiverged: return "diverged";
    case TimeOutcome::kNonFinite: break;
  }
  return "non-finite";
}

bool is_unstable(const TimeRow& row) { return row.ns_p50 > 0 && !(row.ns_p90 <= 1.15 * row.ns_p10); }

std::string table_of(std::span<const PictureRow> rows) { return table(rows); }
std::string table_of(std::span<const TimeRow> rows) { return table(rows); }
std::string table_line_of(const PictureRow& row) { return fixed_line(row, false); }
std::string table_names_of(const PictureRow& first_row) { return fixed_line(first_row, true); }
std::string json_lines_of(std::span<const PictureRow> rows) { return json_lines(rows); }
std::string json_lines_of(std::span<const TimeRow> rows) { return json_lines(rows); }
std::string csv_of(std::span<const PictureRow> rows) { return csv(rows); }
std::string csv_of(std::span<const TimeRow> rows) { return csv(rows); }

Result<std::vector<PictureRow>> picture_rows_from_json_lines(const std::string& text, const std::string& name) {
  std::vector<PictureRow> rows;
  int line_number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    at = end + 1;
    ++line_number;
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const auto object = nlohmann::json::parse(line, nullptr, false);
    if (!object.is_object()) {
      return fail(ErrorCode::kBadInput, "{}:{}: expected one JSON object per line", name, line_number);
    }
    PictureRow row;
    std::string wrong;
    const auto text_at = [&](const char* key, std::string& out) {
      const auto found = object.find(key);
      if (found == object.end() || !found->is_string())
        wrong = fmt::format("a text \"{}\"", key);
      else
        out = found->get<std::string>();
    };
    const auto number_at = [&](const char* key, auto& out) {
      const auto found = object.find(key);
      using Number = std::remove_reference_t<decltype(out)>;
      if (found != object.end() && found->is_null() && std::is_floating_point_v<Number>) {
        out = static_cast<Number>(std::nan(""));
      } else if (found == object.end() ||
                 !(std::is_floating_point_v<Number> ? found->is_number() : found->is_number_integer())) {
        wrong = fmt::format("a number \"{}\"", key);
      } else {
        out = found->template get<Number>();
      }
    };
    text_at("scene", row.scene);
    text_at("method", row.method);
    number_at("knob", row.knob);
    number_at("hits_per_px", row.hits_per_px);
    number_at("ms_p10", row.ms_p10);
    number_at("ms_p50", row.ms_p50);
    number_at("ms_p90", row.ms_p90);
    if (object.contains("own_ms")) number_at("own_ms", row.own_ms);  // older reports have none
    number_at("rel_l2", row.rel_l2);
    number_at("rel_l2_low", row.rel_l2_low);
    number_at("rel_l2_high", row.rel_l2_high);
    number_at("rel_mse", row.rel_mse);
    number_at("p999", row.p999);
    number_at("max", row.max);
    number_at("flip", row.flip);
    number_at("nonfinite", row.nonfinite);
    number_at("bytes", row.bytes);
    if (!wrong.empty()) return fail(ErrorCode::kBadInput, "{}:{}: expected {} in the row", name, line_number, wrong);
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<Curve> curves_of(std::span<const PictureRow> rows) {
  std::vector<Curve> curves;
  for (const PictureRow& row : rows) {
    const bool failed = row.nonfinite > 0;
    Curve& curve = curve_named(curves, row.method);
    if (!failed) curve.points.push_back({row.ms_p50, std::max(row.rel_l2, kLeastError), fmt::format("{:g}", row.knob)});
  }
  return curves;
}

std::vector<Curve> curves_of(std::span<const TimeRow> rows) {
  std::vector<Curve> curves;
  for (const TimeRow& row : rows) {
    Curve& curve = curve_named(curves, row.method);
    if (row.outcome != TimeOutcome::kOk) continue;
    curve.points.push_back({row.ns_p50, std::max(row.rel_l2, kLeastError), fmt::format("{:g}", row.knob)});
  }
  return curves;
}

std::optional<double> cost_at_error(const Curve& curve, double error) {
  const std::vector<CurvePoint> points = by_cost(curve);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(points[i].error <= error)) continue;
    if (i == 0) return points[0].cost;
    return log_interpolated(points[i - 1].error, points[i - 1].cost, points[i].error, points[i].cost, error);
  }
  return std::nullopt;
}

std::optional<double> error_at_cost(const Curve& curve, double cost) {
  const std::vector<CurvePoint> points = by_cost(curve);
  std::optional<double> least;
  const auto take = [&](double error) { least = least ? std::min(*least, error) : error; };
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].cost <= cost) {
      take(points[i].error);
    } else {
      if (i > 0) {
        take(log_interpolated(points[i - 1].cost, points[i - 1].error, points[i].cost, points[i].error, cost));
      }
      break;
    }
  }
  return least;
}

std::optional<double> order_of(const Curve& curve) {
  const std::vector<CurvePoint> points = by_cost(curve);
  double n = 0, x_mean = 0, y_mean = 0;
  for (const CurvePoint& p : points) {
    n += 1;
    x_mean += std::log(p.cost);
    y_mean += std::log(p.error);
  }
  if (n < 2 || points.back().cost < 1.1 * points.front().cost) return std::nullopt;
  x_mean /= n;
  y_mean /= n;
  double xx = 0, xy = 0;
  for (const CurvePoint& p : points) {
    xx += (std::log(p.cost) - x_mean) * (std::log(p.cost) - x_mean);
    xy += (std::log(p.cost) - x_mean) * (std::log(p.error) - y_mean);
  }
  return -xy / xx;
}

std::string summary_of(std::span<const Curve> curves, const std::string& cost_unit, std::span<const double> costs) {
  constexpr std::array<double, 3> kErrors{1e-2, 1e-3, 1e-4};
  std::size_t name_width = 6;
  for (const Curve& curve : curves) name_width = std::max(name_width, curve.name.size());
  std::string text = fmt::format("{:<{}}", "method", name_width);
  for (const double error : kErrors) text += fmt::format("  {:>15}", fmt::format("{} at {:.0e}", cost_unit, error));
  for (const double cost : costs) text += fmt::format("  {:>15}", fmt::format("error at {:g} {}", cost, cost_unit));
  text += "  order\n";
  for (const Curve& curve : curves) {
    text += fmt::format("{:<{}}", curve.name, name_width);
    const auto add = [&](const std::optional<double>& value) {
      text += fmt::format("  {:>15}", value ? fmt::format("{:.3g}", *value) : "not reached");
    };
    for (const double error : kErrors) add(cost_at_error(curve, error));
    for (const double cost : costs) add(error_at_cost(curve, cost));
    const std::optional<double> order = order_of(curve);
    text += fmt::format("  {:>5}\n", order ? fmt::format("{:.1f}", *order) : "-");
  }
  return text;
}

std::string svg_plot(const PlotText& text, std::span<const Curve> curves) {
  constexpr double kLeft = 86, kTop = 74, kPlotWidth = 560, kPlotHeight = 400;
  std::size_t longest = 0;
  for (const Curve& curve : curves) longest = std::max(longest, curve.name.size() + (by_cost(curve).empty() ? 9 : 0));
  const double legend_width = 52 + 6.9 * static_cast<double>(longest);
  const double width = kLeft + kPlotWidth + 24 + legend_width;
  const double height = std::max(kTop + kPlotHeight + 66, kTop + 40 + 24 * static_cast<double>(curves.size()));

  double cost_low = 1e300, cost_high = 0, error_low = 1e300, error_high = 0;
  for (const Curve& curve : curves) {
    for (const CurvePoint& p : by_cost(curve)) {
      cost_low = std::min(cost_low, p.cost);
      cost_high = std::max(cost_high, p.cost);
      error_low = std::min(error_low, p.error);
      error_high = std::max(error_high, p.error);
    }
  }
  const LogScale x = scale_over(cost_low, cost_high, kLeft, kLeft + kPlotWidth);
  const LogScale y = scale_over(error_low, error_high, kTop + kPlotHeight, kTop);

  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='{0:.0f}' height='{1:.0f}' viewBox='0 0 {0:.0f} {1:.0f}' "
      "font-family='DejaVu Sans, Helvetica, Arial, sans-serif' font-size='12' fill='#222'>\n"
      "<rect width='100%' height='100%' fill='#fff'/>\n"
      "<text x='{2:.0f}' y='30' font-size='17' font-weight='bold'>{3}</text>\n"
      "<text x='{2:.0f}' y='52' fill='#666'>{4}</text>\n",
      width, height, kLeft, escaped(text.title), escaped(text.subtitle));

  // Grid lines at every decade, and at its 2 to 9 if there is room. Labels do not overlap.
  const auto grid = [&](const LogScale& scale, bool across) {
    const double decade_px = std::abs(scale.end_px - scale.start_px) / (scale.to - scale.from);
    const int label_every = std::max(1, static_cast<int>(std::ceil((across ? 40.0 : 22.0) / decade_px)));
    const auto line = [&](double at, const char* colour) {
      svg +=
          across
              ? fmt::format("<path d='M{:.1f} {:.1f}V{:.1f}' stroke='{}'/>\n", at, kTop, kTop + kPlotHeight, colour)
              : fmt::format("<path d='M{:.1f} {:.1f}H{:.1f}' stroke='{}'/>\n", kLeft, at, kLeft + kPlotWidth, colour);
    };
    for (int e = scale.from; e < scale.to && decade_px > 50; ++e) {
      for (int i = 2; i < 10; ++i) line(scale.at_log(e + std::log10(i)), "#f1f1f1");
    }
    for (int e = scale.from; e <= scale.to; ++e) {
      const double at = scale.at_log(e);
      line(at, "#d6d6d6");
      if ((e - scale.from) % label_every != 0) continue;
      svg += across ? fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='middle'>{}</text>\n", at,
                                  kTop + kPlotHeight + 20, decade_label(e))
                    : fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='end'>{}</text>\n", kLeft - 9, at + 4,
                                  decade_label(e));
    }
  };
  svg += "<g stroke-width='1'>\n";
  grid(x, true);
  grid(y, false);
  svg += fmt::format(
      "</g>\n<rect x='{0:.1f}' y='{1:.1f}' width='{2:.1f}' height='{3:.1f}' fill='none' stroke='#777'/>\n"
      "<text x='{4:.1f}' y='{5:.1f}' text-anchor='middle' font-size='13'>{6}</text>\n"
      "<text transform='translate(26 {7:.1f}) rotate(-90)' text-anchor='middle' font-size='13'>{8}</text>\n",
      kLeft, kTop, kPlotWidth, kPlotHeight, kLeft + kPlotWidth / 2, kTop + kPlotHeight + 48, escaped(text.cost_axis),
      kTop + kPlotHeight / 2, escaped(text.error_axis));

  double legend_y = kTop + 12;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const char* colour = kColours[i % kColours.size()];
    const char* dash = i >= kColours.size() ? " stroke-dasharray='5 4'" : "";
    const std::vector<CurvePoint> points = by_cost(curves[i]);
    std::string path;
    for (const CurvePoint& p : points) {
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x(p.cost), y(p.error));
    }
    if (points.size() > 1) {
      svg += fmt::format("<path d='{}' fill='none' stroke='{}' stroke-width='2' stroke-linejoin='round'{}/>\n", path,
                         colour, dash);
    }
    for (const CurvePoint& p : points) {
      svg += marker(i, x(p.cost), y(p.error), colour);
      if (p.label.empty() || points.size() < 2) continue;
      svg += fmt::format(
          "<text x='{:.1f}' y='{:.1f}' font-size='10' fill='{}' stroke='#fff' stroke-width='3' paint-order='stroke'>{}"
          "</text>\n",
          x(p.cost) + 7, y(p.error) - 6, colour, escaped(p.label));
    }
    const double legend_x = kLeft + kPlotWidth + 22;
    svg +=
        fmt::format("<path d='M{:.1f} {:.1f}h26' stroke='{}' stroke-width='2'{}/>\n", legend_x, legend_y, colour, dash);
    svg += marker(i, legend_x + 13, legend_y, colour);
    svg +=
        fmt::format("<text x='{:.1f}' y='{:.1f}'{}>{}{}</text>\n", legend_x + 34, legend_y + 4,
                    points.empty() ? " fill='#999'" : "", escaped(curves[i].name), points.empty() ? " (failed)" : "");
    legend_y += 24;
  }
  if (cost_low > cost_high) {
    svg += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='middle' fill='#999'>nothing was measured</text>\n",
                       kLeft + kPlotWidth / 2, kTop + kPlotHeight / 2);
  }
  return svg + "</svg>\n";
}

}  // namespace footlight::render
