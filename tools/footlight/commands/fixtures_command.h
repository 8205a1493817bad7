// The subcommands of `footlight fixtures`, a file each.
#pragma once

#include <string>
#include <string_view>

#include "fixtures/model/fixture_type.h"
#include "sim/core/result.h"
#include "tools/footlight/command.h"

namespace footlight::tools {

void add_fixtures_check(Arguments& arguments);
void add_fixtures_show(Arguments& arguments);
void add_fixtures_find(Arguments& arguments);
void add_fixtures_convert(Arguments& arguments);
void add_fixtures_attributes(Arguments& arguments);

// All of a fixture type that a person may want to know, in lines. `mode`: only this one, by its name in any case or by
// its number from 1; empty: all. Fails where there is none such, with the names that there are.
[[nodiscard]] Result<std::string> text_of_type(const fixtures::FixtureType& type, std::string_view mode);

// What is drawn of its beams (angles; of measured lamps their energy check) and colours (CIEDE2000), each with its
// distance from what the definition says.
[[nodiscard]] std::string optics_of_type(const fixtures::FixtureType& type);

}  // namespace footlight::tools
