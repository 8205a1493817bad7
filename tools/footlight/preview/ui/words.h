// The words of the window in the language of the user, by catalogs of GNU gettext (docs/translating.md).
//
//   ui_text(tr("no address"));
//   tell(trf("saved {}", path));
//   trf_n("{} slot", "{} slots", count, count);
//   if (ImGui::Button(tr_label("save"))) ...        "Speichern###save": the id is the same in every language
//   constexpr const char* kHeads[] = {tr_mark("Name"), ...};   and tr(kHeads[i]) where it is shown
//
// tools/make_words finds texts by the names of these functions, so a text is a literal. Without a catalog each returns
// its argument and looks nothing up. Errors (Result) stay English, as the command line and the files do.
// Threads: any, once use_words() has returned; tr_label() and tr_printf() are for the thread of ImGui.
#pragma once

#include <concepts>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "sim/core/result.h"

namespace footlight::tools {

// A language. Results live as long as it does.
class Words {
 public:
  Words() = default;
  Words(const Words&) = delete;
  Words& operator=(const Words&) = delete;
  virtual ~Words() = default;
  // The text itself, and the same pointer, where there is no translation. With a context it is "context\4text".
  [[nodiscard]] virtual const char* word(const char* english) = 0;
  [[nodiscard]] virtual const char* word_of_count(const char* one, const char* many, unsigned long count) = 0;
};

// From now on; null: English. Before other threads use words, and between pictures.
void use_words(std::unique_ptr<Words> words);

namespace words_detail {
inline Words* current = nullptr;  // of use_words()
const char* word_in(const char* context, const char* english);
// english where the translation has other placeholders.
std::string format(const char* english, const char* translated, fmt::format_args args);
}  // namespace words_detail

// A text that a table holds: marked for the catalog, translated where it is shown.
[[nodiscard]] constexpr const char* tr_mark(const char* english) { return english; }

[[nodiscard]] inline const char* tr(const char* english) {
  return words_detail::current == nullptr ? english : words_detail::current->word(english);
}
// Of an English word that is several words in other languages: `context` says which, to the translator.
[[nodiscard]] inline const char* tr_in(const char* context, const char* english) {
  return words_detail::current == nullptr ? english : words_detail::word_in(context, english);
}
[[nodiscard]] const char* tr_n(const char* one, const char* many, std::integral auto count) {
  if (words_detail::current == nullptr) return count == 1 ? one : many;
  return words_detail::current->word_of_count(one, many, static_cast<unsigned long>(count));
}

// As fmt::format(). Nothing throws where a translation has other placeholders: the English text is used.
template <class... Args>
[[nodiscard]] std::string trf(fmt::format_string<Args...> english, Args&&... args) {
  if (words_detail::current == nullptr) return fmt::format(english, std::forward<Args>(args)...);
  const char* const text = fmt::string_view(english).data();  // of a literal: it ends with 0
  return words_detail::format(text, tr(text), fmt::make_format_args(args...));
}
// Of a text that a table holds. Arguments that do not fit it leave it as it is.
template <class... Args>
[[nodiscard]] std::string trf_marked(const char* english, const Args&... args) {
  return words_detail::format(english, tr(english), fmt::make_format_args(args...));
}
// one, many: with the same placeholders.
template <std::integral Count, class... Args>
[[nodiscard]] std::string trf_n(fmt::format_string<Args...> one, fmt::format_string<Args...> many, Count count,
                                Args&&... args) {
  const char* const single = fmt::string_view(one).data();
  const char* const several = fmt::string_view(many).data();
  return words_detail::format(count == 1 ? single : several, tr_n(single, several, count),
                              fmt::make_format_args(args...));
}

// A label of Dear ImGui, whose id is id, or the English text.
[[nodiscard]] const char* tr_label(const char* english);
[[nodiscard]] const char* tr_label(const char* english, const char* id);
// A format of printf(), as sliders have. English where the translation has other conversions.
[[nodiscard]] const char* tr_printf(const char* english);

// UTF-8 with small letters instead of capitals: Latin, Greek and Cyrillic. For searches.
[[nodiscard]] std::string small_letters(std::string_view text);
// Whether each of the words, which spaces part, is in the text, in any order. Both in small letters.
[[nodiscard]] bool has_words(std::string_view text, std::string_view words);

// Languages with a catalog in this folder, sorted: "de".
[[nodiscard]] std::vector<std::string> languages_in(const std::string& folder);
// The one that variables of the environment ask for, as gettext reads them: LC_ALL, LC_MESSAGES or LANG, and LANGUAGE.
// Empty: English. variable: as getenv().
[[nodiscard]] std::string language_of(const std::function<const char*(const char*)>& variable,
                                      const std::vector<std::string>& languages);
// Of one of languages_in(). Sets LANGUAGE of the environment and no locale, so numbers in files do not change. Errors:
// those of check_catalog_file(); kUnsupported: this system has no locale for it.
[[nodiscard]] Result<std::unique_ptr<Words>> open_words(const std::string& language, const std::string& folder);

// The catalogs of this program: share/locale beside the folder of the program.
[[nodiscard]] std::string words_folder();
// What --language asks for; empty: the environment; "en": English. kBadInput names the languages that there are, or the
// catalog that is damaged. Returns a message for the user, usually none: where the environment asks for a language
// whose catalog is damaged, words are English.
[[nodiscard]] Result<std::string> choose_words(const std::string& language,
                                               const std::string& folder = words_folder());

}  // namespace footlight::tools
