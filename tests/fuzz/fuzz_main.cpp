// Handles "--seeds=FOLDER" for every fuzz target; libFuzzer handles all other arguments.
#include <cstdio>
#include <fstream>
#include <string>

#include "tests/fuzz/fuzz.h"

namespace footlight::testing {

void Seeds::add(std::string_view name, std::span<const std::uint8_t> bytes) {
  const std::string path = folder_ + "/seed-" + std::string(name);
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (file) return;
  std::fprintf(stderr, "%s: cannot be written\n", path.c_str());
  std::exit(1);
}

void Seeds::add(std::string_view name, std::string_view text) {
  add(name, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

}  // namespace footlight::testing

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  constexpr std::string_view kOption = "--seeds=";
  if (*argc != 2 || !std::string_view((*argv)[1]).starts_with(kOption)) return 0;
  footlight::testing::Seeds seeds((*argv)[1] + kOption.size());
  footlight::testing::add_seeds(seeds);
  std::exit(0);
}
