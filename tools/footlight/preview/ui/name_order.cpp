#include "tools/footlight/preview/ui/name_order.h"

#include <cctype>
#include <cstddef>

namespace footlight::tools {
namespace {

// The number that begins at `at`, which moves behind it, without zeros before it.
std::string_view number_at(std::string_view text, std::size_t& at) {
  while (at < text.size() && text[at] == '0') ++at;
  const std::size_t from = at;
  while (at < text.size() && std::isdigit(static_cast<unsigned char>(text[at])) != 0) ++at;
  return text.substr(from, at - from);
}

}  // namespace

int compare_names(std::string_view a, std::string_view b) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    const auto x = static_cast<unsigned char>(a[i]);
    const auto y = static_cast<unsigned char>(b[j]);
    if (std::isdigit(x) != 0 && std::isdigit(y) != 0) {
      const std::string_view one = number_at(a, i);
      const std::string_view other = number_at(b, j);
      if (one.size() != other.size()) return one.size() < other.size() ? -1 : 1;
      if (const int order = one.compare(other); order != 0) return order;
      continue;
    }
    if (std::tolower(x) != std::tolower(y)) return std::tolower(x) - std::tolower(y);
    ++i;
    ++j;
  }
  if (i < a.size() || j < b.size()) return i < a.size() ? 1 : -1;
  return a.compare(b);  // so that each order is the same
}

std::string order_key(std::string_view name) {
  std::string key;
  key.reserve(name.size() + 4);
  for (std::size_t i = 0; i < name.size();) {
    if (std::isdigit(static_cast<unsigned char>(name[i])) == 0) {
      key += static_cast<char>(std::tolower(static_cast<unsigned char>(name[i++])));
      continue;
    }
    const std::string_view number = number_at(name, i);  // a longer one is larger
    key += '0';
    key += static_cast<char>(number.size() < 255 ? number.size() : 255);
    key += number;
  }
  return key;
}

}  // namespace footlight::tools
