// Rules that the compiler does not check: includes, line widths, files that are not built, commands in the README.
//
// Reads the source tree as text. To break a rule somewhere, add an exception here, with the reason beside it.
#include <algorithm>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace footlight {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = FOOTLIGHT_SOURCE_DIR;
constexpr int kColumnsMax = 120;

struct SourceFile {
  std::string path;  // from the root, with "/"
  std::vector<std::string> lines;
};

std::vector<std::string> lines_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

bool starts_with(std::string_view text, std::string_view start) { return text.substr(0, start.size()) == start; }
bool ends_with(std::string_view text, std::string_view end) {
  return text.size() >= end.size() && text.substr(text.size() - end.size()) == end;
}

// Every text file of the tree, in order of path.
const std::vector<SourceFile>& tree() {
  static const std::vector<SourceFile> files = [] {
    std::vector<SourceFile> found;
    for (const char* folder :
         {"sim", "drivers", "fixtures", "render", "tools", "tests", "docs", "udev", ".ci", "CMakeLists.txt",
          "README.md", "CHANGELOG.md", ".clang-format", ".clang-tidy", "CMakePresets.json"}) {
      const fs::path top = kRoot / folder;
      if (fs::is_regular_file(top)) found.push_back({folder, lines_of(top)});
      if (!fs::is_directory(top)) continue;
      for (const auto& entry : fs::recursive_directory_iterator(top)) {
        if (!entry.is_regular_file()) continue;
        found.push_back({fs::relative(entry.path(), kRoot).generic_string(), lines_of(entry.path())});
      }
    }
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
    return found;
  }();
  return files;
}

bool is_header(std::string_view path) { return ends_with(path, ".h"); }
bool is_cpp(std::string_view path) { return is_header(path) || ends_with(path, ".cpp"); }
bool is_shader(std::string_view path) {
  return ends_with(path, ".comp") || ends_with(path, ".vert") || ends_with(path, ".frag") || ends_with(path, ".glsl");
}
// Headers that C++ and GLSL share are included several times, on purpose. A *_body.h contains a class that is compiled
// in two namespaces.
bool is_shared(std::string_view path) {
  return path.find("/shared/") != std::string_view::npos || ends_with(path, "_body.h");
}

struct Include {
  std::string file;
  int line = 0;
  std::string target;  // the text between the quotes
  bool quoted = false;
};

std::vector<Include> includes_of(const SourceFile& file) {
  static const std::regex kInclude(R"rx(^\s*#\s*include\s*(["<])([^">]+)[">])rx");
  std::vector<Include> includes;
  for (std::size_t i = 0; i < file.lines.size(); ++i) {
    std::smatch match;
    if (file.lines[i].find("include") == std::string::npos || !std::regex_search(file.lines[i], match, kInclude))
      continue;
    includes.push_back({file.path, static_cast<int>(i) + 1, match[2], match[1] == "\""});
  }
  return includes;
}

std::string top_of(std::string_view path) { return std::string(path.substr(0, path.find('/'))); }

void check_none(const std::vector<std::string>& offences) {
  for (const std::string& offence : offences) MESSAGE(offence);
  CHECK(offences.empty());
}

TEST_CASE("the source tree is found") {
  CHECK(tree().size() > 100);
  CHECK(std::any_of(tree().begin(), tree().end(), [](const auto& file) { return file.path == "sim/core/dmx.h"; }));
}

