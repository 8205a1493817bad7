// Archives with wrong fields, for tests: sizes, methods and names that no correct program writes.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace footlight::testing {

struct ZipEntry {
  std::string name;
  std::string content;
  unsigned method = 0;          // 0: stored; 8: deflate, in uncompressed blocks; others are only declared
  long long claimed_size = -1;  // unpacked; -1: the true size. Beyond 32 bits it is stored as in zip64
  unsigned flags = 0;           // 1: encrypted
  bool wrong_sum = false;       // the checksum does not match the content
  std::uint64_t zeros = 0;  // this many zero bytes instead of `content`, as small as deflate can make them: a zip bomb
};

[[nodiscard]] std::string make_zip(const std::vector<ZipEntry>& entries);

}  // namespace footlight::testing
