// Languages for tests that need no catalog.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "tools/footlight/preview/ui/words.h"

namespace footlight::testing {

// Around every text that is translated. Dear ImGui writes "[" itself.
inline constexpr const char* kOpens = "<<";
inline constexpr const char* kCloses = ">>";

// Every text in brackets. Notes what was asked for.
class BracketWords final : public tools::Words {
 public:
  explicit BracketWords(std::set<std::string>& asked) : asked_(asked) {}
  const char* word(const char* english) override {
    asked_.insert(english);
    std::string& text = texts_[english];
    const std::string_view all = english;
    if (text.empty()) text = kOpens + std::string(all.substr(all.find('\4') + 1)) + kCloses;
    return text.c_str();
  }
  const char* word_of_count(const char* one, const char* many, unsigned long count) override {
    asked_.insert(one);
    return word(count == 1 ? one : many);
  }

 private:
  std::set<std::string>& asked_;
  std::map<std::string, std::string> texts_;
};

// Texts by a table; others stay.
class TableWords final : public tools::Words {
 public:
  explicit TableWords(std::map<std::string, std::string> texts) : texts_(std::move(texts)) {}
  const char* word(const char* english) override {
    const auto at = texts_.find(english);
    return at == texts_.end() ? english : at->second.c_str();
  }
  const char* word_of_count(const char* one, const char* many, unsigned long count) override {
    return word(count == 1 ? one : many);
  }

 private:
  std::map<std::string, std::string> texts_;
};

// A language while it lives.
class Spoken {
 public:
  explicit Spoken(std::unique_ptr<tools::Words> words) { tools::use_words(std::move(words)); }
  ~Spoken() { tools::use_words(nullptr); }
  Spoken(const Spoken&) = delete;
  Spoken& operator=(const Spoken&) = delete;
};

}  // namespace footlight::testing
