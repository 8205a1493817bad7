// The words of the window: languages, placeholders, and the catalogs in po/.
#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <clocale>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "tests/support/must.h"
#include "tests/tools/footlight/edit_desk.h"
#include "tests/tools/footlight/po_file.h"
#include "tests/tools/footlight/ui_rigs.h"
#include "tests/tools/footlight/words.h"
#include "tools/footlight/preview/ui/known_texts.h"
#include "tools/footlight/preview/ui/markers.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;
using testing::BracketWords;
using testing::must;
using testing::PoEntry;
using testing::Spoken;
using testing::TableWords;

const std::string kPoFolder = FOOTLIGHT_SOURCE_DIR "/po";

bool has_catalogs() {
  if (!languages_in(FOOTLIGHT_WORDS_FOLDER).empty()) return true;
  MESSAGE("skipped: needs catalogs; 'sudo apt-get install gettext', configure and build again");
  return false;
}

std::string output_of(const std::string& command) {
  std::string text;
  std::FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::array<char, 4096> part{};
  for (std::size_t got = 0; (got = std::fread(part.data(), 1, part.size(), pipe)) > 0;) text.append(part.data(), got);
  return pclose(pipe) == 0 ? text : "";
}

std::vector<std::string> translations() {
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(kPoFolder)) {
    if (entry.path().extension() == ".po") files.push_back(entry.path().string());
  }
  return files;
}

// "{}", "{:.1f}" and "%.1f" in the order of their texts: a translation may move them only by numbers.
std::vector<std::string> placeholders_of(const std::string& text) {
  static const std::regex kPlaceholder(R"(\{[^{}]*\}|%[0-9.+\-]*[a-z%])");
  return {std::sregex_token_iterator(text.begin(), text.end(), kPlaceholder), std::sregex_token_iterator()};
}

// What the English text has at each place: {1} of a translation is the second.
std::vector<std::string> in_english_order(const std::string& translated) {
  std::vector<std::string> order;
  for (const std::string& one : placeholders_of(translated)) {
    if (one.size() < 3 || one[0] != '{' || std::isdigit(static_cast<unsigned char>(one[1])) == 0) {
      order.push_back(one);
      continue;
    }
    const auto at = static_cast<std::size_t>(one[1] - '0');
    if (order.size() <= at) order.resize(at + 1);
    order[at] = "{" + one.substr(2);
  }
  return order;
}

TEST_CASE("without a language a text is its argument") {
  const char* const text = "no address";
  CHECK(tr(text) == text);
  CHECK(tr_printf(text) == text);
  CHECK(std::string(tr_n("{} slot", "{} slots", 1)) == "{} slot");
  CHECK(trf_n("{} slot", "{} slots", 2, 2) == "2 slots");
  CHECK(tr_known("patch 3 fixtures from 2.1") == "patch 3 fixtures from 2.1");
  CHECK(std::string(tr_in("DMX", "frames")) == "frames");
}

TEST_CASE("a context tells words apart that are one in English") {
  const Spoken words(std::make_unique<TableWords>(
      std::map<std::string, std::string>{{"frames", "Bilder"}, {"DMX\4frames", "Frames"}}));
  CHECK(std::string(tr("frames")) == "Bilder");
  CHECK(std::string(tr_in("DMX", "frames")) == "Frames");
  CHECK(std::string(tr_in("film", "frames")) == "frames");
}

TEST_CASE("the id of a label is the same in every language") {
  CHECK(std::string(tr_label("save")) == "save###save");
  {
    const Spoken german(std::make_unique<TableWords>(std::map<std::string, std::string>{{"save", "Speichern"}}));
    CHECK(std::string(tr_label("save")) == "Speichern###save");
    CHECK(std::string(tr_label("save", "rig")) == "Speichern###rig");
  }
  CHECK(std::string(tr_label("save")) == "save###save");
}

TEST_CASE("a translation with other placeholders is not used, and one that moves them by numbers is") {
  const Spoken words(
      std::make_unique<TableWords>(std::map<std::string, std::string>{{"saved {}", "gespeichert {} {}"},
                                                                      {"open {}", "öffne {:d}"},
                                                                      {"close {}", "schließe {"},
                                                                      {"{} of {}", "von {1} sind es {0}"},
                                                                      {"{} slot", "{} Kanal {}"},
                                                                      {"{} slots", "{} Kanäle"},
                                                                      {"error %.3f %%", "Fehler %s"},
                                                                      {"glare %.1f %%", "Streulicht %.1f %%"},
                                                                      {"head %d", "Kopf %"}}));
  CHECK(trf("saved {}", "a.toml") == "saved a.toml");
  CHECK(trf("open {}", "a.toml") == "open a.toml");
  CHECK(trf("close {}", "a.toml") == "close a.toml");
  CHECK(trf("{} of {}", 3, 5) == "von 5 sind es 3");
  CHECK(trf_marked(tr_mark("saved {}"), 3) == "saved 3");
  CHECK(trf_n("{} slot", "{} slots", 1, 1) == "1 slot");
  CHECK(trf_n("{} slot", "{} slots", 2, 2) == "2 Kanäle");
  CHECK(std::string(tr_printf("error %.3f %%")) == "error %.3f %%");
  CHECK(std::string(tr_printf("glare %.1f %%")) == "Streulicht %.1f %%");
  CHECK(std::string(tr_printf("head %d")) == "head %d");
}

