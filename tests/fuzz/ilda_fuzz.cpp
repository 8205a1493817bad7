// ILDA files: what is read has frames of points within the range, in colours from 0 to 1, and can be cut into parts.
#include <cmath>

#include "fixtures/laser/ilda.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/ilda_bytes.h"

using namespace footlight;
using footlight::testing::require;

void footlight::testing::add_seeds(Seeds& seeds) {
  const std::vector<IldaRecord> points = {
      {-20000, 0, 0, 0x40, 0, 0, 0, 0}, {20000, 100, 5, 0, 3, 255, 10, 20}, {0, 32767, -5, 0x80, 60, 0, 255, 0}};
  for (const int format : {0, 1, 4, 5}) {
    seeds.add("format" + std::to_string(format), ilda_section(format, points) + ilda_end());
  }
  seeds.add("palette", ilda_section(2, points) + ilda_section(1, points) + ilda_section(0, points) + ilda_end());
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto file = fixtures::parse_ilda(std::as_bytes(std::span(data, size)), "fuzz");
  if (!file) {
    require(file.error().message.starts_with("fuzz"));
    return 0;
  }
  require(!file->figure.frames.empty());
  require(file->figure.frames.size() == static_cast<std::size_t>(file->figure.counts * file->figure.frames_each));
  require(file->lit_points <= file->points);
  for (const fixtures::LaserFrame& frame : file->figure.frames) {
    require(!frame.empty());
    for (const fixtures::LaserPoint& point : frame) {
      for (const double share : {point.at.x, point.at.y}) require(share >= -1 && share <= 1);
      for (const double share : {point.rgb.x, point.rgb.y, point.rgb.z}) require(share >= 0 && share <= 1);
    }
    for (const fixtures::LaserSegmentRow& part : fixtures::laser_segments(frame, 0.5, 0.5)) {
      require(part.begin >= 0 && part.end <= 1.000001f && part.begin <= part.end);
    }
  }
  return 0;
}
