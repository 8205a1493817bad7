#include "drivers/widgets/velleman_frame.h"

#include <algorithm>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "drivers/mock/velleman_model.h"

namespace footlight::drivers {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes report_of(const VellemanReports& reports, std::size_t i) { return {reports[i].begin(), reports[i].end()}; }

Bytes line_frame_of(const Slots& snapshot) {
  Bytes frame{0};
  frame.insert(frame.end(), snapshot.begin(), snapshot.end());
  return frame;
}

// What the model makes of a look, and how many reports it took.
struct Shown {
  Bytes line;
  std::uint64_t snapshot_count = 0, broken_count = 0, cut_count = 0;
};
Shown show(const VellemanReports& reports, bool upgraded) {
  mock::VellemanModel model;
  model.upgraded = upgraded;
  model.power_on();
  for (std::size_t i = 0; i < reports.count(); ++i) model.data_out(0x01, reports[i]);
  return {model.line(0).frame, model.line(0).frame_count, model.broken_count, model.cut_count};
}

TEST_CASE("a dark look is five reports of the original firmware, as its protocol page lays them out") {
  const VellemanReports reports(Slots{}, kVellemanReportSize);
  REQUIRE(reports.count() == 5);
  CHECK(report_of(reports, 0) == Bytes{4, 101, 0, 0, 0, 0, 0, 0});
  for (std::size_t i = 1; i < 4; ++i) CHECK(report_of(reports, i) == Bytes{5, 100, 0, 0, 0, 0, 0, 0});
  CHECK(report_of(reports, 4) == Bytes{5, 82, 0, 0, 0, 0, 0, 0});
}

TEST_CASE("a look without zeros is 75 reports of the original firmware, the last two of one slot") {
  Slots snapshot;
  for (std::size_t i = 0; i < snapshot.size(); ++i) snapshot[i] = static_cast<std::uint8_t>(1 + i % 255);
  const VellemanReports reports(snapshot, kVellemanReportSize);
  REQUIRE(reports.count() == 75);
  CHECK(report_of(reports, 0) == Bytes{4, 1, 1, 2, 3, 4, 5, 6});
  CHECK(report_of(reports, 1) == Bytes{2, 7, 8, 9, 10, 11, 12, 13});
  CHECK(report_of(reports, 73) == Bytes{3, snapshot[510], 0, 0, 0, 0, 0, 0});
  CHECK(report_of(reports, 74) == Bytes{3, snapshot[511], 0, 0, 0, 0, 0, 0});
}

TEST_CASE("a look without zeros is nine reports of the replacement firmware, the last one counted") {
  Slots snapshot;
  snapshot.fill(9);
  const VellemanReports reports(snapshot, kVellemanUpgradedReportSize);
  REQUIRE(reports.count() == 9);
  CHECK(reports[0].size() == 64);
  CHECK(reports[0][0] == 4);
  CHECK(reports[0][1] == 1);
  CHECK(reports[1][0] == 2);
  CHECK(reports[8][0] == 6);
  CHECK(reports[8][1] == 9);
}

TEST_CASE("a run of zeros is counted, and what follows it is in the same report") {
  Slots snapshot{};
  std::fill(snapshot.begin(), snapshot.begin() + 6, std::uint8_t{1});
  snapshot[40] = 0xAB;
  const VellemanReports reports(snapshot, kVellemanReportSize);
  CHECK(report_of(reports, 0) == Bytes{4, 1, 1, 1, 1, 1, 1, 1});
  CHECK(report_of(reports, 1) == Bytes{5, 34, 0xAB, 0, 0, 0, 0, 0});
}

TEST_CASE("any look is shown as it is, in no more reports than promised, by both firmwares") {
  std::mt19937 random(7);
  std::size_t most = 0;
  for (int round = 0; round < 4000; ++round) {
    Slots snapshot{};
    const auto lit_of_16 = random() % 17;
    for (auto& slot : snapshot)
      if (random() % 16 < lit_of_16) slot = static_cast<std::uint8_t>(random());
    if (round % 4 == 1) std::fill(snapshot.begin() + static_cast<int>(random() % 512), snapshot.end(), std::uint8_t{0});
    if (round % 4 == 2)
      std::fill(snapshot.begin(), snapshot.begin() + static_cast<int>(random() % 512), std::uint8_t{0});
    for (const bool upgraded : {false, true}) {
      const VellemanReports reports(snapshot, upgraded ? kVellemanUpgradedReportSize : kVellemanReportSize);
      const Shown shown = show(reports, upgraded);
      REQUIRE(shown.snapshot_count == 1);
      REQUIRE(shown.broken_count == 0);
      REQUIRE(shown.line == line_frame_of(snapshot));
      REQUIRE(reports.count() <= (upgraded ? 9 : kVellemanReportCountMax));
      most = std::max(most, reports.count());
    }
  }
  CHECK(most >= 75);
}

TEST_CASE("the costliest looks fit: single zeros placed so that the end falls apart into single slots") {
  for (std::size_t zeros = 0; zeros < 14; ++zeros) {
    Slots snapshot;
    snapshot.fill(255);
    // A zero at the head of a report makes it cover one slot more: so many of them shift the end.
    std::size_t at = 6;
    for (std::size_t i = 0; i < zeros; ++i, at += 8) snapshot[at] = snapshot[at + 1] = 0;
    const VellemanReports reports(snapshot, kVellemanReportSize);
    CHECK(reports.count() <= kVellemanReportCountMax);
    CHECK(show(reports, false).line == line_frame_of(snapshot));
  }
}

TEST_CASE("the model counts a look that was cut short, and shows nothing of it") {
  Slots snapshot;
  snapshot.fill(3);
  const VellemanReports reports(snapshot, kVellemanReportSize);
  mock::VellemanModel model;
  model.power_on();
  for (std::size_t i = 0; i < 10; ++i) model.data_out(0x01, reports[i]);
  for (std::size_t i = 0; i < reports.count(); ++i) model.data_out(0x01, reports[i]);
  CHECK(model.cut_count == 1);
  CHECK(model.line(0).frame_count == 1);
  model.data_out(0x01, reports[1]);  // goes on where nothing was begun
  CHECK(model.broken_count == 1);
}

}  // namespace
}  // namespace footlight::drivers
