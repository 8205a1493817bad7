#include "tools/footlight/preview/ui/words.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <unordered_map>

#include <libintl.h>
#include <locale.h>

#include "tools/footlight/preview/catalog_file.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDomain = "footlight";

using TextAndId = std::pair<const char*, const char*>;
struct HashOfBoth {
  std::size_t operator()(const TextAndId& both) const {
    return std::hash<const char*>()(both.first) * 31 + std::hash<const char*>()(both.second);
  }
};
struct WordsInUse {
  std::unique_ptr<Words> words;
  std::unordered_map<TextAndId, std::string, HashOfBoth> labels;
  std::unordered_map<const char*, const char*> formats;
};
WordsInUse& in_use() {
  static WordsInUse all;
  return all;
}

// The locale of the calling thread, for one call: strerror() and numbers keep theirs.
class LocaleOfWords {
 public:
  explicit LocaleOfWords(locale_t locale) : before_(uselocale(locale)) {}
  ~LocaleOfWords() { uselocale(before_); }
  LocaleOfWords(const LocaleOfWords&) = delete;
  LocaleOfWords& operator=(const LocaleOfWords&) = delete;

 private:
  locale_t before_;
};

class CatalogWords final : public Words {
 public:
  explicit CatalogWords(locale_t locale) : locale_(locale) {}
  ~CatalogWords() override { freelocale(locale_); }
  CatalogWords(const CatalogWords&) = delete;
  CatalogWords& operator=(const CatalogWords&) = delete;

  const char* word(const char* english) override {
    if (english[0] == '\0') return english;  // gettext has the catalog's head there
    const LocaleOfWords during(locale_);
    return dgettext(kDomain, english);
  }
  const char* word_of_count(const char* one, const char* many, unsigned long count) override {
    const LocaleOfWords during(locale_);
    return dngettext(kDomain, one, many, count);
  }
  [[nodiscard]] bool has_catalog() const {
    const LocaleOfWords during(locale_);
    return dgettext(kDomain, "")[0] != '\0';
  }

 private:
  locale_t locale_;
};

// The conversions of a format of printf(): "%.1f%%".
std::string conversions_of(std::string_view format) {
  std::string found;
  for (std::size_t at = format.find('%'); at != std::string_view::npos; at = format.find('%', at)) {
    const std::size_t end = format.find_first_not_of("0123456789.+-# ", at + 1);
    if (end == std::string_view::npos) return found + "?";
    found += format.substr(at, end + 1 - at);
    at = end + 1;
  }
  return found;
}

// Of the letters of ui_glyph_ranges().
std::uint32_t small_letter(std::uint32_t code) {
  const auto in = [&](std::uint32_t from, std::uint32_t to) { return code >= from && code <= to; };
  if (in('A', 'Z') || (in(0xc0, 0xde) && code != 0xd7) || in(0x391, 0x3a9) || in(0x410, 0x42f)) return code + 0x20;
  if (in(0x400, 0x40f)) return code + 0x50;
  if (in(0x139, 0x148) || in(0x179, 0x17e)) return code + code % 2;  // pairs that begin with odd ones
  if ((in(0x100, 0x137) && code != 0x130) || in(0x14a, 0x177) || in(0x460, 0x481) || in(0x48a, 0x4bf) ||
      in(0x4d0, 0x52f)) {
    return code | 1u;
  }
  return code == 0x178 ? 0xff : code;
}

// "de_AT" of "de_AT.UTF-8@euro".
std::string without_charset(std::string_view locale) {
  return std::string(locale.substr(0, locale.find_first_of(".@")));
}

}  // namespace

namespace words_detail {

const char* word_in(const char* context, const char* english) {
  const std::string both = fmt::format("{}\4{}", context, english);  // as catalogs have it
  const char* const translated = current->word(both.c_str());
  return translated == both.c_str() ? english : translated;
}

std::string format(const char* english, const char* translated, fmt::format_args args) {
  if (translated != english) {
    try {
      return fmt::vformat(translated, args);
    } catch (const fmt::format_error&) {  // of a catalog that nobody has checked
    }
  }
  return fmt::vformat(english, args);
}

}  // namespace words_detail

void use_words(std::unique_ptr<Words> words) {
  in_use().labels.clear();
  in_use().formats.clear();
  words_detail::current = words.get();
  in_use().words = std::move(words);
}

const char* tr_label(const char* english) { return tr_label(english, english); }

const char* tr_label(const char* english, const char* id) {
  std::string& label = in_use().labels[{english, id}];
  if (label.empty()) label = fmt::format("{}###{}", tr(english), id);
  return label.c_str();
}

const char* tr_printf(const char* english) {
  if (words_detail::current == nullptr) return english;
  const char*& format = in_use().formats[english];
  if (format == nullptr) {
    const char* const translated = tr(english);
    format = conversions_of(translated) == conversions_of(english) ? translated : english;
  }
  return format;
}

bool has_words(std::string_view text, std::string_view words) {
  for (std::size_t at = 0; at < words.size();) {
    const std::size_t end = std::min(words.find(' ', at), words.size());
    if (text.find(words.substr(at, end - at)) == std::string_view::npos) return false;
    at = end + 1;
  }
  return true;
}