TEST_CASE("includes point down only: tools, then render and drivers, then fixtures, then sim") {
  const std::map<std::string, std::set<std::string>> allowed = {
      {"sim", {"sim"}},
      {"drivers", {"drivers", "sim"}},
      {"fixtures", {"fixtures", "sim"}},
      {"render", {"render", "fixtures", "sim"}},
      {"tools", {"tools", "render", "fixtures", "drivers", "sim"}},
      {"tests", {"tests", "tools", "render", "fixtures", "drivers", "sim"}},
  };
  std::vector<std::string> offences;
  for (const SourceFile& file : tree()) {
    if (!is_cpp(file.path) && !is_shader(file.path)) continue;
    const auto rule = allowed.find(top_of(file.path));
    if (rule == allowed.end()) continue;
    for (const Include& include : includes_of(file)) {
      if (!include.quoted) continue;
      const std::string top = top_of(include.target);
      const bool generated = starts_with(include.target, "shaders/");  // glslang's arrays, included only by render
      if (generated ? top_of(file.path) == "render" : rule->second.contains(top)) continue;
      offences.push_back(fmt::format("{}:{}: {}/ must not include \"{}\"; it may include {}", file.path, include.line,
                                     rule->first, include.target, fmt::join(rule->second, ", ")));
    }
  }
  check_none(offences);
}

TEST_CASE("sim/core includes only itself, and render/vk does not depend on DMX") {
  std::vector<std::string> offences;
  for (const SourceFile& file : tree()) {
    const bool core = starts_with(file.path, "sim/core/");
    const bool vk = starts_with(file.path, "render/vk/");
    if (!core && !vk) continue;
    for (const Include& include : includes_of(file)) {
      if (!include.quoted || starts_with(include.target, core ? "sim/core/" : "render/vk/")) continue;
      if (vk && starts_with(include.target, "sim/core/") && !starts_with(include.target, "sim/core/dmx")) continue;
      offences.push_back(fmt::format("{}:{}: \"{}\"", file.path, include.line, include.target));
    }
  }
  check_none(offences);
}

// These files are also linked where the renderer is not built.
TEST_CASE("the scene without pictures includes nothing of the renderer but what C++ and GLSL share") {
  const std::vector<std::string> lines = lines_of(kRoot / "tools/footlight/CMakeLists.txt");
  auto line = std::find(lines.begin(), lines.end(), "add_library(footlight_scene STATIC");
  REQUIRE(line != lines.end());
  std::set<std::string> sources;
  while (line->find(')') == std::string::npos) {
    std::istringstream words(*++line);
    for (std::string word; words >> word;) sources.insert("tools/footlight/" + word.substr(0, word.find('.')));
  }
  REQUIRE(sources.size() > 3);
  std::vector<std::string> offences;
  for (const SourceFile& file : tree()) {
    if (!is_cpp(file.path) || !sources.contains(file.path.substr(0, file.path.find('.')))) continue;
    for (const Include& include : includes_of(file)) {
      if (!starts_with(include.target, "render/") || is_shared(include.target)) continue;
      offences.push_back(fmt::format("{}:{}: \"{}\"", file.path, include.line, include.target));
    }
  }
  check_none(offences);
}

TEST_CASE("quoted includes start at the root and name an existing file") {
  std::vector<std::string> offences;
  for (const SourceFile& file : tree()) {
    if (!is_cpp(file.path) && !is_shader(file.path)) continue;
    for (const Include& include : includes_of(file)) {
      if (!include.quoted || starts_with(include.target, "shaders/")) continue;
      if (fs::is_regular_file(kRoot / include.target)) continue;
      offences.push_back(fmt::format("{}:{}: \"{}\"", file.path, include.line, include.target));
    }
  }
  check_none(offences);
}

