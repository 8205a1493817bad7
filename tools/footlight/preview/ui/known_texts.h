// Texts that code below the window makes in English, in the language of the window.
//
// The command line has the same texts, and stays English. So the code that makes them has no part in languages, and a
// table has the forms of its texts: "patch 3 fixtures from 2.1" has the form "patch {} from {}".
#pragma once

#include <string>

namespace footlight::tools {

// The text itself where no form fits, as for most errors. Texts without gaps that are shown as they are go to tr().
[[nodiscard]] std::string tr_known(const std::string& english);

}  // namespace footlight::tools