std::string small_letters(std::string_view text) {
  std::string small;
  small.reserve(text.size());
  for (std::size_t at = 0; at < text.size(); ++at) {
    const auto first = static_cast<unsigned char>(text[at]);
    const auto second = at + 1 < text.size() ? static_cast<unsigned char>(text[at + 1]) : 0u;
    if ((first & 0xe0u) != 0xc0u || (second & 0xc0u) != 0x80u) {  // ASCII, and what has no such letters
      small += first < 0x80 ? static_cast<char>(small_letter(first)) : text[at];
      continue;
    }
    const std::uint32_t code = small_letter((first & 0x1fu) << 6u | (second & 0x3fu));
    small += static_cast<char>(0xc0u | code >> 6u);
    small += static_cast<char>(0x80u | (code & 0x3fu));
    ++at;
  }
  return small;
}

std::vector<std::string> languages_in(const std::string& folder) {
  std::vector<std::string> languages;
  std::error_code trouble;
  for (fs::directory_iterator at(folder, trouble); !trouble && at != fs::directory_iterator(); at.increment(trouble)) {
    std::error_code unknown;
    if (fs::exists(at->path() / "LC_MESSAGES" / (std::string(kDomain) + ".mo"), unknown)) {
      languages.push_back(at->path().filename().string());
    }
  }
  std::sort(languages.begin(), languages.end());
  return languages;
}

std::string language_of(const std::function<const char*(const char*)>& variable,
                        const std::vector<std::string>& languages) {
  const auto text_of = [&](const char* name) {
    const char* const value = variable(name);
    return std::string(value != nullptr ? value : "");
  };
  std::string locale;
  for (const char* name : {"LC_ALL", "LC_MESSAGES", "LANG"}) {
    if (locale.empty()) locale = text_of(name);
  }
  if (locale.empty() || locale == "C" || locale == "POSIX") return "";
  std::string wanted = text_of("LANGUAGE");
  if (wanted.empty()) wanted = locale;
  for (std::size_t at = 0; at < wanted.size();) {
    const std::size_t end = std::min(wanted.find(':', at), wanted.size());
    const std::string one = without_charset(std::string_view(wanted).substr(at, end - at));
    at = end + 1;
    const std::string language = one.substr(0, one.find('_'));
    if (language == "en" || language == "C" || language == "POSIX") return "";
    for (const std::string& known : {one, language}) {
      if (std::find(languages.begin(), languages.end(), known) != languages.end()) return known;
    }
  }
  return "";
}

namespace {

fs::path catalog_path(const std::string& language, const std::string& folder) {
  return fs::path(folder) / language / "LC_MESSAGES" / (std::string(kDomain) + ".mo");
}

// Of the files that gettext takes texts from: "pt_BR", and "pt" for what that lacks.
Status check_catalogs(const std::string& language, const std::string& folder) {
  for (const std::string& one : {language, language.substr(0, language.find('_'))}) {
    const fs::path path = catalog_path(one, folder);
    std::error_code trouble;
    if (fs::exists(path, trouble)) FL_TRY(check_catalog_file(path.string()));
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<Words>> open_words(const std::string& language, const std::string& folder) {
  FL_TRY(check_catalogs(language, folder));
  const char* const set = std::getenv("LANGUAGE");
  const std::optional<std::string> before = set != nullptr ? std::optional<std::string>(set) : std::nullopt;
  (void)setenv("LANGUAGE", language.c_str(), 1);
  bindtextdomain(kDomain, "/");  // another folder: gettext forgets the texts of another language
  bindtextdomain(kDomain, folder.c_str());
  bind_textdomain_codeset(kDomain, "UTF-8");
  // gettext reads LANGUAGE in any locale but "C", and newer ones not in C.UTF-8 either. The one of the language may not
  // be installed.
  for (const char* name : {"C.UTF-8", "", "en_US.UTF-8", "en_GB.UTF-8", "de_DE.UTF-8", "fr_FR.UTF-8"}) {
    const locale_t locale = newlocale(LC_MESSAGES_MASK, name, static_cast<locale_t>(nullptr));
    if (locale == nullptr) continue;
    auto words = std::make_unique<CatalogWords>(locale);
    if (words->has_catalog()) return std::unique_ptr<Words>(std::move(words));
  }
  (void)(before ? setenv("LANGUAGE", before->c_str(), 1) : unsetenv("LANGUAGE"));
  return fail(ErrorCode::kUnsupported,
              "no words of '{}' from {}: gettext takes them in no locale of this system; install one such as "
              "en_US.UTF-8, or use the language en",
              language, folder);
}

std::string words_folder() {
  std::error_code trouble;
  const fs::path program = fs::read_symlink("/proc/self/exe", trouble);
  return (program.parent_path().parent_path() / "share" / "locale").string();
}

Result<std::string> choose_words(const std::string& language, const std::string& folder) {
  const std::vector<std::string> languages = languages_in(folder);
  std::string chosen = language;
  if (language.empty()) {
    chosen = language_of([](const char* name) { return std::getenv(name); }, languages);
  } else if (language != "en" && std::find(languages.begin(), languages.end(), language) == languages.end()) {
    std::string known = "en";
    for (const std::string& one : languages) known += ", " + one;
    return fail(ErrorCode::kBadInput, "--language {}: expected one of {}; docs/translating.md has the steps to add one",
                language, known);
  }
  if (chosen.empty() || chosen == "en") {
    use_words(nullptr);
    return std::string();
  }
  auto words = open_words(chosen, folder);
  if (!words && !language.empty())
    return fail(words.error().code, "--language {}: {}", language, words.error().message);
  const bool damaged = !words && words.error().code != ErrorCode::kUnsupported;
  std::string note = damaged ? words.error().message + "; the window is in English" : "";
  use_words(words ? std::move(*words) : nullptr);
  return note;
}

}  // namespace footlight::tools