TEST_CASE("the language is that of the environment, as gettext reads it, if there is a catalog") {
  const auto language = [](std::map<std::string, std::string> environment) {
    return language_of(
        [&](const char* name) {
          const auto at = environment.find(name);
          return at == environment.end() ? nullptr : at->second.c_str();
        },
        {"de", "pt", "pt_BR"});
  };
  CHECK(language({}).empty());
  CHECK(language({{"LANG", "de_AT.UTF-8@euro"}}) == "de");
  CHECK(language({{"LANG", "pt_BR.UTF-8"}}) == "pt_BR");
  CHECK(language({{"LANG", "pt_PT.UTF-8"}}) == "pt");
  CHECK(language({{"LANG", "fr_FR.UTF-8"}}).empty());
  CHECK(language({{"LANG", "fr_FR.UTF-8"}, {"LANGUAGE", "fr:de"}}) == "de");
  CHECK(language({{"LANG", "de_DE.UTF-8"}, {"LANGUAGE", "en_GB:de"}}).empty());
  CHECK(language({{"LANG", "de_DE.UTF-8"}, {"LC_MESSAGES", "en_US.UTF-8"}}).empty());
  CHECK(language({{"LANG", "de_DE.UTF-8"}, {"LC_MESSAGES", "fr_FR"}, {"LC_ALL", "pt_PT"}}) == "pt");
  // LANGUAGE counts for nothing in the locale C.
  CHECK(language({{"LANG", "C"}, {"LANGUAGE", "de"}}).empty());
  CHECK(language({{"LANGUAGE", "de"}}).empty());
}

TEST_CASE("an unknown language is refused with those that there are") {
  const auto chosen = choose_words("tlh", "/nowhere");
  REQUIRE(!chosen);
  CHECK(chosen.error().message.find("--language tlh: expected one of en;") != std::string::npos);
  CHECK(choose_words("en", "/nowhere"));
}

TEST_CASE("German words come from the catalog, and the locale, numbers and errors of the system stay as they are") {
  if (!has_catalogs()) return;
  const std::string locale = std::setlocale(LC_ALL, nullptr);
  const std::string error = std::strerror(EACCES);
  REQUIRE(choose_words("de", FOOTLIGHT_WORDS_FOLDER));
  CHECK(std::string(tr("no address")) == "keine Adresse");
  CHECK(trf_n("{} channel", "{} channels", 1, 1) == "1 Kanal");
  CHECK(trf_n("{} channel", "{} channels", 4, 4) == "4 Kanäle");
  CHECK(std::string(tr("a text of no catalog")) == "a text of no catalog");
  CHECK(std::string(tr("")).empty());
  CHECK(std::setlocale(LC_ALL, nullptr) == locale);
  CHECK(std::strerror(EACCES) == error);
  CHECK(std::string(std::localeconv()->decimal_point) == ".");
  CHECK(trf("{:.1f} s ago", 0.5) == "vor 0.5 s");
  CHECK(markers_text(Markers{{500'000'000, "Refrain"}}).find("at_s = 0.500000000") != std::string::npos);
  REQUIRE(choose_words("en", FOOTLIGHT_WORDS_FOLDER));
  CHECK(std::string(tr("no address")) == "no address");
}

TEST_CASE("texts of edits are known by their forms, with their counts, and errors of libraries stay English") {
  std::set<std::string> asked;
  const Spoken words(std::make_unique<BracketWords>(asked));
  CHECK(tr_known("patch 3 fixtures from 2.1") == "<<patch <<3 fixtures>> from 2.1>>");
  CHECK(tr_known("patch Spot 3 at 2.1") == "<<patch Spot 3 at 2.1>>");
  CHECK(tr_known("rename 2 fixtures to Par 1 ...") == "<<rename <<2 fixtures>> to Par 1 ...>>");
  CHECK(tr_known("delete the camera stalls") == "<<delete the camera stalls>>");
  CHECK(tr_known("sacn:1: lost: no route") == "<<sacn:1: lost: no route>>");
  for (const char* notice :
       {"sacn:1-9: universe 4 is not among those of this run; it stays unused",
        "sacn:1-9: universes 4-9 are not among those of this run; they stay unused",
        "a.dmxlog: damaged at byte 12: 2 parts of 90 bytes left out, where levels stay as they were; 'footlight log "
        "info a.dmxlog' lists them",
        "sacn:1: armed: it sends zeros until End is held, then the levels of the picture to real lamps"}) {
    CHECK_MESSAGE(tr_known(notice).starts_with(testing::kOpens), notice);
  }
  CHECK(tr_known("Spots of the fixtures") == "Spots of the fixtures");
  CHECK(tr_known("rig.toml:12: address 530 is past 512. Use 1 to 512.") ==
        "rig.toml:12: address 530 is past 512. Use 1 to 512.");
  CHECK(tr_known("").empty());
}

