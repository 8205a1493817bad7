// The parts of a fuzz target, in addition to LLVMFuzzerTestOneInput(): the first inputs of its corpus.
//
// A target is one file, <name>_fuzz.cpp, and one line in CMakeLists.txt here. It parses bytes in the same way as the
// program and checks what the header of the parser states. fuzz_main.cpp is linked into every target and adds
// "--seeds=FOLDER", which writes the first inputs and exits; tools/fuzz builds, seeds and runs all targets.
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
  // One file of the corpus. Ends the program if it cannot be written.
  void add(std::string_view name, std::span<const std::uint8_t> bytes);
  void add(std::string_view name, std::string_view text);

 private:
  std::string folder_;
};

// Defined by every target: well-formed inputs of each kind, from our own encoders.
void add_seeds(Seeds& seeds);

// Aborts unless the property holds.
inline void require(bool holds) {
  if (!holds) std::abort();
}

}  // namespace footlight::testing
