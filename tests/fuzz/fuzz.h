// What a fuzz target consists of, beside LLVMFuzzerTestOneInput(): the inputs that its corpus begins with.
//
// A target is one file, <name>_fuzz.cpp, and one line in CMakeLists.txt here. It reads bytes from outside the way the
// program does and checks what the header of the parser promises. fuzz_main.cpp is linked into every target and adds
// "--seeds=FOLDER", which writes the first inputs and ends; tools/fuzz builds, seeds and runs all of them.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <string_view>

namespace footlight::testing {

class Seeds {
 public:
  explicit Seeds(std::string folder) : folder_(std::move(folder)) {}
  // One file of the corpus. Ends the program where it cannot be written.
  void add(std::string_view name, std::span<const std::uint8_t> bytes);
  void add(std::string_view name, std::string_view text);

 private:
  std::string folder_;
};

// Every target defines it: well-formed inputs of each kind, from our own encoders.
void add_seeds(Seeds& seeds);

// What has to hold for every input.
inline void require(bool holds) {
  if (!holds) std::abort();
}

}  // namespace footlight::testing
