// Whether a catalog of words (.mo of GNU gettext) can be given to gettext: glibc trusts what it maps, and a damaged
// file ends the program or never returns from a lookup.
#pragma once

#include <string>
#include <string_view>

#include "sim/core/result.h"

namespace footlight::tools {

inline constexpr std::size_t kCatalogBytesMax = std::size_t{16} << 20;

// bytes: of a .mo of revision 0, in either order of bytes. kBadInput names `path` and what is wrong: a table or a text
// outside of the file, a text without its end, texts that are not sorted, a table of hashes in which a text is not
// found, text that is not UTF-8, a rule for plural forms that may divide by 0, or a translation with other placeholders
// than its text.
[[nodiscard]] Status check_catalog(std::string_view bytes, const std::string& path);
// Of this file. Errors: those above, and kNotFound or kPermission.
[[nodiscard]] Status check_catalog_file(const std::string& path);

// "{}", "{:.1f}" and "%.1f" of a text in the order of their arguments, which "{1}" and "{0}" may change; a translation
// must have those of its text. What is no placeholder, as "{" alone, is one that no text has.
[[nodiscard]] std::string placeholders_in_order(std::string_view text);

}  // namespace footlight::tools
