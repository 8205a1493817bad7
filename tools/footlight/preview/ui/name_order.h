// The order of names in lists.
#pragma once

#include <string>
#include <string_view>

namespace footlight::tools {

// Below 0: a comes first. "Spot 9" is before "Spot 10": numbers count by their value, letters of ASCII in any case.
// Equal names are those of the same bytes.
[[nodiscard]] int compare_names(std::string_view a, std::string_view b);
// Names whose keys are compared byte by byte have that order, but for names that differ in capitals and zeros alone.
[[nodiscard]] std::string order_key(std::string_view name);

}  // namespace footlight::tools
