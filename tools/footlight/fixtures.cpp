// footlight fixtures: definitions of fixtures as files: judged and shown.
#include "tools/footlight/fixtures_command.h"

namespace footlight::tools {
namespace {

void add(Arguments& arguments) {
  add_fixtures_check(arguments);
  add_fixtures_show(arguments);
}

}  // namespace

extern const CommandInfo fixtures_command{
    .name = "fixtures",
    .help = "Judge definitions of fixtures, and show what is in them",
    .examples =
        "  footlight fixtures check ~/gdtf /usr/share/qlcplus/fixtures\n"
        "  footlight fixtures show head.gdtf --mode Standard\n",
    .add = add,
};

}  // namespace footlight::tools
