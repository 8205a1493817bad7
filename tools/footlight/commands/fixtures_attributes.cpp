// footlight fixtures attributes: prints which attributes are parsed and which are simulated.
#include <fmt/format.h>

#include "fixtures/model/coverage.h"
#include "tools/footlight/commands/fixtures_command.h"

namespace footlight::tools {

void add_fixtures_attributes(Arguments& arguments) {
  Arguments attributes =
      arguments.subcommand("attributes", "List the GDTF attributes, and whether each is parsed and simulated",
                           "  footlight fixtures attributes > attributes.md\n");
  attributes.job([]() -> Result<int> {
    fmt::print("{}", fixtures::coverage_table());
    return kExitOk;
  });
}

}  // namespace footlight::tools
