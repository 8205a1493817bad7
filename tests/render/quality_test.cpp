// The choice of knobs: curves and a request in, knobs out; and the adaptation to a time. Without a GPU.
#include <cmath>
#include <set>

#include <doctest/doctest.h>

#include "render/quality.h"
#include "tests/support/must.h"

namespace footlight::render {
namespace {

using footlight::testing::must;

KnobPoint beams_point(double tile_error, std::uint32_t nodes, double error, double ms) {
  Knobs knobs;
  knobs.tile_error = tile_error;
  knobs.nodes = nodes;
  return {knobs, error, ms};
}
KnobPoint gobo_point(GoboMethod method, std::uint32_t taps, double error, double ms) {
  Knobs knobs;
  knobs.gobo_method = method;
  knobs.gobo_taps = taps;
  return {knobs, error, ms};
}
KnobPoint body_point(double error_px, double ms) {
  Knobs knobs;
  knobs.body_error_px = error_px;
  return {knobs, 0, ms};
}

// A machine on which tiles cost more than they save with 2 nodes, and 4 nodes with tiles are never worth their time.
KnobCurves some_curves() {
  KnobCurves curves;
  curves.beams = {beams_point(0, 8, 0, 20),       beams_point(0, 4, 2e-5, 14),   beams_point(4e-3, 4, 1.2e-4, 14.5),
                  beams_point(0, 3, 2.5e-4, 12),  beams_point(4e-3, 3, 3e-4, 8), beams_point(0, 2, 1e-3, 6),
                  beams_point(4e-3, 2, 1.1e-3, 9)};
  curves.gobos = {gobo_point(GoboMethod::kTaps, 1024, 0, 90), gobo_point(GoboMethod::kTaps, 64, 5e-3, 12),
                  gobo_point(GoboMethod::kTaps, 16, 5e-2, 10), gobo_point(GoboMethod::kTables, 128, 1e-3, 16)};
  curves.bodies = {body_point(0, 9), body_point(0.25, 4), body_point(0.5, 3), body_point(1, 2), body_point(2, 1)};
  curves.left_out = {{Knobs{}, 0, 8}};
  double ms = 8;
  for (const Knobs& knobs : left_out_knobs()) {
    ms *= knobs.bounce || !knobs.shadows ? 0.6 : 0.95;  // the bounce alone is not worth a place
    curves.left_out.push_back({knobs, 0, ms});
  }
  return curves;
}

fixtures::Needs some_needs(bool gobo) {
  fixtures::Needs needs;
  needs.fixtures = needs.haze = true;
  needs.gobo = gobo;
  return needs;
}

TEST_CASE("bodies follow from the error that is asked for, whatever the error of the knobs that keep it") {
  for (const double error : {1e-4, 5e-4, 3e-3}) {
    const QualityRequest request{.error = error, .ms = 0};
    const auto ladder = ladder_of(some_curves(), some_needs(false), request);
    const KnobPoint& chosen = ladder[choose(ladder, request)];
    CHECK(chosen.knobs.body_error_px == body_error_for(error));
    CHECK(chosen.error <= error);
    CHECK(ladder.front().knobs.body_error_px == body_error_for(error));
  }
}

TEST_CASE("each place of a ladder takes less time and has no less error than the one before") {
  for (const bool gobo : {false, true}) {
    const auto ladder = ladder_of(some_curves(), some_needs(gobo));
    REQUIRE(ladder.size() > 4);
    for (std::size_t i = 1; i < ladder.size(); ++i) {
      CHECK(ladder[i].ms <= 0.9 * ladder[i - 1].ms);
      CHECK(ladder[i].error >= ladder[i - 1].error);
      CHECK(ladder[i].knobs.divisor >= ladder[i - 1].knobs.divisor);
      CHECK(ladder[i].knobs.smooth_edges <= ladder[i - 1].knobs.smooth_edges);
      CHECK(ladder[i].knobs.shadows <= ladder[i - 1].knobs.shadows);
      CHECK((ladder[i].knobs.bounce || !ladder[i].knobs.shadows));  // too little time for a place of its own
    }
    CHECK(ladder.front().knobs.smooth_edges);
    CHECK(!ladder.back().knobs.bounce);
    CHECK(ladder.front().error == 0);
    CHECK(ladder.front().knobs.body_error_px == Knobs{}.body_error_px);
    CHECK(ladder.back().knobs.divisor == 4);
    CHECK(ladder.back().knobs.body_error_px == 2);  // plainer bodies come before fewer pixels
    CHECK(ladder.back().knobs.nodes == 2);
  }
  CHECK(ladder_of({}, some_needs(false)).empty());
}

TEST_CASE("an error gets the cheapest knobs that keep it, at full resolution") {
  const auto ladder = ladder_of(some_curves(), some_needs(false));
  const auto knobs_for = [&](double error) { return ladder[choose(ladder, {.error = error, .ms = 0})].knobs; };
  CHECK(knobs_for(1e-9).nodes == 8);
  CHECK(knobs_for(1e-4).nodes == 4);
  CHECK(knobs_for(1e-4).tile_error == 0);
  CHECK(knobs_for(5e-4).nodes == 3);
  CHECK(knobs_for(5e-4).tile_error == 4e-3);
  CHECK(knobs_for(0.5).nodes == 2);
  CHECK(knobs_for(0.5).tile_error == 0);  // with tiles it is dearer and worse
  for (const double error : {1e-9, 1e-4, 1e-3, 1e-2, 0.9}) {
    CHECK(knobs_for(error).divisor == 1);
    CHECK(knobs_for(error).smooth_edges);
  }
}

TEST_CASE("a gobo counts only in a rig that has one, and errors of two groups add as squares") {
  const auto with = ladder_of(some_curves(), some_needs(true));
  const auto without = ladder_of(some_curves(), some_needs(false));
  for (const KnobPoint& point : without) CHECK(point.knobs.gobo_method == GoboMethod::kSuited);
  const KnobPoint& tables = with[choose(with, {.error = 1.2e-3, .ms = 0})];
  CHECK(tables.knobs.gobo_method == GoboMethod::kTables);
  const auto usual = predicted(some_curves(), some_needs(true), {});
  REQUIRE(usual);
  CHECK(usual->knobs.gobo_method == GoboMethod::kTables);  // what suits this machine
  CHECK(usual->error == doctest::Approx(std::hypot(3e-4, 1e-3)));
  CHECK(usual->ms == doctest::Approx(8 + 6 + 2));  // gobos and bodies above their cheapest
  Knobs unknown;
  unknown.nodes = 7;
  CHECK(!predicted(some_curves(), some_needs(true), unknown));
}

TEST_CASE("a time gets the least error that fits, and a slower scene cheaper knobs") {
  const auto ladder = ladder_of(some_curves(), some_needs(false));
  const auto at = [&](double ms, double scale) { return choose(ladder, {.error = 0, .ms = ms}, scale); };
  CHECK(at(1000, 1) == 0);
  CHECK(at(1e-3, 1) == ladder.size() - 1);
  for (const double ms : {2.0, 5.0, 8.0, 15.0}) {
    const std::size_t chosen = at(ms, 1);
    CHECK(ladder[chosen].ms <= ms);
    CHECK((chosen == 0 || ladder[chosen - 1].ms > ms));
    if (chosen + 1 < ladder.size()) CHECK(at(ms, 3) > chosen);
  }
}

TEST_CASE("what is no error or time is refused by the name of its option") {
  CHECK(must(parse_quality("", "")).error == 0);
  CHECK(must(parse_quality("0.1%", "")).error == doctest::Approx(1e-3));
  CHECK(must(parse_quality("0.001", "")).error == doctest::Approx(1e-3));
  CHECK(must(parse_quality("1e-4", "")).error == doctest::Approx(1e-4));
  CHECK(must(parse_quality("", "8")).ms == 8);
  for (const char* error : {"0", "200%", "100%", "1", "-0.1%", "abc", "%", "0.1%%", "nan", "inf", "0.1 %", "0,1%"}) {
    const auto refused = parse_quality(error, "");
    REQUIRE(!refused);
    CHECK(refused.error().code == ErrorCode::kBadInput);
    CHECK(refused.error().message.starts_with(fmt::format("--error {}: expected", error)));
  }
  for (const char* ms : {"0", "-1", "abc", "8ms", "nan", "1e9"}) {
    const auto refused = parse_quality("", ms);
    REQUIRE(!refused);
    CHECK(refused.error().message.starts_with(fmt::format("--ms {}: expected", ms)));
  }
  const auto both = parse_quality("0.1%", "8");
  REQUIRE(!both);
  CHECK(both.error().message.find("leave out one") != std::string::npos);
}

TEST_CASE("the fixed table has one row for each error, and none below its least") {
  const auto table = fixed_table();
  for (std::size_t i = 1; i < table.size(); ++i) {
    CHECK(table[i].error > table[i - 1].error);
    CHECK(table[i].knobs.nodes <= table[i - 1].knobs.nodes);
    CHECK(table[i].knobs.tile_error >= table[i - 1].knobs.tile_error);
    CHECK(table[i].knobs.gobo_taps <= table[i - 1].knobs.gobo_taps);
    CHECK(table[i].knobs.body_error_px >= table[i - 1].knobs.body_error_px);
  }
  for (const KnobPoint& row : table) {
    CHECK(must(fixed_knobs(row.error)).knobs == row.knobs);
    CHECK(must(fixed_knobs(row.error * 1.01)).knobs == row.knobs);
    CHECK(row.knobs.gobo_method == GoboMethod::kTaps);  // the same on every device
    CHECK(row.knobs.body_error_px == body_error_for(row.error));
  }
  const auto refused = fixed_knobs(table.front().error * 0.9);
  REQUIRE(!refused);
  CHECK(refused.error().message.find("or more") != std::string::npos);
}

TEST_CASE("settings by knobs are read back as those knobs, and the general path has neither tiles nor tables") {
  Knobs knobs;
  knobs.tile_error = 1e-3;
  knobs.nodes = 5;
  knobs.gobo_method = GoboMethod::kTaps;
  knobs.gobo_taps = 77;
  knobs.body_error_px = 0.3;
  CHECK(knobs_of(with_knobs({}, knobs)) == knobs);
  const FrameSettings general = general_settings({});
  CHECK(general.tile_error == 0);
  CHECK(general.gobo_method == GoboMethod::kTaps);
  CHECK(general.nodes == 8);
  CHECK(general.body_error_px == 0);
}

TEST_CASE("knobs leave out parts of a picture, and add none that its settings leave out") {
  FrameSettings asked;
  asked.bounce = asked.probes = true;
  const Knobs last = left_out_knobs().back();
  const FrameSettings bare = with_knobs(asked, last);
  CHECK(bare.edge_samples == 0);
  CHECK(!bare.bounce);
  CHECK(!bare.probes);
  CHECK(!bare.shadows);
  CHECK(text_of(last).ends_with(", jagged edges, no reflected light, no shadows, 1/4 of the resolution"));
  const FrameSettings whole = with_knobs(asked, {});
  CHECK(whole == asked);
  CHECK(with_knobs(bare, {}) == bare);
  for (std::size_t i = 1; i < left_out_knobs().size(); ++i) {
    const Knobs& before = left_out_knobs()[i - 1];
    const Knobs& knobs = left_out_knobs()[i];
    CHECK(knobs != before);
    CHECK((before.smooth_edges || !knobs.smooth_edges));
    CHECK((before.bounce || !knobs.bounce));
    CHECK((before.shadows || !knobs.shadows));
    CHECK(knobs.divisor >= before.divisor);
  }
}

TEST_CASE("the place nearest in time leaves nothing out, however little time is asked for") {
  const auto ladder = ladder_of(some_curves(), some_needs(true));
  const std::size_t least = nearest(ladder, 0);
  CHECK(least > 0);
  CHECK(ladder[least].knobs == with_everything(ladder[least].knobs));
  REQUIRE(least + 1 < ladder.size());
  CHECK(!ladder[least + 1].knobs.smooth_edges);
  CHECK(nearest(ladder, ladder.front().ms) == 0);
}

// A scene that takes `load` times the ladder's times, with noise of up to a tenth that follows from the picture's
// number. Returns the places of all pictures.
struct Run {
  TimeKeeper& keeper;
  const std::vector<KnobPoint>& ladder;
  TimeNs now_ns = 0;
  std::uint32_t number = 0;
  std::vector<std::size_t> places;

