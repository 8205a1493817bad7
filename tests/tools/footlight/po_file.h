// Reads the catalogs that translators edit (po/*.po).
#pragma once

#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace footlight::testing {

struct PoEntry {
  std::string one;                      // with its context: "context\4text"
  std::string many;                     // empty: no count
  std::vector<std::string> translated;  // one, or one a plural form
  bool fuzzy = false;
};

inline std::string po_text(const std::string& line) {
  std::string text;
  const std::size_t from = line.find('"');
  for (std::size_t i = from + 1; i + 1 < line.size(); ++i) {
    const bool escaped = line[i] == '\\';
    if (escaped) ++i;
    text += escaped && line[i] == 'n' ? '\n' : line[i];
  }
  return text;
}

// Without the head, which has an empty text.
inline std::vector<PoEntry> read_po(const std::string& path) {
  std::vector<PoEntry> all;
  std::ifstream file(path);
  std::string* into = nullptr;
  bool fuzzy = false;
  std::string context;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("#,")) fuzzy = line.find("fuzzy") != std::string::npos;
    if (line.starts_with("msgctxt ")) context = po_text(line) + '\4';
    if (line.starts_with("msgid ")) {
      all.emplace_back().fuzzy = fuzzy;
      all.back().one = std::exchange(context, {});
      fuzzy = false;
      into = &all.back().one;
    } else if (line.starts_with("msgid_plural ")) {
      into = &all.back().many;
    } else if (line.starts_with("msgstr")) {
      into = &all.back().translated.emplace_back();
    } else if (!line.starts_with("\"")) {
      into = nullptr;
    }
    if (into != nullptr) *into += po_text(line);
  }
  std::erase_if(all, [](const PoEntry& entry) { return entry.one.empty(); });
  return all;
}

}  // namespace footlight::testing
