// footlight fixtures: checks, shows, finds, lists and converts fixture definitions.
#include "tools/footlight/commands/fixtures_command.h"

namespace footlight::tools {
namespace {

void add(Arguments& arguments) {
  add_fixtures_check(arguments);
  add_fixtures_show(arguments);
  add_fixtures_find(arguments);
  add_fixtures_list(arguments);
  add_fixtures_convert(arguments);
  add_fixtures_attributes(arguments);
}

}  // namespace

extern const CommandInfo fixtures_command{
    .name = "fixtures",
    .help = "Check, show, find, list and convert fixture definitions",
    .examples =
        "  footlight fixtures check ~/gdtf /usr/share/qlcplus/fixtures\n"
        "  footlight fixtures show head.gdtf --mode Standard\n"
        "  footlight fixtures find robe pointe\n"
        "  footlight fixtures list wash\n"
        "  footlight fixtures convert head.gdtf -o head.toml\n"
        "  footlight fixtures attributes\n",
    .add = add,
};

}  // namespace footlight::tools
