#include "tools/footlight/monitor/monitor_view.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <cctype>
#include <optional>
#include <span>
#include <utility>

#include <locale.h>
#include <wchar.h>

#include "sim/core/endpoint.h"
#include "tools/footlight/duration.h"

namespace footlight::tools {
namespace {

constexpr int kBlocksPerRow = 64;
constexpr int kNumbersPerRow = 32;

// SGR parameters, ECMA-48 section 8.3.117.
constexpr std::string_view kBar = "7";  // reverse
constexpr std::string_view kDim = "2";
constexpr std::string_view kBold = "1";
constexpr std::string_view kGood = "32";   // green
constexpr std::string_view kWarn = "33";   // yellow
constexpr std::string_view kBad = "1;31";  // red
constexpr std::string_view kChanged = "1;33";

struct Glyph {
  std::size_t bytes = 0;
  int columns = 0;
};

// The first character of a text, which must not be empty.
Glyph glyph_at(std::string_view text) {
  static const locale_t kUtf8 = newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr);
  const auto lead = static_cast<unsigned char>(text.front());
  const std::size_t length = lead < 0x80 ? 1 : lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (length == 1 || length > text.size()) return {1, 1};
  std::uint32_t code = lead & (0x7Fu >> length);
  for (std::size_t i = 1; i < length; ++i) code = code << 6 | (static_cast<unsigned char>(text[i]) & 0x3Fu);
  const locale_t before = kUtf8 == nullptr ? nullptr : uselocale(kUtf8);
  const int columns = wcwidth(static_cast<wchar_t>(code));
  if (before != nullptr) uselocale(before);
  return {length, columns < 0 ? 1 : columns};
}

// A line being built: text with its width, cut at the edge of the screen.
class Line {
 public:
  explicit Line(const MonitorView& view) : columns_max_(view.columns), colour_(view.colour) {}

  Line& add(std::string_view text, std::string_view style = {}) {
    const std::string part = cut_to(text, columns_max_ - columns_);
    if (part.empty()) return *this;
    columns_ += columns_of(part);
    set_style(style);
    text_ += part;
    return *this;
  }
  Line& pad_to(int column, std::string_view style = {}) {
    return add(std::string(static_cast<std::size_t>(std::max(column - columns_, 0)), ' '), style);
  }
  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] std::string take() {
    set_style({});
    return std::move(text_);
  }

 private:
  void set_style(std::string_view style) {
    if (!colour_ || style == style_) return;
    if (!style_.empty()) text_ += "\033[0m";
    if (!style.empty()) text_ += fmt::format("\033[{}m", style);
    style_ = style;
  }

  const int columns_max_;
  const bool colour_;
  std::string_view style_;
  int columns_ = 0;
  std::string text_;
};

// Exactly this number of columns, cut or padded.
std::string field(std::string_view text, int columns) {
  std::string part = cut_to(text, columns);
  part.append(static_cast<std::size_t>(std::max(columns - columns_of(part), 0)), ' ');
  return part;
}

std::string_view block_of(int level) {
  static constexpr std::array<std::string_view, 8> kBlocks = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  return kBlocks[static_cast<std::size_t>(level * 8 / 256)];
}

