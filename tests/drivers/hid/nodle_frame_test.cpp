#include "drivers/widgets/nodle_frame.h"

#include <vector>

#include <doctest/doctest.h>

#include "drivers/mock/nodle_model.h"
#include "tests/support/nodle_property.h"

namespace footlight::drivers {
namespace {

using Bytes = std::vector<std::uint8_t>;

Slots ramp() {
  Slots slots;
  for (std::size_t i = 0; i < slots.size(); ++i) slots[i] = static_cast<std::uint8_t>(i * 7 + 1);
  return slots;
}

TEST_CASE("a block carries its number and the 32 levels that belong there") {
  const Slots snapshot = ramp();
  const NodleReport report = encode_nodle_block(15, snapshot);
  REQUIRE(report.size() == 34);
  CHECK(report[0] == 0);
  CHECK(report[1] == 15);
  CHECK(std::equal(snapshot.begin() + 480, snapshot.end(), report.begin() + 2));
}

TEST_CASE("the mode report is number 16 with the mode behind it and zeros to its end") {
  const NodleReport report = encode_nodle_mode(kNodleOutput | kNodleInput);
  Bytes expected(34, 0);
  expected[1] = 16;
  expected[2] = 6;
  CHECK(Bytes(report.begin(), report.end()) == expected);
}

TEST_CASE("sixteen blocks make the model show the look") {
  mock::NodleModel model;
  model.power_on();
  for (int block = 0; block < kNodleBlockCount; ++block)
    model.data_out(0x02, std::span<const std::uint8_t>(encode_nodle_block(block, ramp())).subspan(1));
  CHECK(model.memory == ramp());
  CHECK(model.broken_count == 0);
}

TEST_CASE("the model's input reports decode to what was on its line") {
  mock::NodleModel model;
  model.power_on();
  model.data_out(0x02, std::span<const std::uint8_t>(encode_nodle_mode(kNodleInput)).subspan(1));
  Bytes line_frame{0};
  const Slots slots = ramp();
  line_frame.insert(line_frame.end(), slots.begin(), slots.end());
  model.receive_line_frame(1, line_frame);
  Slots heard{};
  int count = 0;
  for (; model.has_data(0x81); ++count) {
    Bytes report = model.data_in(0x81, 64);
    report.insert(report.begin(), 0);
    CHECK(apply_nodle_report(report, heard) == count);
  }
  CHECK(count == 16);
  CHECK(heard == ramp());
}

TEST_CASE("reports of another size or number are told apart and change nothing") {
  Slots slots = ramp();
  Bytes report(34, 0xEE);
  report[1] = 16;  // a mode report is never an input report
  CHECK_FALSE(apply_nodle_report(report, slots));
  report[1] = 255;
  CHECK_FALSE(apply_nodle_report(report, slots));
  report[1] = 3;
  report.push_back(0);
  CHECK_FALSE(apply_nodle_report(report, slots));
  report.resize(33);
  CHECK_FALSE(apply_nodle_report(report, slots));
  CHECK_FALSE(apply_nodle_report({}, slots));
  CHECK(slots == ramp());
}

TEST_CASE("every size and number of a report keeps to its block") {
  for (std::size_t size = 0; size < 70; ++size)
    for (int number = 0; number < 256; ++number) {
      Bytes report(size, 0xA5);
      if (size > 1) report[1] = static_cast<std::uint8_t>(number);
      const std::string broken = testing::check_nodle_report(report);
      REQUIRE_MESSAGE(broken.empty(), broken);
    }
}

}  // namespace
}  // namespace footlight::drivers