TEST_CASE("every edit that panels make has a known form") {
  testing::EditDesk edit(testing::parsed_rig(testing::kUiRig));
  std::set<std::string> asked;
  const Spoken words(std::make_unique<BracketWords>(asked));
  const fixtures::Rig& rig = edit.desk.edited();
  const std::vector<int> all{0, 1, 2};
  std::vector<Result<fixtures::RigEdit>> edits;
  for (const std::vector<int>& which : {std::vector<int>{0}, all}) {
    edits.push_back(fixtures::unpatch_fixtures(rig, which));
    edits.push_back(fixtures::delete_fixtures(rig, which));
    edits.push_back(fixtures::rename_fixtures(rig, which, "Front {}", 1));
    edits.push_back(fixtures::number_fixtures(rig, which, 11));
    edits.push_back(fixtures::move_fixtures(rig, which, {1, 0, 0}));
    edits.push_back(fixtures::add_rotation(rig, which, {1, 0, 0}));
    edits.push_back(fixtures::turn_fixtures(rig, which, {10.0, std::nullopt, std::nullopt}));
    edits.push_back(fixtures::clone_fixtures(rig, which, {.count = 1}));
    edits.push_back(fixtures::clone_fixtures(rig, which, {.count = 2}));
    fixtures::PatchStart start;
    start.universe = 3;
    edits.push_back(fixtures::patch_fixtures(rig, which, start));
    fixtures::PlaceAt at;
    at.position_m[0] = 1;
    edits.push_back(fixtures::place_fixtures(rig, which, at));
  }
  edits.push_back(fixtures::set_haze(rig, 0.01));
  for (const Result<fixtures::RigEdit>& one : edits) {
    const std::string text = must(one).text;
    INFO(text);
    CHECK(tr_known(text).starts_with(testing::kOpens));
  }
}

TEST_CASE("capitals become small letters in Latin, Greek and Cyrillic, and other bytes stay") {
  CHECK(small_letters("ÄÖÜ ÉŁŽŸ Ő") == "äöü éłžÿ ő");
  CHECK(small_letters("ΑΩ ЖЁ") == "αω жё");
  CHECK(small_letters("straße × ÷ 5°") == "straße × ÷ 5°");
  CHECK(small_letters("\xc3") == "\xc3");
  CHECK(small_letters("\xff\xc3\x28") == "\xff\xc3\x28");
}

TEST_CASE("the list of words is that of the sources") {
  if (output_of("command -v xgettext msgcat").empty()) {
    MESSAGE("skipped: needs xgettext; 'sudo apt-get install gettext'");
    return;
  }
  std::ifstream file(kPoFolder + "/footlight.pot");
  const std::string listed{std::istreambuf_iterator<char>(file), {}};
  const std::string found = output_of(FOOTLIGHT_SOURCE_DIR "/tools/make_words --pot");
  REQUIRE(!found.empty());
  const bool same = listed == found;
  CHECK_MESSAGE(same, "po/footlight.pot is old: run tools/make_words");
}

TEST_CASE("every translation has the placeholders of its text, and the list of languages has its file") {
  std::ifstream linguas(kPoFolder + "/LINGUAS");
  const std::string languages{std::istreambuf_iterator<char>(linguas), {}};
  for (const std::string& path : translations()) {
    INFO(path);
    CHECK(languages.find(fs::path(path).stem().string() + "\n") != std::string::npos);
    for (const PoEntry& entry : testing::read_po(path)) {
      INFO(entry.one);
      for (const std::string& text : entry.translated) {
        if (text.empty()) continue;
        CHECK(in_english_order(text) == placeholders_of(entry.one));
        CHECK((text.back() == '\n') == (entry.one.back() == '\n'));
      }
    }
  }
}

TEST_CASE("German has every word") {
  const std::vector<PoEntry> listed = testing::read_po(kPoFolder + "/footlight.pot");
  const std::vector<PoEntry> german = testing::read_po(kPoFolder + "/de.po");
  CHECK(listed.size() > 500);
  std::set<std::string> there;
  for (const PoEntry& entry : german) {
    const bool whole = std::none_of(entry.translated.begin(), entry.translated.end(),
                                    [](const std::string& text) { return text.empty(); });
    if (whole && !entry.fuzzy) there.insert(entry.one);
  }
  for (const PoEntry& entry : listed) CHECK_MESSAGE(there.contains(entry.one), entry.one);
}

}  // namespace
}  // namespace footlight::tools