TEST_CASE("hardware libraries, and those that compile slowly, are included only by their wrappers") {
  struct Rule {
    const char* library;  // beginning of the text between < and >
    const char* may;      // pattern of the paths that may include it
  };
  const Rule rules[] = {
      {"libusb", R"((drivers|tests/drivers)/.*\.cpp)"},
      {"hidapi", R"((drivers|tests/drivers)/.*\.cpp)"},
      {"gpiod", R"((drivers|tests/drivers)/.*\.cpp)"},
      {"libudev", R"((drivers|tests/drivers)/.*\.cpp)"},
      {"vulkan/", R"((render|tests/render)/.*|tools/footlight/preview/window.*)"},
      {"GLFW/", R"(tools/footlight/(preview/(window|preview_|key_presses|ui/keys\.|ui/panels\.)|vrsl/vrsl_window).*|)"
                R"(tests/tools/footlight/(ui_input|key_state)_test.*)"},
      {"imgui", R"(tools/footlight/preview/(window|preview_|)"
                R"(ui/(.*panels?|draw_.*|file_dialog|menu|palette|escape|live_band|questions|rig_editor|stage_marks|)"
                R"(start_screen|toasts|)"
                R"(ui_theme)\.).*|)"
                R"(tests/(tools/footlight/((panels|panel_edits|unpatched_panel|busy_panel|compare_panel|messages|)"
                R"(devices_panel|file_dialog|library_panel|)"
                R"(palette|inspector|shown_ui|side_panel|small_window|start_screen|theme|report_panel|)"
                R"(wheels|words_panels)_test|)"
                R"(edit_ui)|bench/ui_bench).*)"},
      {"libav", R"(tools/footlight/pictures/video.*\.cpp|tools/footlight/vrsl/(video_.*\.cpp|av_error\.h)|)"
                R"(drivers/(sound/sound_file|av/libav)\.cpp|tests/tools/.*\.cpp)"},
      {"OpenEXR/", R"(tools/footlight/pictures/exr_file\.cpp|tests/tools/.*\.cpp)"},
      {"alsa/", R"(drivers/(sound/alsa_device|midi/alsa_midi)\.cpp)"},
      {"avahi-", R"(drivers/net/avahi_discovery\.cpp)"},
      {"libsw", R"(tools/footlight/(pictures|vrsl)/video.*\.cpp|drivers/av/libav\.cpp|tests/tools/.*\.cpp)"},
      {"microhttpd", R"(tools/footlight/status/http_server\.cpp)"},
      {"systemd/", R"(tools/footlight/bridge/(service|event_log)\.cpp)"},
      {"pcap/", R"(drivers/capture/pcap_input\.cpp)"},
      {"zip.h", R"((drivers/capture/sigrok_file|fixtures/files/(import/archive|export/zip_writer)|)"
                R"(tests/(fixtures|fuzz)/.*)\.cpp)"},
      {"png.h", R"((fixtures/gobos/png|tests/fixtures/gobos/png_test)\.cpp)"},
      {"cairo", R"(fixtures/paperwork/patch_pdf\.cpp)"},
      {"pugixml", R"(fixtures/files/import/xml\.cpp|tests/fixtures/files/every_channel_test\.cpp)"},
      {"zstd", R"((sim|tests/sim)/dmx_log/.*\.cpp)"},
      {"CLI/", R"(tools/(footlight/arguments|[a-z_]+)\.cpp)"},
      {"nlohmann/", R"(.*\.cpp|fixtures/files/import/ofl_json\.h|tests/kernel/guest\.h)"},
      {"tiny_gltf", R"(fixtures/bodies/(read_gltf\.cpp|gltf_textures\.h))"},
      {"meshoptimizer", R"(fixtures/bodies/(levels|mesh)\.cpp)"},
      {"toml++/", R"(fixtures/.*\.cpp)"},
      {"cvode/", R"(render/reference/time_cvode\.cpp)"},
      {"boost/numeric/", R"(render/reference/time_rosenbrock4\.cpp)"},
      {"boost/", R"((render/reference|tests)/.*\.(cpp|h))"},
      {"doctest/", R"(tests/.*)"},
      {"benchmark/", R"(tests/.*)"},
      {"umockdev", R"(tests/.*)"},
  };
  std::vector<std::string> offences;
  for (const SourceFile& file : tree()) {
    if (!is_cpp(file.path)) continue;
    for (const Include& include : includes_of(file)) {
      for (const Rule& rule : rules) {
        if (include.quoted || !starts_with(include.target, rule.library)) continue;
        if (std::regex_match(file.path, std::regex(rule.may))) continue;
        offences.push_back(fmt::format("{}:{}: <{}> belongs in {}", file.path, include.line, include.target, rule.may));
      }
    }
  }
  check_none(offences);
}

