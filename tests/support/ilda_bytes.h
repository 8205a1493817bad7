// Writes ILDA files for tests.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace footlight::testing {

struct IldaRecord {
  int x = 0, y = 0, z = 0;
  std::uint8_t status = 0;
  std::uint8_t color = 0;  // number in the palette; formats 0 and 1
  std::uint8_t red = 0, green = 0, blue = 0;
};

// One section: a header and its records. format: 0, 1, 2 (of a palette), 4, 5.
[[nodiscard]] std::string ilda_section(int format, const std::vector<IldaRecord>& records);
// The header of 0 records that ends a file.
[[nodiscard]] std::string ilda_end();

}  // namespace footlight::testing
