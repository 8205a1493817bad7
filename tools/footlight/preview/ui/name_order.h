// The order of names in lists.
#pragma once

#include <string_view>

namespace footlight::tools {

// Below 0: a comes first. "Spot 9" is before "Spot 10": numbers count by their value, letters of ASCII in any case.
// Equal names are those of the same bytes.
[[nodiscard]] int compare_names(std::string_view a, std::string_view b);

}  // namespace footlight::tools