TEST_CASE("no line of source is wider than 120 columns, ends in a space or holds a tab") {
  std::vector<std::string> offences;
  for (const SourceFile& file : tree()) {
    const bool build = ends_with(file.path, "CMakeLists.txt") || ends_with(file.path, ".cmake");
    if (!is_cpp(file.path) && !is_shader(file.path) && !build) continue;
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
      const std::string& line = file.lines[i];
      const auto columns = std::count_if(line.begin(), line.end(),
                                         [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; });
      if (columns > kColumnsMax) offences.push_back(fmt::format("{}:{}: {} columns", file.path, i + 1, columns));
      if (ends_with(line, " ")) offences.push_back(fmt::format("{}:{}: ends in a space", file.path, i + 1));
      if (line.find('\t') != std::string::npos) offences.push_back(fmt::format("{}:{}: holds a tab", file.path, i + 1));
      if (ends_with(line, "\r")) offences.push_back(fmt::format("{}:{}: DOS line end", file.path, i + 1));
    }
  }
  check_none(offences);
}

TEST_CASE("no work is left for later, and no path of one machine is in the tree") {
  // In two parts, so that this file does not match itself.
  const std::vector<std::string> banned = {
      "TO"
      "DO",
      "FIX"
      "ME",
      "XX"
      "X:",
      "/wo"
      "rk/",
      "/ro"
      "ot/",
      "for no"
      "w,"};
  std::vector<std::string> offences;
  for (const SourceFile& file : tree()) {
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
      for (const std::string& word : banned) {
        if (file.lines[i].find(word) == std::string::npos) continue;
        offences.push_back(fmt::format("{}:{}: {}", file.path, i + 1, word));
      }
    }
  }
  check_none(offences);
}

// The words that the glossary in docs/ARCHITECTURE.md has replaced.
TEST_CASE("texts use the words of the glossary, not those that it replaced") {
  // In two parts, so that this file does not match itself.
  const std::regex replaced(
      "\\b(wi"
      "sh(es|ed)?|me"
      "nd(s|ed|ing)?|(last|merged|newest|unchanged|whole) lo"
      "oks?)\\b",
      std::regex::icase);
  // Searched for first, since the regular expression is slow.
  const std::vector<std::string> stems = {
      "wi"
      "sh",
      "me"
      "nd",
      "lo"
      "ok"};
  const auto may_match = [&](std::string line) {
    std::transform(line.begin(), line.end(), line.begin(), [](unsigned char c) { return std::tolower(c); });
    return std::any_of(stems.begin(), stems.end(),
                       [&](const std::string& stem) { return line.find(stem) != std::string::npos; });
  };
  std::vector<std::string> offences;
  for (const SourceFile& file : tree()) {
    const bool text = is_cpp(file.path) || is_shader(file.path) || ends_with(file.path, ".md");
    if (!text || starts_with(file.path, "docs/decisions/") || file.path == "CHANGELOG.md") continue;
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
      std::smatch match;
      if (!may_match(file.lines[i]) || !std::regex_search(file.lines[i], match, replaced)) continue;
      offences.push_back(fmt::format("{}:{}: {}", file.path, i + 1, match.str()));
    }
  }
  check_none(offences);
}

TEST_CASE("every header guards itself, except those that C++ and GLSL share") {
  std::vector<std::string> offences;
  for (const SourceFile& file : tree()) {
    if (!is_header(file.path)) continue;
    const bool guarded = std::find(file.lines.begin(), file.lines.end(), "#pragma once") != file.lines.end();
    if (!guarded && !is_shared(file.path)) offences.push_back(file.path + ": no #pragma once");
  }
  check_none(offences);
}

TEST_CASE("every header is included by a file") {
  std::set<std::string> included;
  for (const SourceFile& file : tree()) {
    for (const Include& include : includes_of(file)) included.insert(include.target);
  }
  std::vector<std::string> offences;
  for (const SourceFile& file : tree()) {
    const bool includable = is_header(file.path) || ends_with(file.path, ".glsl");
    if (includable && !included.contains(file.path)) offences.push_back(file.path + ": no file includes it");
  }
  check_none(offences);
}

