// Archives made by hand, so that tests can lie in them: sizes, methods and names that no honest program writes.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace footlight::testing {

struct ZipEntry {
  std::string name;
  std::string content;
  unsigned method = 0;          // 0: stored; 8: deflate, in blocks that are not squeezed; others are only claimed
  long long claimed_size = -1;  // unpacked; -1: the truth. Beyond 32 bits it is said as zip64 does
  unsigned flags = 0;           // 1: encrypted
  bool wrong_sum = false;       // the checksum is not that of the content
  std::uint64_t zeros = 0;      // instead of `content` so many zero bytes, as small as deflate can have them: a bomb
};

[[nodiscard]] std::string make_zip(const std::vector<ZipEntry>& entries);

}  // namespace footlight::testing
