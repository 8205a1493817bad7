// Texts that code below the window makes in English, in the language of the window.
//
// The command line has the same texts, and stays English. So the code that makes them knows no languages, and this table
// knows the forms that they have: "patch 3 fixtures from 2.1" is one of "patch {} from {}".
#pragma once

#include <string>

namespace footlight::tools {

// The text itself where no form fits: errors stay English. A form that is the whole text is for tr() instead.
[[nodiscard]] std::string tr_known(const std::string& english);

}  // namespace footlight::tools