TEST_CASE("every source file is listed in the CMakeLists.txt of its folder or of one above") {
  std::vector<std::string> offences;
  for (const SourceFile& file : tree()) {
    if (!ends_with(file.path, ".cpp") && !(is_shader(file.path) && !ends_with(file.path, ".glsl"))) continue;
    // Lists of words: subcommands and fuzz targets are listed without ".cpp".
    const bool by_word = starts_with(file.path, "tools/footlight/") || starts_with(file.path, "tests/fuzz/");
    const std::string name = fs::path(file.path).filename().string();
    const std::string word = fs::path(file.path).stem().string();
    const std::regex listed(fmt::format("(^|[^A-Za-z0-9_])({}{})($|[^A-Za-z0-9_.])",
                                        std::regex_replace(name, std::regex(R"(\.)"), R"(\.)"),
                                        by_word ? "|" + word : ""));
    // Files that several folders share are named from the root.
    bool found = std::any_of(tree().begin(), tree().end(), [&](const SourceFile& list) {
      return ends_with(list.path, "CMakeLists.txt") &&
             std::any_of(list.lines.begin(), list.lines.end(),
                         [&](const std::string& line) { return line.find("}/" + file.path) != std::string::npos; });
    });
    for (fs::path folder = fs::path(file.path).parent_path(); !found; folder = folder.parent_path()) {
      for (const std::string& line : lines_of(kRoot / folder / "CMakeLists.txt")) {
        found = found || std::regex_search(line.substr(0, line.find('#')), listed);
      }
      if (folder.empty()) break;
    }
    if (!found) offences.push_back(file.path + ": not built");
  }
  check_none(offences);
}

TEST_CASE("every test file has a test, and no two tests of one program share a name") {
  std::vector<std::string> offences;
  for (const SourceFile& file : tree()) {
    if (!starts_with(file.path, "tests/") || !ends_with(file.path, "_test.cpp")) continue;
    std::set<std::string> names;
    bool any = false;
    for (const std::string& line : file.lines) {
      const std::size_t at = line.find("TEST_CASE");
      any = any || at != std::string::npos;
      if (at != 0 || line.find('"') == std::string::npos) continue;
      if (!names.insert(line).second) offences.push_back(fmt::format("{}: twice: {}", file.path, line));
    }
    if (!any) offences.push_back(file.path + ": no test");
  }
  check_none(offences);
}

TEST_CASE("no name of a test has a semicolon: CTest would run the part before it, which is no test") {
  const std::regex name(R"re(TEST_CASE(?:_TEMPLATE)?\(\s*((?:"(?:[^"\\]|\\.)*"\s*)+))re");
  std::vector<std::string> offences;
  for (const SourceFile& file : tree()) {
    if (!starts_with(file.path, "tests/") || !ends_with(file.path, "_test.cpp")) continue;
    std::string text;
    for (const std::string& line : file.lines) text += line + "\n";
    for (std::sregex_iterator at(text.begin(), text.end(), name), end; at != end; ++at) {
      if (at->str(1).find(';') != std::string::npos) offences.push_back(file.path + ": " + at->str(1));
    }
  }
  check_none(offences);
}

TEST_CASE("every package is listed once, with its reason") {
  std::vector<std::string> offences;
  const std::regex line_form(R"(([a-z0-9][a-z0-9+.-]+)\s+# \S.*)");
  std::set<std::string> packages;
  for (const char* const list : {"tools/packages.txt", "tools/packages_kernel.txt"}) {
    std::set<std::string> in_list;
    for (const std::string& line : lines_of(kRoot / list)) {
      if (line.empty() || line.front() == '#') continue;
      std::smatch match;
      if (!std::regex_match(line, match, line_form)) {
        offences.push_back(fmt::format("{}: expected \"package  # reason\", got \"{}\"", list, line));
      } else if (!in_list.insert(match[1]).second) {
        offences.push_back(fmt::format("{}: twice: {}", list, line));
      }
    }
    packages.merge(in_list);
  }
  CHECK(packages.contains("qemu-system-x86"));
  CHECK(packages.contains("g++"));
  check_none(offences);
}

