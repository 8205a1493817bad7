#include "tools/footlight/preview/catalog_file.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

#include <fmt/format.h>

#include "fixtures/files/import/text.h"

namespace footlight::tools {
namespace {

constexpr std::uint32_t kMagic = 0x950412de;
constexpr std::size_t kHeadBytes = 28;
constexpr std::size_t kPluralRuleMax = 500;  // glibc parses it by recursion

bool is_utf8(std::string_view text) { return fixtures::first_not_utf8(text) >= text.size(); }

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

// As glibc computes it, of P. J. Weinberger.
std::uint32_t hash_of(std::string_view text) {
  std::uint32_t hash = 0;
  for (const char each : text) {
    hash = (hash << 4) + static_cast<unsigned char>(each);
    if (const std::uint32_t high = hash & 0xf0000000u; high != 0) hash = (hash ^ (high >> 24)) & ~high;
  }
  return hash;
}

bool is_prime(std::uint32_t number) {
  if (number < 2) return false;
  for (std::uint32_t by = 2; by * by <= number; ++by) {
    if (number % by == 0) return false;
  }
  return true;
}

// A rule as "nplurals=2; plural=(n != 1);": letters, numbers and operators of C, and nothing that divides by 0, which
// would end the program.
bool is_plural_rule(std::string_view rule) {
  if (rule.size() > kPluralRuleMax) return false;
  for (std::size_t i = 0; i < rule.size(); ++i) {
    if (rule[i] == '/') return false;
    if (rule[i] != '%') continue;
    const std::size_t digits = rule.find_first_not_of(' ', i + 1);
    if (digits == std::string_view::npos || !is_digit(rule[digits]) || rule[digits] == '0') return false;
  }
  return true;
}

// The value of a line "Name: value" of the catalog's head.
std::string_view head_value(std::string_view head, std::string_view name) {
  for (std::size_t at = 0; at < head.size();) {
    const std::size_t end = std::min(head.find('\n', at), head.size());
    const std::string_view line = head.substr(at, end - at);
    if (line.starts_with(name) && line.substr(name.size()).starts_with(':')) return line.substr(name.size() + 1);
    at = end + 1;
  }
  return {};
}

// A placeholder of printf() that begins at `at`: as "%.1f" or "%%"; empty: it is a per cent sign of a text.
std::string_view conversion_at(std::string_view text, std::size_t at) {
  const std::size_t end = text.find_first_not_of("0123456789.+-", at + 1);
  if (end == std::string_view::npos) return {};
  const bool ends = text[end] == '%' || std::islower(static_cast<unsigned char>(text[end])) != 0;
  return ends ? text.substr(at, end + 1 - at) : std::string_view();
}

class Catalog {
 public:
  Catalog(std::string_view bytes, const std::string& path) : bytes_(bytes), path_(path) {}

  Status check() {
    if (bytes_.size() < kHeadBytes) return wrong("it is shorter than the head of a catalog");
    if (bytes_.size() > kCatalogBytesMax) return wrong(fmt::format("more than {} MiB", kCatalogBytesMax >> 20));
    if (number(0) != kMagic) swapped_ = true;
    if (number(0) != kMagic) return wrong("it does not begin as a catalog");
    if (number(4) != 0) return wrong("its revision is not 0");
    count_ = number(8);
    if (!fits(number(12), count_, 8) || !fits(number(16), count_, 8)) return wrong("its tables reach beyond its end");
    if (count_ == 0) return wrong("it has no texts");
    for (std::uint32_t i = 0; i < count_; ++i) FL_TRY(check_text(i));
    FL_TRY(check_head());
    return check_hashes();
  }

 private:
  [[nodiscard]] Error fault(std::string_view what) const {
    return {ErrorCode::kBadInput,
            fmt::format("{}: damaged catalog of words: {}; build or install it again", path_, what)};
  }
  [[nodiscard]] Status wrong(std::string_view what) const { return tl::unexpected<Error>(fault(what)); }

  [[nodiscard]] std::uint32_t number(std::size_t at) const {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes_.data() + at, sizeof(value));
    return swapped_ ? __builtin_bswap32(value) : value;
  }
  [[nodiscard]] bool fits(std::uint64_t at, std::uint64_t count, std::uint64_t size) const {
    return at % 4 == 0 && at <= bytes_.size() && count * size <= bytes_.size() - at;
  }
  // Of the table that number(table) names. Nothing: outside of the file, or without its end.
  [[nodiscard]] Result<std::string_view> text_of(std::size_t table, std::uint32_t index) const {
    const std::size_t row = number(table) + std::size_t{index} * 8;
    const std::uint64_t length = number(row);
    const std::uint64_t at = number(row + 4);
    if (at + length >= bytes_.size()) {
      return tl::unexpected<Error>(fault(fmt::format("text {} reaches beyond its end", index)));
    }
    if (bytes_[at + length] != '\0') return tl::unexpected<Error>(fault(fmt::format("text {} has no end", index)));
    return bytes_.substr(at, length);
  }

