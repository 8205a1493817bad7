#include "tools/footlight/status/printable.h"

#include <algorithm>
#include <cstdint>

namespace footlight::tools {

std::string printable_utf8(std::string_view text) {
  static constexpr std::string_view kReplacement = "\xEF\xBF\xBD";
  std::string clean;
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const std::size_t length = lead < 0x80 ? 1 : lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
    std::uint32_t code = length == 1 ? lead : lead & (0x7Fu >> length);
    bool good = lead < 0x80 || (lead >= 0xC2 && lead < 0xF5 && i + length <= text.size());
    for (std::size_t k = 1; good && k < length; ++k) {
      const auto next = static_cast<unsigned char>(text[i + k]);
      good = (next & 0xC0) == 0x80;
      code = code << 6 | (next & 0x3Fu);
    }
    const bool overlong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
    const bool control = code < 0x20 || (code >= 0x7F && code < 0xA0) || code == 0x2028 || code == 0x2029 ||
                         (code >= 0x202A && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);  // bidirectional
    good = good && !overlong && code <= 0x10FFFF && (code < 0xD800 || code > 0xDFFF);
    clean += good && !control ? text.substr(i, length) : kReplacement;
    i += good ? length : 1;
  }
  return clean;
}

std::string printable_line(std::string_view text) {
  constexpr std::size_t kBeginBytes = 1500, kEndBytes = 400;
  if (text.size() <= kBeginBytes + kEndBytes) return printable_utf8(text);
  // Cuts between characters: a byte of 10xxxxxx continues one.
  const auto goes_on = [&](std::size_t at) { return (static_cast<unsigned char>(text[at]) & 0xC0) == 0x80; };
  std::size_t end_of_begin = kBeginBytes, end = text.size() - kEndBytes;
  while (end_of_begin > 0 && goes_on(end_of_begin)) --end_of_begin;
  while (end < text.size() && goes_on(end)) ++end;
  return printable_utf8(text.substr(0, end_of_begin)) + " [...] " + printable_utf8(text.substr(end));
}

std::string printable_lines(std::string_view text) {
  std::string lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    lines += printable_line(text.substr(at, end - at));
    if (end < text.size()) lines += '\n';
    at = end + 1;
  }
  return lines;
}

}  // namespace footlight::tools