std::string age_text(DurationNs age_ns) {
  if (age_ns < kNsPerS) return fmt::format("{} ms", age_ns / kNsPerMs);
  if (age_ns < 10 * kNsPerS) return fmt::format("{:.1f} s", static_cast<double>(age_ns) * 1e-9);
  if (age_ns < 120 * kNsPerS) return fmt::format("{} s", age_ns / kNsPerS);
  if (age_ns < 7'200 * kNsPerS) return fmt::format("{} min", age_ns / (60 * kNsPerS));
  return fmt::format("{} h", age_ns / (3'600 * kNsPerS));
}

bool contains_word(std::string_view text, std::string_view word) {
  return std::search(text.begin(), text.end(), word.begin(), word.end(),
                     [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); }) != text.end();
}

const MonitorSender* first_winner(const MonitorUniverse& universe) {
  const auto at = std::find_if(universe.senders.begin(), universe.senders.end(),
                               [](const MonitorSender& sender) { return sender.wins; });
  return at == universe.senders.end() ? nullptr : &*at;
}

// The comparison of two moments, if there is one.
struct Compared {
  MomentDifference difference;
  MonitorMoment now;
  const MonitorMoment* b = nullptr;  // what is compared with A: the kept moment, or `now`

  // The slots of a universe that differ.
  [[nodiscard]] std::bitset<kSlotCountMax> slots_of(Universe universe) const {
    std::bitset<kSlotCountMax> differ;
    for (const SlotDifference& one : of(universe)) differ.set(static_cast<std::size_t>(one.address - 1));
    return differ;
  }
  [[nodiscard]] std::span<const SlotDifference> of(Universe universe) const {
    const auto before = [](const SlotDifference& one, Universe wanted) { return one.universe < wanted; };
    const auto& slots = difference.slots;
    const auto from = std::lower_bound(slots.begin(), slots.end(), universe, before);
    const auto to =
        std::find_if(from, slots.end(), [&](const SlotDifference& one) { return one.universe != universe; });
    return {from, to};
  }
};

std::optional<Compared> compared(const MonitorState& state, const MonitorView& view) {
  if (!view.a) return std::nullopt;
  std::optional<Compared> both(std::in_place);
  both->now = keep_moment(state);
  both->b = view.b ? &*view.b : &both->now;
  both->difference = compare_moments(view.a->levels, both->b->levels);
  return both;
}

// The universe with the levels of the kept moment B, where there is one.
MonitorUniverse as_compared(const MonitorUniverse& universe, const MonitorView& view) {
  MonitorUniverse shown = universe;
  if (!view.a || !view.b) return shown;
  shown.levels.fill(0);
  shown.changed_ns.fill(0);
  const auto levels = LevelView(view.b->levels).of(universe.universe);
  std::copy(levels.begin(), levels.end(), shown.levels.begin());
  return shown;
}

// The levels [begin, end) as blocks, with changes marked, or with what differs.
void add_blocks(Line& line, const MonitorUniverse& universe, TimeNs now_ns, int begin, int end, int groups,
                std::string_view zero, const std::bitset<kSlotCountMax>* differ = nullptr) {
  const int count = end - begin;
  for (int g = 0; g < groups; ++g) {
    int level = 0;
    bool changed = false;
    for (int i = begin + g * count / groups;
         i < std::max(begin + (g + 1) * count / groups, begin + g * count / groups + 1); ++i) {
      const auto slot = static_cast<std::size_t>(i);
      level = std::max(level, static_cast<int>(universe.levels[slot]));
      changed = changed || (differ != nullptr ? differ->test(slot) : universe.heat(slot, now_ns) > 0);
    }
    const std::string_view mark = differ != nullptr ? kBar : kChanged;
    line.add(level == 0 ? zero : block_of(level), changed ? mark : level == 0 ? kDim : kGood);
  }
}

std::string header(const MonitorState& state, const MonitorView& view, std::size_t shown) {
  double rate_hz = 0.0;
  for (const MonitorPort& port : state.ports)
    if (!port.is_out) rate_hz += port.rate_hz;
  std::string right = fmt::format(" {} universes  {:.0f} frames/s ", shown, rate_hz);
  if (view.paused) right = " PAUSED " + right;
  Line line(view);
  line.add(cut_to(fmt::format(" footlight monitor  {}", state.title), std::max(view.columns - columns_of(right), 0)),
           kBar);
  line.pad_to(view.columns - columns_of(right), kBar).add(right, kBar);
  return line.take();
}

std::string port_line(const MonitorPort& port, const MonitorView& view) {
  Line line(view);
  line.add(port.is_out ? "out " : "in  ", kDim);
  line.add(field(port.name, std::clamp(view.columns / 3, 8, 48))).add(" ");
  const bool bad = port.state == "gone";
  line.add(field(port.standby && !bad ? "standby" : port.state, 10), bad ? kBad : kGood);
  line.add(fmt::format("{:7.1f}/s", port.rate_hz));
  if (port.latency_p99_ns != 0) line.add(fmt::format("  p99 {}", show_duration(port.latency_p99_ns)), kDim);
  if (port.rejected != 0) line.add(fmt::format("  {} bad", port.rejected), kWarn);
  if (port.lost != 0) line.add(fmt::format("  {} lost", port.lost), kWarn);
  if (!port.trouble.empty()) line.add("  " + port.trouble, kBad);
  return line.take();
}

constexpr int kNumberColumns = 8;

// "A 12 s ago, B now: 3 slots differ, in 1 universe".
std::string compared_line(const Compared& both, const MonitorState& state, const MonitorView& view) {
  const auto ago = [&](const MonitorMoment& moment) {
    return age_text(std::max<DurationNs>(state.now_ns - moment.at_ns, 0)) + " ago";
  };
  const std::size_t slots = both.difference.slots.size();
  const auto universes = std::count_if(both.difference.universes.begin(), both.difference.universes.end(),
                                       [](const MomentDifference::Count& one) { return one.slots > 0; });
  Line line(view);
  line.add(fmt::format(" A {}, B {}: ", ago(*view.a), view.b ? ago(*view.b) : "now"), kBold);
  line.add(fmt::format("{} slot{} differ{}", slots, slots == 1 ? "" : "s", slots == 1 ? "s" : ""),
           slots == 0 ? kGood : kWarn);
  if (slots > 0) line.add(fmt::format(", in {} universe{}", universes, universes == 1 ? "" : "s"), kWarn);
  return line.take();
}

// "2: 17 0>255, 18 0>40": the slots of the selected universe, as many as fit.
std::string differences_line(const Compared& both, Universe universe, const MonitorView& view) {
  Line line(view);
  line.add(fmt::format(" {}: ", universe), kBar);
  const auto slots = both.of(universe);
  if (slots.empty()) line.add(" no slot differs", kDim);
  for (std::size_t i = 0; i < slots.size() && line.columns() < view.columns; ++i) {
    line.add(fmt::format("{} {} {}>{}", i == 0 ? "" : ",", slots[i].address, slots[i].a, slots[i].b));
  }
  return line.take();
}

std::string table_head(const MonitorView& view) {
  Line line(view);
  const int name_columns = std::clamp(view.columns / 4, 8, 32);
  line.add(
      fmt::format("{:>{}} {:>7} {:>7} {:>4}  ", "universe", kNumberColumns, "rate", "age", view.a ? "diff" : "prio"),
      kDim);
  line.add(field("sender", name_columns), kDim).add(" levels 1-512", kDim);
  return line.take();
}

std::string universe_line(const MonitorUniverse& universe, const MonitorState& state, const MonitorView& view,
                          bool selected, const Compared* both) {
  Line line(view);
  const bool received = universe.revision != 0;
  const DurationNs age_ns = std::max<DurationNs>(state.now_ns - universe.stamp_ns, 0);
  const bool silent = !received || age_ns >= kSilentNs;
  line.add(fmt::format("{}{:>{}} ", selected ? ">" : " ", universe.universe, kNumberColumns - 1),
           selected ? kBold : "");
  line.add(fmt::format("{:7.1f} ", universe.rate_hz), silent ? kDim : "");
  line.add(fmt::format("{:>7} ", received ? age_text(age_ns) : "never"), silent ? kBad : "");
  if (both != nullptr) {
    const int slots = both->difference.slots_of(universe.universe);
    line.add(fmt::format("{:>4}  ", slots), slots > 0 ? kWarn : kDim);
  } else {
    line.add(fmt::format("{:>4}  ", received ? fmt::format("{}", universe.priority) : ""));
  }
  const MonitorSender* const winner = first_winner(universe);
  const int others = universe.sender_count - (winner == nullptr ? 0 : 1);
  std::string name = winner == nullptr ? (universe.sender_count == 0 ? "none" : "") : winner->name;
  std::string more;
  if (others > 0)
    more = winner == nullptr ? fmt::format("{} sender{}", others, others == 1 ? "" : "s") : fmt::format(" +{}", others);
  const int name_columns = std::clamp(view.columns / 4, 8, 32);
  line.add(field(cut_to(name, name_columns - columns_of(more)) + more, name_columns),
           universe.sender_count == 0 ? kDim : "");
  line.add(" ");
  const int room = view.columns - line.columns();
  if (received && room > 0)
    add_blocks(line, universe, state.now_ns, 0, kSlotCountMax, std::min(room, kSlotCountMax), " ");
  return line.take();
}

std::string sender_line(const MonitorSender& sender, const MonitorView& view) {
  Line line(view);
  line.add(sender.wins ? " wins " : "      ", kGood);
  line.add(field(sender.name, std::clamp(view.columns / 2 - 10, 8, 64)));
  line.add(fmt::format(" prio {:>3}{} {:6.1f}/s  age {}", sender.priority, sender.per_address ? "+" : " ",
                       sender.rate_hz, age_text(sender.age_ns)),
           sender.age_ns >= kSilentNs ? kBad : "");
  if (sender.lost != 0) line.add(fmt::format("  {} lost", sender.lost), kWarn);
  if (sender.late != 0) line.add(fmt::format("  {} late", sender.late), kWarn);
  return line.take();
}

// 16 rows of numbers if they fit, else 8 rows of blocks.
bool numbers_fit(const MonitorView& view) { return view.columns >= 5 + 4 * kNumbersPerRow && view.rows >= 40; }

// The slot that is explained, with its level.
std::string meaning_line(const MonitorUniverse& universe, const MonitorView& view) {
  Line line(view);
  const std::uint8_t level = universe.levels[static_cast<std::size_t>(view.slot)];
  line.add(fmt::format(" {}.{} ", universe.universe, view.slot + 1), kBar);
  line.add(fmt::format(" {} ({:.0f} %)  ", level, level / 2.55));
  line.add(view.meaning.empty() ? "no fixture uses this slot" : view.meaning, view.meaning.empty() ? kDim : kBold);
  return line.take();
}

std::string grid_line(const MonitorUniverse& universe, const MonitorState& state, const MonitorView& view, int row,
                      const std::bitset<kSlotCountMax>* differ) {
  Line line(view);
  const bool numbers = numbers_fit(view);
  const int per_row = numbers ? kNumbersPerRow : kBlocksPerRow;
  const int begin = row * per_row;
  line.add(fmt::format("{:>4} ", begin + 1), kDim);
  if (!numbers) {
    add_blocks(line, universe, state.now_ns, begin, begin + per_row, per_row, "·", differ);
    return line.take();
  }
  for (int i = begin; i < begin + per_row; ++i) {
    const auto slot = static_cast<std::size_t>(i);
    const bool changed = differ != nullptr ? differ->test(slot) : universe.heat(slot, state.now_ns) > 0;
    const std::string_view style = view.explains && i == view.slot ? kBar
                                   : changed                       ? differ != nullptr ? kBad : kChanged
                                   : universe.levels[slot] == 0    ? kDim
                                                                   : std::string_view{};
    line.add(fmt::format("{:>3}", universe.levels[slot]), style).add(" ");
  }
  return line.take();
}

std::string footer(const MonitorState& state, const MonitorView& view) {
  Line line(view);
  if (!state.trouble.empty()) {
    line.add(" " + state.trouble, kBad);
  } else if (view.typing) {
    line.add(fmt::format(" filter: {}_   Enter: done   Esc: all", view.filter), kBar);
  } else {
    line.add(view.explains ? " up/down: universe   left/right: slot   space: pause   /: filter   q: quit"
                           : " up/down: universe   space: pause   /: filter   q: quit",
             kDim);
    line.add(view.a ? "   a, b: keep A, B   x: end" : "   a: compare", kDim);
    if (!view.filter.empty()) line.add(fmt::format("   filter: {}", view.filter), kWarn);
  }
  return line.take();
}

}  // namespace

int columns_of(std::string_view text) {
  int columns = 0;
  while (!text.empty()) {
    const Glyph glyph = glyph_at(text);
    columns += glyph.columns;
    text.remove_prefix(glyph.bytes);
  }
  return columns;
}

std::string cut_to(std::string_view text, int columns) {
  if (columns <= 0) return {};
  std::string kept;
  std::size_t kept_short = 0;  // of `kept`, with room for the mark
  int width = 0;
  while (!text.empty()) {
    const Glyph glyph = glyph_at(text);
    if (width + glyph.columns > columns) return kept.substr(0, kept_short) + "…";
    width += glyph.columns;
    kept += text.substr(0, glyph.bytes);
    text.remove_prefix(glyph.bytes);
    if (width < columns) kept_short = kept.size();
  }
  return kept;
}

std::vector<Universe> shown_universes(const MonitorState& state, std::string_view filter) {
  const auto list = filter.empty() ? Result<std::vector<WireUniverse>>() : parse_wire_universes(filter);
  std::vector<Universe> shown;
  for (const MonitorUniverse& universe : state.universes) {
    const bool listed = list && std::any_of(list->begin(), list->end(), [&](const WireUniverse& selected) {
                          return selected.wire == universe.universe;
                        });
    const bool named = std::any_of(universe.senders.begin(), universe.senders.end(),
                                   [&](const MonitorSender& sender) { return contains_word(sender.name, filter); });
    if (filter.empty() || listed || (!list && named)) shown.push_back(universe.universe);
  }
  return shown;
}

const MonitorUniverse* shown_universe(const MonitorState& state, const MonitorView& view) {
  const std::vector<Universe> shown = shown_universes(state, view.filter);
  if (shown.empty()) return nullptr;
  const bool is_shown = std::find(shown.begin(), shown.end(), view.selected) != shown.end();
  const Universe number = is_shown ? view.selected : shown.front();
  const auto at = std::find_if(state.universes.begin(), state.universes.end(),
                               [&](const MonitorUniverse& one) { return one.universe == number; });
  return at == state.universes.end() ? nullptr : &*at;
}

MonitorMoment keep_moment(const MonitorState& state) {
  MonitorMoment moment;
  moment.at_ns = state.now_ns;
  for (const MonitorUniverse& one : state.universes) {
    if (one.revision == 0) continue;
    moment.levels.universes.push_back(one.universe);
    moment.levels.levels.insert(moment.levels.levels.end(), one.levels.begin(), one.levels.end());
  }
  return moment;
}

namespace {

// What is below the table: the selected universe with its senders and levels.
std::vector<std::string> selected_lines(const MonitorUniverse& universe, const MonitorState& state,
                                        const MonitorView& view, const Compared* both) {
  const auto rows = static_cast<std::size_t>(std::max(view.rows, 1));
  std::vector<std::string> below;
  const std::size_t senders_max = rows < 16 ? 0 : std::max<std::size_t>(2, rows / 10);
  Line title(view);
  title.add(fmt::format("universe {}", universe.universe), kBold)
      .add(fmt::format("  {} {}", universe.sender_count, universe.sender_count == 1 ? "sender" : "senders"));
  if (universe.frames_refused != 0) title.add(fmt::format("  {} frames refused", universe.frames_refused), kWarn);
  if (rows >= 30) below.push_back(title.take());  // else the mark in the table is enough
  for (std::size_t i = 0; i < universe.senders.size() && i < senders_max; ++i) {
    below.push_back(i + 1 == senders_max && universe.senders.size() > senders_max
                        ? fmt::format("      and {} more", universe.senders.size() - i)
                        : sender_line(universe.senders[i], view));
  }
  const MonitorUniverse shown = as_compared(universe, view);
  const std::bitset<kSlotCountMax> differ =
      both != nullptr ? both->slots_of(universe.universe) : std::bitset<kSlotCountMax>();
  const int grid_rows = numbers_fit(view) ? kSlotCountMax / kNumbersPerRow : kSlotCountMax / kBlocksPerRow;
  if (rows >= 14) {
    for (int row = 0; row < grid_rows; ++row) {
      below.push_back(grid_line(shown, state, view, row, both != nullptr ? &differ : nullptr));
    }
  }
  if (both != nullptr && rows >= 7) below.push_back(differences_line(*both, universe.universe, view));
  if (view.explains && rows >= 6) below.push_back(meaning_line(shown, view));
  return below;
}

}  // namespace

std::vector<std::string> draw_monitor(const MonitorState& state, const MonitorView& view) {
  const std::optional<Compared> comparison = compared(state, view);
  const Compared* const both = comparison ? &*comparison : nullptr;
  const auto rows = static_cast<std::size_t>(std::max(view.rows, 1));
  std::vector<const MonitorUniverse*> shown;
  for (const Universe number : shown_universes(state, view.filter)) {
    for (const MonitorUniverse& universe : state.universes)
      if (universe.universe == number) shown.push_back(&universe);
  }
  std::size_t selected = 0;
  while (selected < shown.size() && shown[selected]->universe != view.selected) ++selected;
  if (selected == shown.size()) selected = 0;

  std::vector<std::string> lines = {header(state, view, shown.size())};
  // The part below the table has a fixed size and is laid out first. The table gets the rest.
  std::vector<std::string> below;
  if (!shown.empty()) below = selected_lines(*shown[selected], state, view, both);
  if (!state.note.empty() && rows >= 10) {
    Line note(view);
    note.add(cut_to(" " + state.note, view.columns), kWarn);
    lines.push_back(note.take());
  }
  const std::size_t ports_max = rows < 10 ? 0 : std::max<std::size_t>(2, rows / 8);
  for (std::size_t i = 0; i < state.ports.size() && i < ports_max; ++i) {
    const bool last = i + 1 == ports_max && state.ports.size() > ports_max;
    lines.push_back(last ? cut_to(fmt::format("    and {} more ports", state.ports.size() - i), view.columns)
                         : port_line(state.ports[i], view));
  }
  if (both != nullptr && rows >= 5) lines.push_back(compared_line(*both, state, view));
  if (rows >= 4) lines.push_back(table_head(view));

  const std::size_t used = lines.size() + below.size() + 1;
  const std::size_t table_rows = used < rows ? std::min(rows - used, shown.size()) : 0;
  const std::size_t first =
      selected < table_rows / 2 ? 0 : std::min(selected - table_rows / 2, shown.size() - table_rows);
  for (std::size_t i = first; i < first + table_rows; ++i) {
    lines.push_back(universe_line(*shown[i], state, view, i == selected, both));
  }
  if (shown.empty() && lines.size() < rows) {
    lines.push_back(
        cut_to(state.universes.empty() ? " no frames yet" : " no universe passes the filter", view.columns));
  }
  lines.insert(lines.end(), below.begin(), below.end());
  lines.resize(rows);
  if (rows >= 2) lines.back() = footer(state, view);
  return lines;
}

}  // namespace footlight::tools