TEST_CASE("every disabled check of clang-tidy has a reason") {
  const auto lines = lines_of(kRoot / ".clang-tidy");
  std::string rationale;
  for (const std::string& line : lines) {
    if (starts_with(line, "#")) rationale += line + "\n";
  }
  std::vector<std::string> offences;
  for (const std::string& line : lines) {
    static const std::regex kOff(R"(^\s+-([a-z][A-Za-z0-9.-]+),?$)");
    std::smatch match;
    if (!std::regex_match(line, match, kOff)) continue;
    if (rationale.find(" " + match[1].str() + " ") == std::string::npos)
      offences.push_back(match[1].str() + ": no reason");
  }
  check_none(offences);
}

TEST_CASE("the scripts in the README and the documents exist and are executable") {
  std::vector<std::string> offences;
  bool any = false;
  const std::regex script(R"((?:^|[\s`(./])(tools/[a-z_]+|\.ci/run)(?=$|[\s`),.:;]))");
  for (const SourceFile& file : tree()) {
    if (!ends_with(file.path, ".md")) continue;
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
      const std::string& line = file.lines[i];
      for (auto at = std::sregex_iterator(line.begin(), line.end(), script); at != std::sregex_iterator(); ++at) {
        const fs::path path = kRoot / (*at)[1].str();
        any = true;
        if (fs::is_directory(path) || fs::is_regular_file(path.string() + ".cpp")) continue;  // a folder, or a program
        std::error_code error;
        const auto status = fs::status(path, error);
        if (fs::is_regular_file(status) && (status.permissions() & fs::perms::owner_exec) != fs::perms::none) continue;
        offences.push_back(fmt::format("{}:{}: {}", file.path, i + 1, (*at)[1].str()));
      }
    }
  }
  CHECK(any);
  check_none(offences);
}

// ---- lengths ----

constexpr std::size_t kFunctionLinesMax = 100;
constexpr std::size_t kFileLinesMax = 600;

struct LongFunction {
  const char* file;
  const char* name;
  const char* reason;  // why one function is easier to read than its parts would be
};

constexpr LongFunction kLongFunctions[] = {
    {"drivers/mock/rdm_line_model.cpp", "RdmResponderModel::act", "one case for each RDM parameter"},
    {"drivers/rdm/rdm_parameters.cpp", "rdm_fields", "one case for each form of parameter data"},
    {"fixtures/files/import/ofl_channels.cpp", "Reader::read_matrix",
     "the pixels and their groups share one count and its limit"},
    {"fixtures/files/import/ofl_channels.cpp", "Reader::set_physical", "one case for each scale of OFL"},
    {"fixtures/files/import/plain.cpp", "PlainBody::build",
     "parts of a body in the order of the tree, sharing a lambda"},
    {"fixtures/files/import/qxf_channels.cpp", "Reader::read_range",
     "preset, group and words of one range, each overruled by the one before"},
    {"fixtures/files/import/qxf_channels.cpp", "Reader::set_span", "one case for each meaning of a range"},
    {"fixtures/files/toml/rig_toml.cpp", "read_row",
     "each key of a row of fixtures once, in the order of the document"},
    {"fixtures/simulate/decode_model.cpp", "add_values", "one case for each parameter"},
    {"fixtures/photometry/parse.cpp", "parse_ldt", "EULUMDAT's fields in the order of their lines"},
    {"fixtures/photometry/table.cpp", "measured_table", "one derivation from angles to texels, with shared names"},
    {"render/reference/judge.cpp", "judge_scene", "one integral with the state that its lambdas share"},
    {"tools/footlight/status/metrics.cpp", "metrics_text", "each metric once, in the order of the page"},
};

