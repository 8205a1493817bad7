// Words that a user of the window reads go through tr() and its kin (tools/footlight/preview/ui/words.h).
//
// Reads the sources of the window as text: every literal with a word in it must stand in a call that translates it, or
// in one whose text nobody reads, as an id of Dear ImGui.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>
#include <fmt/format.h>

namespace footlight {
namespace {

namespace fs = std::filesystem;

struct Literal {
  std::string text;
  std::string call;    // whose argument it is: "tr", "ImGui::Button"; empty: none
  std::string before;  // what stands before it, without spaces: "==" of a comparison
  int line = 1;
};

bool of_name(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == ':' || c == '.'; }

// All text literals of a source, with the innermost call around each. Comments and raw literals are skipped.
std::vector<Literal> literals_of(const std::string& source) {
  std::vector<Literal> found;
  std::vector<std::string> calls;
  int line = 1;
  std::size_t line_begin = 0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const char c = source[i];
    if (c == '\n') {
      ++line;
      line_begin = i + 1;
    } else if (source.compare(i, 2, "//") == 0) {
      i = std::min(source.find('\n', i), source.size()) - 1;
    } else if (c == '\'' && (i == 0 || std::isalnum(static_cast<unsigned char>(source[i - 1])) == 0)) {
      i = source.find('\'', i + (source[i + 1] == '\\' ? 3 : 2));
    } else if (source.compare(i, 3, "R\"(") == 0) {
      const std::size_t end = source.find(")\"", i);
      line += static_cast<int>(std::count(source.begin() + static_cast<std::ptrdiff_t>(i),
                                          source.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
      i = end + 1;
    } else if (c == '(' || c == '{') {
      std::size_t from = i;
      while (from > 0 && of_name(source[from - 1])) --from;
      std::string name = source.substr(from, i - from);
      // A list in braces, and brackets that only group, belong to the call around them.
      calls.push_back(name.empty() && !calls.empty() && source[i] == '(' ? calls.back() : name);
    } else if ((c == ')' || c == '}') && !calls.empty()) {
      calls.pop_back();
    } else if (c == '"') {
      Literal one{.text = "", .call = calls.empty() ? "" : calls.back(), .before = "", .line = line};
      std::size_t end = i + 1;
      for (; source[end] != '"'; ++end) {
        if (source[end] == '\\') one.text += source[end++];
        one.text += source[end];
      }
      std::size_t before = i;
      while (before > 0 && std::isspace(static_cast<unsigned char>(source[before - 1])) != 0) --before;
      one.before = source.substr(before >= 2 ? before - 2 : 0, std::min<std::size_t>(before, 2));
      const bool includes = source.compare(line_begin, 8, "#include") == 0;
      if (!includes) found.push_back(std::move(one));
      i = end;
    }
  }
  return found;
}

// Without placeholders, conversions, escapes and ids: are there letters that make a word?
bool has_words(std::string text) {
  static const std::regex kNoWords(R"(\{[^{}]*(\{[^{}]*\}[^{}]*)*\}|%[0-9.+\-]*[a-zA-Z]|\\u[0-9a-f]{4}|\\.|##.*$)");
  static const std::set<std::string, std::less<>> kUnits{"m",  "s",  "ms", "us", "m/s", "Hz", "K", "MB", "MiB", "lx",
                                                         "lm", "px", "x",  "y",  "z",   "EV", "A", "B",  "GPU", "XYZ"};
  text = std::regex_replace(text, kNoWords, " ");
  std::string word;
  for (const char c : text + ' ') {
    if (std::isalpha(static_cast<unsigned char>(c)) != 0) {
      word += c;
      continue;
    }
    if (!word.empty() && !kUnits.contains(word)) return true;
    word.clear();
  }
  return false;
}

bool translates(std::string_view call) {
  static const std::set<std::string, std::less<>> kAll{"tr",         "trf",      "tr_n",      "trf_n", "tr_mark",
                                                       "trf_marked", "tr_label", "tr_printf", "tr_in"};
  return kAll.contains(call);
}

// Calls with texts that nobody reads in the window.
bool is_no_text(std::string_view call) {
  static const std::set<std::string, std::less<>> kAll{
      // Ids of Dear ImGui and of panels.
      "ImGui::BeginChild", "ImGui::BeginTable", "ImGui::PushID", "ImGui::InvisibleButton", "ImGui::OpenPopup",
      "begin_port_table", "draw_notes",
      "ImGui::BeginPopup", "ImGui::ArrowButton", "ImGui::BeginTabBar", "ImGui::ColorPicker3", "ImGui::Begin",
      "begin_line", "draw_field", "begin_table", "panel_of", "panels_.open_words",
      // Errors are English where they are made; tr_known() translates those of the window where it shows them.
      "fail", "counted",
      // Standard error and output, the environment, files.
      "fmt::print", "std::fputs", "std::getenv", "fs::path", "one.number", "one.text", "one.place_of", "reader.tables",
      "mark_start", "Window::open", "fixtures::as_imported", "rest_on",
      // Attributes of GDTF.
      "fixtures::same_attribute", "axis_of", "range_of", "std::pair"};
  return kAll.contains(call) || call.ends_with("starts_with") || call.ends_with("ends_with");
}

// "ColorAdd_R", "mock:enttec-pro", ".dmxlog", "F10": no word of a language.
bool is_identifier(const std::string& text) {
  if (text.find(' ') != std::string::npos) return false;
  return text.find_first_of("_.:=/[") != std::string::npos || text.find_first_of("0123456789") != std::string::npos;
}

// "file: text" that stays as it is in every language.
bool is_excepted(const std::string& file_and_text) {
  static const std::set<std::string, std::less<>> kAll{
      // Ids of Dear ImGui that have names.
      "devices_panel.cpp: interface", "devices_panel.cpp: output", "devices_panel.cpp: input", "palette.cpp: actions",
      "rig_editor.cpp: edit fixtures", "timeline_panel.cpp: marker", "draw_wheels.cpp: gobo {} {} {}",
      // Words of --panels.
      "panels.cpp: keys", "panels.cpp: universes", "panels.cpp: fixtures", "panels.cpp: inspector",
      "panels.cpp: timeline", "panels.cpp: devices", "panels.cpp: library", "panels.cpp: messages",
      "panels.cpp: report", "panels.cpp: F1, ?",
      // Wheels among the columns of a trace; known_texts.cpp has what is shown of them.
      "inspector_panel.cpp: animation", "inspector_panel.cpp:  turn",
      // A file.
      "markers.cpp: # Named times of the log beside this file, of 'footlight preview'.\\n", "markers.cpp: [[marker]]",
      "markers.cpp: \\n[[marker]]\\nat_s = {:.9f}\\nname = {}\\n", "preview_hand.cpp: demo",
      // Names of this program, of a sender, of a quantile and of a pass.
      "preview_panel.cpp: FOOTLIGHT", "preview_panel.cpp: p50, p90", "preview_outputs.cpp: Footlight preview",
      "start_screen.cpp: Footlight", "preview_open.cpp: {} - Footlight",
      "preview_edits.cpp: {}{} - Footlight", "preview_window.cpp: error",
      // Units.
      "file_list.cpp: kB", "file_list.cpp: MB", "file_list.cpp: GB", "file_list.cpp: TB",
      // Events for standard output.
      "preview_window.cpp: event", "preview_window.cpp: flashes-begin", "preview_window.cpp: device-lost",
      "preview_window.cpp: device", "preview_window.cpp: stage", "preview_window.cpp: window",
      "preview_window.cpp: message",
      // Translated by tr_known(), since standard error has it, too.
      "preview_steps.cpp: ; its displays keep their last picture"};
  return kAll.contains(file_and_text);
}

// Literals of a source of the window that a user would read in English only.
std::vector<std::string> untranslated(const std::string& file, const std::string& source) {
  std::vector<std::string> found;
  for (const Literal& one : literals_of(source)) {
    if (!has_words(one.text) || translates(one.call) || is_no_text(one.call) || is_identifier(one.text)) continue;
    if (one.before == "==" || one.before == "!=" || is_excepted(file + ": " + one.text)) continue;
    found.push_back(fmt::format("{}:{}: \"{}\"", file, one.line, one.text));
  }
  return found;
}

TEST_CASE("a literal with words that is drawn without tr() is found, and an id, a unit and an attribute are not") {
  const auto found = [](const std::string& source) { return !untranslated("a.cpp", source).empty(); };
  CHECK(found(R"x(ui_text(kUiDim, "no address");)x"));
  CHECK(found(R"x(ImGui::Button("save");)x"));
  CHECK(found(R"x(ui_text(kUiDim, fmt::format("{} slots", count));)x"));
  CHECK(found(R"x(ui_text(tr("one") + std::string("two"));)x"));
  CHECK(found(R"x(return on ? "on" : tr("off");)x"));
  CHECK(found(R"x(constexpr const char* kHeads[] = {"Name", tr_mark("Type")};)x"));
  CHECK(found("SliderFloat(\"##ev\", &ev, -4, 16, \"exposure %.1f EV\");"));
  CHECK(!found(R"x(ui_text(kUiDim, tr("no " "address"));)x"));
  CHECK(!found(R"x(tell(trf_n("{} slot", "{} slots", count, count));)x"));
  CHECK(!found(R"x(ImGui::Button(tr_label("save"));)x"));
  CHECK(!found(R"x(ImGui::Selectable("##row", one.kind == "built"); // "a comment")x"));
  CHECK(!found(R"x(ui_text(fmt::format("{:.1f} ms", ms)); ImGui::PushID("pad");)x"));
  CHECK(!found(R"x(fixtures::same_attribute(attribute, "NoFeature");)x"));
}

TEST_CASE("every word of the window's sources is in a call that translates it") {
  const fs::path folder = fs::path(FOOTLIGHT_SOURCE_DIR) / "tools/footlight/preview";
  // The table of keys is listed as a whole by tools/make_words; figures are JSON.
  const std::set<std::string, std::less<>> others{"keys.cpp", "words.cpp", "preview_figures.cpp"};
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const bool drawn = entry.path().parent_path().filename() == "ui" || name.starts_with("preview_");
    if (!drawn || entry.path().extension() != ".cpp" || others.contains(name)) continue;
    ++files;
    std::ifstream file(entry.path());
    for (const std::string& one : untranslated(name, {std::istreambuf_iterator<char>(file), {}})) {
      FAIL_CHECK(one << " is English in every language: use tr() of tools/footlight/preview/ui/words.h");
    }
  }
  CHECK(files > 50);
}

}  // namespace
}  // namespace footlight
