// The subcommands of `footlight fixtures`, one file each.
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
void add_fixtures_list(Arguments& arguments);
void add_fixtures_convert(Arguments& arguments);
void add_fixtures_attributes(Arguments& arguments);

// Lines that describe a fixture type. `mode`: only this one, by its name in any case or by its number from 1; empty:
// all. Fails if there is no such mode; the message lists the modes.
[[nodiscard]] Result<std::string> text_of_type(const fixtures::FixtureType& type, std::string_view mode);

// Its beams (angles; for measured lamps their energy check) and colours (CIEDE2000) as drawn, each with its difference
// from the definition.
[[nodiscard]] std::string optics_of_type(const fixtures::FixtureType& type);

}  // namespace footlight::tools