struct LongFile {
  const char* file;
  const char* reason;
};

constexpr LongFile kLongFiles[] = {
    {"drivers/device/device.cpp", "one thread and what it shares with its ports"},
    {"fixtures/compile/compile_type.cpp", "one pass over a type, which fills one table"},
    {"fixtures/files/export/gdtf.cpp", "one document, in the order of its elements"},
    {"fixtures/files/import/gdtf_modes.cpp", "one reader, in the order of the elements of a mode"},
    {"fixtures/files/import/mvr.cpp", "one reader, in the order of the scene's elements"},
    {"fixtures/files/import/ofl_channels.cpp", "one reader: matrix, capabilities, channels"},
    {"fixtures/files/import/qxf_tables.cpp", "tables"},
    {"fixtures/files/import/rig_builder.cpp", "one builder: definitions, fixtures, frame of the rig"},
    {"fixtures/files/toml/fixture_toml_full.cpp", "one document, in the order of its tables"},
    {"fixtures/paperwork/plan.cpp", "one drawing, layer by layer"},
    {"fixtures/photometry/parse.cpp", "two formats that share their numbers"},
    {"fixtures/shared/decode.h", "decoding as one source for C++ and GLSL"},
    {"render/reference/judge.cpp", "one integral from the definition, apart from all that it judges"},
    {"render/resources.cpp", "sizes and makers of the buffers, in the order of what they follow from"},
    {"render/shaders/shared/beam.h", "the light of a beam as one source for C++ and GLSL"},
    {"render/shaders/shared/frame_io.h", "numbers and rows that every pass shares, once"},
    {"sim/merge.cpp", "who wins a universe, in one place"},
    {"sim/pump.cpp", "the loop, from top to bottom"},
    {"sim/shared/lamp.h", "lamps as one source for C++ and GLSL"},
    {"tools/footlight/doctor/doctor_checks.cpp", "one check after another"},
};

// Files of the program, its tools and benchmarks. Tests are excluded because their length has no meaning: they are
// lists.
bool is_product(std::string_view path) {
  return is_cpp(path) &&
         (starts_with(path, "sim/") || starts_with(path, "drivers/") || starts_with(path, "fixtures/") ||
          starts_with(path, "render/") || starts_with(path, "tools/"));
}

struct Function {
  std::string name;
  std::size_t line = 0;   // of its first line, from 1
  std::size_t count = 0;  // of lines, from the return type to the closing brace
};

std::string name_in(const std::string& head) {
  static const std::regex kName(R"rx(([~A-Za-z_][~A-Za-z0-9_:]*|operator[^ (]+)\s*\()rx");
  std::smatch match;
  return std::regex_search(head, match, kName) ? match[1].str() : head.substr(0, 60);
}

bool begins_with_word(std::string_view text, const std::set<std::string_view>& words) {
  return words.contains(text.substr(0, text.find_first_not_of("abcdefghijklmnopqrstuvwxyz")));
}

bool opens_type(std::string_view line) {
  if (starts_with(line, "template ")) line.remove_prefix(std::min(line.size(), line.find("> ") + 2));
  return ends_with(line, "{") && begins_with_word(line, {"class", "struct", "enum", "union"});
}

