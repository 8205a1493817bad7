#include "tests/support/ilda_bytes.h"

namespace footlight::testing {
namespace {

void word(std::string& out, int value) {
  const auto bits = static_cast<std::uint16_t>(value);
  out += static_cast<char>(bits >> 8);
  out += static_cast<char>(bits & 255);
}

}  // namespace

std::string ilda_section(int format, const std::vector<IldaRecord>& records) {
  std::string out = "ILDA";
  out.append(3, '\0');
  out += static_cast<char>(format);
  out += "FRAME   FOOTLIGH";
  word(out, static_cast<int>(records.size()));
  out.append(6, '\0');
  for (const IldaRecord& record : records) {
    if (format != 2) {
      word(out, record.x);
      word(out, record.y);
      if (format == 0 || format == 4) word(out, record.z);
      out += static_cast<char>(record.status);
    }
    if (format <= 1) {
      out += static_cast<char>(record.color);
    } else if (format == 2) {
      for (const std::uint8_t part : {record.red, record.green, record.blue}) out += static_cast<char>(part);
    } else {
      for (const std::uint8_t part : {record.blue, record.green, record.red}) out += static_cast<char>(part);
    }
  }
  return out;
}

std::string ilda_end() { return ilda_section(0, {}); }

}  // namespace footlight::testing
