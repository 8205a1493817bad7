// Prints the files that are generated from the driver table: udev/70-footlight.rules; with --hwdb
// udev/70-footlight.hwdb; with --hardware the table in docs/hardware.md.
#include <cstdio>
#include <cstring>

#include "drivers/udev_rules.h"

int main(int argc, char** argv) {
  using namespace footlight::drivers;
  const bool hardware = argc == 2 && std::strcmp(argv[1], "--hardware") == 0;
  if (argc > 1 && !hardware) {
    std::fprintf(stderr, "usage: %s [--hardware]\n", argv[0]);
    return 2;
  }
  const std::string text = hardware ? hardware_table_text() : udev_rules_text();
  return std::fputs(text.c_str(), stdout) < 0 ? 1 : 0;
}