// Functions of namespaces and classes, found by the braces as clang-format places them. A function starts at the
// indentation at which its "}" is alone on a line. Functions of nested classes and lambdas are part of the function
// around them.
std::vector<Function> functions_of(const SourceFile& file) {
  static const std::set<std::string_view> kNoFunction = {"namespace", "extern", "for",    "while", "if",     "switch",
                                                         "do",        "else",   "return", "case",  "default"};
  std::vector<Function> found;
  for (const std::size_t indent : {std::size_t{0}, std::size_t{2}}) {
    std::size_t begin = 0;  // 0: outside a function
    bool in_class = false;
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
      const std::string& line = file.lines[i];
      if (!line.empty() && line.front() != ' ') in_class = opens_type(line);
      if (indent > 0 && !in_class) {
        begin = 0;
        continue;
      }
      if (line.size() <= indent || line.find_first_not_of(' ') != indent) continue;
      const std::string rest = line.substr(indent);
      if (rest == "}") {
        if (begin > 0) found.push_back({name_in(file.lines[begin - 1] + file.lines[begin]), begin, i + 2 - begin});
        begin = 0;
      } else if (rest.front() == '}' || rest.front() == '#' || starts_with(rest, "//") || ends_with(rest, ";") ||
                 ends_with(rest, "}") || ends_with(rest, ":") || opens_type(rest) ||
                 begins_with_word(rest, kNoFunction)) {
        begin = 0;
      } else if (begin == 0) {
        begin = i + 1;
      }
    }
  }
  return found;
}

TEST_CASE("the length of a function is counted from its return type to its closing brace") {
  const auto counted = [](std::vector<std::string> lines) { return functions_of({"a.cpp", std::move(lines)}); };
  const auto plain =
      counted({"namespace a {", "// About f.", "int f(int a,", "      int b) {", "  if (a) {", "    g();", "  }",
               "  return b;", "}", "", "int x = 3;", "int g() { return 3; }", "int h() {", "}"});
  REQUIRE(plain.size() == 2);
  CHECK(plain[0].name == "f");
  CHECK(plain[0].line == 3);
  CHECK(plain[0].count == 7);
  CHECK(plain[1].count == 2);
  const auto members = counted({"class A {", " public:", "  A();", "  int f() const {", "    return 3;", "  }", "};",
                                "", "int A::g() {", "  for (;;) {", "  }", "}"});
  REQUIRE(members.size() == 2);
  CHECK(members[0].name == "A::g");
  CHECK(members[1].name == "f");
  CHECK(members[1].count == 3);
}

TEST_CASE("functions of the program have at most 100 lines, except those that are listed with the reason") {
  std::vector<std::string> offences;
  std::set<std::pair<std::string, std::string>> longer;
  std::size_t count = 0;
  for (const SourceFile& file : tree()) {
    if (!is_product(file.path)) continue;
    for (const Function& function : functions_of(file)) {
      ++count;
      if (function.count <= kFunctionLinesMax) continue;
      longer.emplace(file.path, function.name);
      const bool listed =
          std::any_of(std::begin(kLongFunctions), std::end(kLongFunctions),
                      [&](const LongFunction& one) { return file.path == one.file && function.name == one.name; });
      if (listed) continue;
      offences.push_back(fmt::format("{}:{}: {} has {} lines; at most {}, or a row of kLongFunctions with the reason",
                                     file.path, function.line, function.name, function.count, kFunctionLinesMax));
    }
  }
  for (const LongFunction& one : kLongFunctions) {
    if (longer.contains({one.file, one.name})) continue;
    offences.push_back(fmt::format("kLongFunctions: {} in {} is short now: remove its row", one.name, one.file));
  }
  CHECK(count > 3000);
  check_none(offences);
}

TEST_CASE("files of the program have at most 600 lines, except those that are listed with the reason") {
  std::vector<std::string> offences;
  std::set<std::string> longer;
  for (const SourceFile& file : tree()) {
    if (!is_product(file.path) || file.lines.size() <= kFileLinesMax) continue;
    longer.insert(file.path);
    const bool listed = std::any_of(std::begin(kLongFiles), std::end(kLongFiles),
                                    [&](const LongFile& one) { return file.path == one.file; });
    if (listed) continue;
    offences.push_back(fmt::format("{}: {} lines; at most {}, or a row of kLongFiles with the reason", file.path,
                                   file.lines.size(), kFileLinesMax));
  }
  for (const LongFile& one : kLongFiles) {
    if (!longer.contains(one.file)) offences.push_back(fmt::format("kLongFiles: {}: remove its row", one.file));
  }
  check_none(offences);
}

}  // namespace
}  // namespace footlight
