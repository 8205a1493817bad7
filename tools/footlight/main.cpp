#include "tools/footlight/command.h"

int main(int argc, char** argv) { return footlight::tools::run_command_line(argc, argv, footlight::tools::commands()); }
