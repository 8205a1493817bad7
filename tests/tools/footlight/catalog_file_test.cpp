// Damaged catalogs of words, which end the program in gettext if they get there.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "tests/sim/dmx_log/support.h"
#include "tools/footlight/preview/catalog_file.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;
using testing::TempFolder;

// A catalog as msgfmt writes it; "" without gettext.
std::string catalog_of(const TempFolder& folder, const std::string& entries, const std::string& options = "") {
  const std::string rule = "msgid \"\"\nmsgstr \"\"\n\"Content-Type: text/plain; charset=UTF-8\\n\"\n"
                           "\"Plural-Forms: nplurals=2; plural=(n != 1);\\n\"\n\n";
  std::ofstream(folder.file("a.po")) << (entries.starts_with("msgid \"\"") ? "" : rule) << entries;
  const std::string line = "msgfmt " + options + " -o " + folder.file("a.mo") + " " + folder.file("a.po") + " 2> " +
                           folder.file("err");
  if (std::system(line.c_str()) != 0) return "";  // NOLINT: a fixed command
  std::ifstream stream(folder.file("a.mo"), std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

bool has_msgfmt() {
  if (std::system("command -v msgfmt > /dev/null") == 0) return true;  // NOLINT: a fixed command
  MESSAGE("skipped: needs msgfmt; 'sudo apt-get install gettext'");
  return false;
}

std::string fault_of(std::string_view bytes) {
  const Status checked = check_catalog(bytes, "/x/de.mo");
  if (!checked) CHECK(checked.error().message.starts_with("/x/de.mo: damaged catalog of words: "));
  return checked ? "" : checked.error().message;
}

constexpr const char* kEntries = R"(
msgid "saved {}"
msgstr "gespeichert {}"

msgid "{} of {}"
msgstr "von {1} sind es {0}"

msgid "{} slot"
msgid_plural "{} slots"
msgstr[0] "{} Kanal"
msgstr[1] "{} Kanäle"

msgid "glare %.1f %%"
msgstr "Streulicht %.1f %%"
)";

TEST_CASE("a catalog is taken in either order of bytes and without a table of hashes") {
  if (!has_msgfmt()) return;
  const TempFolder folder;
  for (const char* options : {"", "--endianness=big", "--no-hash"}) {
    CAPTURE(options);
    const std::string bytes = catalog_of(folder, kEntries, options);
    REQUIRE(bytes.size() > 200);
    CHECK(fault_of(bytes).empty());
  }
}

TEST_CASE("placeholders of a translation are those of its text, in any order by their numbers") {
  CHECK(placeholders_in_order("{} of {:.1f}") == placeholders_in_order("{1:.1f} von {0}"));
  CHECK(placeholders_in_order("{} of {}") != placeholders_in_order("{} von"));
  CHECK(placeholders_in_order("{}") != placeholders_in_order("{:999999999}"));
  CHECK(placeholders_in_order("{}") != placeholders_in_order("{} {"));
  CHECK(placeholders_in_order("{{}}").empty());
  CHECK(placeholders_in_order("60 % of it").empty());
  CHECK(placeholders_in_order("%.1f %%") != placeholders_in_order("%s %%"));
}

TEST_CASE("a catalog with other placeholders, a rule that divides by 0 or another charset is refused with its path") {
  if (!has_msgfmt()) return;
  const TempFolder folder;
  CHECK(fault_of(catalog_of(folder, "msgid \"saved {}\"\nmsgstr \"{} {}\"\n")).find("'saved {}' has other") !=
        std::string::npos);
  const auto with_head = [&](const std::string& charset, const std::string& plural) {
    return fault_of(catalog_of(folder, "msgid \"\"\nmsgstr \"\"\n\"Content-Type: text/plain; charset=" + charset +
                                           "\\n\"\n\"Plural-Forms: nplurals=2; plural=" + plural +
                                           ";\\n\"\n\nmsgid \"a\"\nmsgstr \"b\"\n"));
  };
  CHECK(with_head("UTF-8", "n!=1").empty());
  CHECK(with_head("UTF-8", "n%10==1").empty());
  CHECK(with_head("ISO-8859-1", "n!=1").find("charset is not UTF-8") != std::string::npos);
  std::string bytes = catalog_of(folder, kEntries);
  const std::size_t rule = bytes.find("(n != 1)");
  REQUIRE(rule != std::string::npos);
  CHECK(fault_of(bytes.replace(rule, 8, "(n % 0 )")).find("rule for plural forms") != std::string::npos);
}

// As a user's files are: a bit, a byte or a word is another one, a part is gone, or the end is.
std::string damaged(std::string bytes, std::mt19937& random) {
  const auto any = [&](std::size_t below) { return std::uniform_int_distribution<std::size_t>(0, below - 1)(random); };
  switch (any(5)) {
    case 0: bytes[any(bytes.size())] ^= static_cast<char>(1 << any(8)); break;
    case 1: bytes[any(28)] = static_cast<char>(any(256)); break;
    case 2: bytes.resize(any(bytes.size())); break;
    case 3: bytes.erase(any(bytes.size() - 1), 1 + any(3)); break;
    default:
      for (std::size_t i = 0, at = any(bytes.size() - 8); i < 8; ++i) bytes[at + i] = static_cast<char>(any(256));
  }
  return bytes;
}

TEST_CASE("damaged copies of a catalog are refused with their path, or gettext can read them") {
  std::ifstream stream(FOOTLIGHT_WORDS_FOLDER "/de/LC_MESSAGES/footlight.mo", std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(stream), {}};
  if (whole.empty()) {
    MESSAGE("skipped: needs catalogs; 'sudo apt-get install gettext', configure and build again");
    return;
  }
  REQUIRE(fault_of(whole).empty());
  const TempFolder folder;
  std::mt19937 random(7);
  int refused = 0;
  int read = 0;
  for (int i = 0; i < 600; ++i) {
    const std::string bytes = damaged(whole, random);
    // Each in a folder of its own: gettext keeps what it has read.
    const std::string one = folder.file(std::to_string(i));
    fs::create_directories(one + "/de/LC_MESSAGES");
    std::ofstream(one + "/de/LC_MESSAGES/footlight.mo", std::ios::binary) << bytes;
    const auto chosen = choose_words("de", one);
    if (!chosen) {
      ++refused;
      CHECK_MESSAGE(chosen.error().message.find("footlight.mo: damaged catalog of words") != std::string::npos,
                    chosen.error().message);
      continue;
    }
    ++read;
    for (const char* text : {"no address", "saved {}", "a text of no catalog", "Fixtures", "error %.3f %%"}) {
      CHECK(std::string(tr(text)).size() < whole.size());
    }
    CHECK(!trf_n("{} channel", "{} channels", i, i).empty());
  }
  CHECK(refused > 150);
  CHECK(read > 30);
  REQUIRE(choose_words("en", folder.path().string()));
}

TEST_CASE("a damaged catalog of the language of the environment leaves words English, with a message") {
  const TempFolder folder;
  fs::create_directories(folder.file("de/LC_MESSAGES"));
  std::ofstream(folder.file("de/LC_MESSAGES/footlight.mo")) << "no catalog, but long enough for a head of one";
  const auto asked = choose_words("de", folder.file(""));
  REQUIRE(!asked);
  CHECK(asked.error().message.starts_with("--language de: " + folder.file("")));
  const char* const before = std::getenv("LC_ALL");
  const std::string kept = before != nullptr ? before : "";
  setenv("LC_ALL", "de_DE.UTF-8", 1);
  const auto chosen = choose_words("", folder.file(""));
  if (before != nullptr) {
    setenv("LC_ALL", kept.c_str(), 1);
  } else {
    unsetenv("LC_ALL");
  }
  REQUIRE(chosen);
  CHECK(chosen->find("footlight.mo: damaged catalog of words: it does not begin as a catalog") != std::string::npos);
  CHECK(chosen->ends_with("; the window is in English"));
  CHECK(std::string(tr("no address")) == "no address");
}

}  // namespace
}  // namespace footlight::tools
