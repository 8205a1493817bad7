// The lines of a document that a user types, and how a test runs them.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {

using Words = std::vector<std::string>;

// How a line is changed for the test.
struct Special {
  const char* line;     // as in the document, without its comment
  const char* instead;  // the command to run; nullptr: the line itself with `more`
  const char* more;     // arguments added at the end
  int exit_code;        // besides 0
  const char* reason;
};

inline std::string trimmed_line(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(' ');
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(' ') - begin + 1);
}

// Lines of the code blocks that begin with the program's name, without their comments.
inline Words doc_lines(const std::string& path) {
  std::ifstream file(path);
  REQUIRE(file.good());
  Words lines;
  bool in_block = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("```")) {
      in_block = !in_block;
    } else if (in_block && line.starts_with("footlight ")) {
      lines.push_back(trimmed_line(line.substr(0, line.find(" #"))));
    }
  }
  return lines;
}

// The blocks of TOML whose first line is "# NAME", by that name.
inline std::map<std::string, std::string> doc_files(const std::string& path) {
  std::ifstream file(path);
  REQUIRE(file.good());
  std::map<std::string, std::string> files;
  std::string* open = nullptr;
  bool begins = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("```")) {
      begins = line == "```toml";
      open = nullptr;
    } else if (begins) {
      begins = false;
      REQUIRE(line.starts_with("# "));
      open = &files[line.substr(2)];
    } else if (open != nullptr) {
      *open += line + "\n";
    }
  }
  return files;
}

// Splits words as a shell does, with single quotes.
inline Words words_of(const std::string& line) {
  Words words;
  std::string word;
  bool any = false, quoted = false;
  for (const char c : line + " ") {
    if (c == '\'') {
      quoted = !quoted;
      any = true;
    } else if (c == ' ' && !quoted) {
      if (any) words.push_back(std::exchange(word, {}));
      any = false;
    } else {
      word += c;
      any = true;
    }
  }
  return words;
}

// Every special line must be in the document.
inline void check_specials(std::span<const Special> specials, const Words& lines) {
  for (const Special& special : specials) {
    const bool found = std::find(lines.begin(), lines.end(), special.line) != lines.end();
    CHECK_MESSAGE(found, "not in the document: " << special.line);
  }
}

// The command of a line, with what is special about it.
inline std::pair<Words, Special> command_of(const std::string& line, std::span<const Special> specials) {
  Special special{line.c_str(), nullptr, "", 0, ""};
  for (const Special& one : specials) {
    if (line == one.line) special = one;
  }
  Words words = words_of((special.instead != nullptr ? special.instead : line) + (" " + std::string(special.more)));
  words.erase(words.begin());
  return {words, special};
}

// The folder in which programs are started.
class WorkingFolder {
 public:
  explicit WorkingFolder(const std::filesystem::path& folder) : before_(std::filesystem::current_path()) {
    std::filesystem::current_path(folder);
  }
  ~WorkingFolder() { std::filesystem::current_path(before_); }
  WorkingFolder(const WorkingFolder&) = delete;
  WorkingFolder& operator=(const WorkingFolder&) = delete;

 private:
  std::filesystem::path before_;
};

}  // namespace footlight::testing