  // With the text before it, since gettext looks texts up in their order.
  Status check_text(std::uint32_t index) {
    FL_ASSIGN(const std::string_view text, text_of(12, index));
    FL_ASSIGN(const std::string_view translated, text_of(16, index));
    if (!is_utf8(text) || !is_utf8(translated)) return wrong(fmt::format("text {} is not UTF-8", index));
    const std::string_view one = text.substr(0, text.find('\0'));
    if (index > 0 && one <= before_) return wrong(fmt::format("text {} is not in order", index));
    before_ = one;
    if (one.empty()) return {};
    const std::size_t several = text.find('\0');
    const std::string_view many = several == std::string_view::npos ? one : text.substr(several + 1);
    const std::string expected = placeholders_in_order(one);
    const std::string expected_many = placeholders_in_order(many);
    for (std::size_t at = 0; at <= translated.size();) {
      const std::size_t end = std::min(translated.find('\0', at), translated.size());
      const std::string own = placeholders_in_order(translated.substr(at, end - at));
      if (own != expected && own != expected_many) {
        return wrong(fmt::format("the translation of '{}' has other placeholders", one));
      }
      at = end + 1;
    }
    return {};
  }

  Status check_head() {
    FL_ASSIGN(const std::string_view first, text_of(12, 0));
    FL_ASSIGN(const std::string_view head, text_of(16, 0));
    if (!first.empty()) return wrong("it has no head");
    if (head_value(head, "Content-Type").find("charset=UTF-8") == std::string_view::npos) {
      return wrong("its charset is not UTF-8");
    }
    // glibc looks for these words anywhere in the head.
    const std::size_t rule = head.find("plural=");
    if (rule == std::string_view::npos) return {};
    const std::string_view line = head.substr(rule, head.find('\n', rule) - rule);
    return is_plural_rule(line) ? Status{} : wrong("its rule for plural forms cannot be used");
  }

  // Each text must be found, and each search must end: it goes through a table of a prime size with a gap in it.
  Status check_hashes() const {
    const std::uint32_t size = number(20);
    const std::uint32_t table = number(24);
    if (size <= 2) return {};  // gettext searches the sorted texts
    if (!fits(table, size, 4)) return wrong("its table of hashes reaches beyond its end");
    if (!is_prime(size) || size <= count_) return wrong("its table of hashes has a wrong size");
    std::size_t used = 0;
    for (std::uint32_t i = 0; i < size; ++i) {
      const std::uint32_t entry = number(table + std::size_t{i} * 4);
      if (entry > count_) return wrong("its table of hashes names a text that is not there");
      used += entry != 0 ? 1 : 0;
    }
    if (used != count_) return wrong("its table of hashes has a wrong number of texts");
    for (std::uint32_t i = 0; i < count_; ++i) {
      FL_ASSIGN(const std::string_view text, text_of(12, i));
      const std::uint32_t hash = hash_of(text.substr(0, text.find('\0')));
      const std::uint32_t step = 1 + hash % (size - 2);
      std::uint64_t at = hash % size;
      std::uint32_t entry = 0;
      while ((entry = number(table + at * 4)) != 0 && entry != i + 1) at = (at + step) % size;
      if (entry == 0) return wrong(fmt::format("text {} is not in its table of hashes", i));
    }
    return {};
  }

  std::string_view bytes_;
  const std::string& path_;
  bool swapped_ = false;
  std::uint32_t count_ = 0;
  std::string_view before_;
};

}  // namespace

std::string placeholders_in_order(std::string_view text) {
  std::vector<std::string> order;
  for (std::size_t at = text.find_first_of("{}%"); at < text.size(); at = text.find_first_of("{}%", at)) {
    std::string one;
    std::size_t place = order.size();
    std::size_t end = at + 1;
    if (text[at] == '%') {
      const std::string_view conversion = conversion_at(text, at);
      if (conversion.empty()) {
        ++at;
        continue;
      }
      one = conversion;
      end = at + conversion.size();
    } else if (text.substr(at, 2) == "{{" || text.substr(at, 2) == "}}") {
      at += 2;
      continue;
    } else if (const std::size_t closed = text.find_first_of("{}", at + 1);
               text[at] == '{' && closed != std::string_view::npos && text[closed] == '}') {
      one = text.substr(at, closed + 1 - at);
      end = closed + 1;
      if (one.size() >= 3 && is_digit(one[1])) {
        place = static_cast<std::size_t>(one[1] - '0');
        one.erase(1, 1);
      }
    } else {
      one = "?";
    }
    if (order.size() <= place) order.resize(place + 1);
    order[place] = one;
    at = end;
  }
  std::string all;
  for (const std::string& one : order) all += one + "\n";
  return all;
}

Status check_catalog(std::string_view bytes, const std::string& path) { return Catalog(bytes, path).check(); }

Status check_catalog_file(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return fail(ErrorCode::kNotFound, "{}: cannot be opened: {}", path, std::strerror(errno));
  std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (stream.bad()) return fail(ErrorCode::kIo, "{}: cannot be read: {}", path, std::strerror(errno));
  return check_catalog(bytes, path);
}

}  // namespace footlight::tools