  // exponent: the scene's times grow with this power of the ladder's.
  void pictures(double seconds, double load, double exponent = 1) {
    const TimeNs end_ns = now_ns + static_cast<TimeNs>(seconds * 1e9);
    while (now_ns < end_ns) {
      number = number * 1664525u + 1013904223u;
      const double noise = 0.95 + 0.1 * static_cast<double>(number >> 8) / double{1 << 24};
      const double ms = load * std::pow(ladder[keeper.at()].ms, exponent) * noise;
      now_ns += static_cast<DurationNs>(std::max(ms, 16.0) * 1e6);
      keeper.take(now_ns, ms);
      places.push_back(keeper.at());
    }
  }
  [[nodiscard]] int changes() const {
    int count = 0;
    for (std::size_t i = 1; i < places.size(); ++i) count += places[i] != places[i - 1] ? 1 : 0;
    return count;
  }
};

TEST_CASE("knobs settle within the budget and then stay, whatever knobs they start from") {
  const auto ladder = ladder_of(some_curves(), some_needs(true));
  for (const double budget_ms : {3.0, 8.0, 20.0}) {
    for (std::size_t start = 0; start < ladder.size(); ++start) {
      TimeKeeper keeper(ladder, budget_ms, start);
      Run run{keeper, ladder};
      run.pictures(10, 1);
      CHECK(ladder[keeper.at()].ms <= 1.05 * budget_ms);
      const std::size_t settled = keeper.at();
      run.places.clear();
      run.pictures(120, 1);
      CHECK(run.changes() == 0);
      CHECK(keeper.at() == settled);
      // No better knobs would have fitted with room to spare.
      CHECK((settled == 0 || ladder[settled - 1].ms > 0.7 * budget_ms));
    }
  }
}

TEST_CASE("a heavier scene gets cheaper knobs within a second, and a lighter one better ones") {
  const auto ladder = ladder_of(some_curves(), some_needs(true));
  TimeKeeper keeper(ladder, 20, ladder.size() - 1);
  Run run{keeper, ladder};
  run.pictures(10, 1);
  const std::size_t before = keeper.at();
  run.pictures(1, 2);
  CHECK(keeper.at() > before);
  CHECK(2 * ladder[keeper.at()].ms <= 20);
  run.pictures(10, 1);
  CHECK(keeper.at() == before);
}

TEST_CASE("lower resolution is the last to be taken and the first to be left") {
  const auto ladder = ladder_of(some_curves(), some_needs(false));
  TimeKeeper keeper(ladder, 1, 0);
  Run run{keeper, ladder};
  run.pictures(5, 1);
  CHECK(keeper.point().knobs.divisor > 1);
  CHECK(keeper.point().knobs.nodes == 2);
  run.pictures(20, 0.05);
  CHECK(keeper.point().knobs.divisor == 1);
}

TEST_CASE("where the ladder predicts too little time, better knobs are tried more and more seldom") {
  const auto ladder = ladder_of(some_curves(), some_needs(true));
  TimeKeeper keeper(ladder, 8, ladder.size() - 1);
  Run run{keeper, ladder};
  const double load = 7 / std::pow(ladder[ladder.size() / 2].ms, 2);  // times are squares: better knobs are far dearer
  run.pictures(60, load, 2);
  run.places.clear();
  run.pictures(60, load, 2);
  CHECK(run.changes() <= 4);
}

TEST_CASE("equal times give equal knobs, and one slow picture changes none") {
  const auto ladder = ladder_of(some_curves(), some_needs(true));
  TimeKeeper one(ladder, 20, 2);
  TimeKeeper other(ladder, 20, 2);
  Run first{one, ladder};
  Run second{other, ladder};
  first.pictures(30, 1.3);
  second.pictures(30, 1.3);
  CHECK(first.places == second.places);
  const std::size_t settled = one.at();
  one.take(first.now_ns + 500 * kNsPerMs, 500);
  CHECK(one.at() == settled);
  first.pictures(5, 1.3);
  CHECK(one.at() == settled);
}

TEST_CASE("rough pictures have fewer pixels, and leave shadows and nodes to whole ones only with many beams") {
  FrameSettings whole;
  whole.width = 640;
  whole.height = 360;
  whole.bounce = true;
  const FrameSettings few = rough_settings(whole, 20);
  CHECK(few.width == 320);
  CHECK(few.height == 180);
  CHECK(few.edge_samples == 0);
  CHECK(!few.bounce);
  CHECK(few.shadows);
  CHECK(few.nodes == whole.nodes);
  CHECK(few.glare == whole.glare);
  const FrameSettings many = rough_settings(whole, 2000);
  CHECK(many.width == 640 / 6);
  CHECK(!many.shadows);
  CHECK(many.nodes == 1);
  whole.width = whole.height = 1;
  CHECK(rough_settings(whole, 2000).width == 1);
  CHECK(rough_settings(whole, 0).height == 1);
}

}  // namespace
}  // namespace footlight::render
