// The plan of a frame for a rig, without a device: its passes, their constants, and what is left out.
#include <algorithm>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "fixtures/compile/tables.h"
#include "render/frame.h"
#include "render/pass.h"
#include "tests/render/scenes.h"

namespace footlight::render {
namespace {

using fixtures::Needs;
using vk::SpecConstant;

const std::vector<std::string> kAll{"step", "gather", "mirrors", "shadows", "gobos", "bodies", "boxes", "tiles",
                                    "bounce", "probes", "surfaces", "reflections", "gloss", "depths", "shadowtiles",
                                    "haze", "coarse", "records", "fine", "shade", "beams", "lasers", "shafts",
                                    "displays", "edges", "strips", "lenses", "blur", "glare", "tonemap"};
// Those that take beams together for tiles.
const std::vector<std::string> kTilePasses{"coarse", "records", "fine", "shade"};

std::vector<std::string> names_of(const std::vector<PassPlan>& plan) {
  std::vector<std::string> names;
  for (const PassPlan& pass : plan) names.push_back(pass.name);
  return names;
}

std::vector<SpecConstant> constants_of(const std::vector<PassPlan>& plan, const std::string& name) {
  for (const PassPlan& pass : plan) {
    if (pass.name == name) return pass.constants;
  }
  FAIL("the plan lacks " << name);
  return {};
}

// Needs of the demo rig without its scenery, whose triangles keep the bodies pass, and those that it lacks.
Needs demo_needs() {
  Needs needs = fixtures::compile(fixtures::demo_rig())->needs;
  CHECK(needs.objects);
  needs.objects = false;
  CHECK_FALSE(needs.color);
  CHECK_FALSE(needs.blades);
  needs.color = true;
  needs.blades = true;
  needs.haze_field = true;
  for (bool Needs::*need : {&Needs::flex, &Needs::smooth, &Needs::tungsten, &Needs::led, &Needs::discharge,
                            &Needs::dowser, &Needs::measured, &Needs::rectangle, &Needs::stacked, &Needs::shake,
                            &Needs::pulses, &Needs::macro, &Needs::wide, &Needs::iris, &Needs::laser,
                            &Needs::panes, &Needs::displays, &Needs::gloss, &Needs::sheen, &Needs::mirrors,
                            &Needs::probes}) {
    CHECK_FALSE(needs.*need);
    needs.*need = true;
  }
  CHECK_FALSE(needs.focus);
  CHECK_FALSE(needs.animation);
  needs.focus = true;
  needs.animation = true;
  needs.params_end = fixtures::kParamCount;
  needs.beams_max = FrameSettings{}.tile_beams;
  return needs;
}

// Settings with every pass: what is off by default is on.
FrameSettings every_setting() {
  FrameSettings settings;
  settings.bounce = true;
  settings.probes = true;
  settings.f_stop = 2;
  return settings;
}

// A plan and the passes that it leaves out together are the whole list, in order, without a pass in both.
void check_left_out(const Needs& needs, const FrameSettings& settings) {
  std::vector<std::string> planned = names_of(plan_frame(needs, settings));
  std::vector<std::string> all;
  const auto left_out = left_out_passes(needs, settings);
  for (const std::string& name : kAll) {
    const bool in_plan = std::count(planned.begin(), planned.end(), name) == 1;
    const bool out = std::count_if(left_out.begin(), left_out.end(),
                                   [&](const LeftOutPass& p) { return p.name == name && !p.loss.empty(); }) == 1;
    CHECK_MESSAGE(in_plan != out, name);
  }
  CHECK(planned.size() + left_out.size() == kAll.size());
}

TEST_CASE("plain beams have a shader of their own where shadows or other beams need code that they do not") {
  Needs needs = demo_needs();
  FrameSettings settings = every_setting();
  settings.nodes = FL_CUT_NODES;
  settings.shadow_map_px = 0;
  REQUIRE(settings.penumbra == 1);
  REQUIRE(needs.haze_field);
  CHECK_FALSE(has_plain_beams(needs, settings));
  needs.haze_field = false;
  CHECK(has_plain_beams(needs, settings));
  needs.plumes = true;
  CHECK_FALSE(has_plain_beams(needs, settings));
  needs.plumes = false;
  const auto with = [&](auto change) {
    FrameSettings other = settings;
    change(other);
    return has_plain_beams(needs, other);
  };
  CHECK_FALSE(with([](FrameSettings& other) { other.nodes = FL_CUT_NODES + 1; }));
  CHECK_FALSE(with([](FrameSettings& other) { other.nodes = FL_CUT_NODES - 1; }));
  CHECK_FALSE(with([](FrameSettings& other) { other.penumbra = 4; }));
  CHECK_FALSE(with([](FrameSettings& other) { other.method = BeamMethod::kMarch; }));
  CHECK_FALSE(with([](FrameSettings& other) { other.view = FrameView::kClasses; }));
  CHECK_FALSE(with([](FrameSettings& other) { other.shadow_map_px = FL_MAP_ROWS / 2; }));
  settings.shadow_map_px = FL_MAP_ROWS;
  CHECK(with([](FrameSettings& other) { other.nodes = FL_ROW_NODES_MAX; }));
  CHECK_FALSE(with([](FrameSettings& other) { other.nodes = FL_ROW_NODES_MAX + 1; }));
  settings.shadows = false;
  CHECK(with([](FrameSettings& other) { other.nodes = FL_ROW_NODES_MAX + 1; }));
  needs.gobo = needs.blades = needs.rectangle = needs.measured = false;
  CHECK_FALSE(has_plain_beams(needs, settings));
}

TEST_CASE("the demo rig with all missing needs added has every pass, with every branch") {
  const FrameSettings settings = every_setting();
  const std::vector<SpecConstant> tile_constants{
      {FL_SPEC_EXTINCTION, 1}, {FL_SPEC_PROFILE, 1},  {FL_SPEC_GOBO, 1}, {FL_SPEC_NODES, settings.nodes},
      {FL_SPEC_BOXES, 1},      {FL_SPEC_BODIES, 1},   {FL_SPEC_MEASURED, 1},
      {FL_SPEC_RECTANGLE, 1},  {FL_SPEC_WIDE, 1},     {FL_SPEC_IRIS, 1},
      {FL_SPEC_SHADOWS, 1},    {FL_SPEC_MAP_PX, 0},   {FL_SPEC_PENUMBRA, 1},
      {FL_SPEC_HAZE, 1},       {FL_SPEC_VIEW, FL_VIEW_PICTURE}};
  const auto plan = plan_frame(demo_needs(), settings);
  CHECK(plan ==
        std::vector<PassPlan>{{"step",
                               {{FL_SPEC_MOTION, 1},
                                {FL_SPEC_SPIN, 1},
                                {FL_SPEC_STROBE, 1},
                                {FL_SPEC_COLOR, 1},
                                {FL_SPEC_OPTICS, 1},
                                {FL_SPEC_BLADES, 1},
                                {FL_SPEC_SHAKE, 1},
                                {FL_SPEC_ANIMATION, 1},
                                {FL_SPEC_STACKED, 1},
                                {FL_SPEC_FLEX, 1},
                                {FL_SPEC_SMOOTH, 1},
                                {FL_SPEC_LAMP(fixtures::kLampTungsten), 1},
                                {FL_SPEC_LAMP(fixtures::kLampLed), 1},
                                {FL_SPEC_LAMP(fixtures::kLampDischarge), 1},
                                {FL_SPEC_DOWSER, 1},
                                {FL_SPEC_PULSES, 1},
                                {FL_SPEC_MACRO, 1},
                                {FL_SPEC_LASER, 1},
                                {FL_SPEC_DECODED_COUNT, fixtures::kParamCount}}},
                              {"gather",
                               {{FL_SPEC_OPTICS, 1},
                                {FL_SPEC_PROFILE, 1},
                                {FL_SPEC_WIDE, 1},
                                {FL_SPEC_IRIS, 1},
                                {FL_SPEC_STACKED, 1},
                                {FL_SPEC_BLADES, 1},
                                {FL_SPEC_MEASURED, 1},
                                {FL_SPEC_RECTANGLE, 1}}},
                              {"mirrors",
                               {{FL_SPEC_GOBO, 1},
                                {FL_SPEC_PROFILE, 1},
                                {FL_SPEC_WIDE, 1},
                                {FL_SPEC_IRIS, 1},
                                {FL_SPEC_FOCUS, 1},
                                {FL_SPEC_BLADES, 1},
                                {FL_SPEC_MEASURED, 1},
                                {FL_SPEC_RECTANGLE, 1},
                                {FL_SPEC_ANIMATION, 1}}},
                              {"shadows",
                               {{FL_SPEC_RECTANGLE, 1},
                                {FL_SPEC_BODIES, 1},
                                {FL_SPEC_MAP_PX, 0},
                                {FL_SPEC_PENUMBRA, 1}}},
                              {"gobos", {{FL_SPEC_FOCUS, 1}}},
                              {"bodies", {{FL_SPEC_GLOSS, 1}, {FL_SPEC_SHEEN, 1}}},
                              {"boxes", {{FL_SPEC_GLOSS, 1}}},
                              {"tiles", {{FL_SPEC_RECTANGLE, 1}}},
                              {"bounce",
                               {{FL_SPEC_GOBO, 1},
                                {FL_SPEC_EXTINCTION, 1},
                                {FL_SPEC_PROFILE, 1},
                                {FL_SPEC_BLADES, 1},
                                {FL_SPEC_FOCUS, 1},
                                {FL_SPEC_ANIMATION, 1},
                                {FL_SPEC_MEASURED, 1},
                                {FL_SPEC_RECTANGLE, 1},
                                {FL_SPEC_WIDE, 1},
                                {FL_SPEC_IRIS, 1}}},
                              {"probes",
                               {{FL_SPEC_GOBO, 1},
                                {FL_SPEC_EXTINCTION, 1},
                                {FL_SPEC_PROFILE, 1},
                                {FL_SPEC_BLADES, 1},
                                {FL_SPEC_FOCUS, 1},
                                {FL_SPEC_ANIMATION, 1},
                                {FL_SPEC_MEASURED, 1},
                                {FL_SPEC_RECTANGLE, 1},
                                {FL_SPEC_WIDE, 1},
                                {FL_SPEC_IRIS, 1},
                                {FL_SPEC_SHADOWS, 1},
                                {FL_SPEC_MAP_PX, 0},
                                {FL_SPEC_PENUMBRA, 1},
                                {FL_SPEC_AIR, 1}}},
                              {"surfaces",
                               {{FL_SPEC_GOBO, 1},
                                {FL_SPEC_EXTINCTION, 1},
                                {FL_SPEC_PROFILE, 1},
                                {FL_SPEC_BOXES, 1},
                                {FL_SPEC_BODIES, 1},
                                {FL_SPEC_BLADES, 1},
                                {FL_SPEC_FOCUS, 1},
                                {FL_SPEC_ANIMATION, 1},
                                {FL_SPEC_MEASURED, 1},
                                {FL_SPEC_RECTANGLE, 1},
                                {FL_SPEC_WIDE, 1},
                                {FL_SPEC_TILES, 1},
                                {FL_SPEC_IRIS, 1},
                                {FL_SPEC_SHADOWS, 1},
                                {FL_SPEC_MAP_PX, 0},
                                {FL_SPEC_PENUMBRA, 1},
                                {FL_SPEC_BOUNCE, 1},
                                {FL_SPEC_LENSES, 1},
                                {FL_SPEC_GLOSS, 1},
                                {FL_SPEC_SHEEN, 1},
                                {FL_SPEC_VIEW, FL_VIEW_PICTURE}}},
                              {"reflections",
                               {{FL_SPEC_EXTINCTION, 1},
                                {FL_SPEC_BOXES, 1},
                                {FL_SPEC_BODIES, 1},
                                {FL_SPEC_BOUNCE, 1},
                                {FL_SPEC_GLOSS, 1},
                                {FL_SPEC_SHEEN, 1}}},
                              {"gloss", {}},
                              {"depths", {}},
                              {"shadowtiles",
                               {{FL_SPEC_RECTANGLE, 1},
                                {FL_SPEC_BOXES, 1},
                                {FL_SPEC_BODIES, 1},
                                {FL_SPEC_MAP_PX, 0},
                                {FL_SPEC_PENUMBRA, 1}}},
                              {"haze", {}},
                              {"coarse", tile_constants},
                              {"records", {{FL_SPEC_PROFILE, 1}, {FL_SPEC_VIEW, FL_VIEW_PICTURE}}},
                              {"fine", tile_constants},
                              {"shade", tile_constants},
                              {"beams",
                               {{FL_SPEC_GOBO, 1},
                                {FL_SPEC_EXTINCTION, 1},
                                {FL_SPEC_PROFILE, 1},
                                {FL_SPEC_METHOD, FL_METHOD_GAUSS},
                                {FL_SPEC_NODES, settings.nodes},
                                {FL_SPEC_GOBO_TAPS, settings.gobo_taps},
                                {FL_SPEC_BOXES, 1},
                                {FL_SPEC_BODIES, 1},
                                {FL_SPEC_BLADES, 1},
                                {FL_SPEC_FOCUS, 1},
                                {FL_SPEC_ANIMATION, 1},
                                {FL_SPEC_MEASURED, 1},
                                {FL_SPEC_RECTANGLE, 1},
                                {FL_SPEC_TILES, 1},
                                {FL_SPEC_WIDE, 1},
                                {FL_SPEC_IRIS, 1},
                                {FL_SPEC_SHADOWS, 1},
                                {FL_SPEC_MAP_PX, 0},
                                {FL_SPEC_PENUMBRA, 1},
                                {FL_SPEC_HAZE, 1},
                                {FL_SPEC_GLOSS, 1},
                                {FL_SPEC_PLAIN_BEAMS, 0},
                                {FL_SPEC_VIEW, FL_VIEW_PICTURE},
                                {FL_SPEC_GOBO_METHOD, FL_GOBO_TABLES}}},
                              {"lasers",
                               {{FL_SPEC_EXTINCTION, 1},
                                {FL_SPEC_BOXES, 1},
                                {FL_SPEC_BODIES, 1},
                                {FL_SPEC_SHEEN, 1},
                                {FL_SPEC_SHADOWS, 1},
                                {FL_SPEC_LASER, 1},
                                {FL_SPEC_TILES, 1},
                                {FL_SPEC_HAZE, 1},
                                {FL_SPEC_VIEW, FL_VIEW_PICTURE}}},
                              {"shafts",
                               {{FL_SPEC_EXTINCTION, 1},
                                {FL_SPEC_BOXES, 1},
                                {FL_SPEC_BODIES, 1},
                                {FL_SPEC_SHEEN, 1},
                                {FL_SPEC_SHADOWS, 1},
                                {FL_SPEC_AIR, 1},
                                {FL_SPEC_DETAIL, 1},
                                {FL_SPEC_TILES, 1},
                                {FL_SPEC_HAZE, 1},
                                {FL_SPEC_VIEW, FL_VIEW_PICTURE}}},
                              {"displays",
                               {{FL_SPEC_EXTINCTION, 1},
                                {FL_SPEC_BOXES, 1},
                                {FL_SPEC_BODIES, 1},
                                {FL_SPEC_SHEEN, 1},
                                {FL_SPEC_AIR, 1},
                                {FL_SPEC_DETAIL, 1},
                                {FL_SPEC_GLOSS, 1},
                                {FL_SPEC_TILES, 1},
                                {FL_SPEC_HAZE, 1},
                                {FL_SPEC_VIEW, FL_VIEW_PICTURE}}},
                              {"edges",
                               {{FL_SPEC_BOXES, 1},
                                {FL_SPEC_BODIES, 1},
                                {FL_SPEC_SHEEN, 1},
                                {FL_SPEC_EDGE_SAMPLES, 16}}},
                              {"strips", {{FL_SPEC_EXTINCTION, 1}, {FL_SPEC_BOXES, 1}, {FL_SPEC_BODIES, 1}}},
                              {"lenses", constants_of(plan_frame(demo_needs(), settings), "surfaces")},
                              {"blur", {}},
                              {"glare", {}},
                              {"tonemap", {{FL_SPEC_TONE, FL_TONE_AGX}, {FL_SPEC_WHITE, 0}, {FL_SPEC_METER, 0}}}});
  CHECK(left_out_passes(demo_needs(), settings).empty());
}

TEST_CASE("method, nodes and gobo taps change only the passes of beams in haze") {
  FrameSettings settings = every_setting();
  settings.method = BeamMethod::kMarch;
  settings.nodes = 64;
  settings.gobo_taps = 5;
  const auto plan = plan_frame(demo_needs(), settings);
  const auto beams = constants_of(plan, "beams");
  CHECK(std::count(beams.begin(), beams.end(), SpecConstant{FL_SPEC_METHOD, FL_METHOD_MARCH}) == 1);
  CHECK(std::count(beams.begin(), beams.end(), SpecConstant{FL_SPEC_NODES, 64}) == 1);
  CHECK(std::count(beams.begin(), beams.end(), SpecConstant{FL_SPEC_GOBO_TAPS, 5}) == 1);
  for (const std::string& name : kAll) {
    if (name == "gobos" || std::find(kTilePasses.begin(), kTilePasses.end(), name) != kTilePasses.end()) {
      const auto names = names_of(plan);
      // A march takes no beams together, and samples gobos.
      CHECK(std::find(names.begin(), names.end(), name) == names.end());
    } else if (name != "beams")
      CHECK(constants_of(plan, name) == constants_of(plan_frame(demo_needs(), every_setting()), name));
  }
}

TEST_CASE("without a need its branches or its passes are left out") {
  FrameSettings settings = every_setting();
  settings.nodes = FL_CUT_NODES + 1;  // else even haze would add the shader of plain beams
  struct Case {
    const char* what;
    bool Needs::*need;
    std::vector<std::string> lost;         // passes
    std::vector<std::uint32_t> constants;  // are 0 without the need
    bool dry = false;                      // lasers, shafts and displays then light surfaces alone
  };
  for (const Case& c :
       {Case{"motion", &Needs::motion, {}, {FL_SPEC_MOTION}},
        Case{"spin", &Needs::spin, {}, {FL_SPEC_SPIN}},
        Case{"strobe", &Needs::strobe, {}, {FL_SPEC_STROBE}},
        Case{"gobo", &Needs::gobo, {"gobos"}, {FL_SPEC_GOBO}},
        Case{"colour", &Needs::color, {}, {FL_SPEC_COLOR}},
        Case{"optics", &Needs::optics, {}, {FL_SPEC_OPTICS}},
        Case{"blades", &Needs::blades, {}, {FL_SPEC_BLADES}},
        Case{"stacked", &Needs::stacked, {}, {FL_SPEC_STACKED}},
        Case{"pulses", &Needs::pulses, {}, {FL_SPEC_PULSES}},
        Case{"macro", &Needs::macro, {}, {FL_SPEC_MACRO}},
        Case{"laser", &Needs::laser, {"lasers"}, {}},
        Case{"mirrors", &Needs::mirrors, {"mirrors"}, {}},
        Case{"panes", &Needs::panes, {"shafts"}, {}},
        Case{"gloss", &Needs::gloss, {"gloss"}, {FL_SPEC_GLOSS}},
        Case{"sheen", &Needs::sheen, {}, {FL_SPEC_SHEEN}},
        Case{"probes", &Needs::probes, {"probes", "reflections"}, {}},
        Case{"displays", &Needs::displays, {"displays", "strips"}, {}},
        Case{"flex", &Needs::flex, {}, {FL_SPEC_FLEX}},
        Case{"smooth", &Needs::smooth, {}, {FL_SPEC_SMOOTH}},
        Case{"tungsten", &Needs::tungsten, {}, {FL_SPEC_LAMP(fixtures::kLampTungsten)}},
        Case{"led", &Needs::led, {}, {FL_SPEC_LAMP(fixtures::kLampLed)}},
        Case{"discharge", &Needs::discharge, {}, {FL_SPEC_LAMP(fixtures::kLampDischarge)}},
        Case{"dowser", &Needs::dowser, {}, {FL_SPEC_DOWSER}},
        Case{"focus", &Needs::focus, {}, {FL_SPEC_FOCUS}},
        Case{"animation", &Needs::animation, {}, {FL_SPEC_ANIMATION}},
        Case{"measured", &Needs::measured, {}, {FL_SPEC_MEASURED}},
        Case{"rectangle", &Needs::rectangle, {}, {FL_SPEC_RECTANGLE}},
        Case{"extinction", &Needs::extinction, {}, {FL_SPEC_EXTINCTION}},
        Case{"profile", &Needs::profile, {}, {FL_SPEC_PROFILE}},
        Case{"wide", &Needs::wide, {}, {FL_SPEC_WIDE}},
        Case{"iris", &Needs::iris, {}, {FL_SPEC_IRIS}},
        Case{"surfaces",
             &Needs::surfaces,
             {"boxes", "bounce", "probes", "reflections"},
             {FL_SPEC_BOXES, FL_SPEC_BOUNCE}},
        Case{"clouds", &Needs::haze_field, {"haze"}, {FL_SPEC_HAZE}},
        Case{"haze",
             &Needs::haze,
             {"gobos", "depths", "shadowtiles", "haze", "coarse", "records", "fine", "shade", "beams"},
             {},
             true},
        Case{"fixtures",
             &Needs::fixtures,
             {"step", "gather", "mirrors", "shadows", "gobos", "bodies", "tiles", "bounce", "probes",
              "reflections", "depths",
              "shadowtiles",
              "coarse", "records", "fine", "shade", "beams", "lasers", "lenses"},
             {FL_SPEC_BODIES, FL_SPEC_SHADOWS, FL_SPEC_BOUNCE, FL_SPEC_LENSES}}}) {
    CAPTURE(c.what);
    Needs needs = demo_needs();
    needs.*c.need = false;
    std::vector<PassPlan> expected = plan_frame(demo_needs(), settings);
    std::erase_if(expected, [&](const PassPlan& pass) {
      return std::find(c.lost.begin(), c.lost.end(), pass.name) != c.lost.end();
    });
    for (PassPlan& pass : expected) {
      for (SpecConstant& constant : pass.constants) {
        const bool lost = std::find(c.constants.begin(), c.constants.end(), constant.id) != c.constants.end();
        const bool shafts = pass.name == std::string("shafts");
        const bool others = shafts || pass.name == std::string("probes") ||
                            pass.name == std::string("lasers") || pass.name == std::string("displays");
        // Boxes hide the sun where there are no fixtures.
        const bool sunny = shafts && c.need == &Needs::fixtures && constant.id == FL_SPEC_SHADOWS;
        if (lost && !sunny) constant.value = 0;
        const bool air =
            constant.id == FL_SPEC_LASER || constant.id == FL_SPEC_AIR || constant.id == FL_SPEC_HAZE;
        if (c.dry && others && air) constant.value = 0;
        const bool stepped = c.need == &Needs::laser && pass.name == std::string("step");
        if (stepped && constant.id == FL_SPEC_LASER) constant.value = 0;
      }
    }
    CHECK(plan_frame(needs, settings) == expected);
    check_left_out(needs, settings);
  }
}

TEST_CASE("without boxes and bodies only passes for light in the air remain") {
  Needs needs = demo_needs();
  needs.surfaces = false;
  FrameSettings settings;
  settings.bodies = false;
  CHECK(names_of(plan_frame(needs, settings)) ==
        std::vector<std::string>{"step", "gather", "mirrors", "gobos", "tiles", "haze", "coarse", "records", "fine",
                                 "beams", "lasers", "shafts", "displays", "strips", "glare", "tonemap"});
  settings.tile_error = 0;
  CHECK(names_of(plan_frame(needs, settings)) ==
        std::vector<std::string>{"step", "gather", "mirrors", "gobos", "tiles", "haze", "beams", "lasers", "shafts",
                                 "displays", "strips", "glare", "tonemap"});
  settings.tile_error = FrameSettings{}.tile_error;
  needs.haze = false;  // without haze, too, no light is visible
  // Only panes are, against the sky, and displays.
  CHECK(names_of(plan_frame(needs, settings)) ==
        std::vector<std::string>{"step", "gather", "mirrors", "shafts", "displays", "strips", "glare", "tonemap"});
  check_left_out(needs, settings);
}

TEST_CASE("plumes alone bring the table of haze and the shaders that read it, and no other pass") {
  Needs needs = demo_needs();
  needs.haze_field = false;
  const std::vector<PassPlan> even = plan_frame(needs, {});
  needs.plumes = true;
  const std::vector<PassPlan> plumes = plan_frame(needs, {});
  needs.plumes = false;
  needs.haze_field = true;
  std::vector<PassPlan> clouds = plan_frame(needs, {});
  CHECK(names_of(plumes) == names_of(clouds));
  CHECK(names_of(even) != names_of(clouds));
  const auto apart = [](std::vector<PassPlan> plan) {
    for (PassPlan& pass : plan) {
      // The table of plumes knows where the rays of a mirrored camera begin.
      const bool table = pass.name == "haze";
      std::erase_if(pass.constants, [&](const SpecConstant& one) {
        return one.id == FL_SPEC_PLUMES || (table && one.id == FL_SPEC_GLOSS);
      });
    }
    return plan;
  };
  CHECK(apart(plumes) == apart(clouds));
  // Every pass that reads the table knows that it has slopes.
  const auto value = [](const PassPlan& pass, std::uint32_t id) {
    const auto found = std::find_if(pass.constants.begin(), pass.constants.end(),
                                    [&](const SpecConstant& one) { return one.id == id; });
    return found == pass.constants.end() ? 0u : found->value;
  };
  int readers = 0;
  for (std::size_t i = 0; i < plumes.size(); ++i) {
    CAPTURE(plumes[i].name);
    if (value(plumes[i], FL_SPEC_HAZE) == 0) continue;
    CHECK(value(plumes[i], FL_SPEC_PLUMES) == 1);
    CHECK(value(clouds[i], FL_SPEC_PLUMES) == 0);
    ++readers;
  }
  CHECK(readers >= 4);
  CHECK(constants_of(plumes, "haze") == std::vector<SpecConstant>{{FL_SPEC_PLUMES, 1}, {FL_SPEC_GLOSS, 1}});
}

TEST_CASE("depth of field is a pass only where it is asked for and something solid is seen") {
  Needs needs = demo_needs();
  FrameSettings settings;
  const auto has_blur = [&] {
    const auto names = names_of(plan_frame(needs, settings));
    return std::find(names.begin(), names.end(), "blur") != names.end();
  };
  CHECK_FALSE(has_blur());
  settings.f_stop = 4;
  CHECK(has_blur());
  settings.view = FrameView::kLux;
  CHECK_FALSE(has_blur());
  settings.view = FrameView::kPicture;
  settings.bodies = false;
  needs.surfaces = false;
  CHECK_FALSE(has_blur());
}

TEST_CASE("an empty rig needs no pass at all") {
  const auto compiled = fixtures::compile(fixtures::Rig{});
  REQUIRE(compiled);
  CHECK(plan_frame(compiled->needs, {}).empty());
  CHECK(left_out_passes(compiled->needs, {}).size() == kAll.size());
  // A stage without fixtures is lit by the work light.
  Needs needs;
  needs.surfaces = true;
  CHECK(names_of(plan_frame(needs, {})) == std::vector<std::string>{"boxes", "surfaces", "edges", "glare", "tonemap"});
  FrameSettings plain;
  plain.edge_samples = 0;
  plain.glare = 0;
  CHECK(names_of(plan_frame(needs, plain)) == std::vector<std::string>{"boxes", "surfaces", "tonemap"});
  // Displays without cases are nothing solid, but they are to be seen.
  needs = {};
  needs.displays = true;
  CHECK(names_of(plan_frame(needs, plain)) == std::vector<std::string>{"displays", "strips", "tonemap"});
  plain.view = FrameView::kClasses;
  CHECK(names_of(plan_frame(needs, plain)) == std::vector<std::string>{"tonemap"});
}

TEST_CASE("every combination of needs has each pass exactly once: in the plan or in what is left out") {
  for (unsigned bits = 0; bits < 16384; ++bits) {
    const auto bit = [&](unsigned i) { return (bits >> i & 1u) != 0; };
    const Needs needs{bit(0), bit(1), bit(2), bit(3),  bit(4),  bit(5), bit(6),
                      bit(7), bit(8), bit(9), bit(10), bit(11), bit(12)};
    FrameSettings settings;
    settings.bodies = bit(13);
    settings.bounce = bit(4) != bit(5);
    check_left_out(needs, settings);
  }
}

TEST_CASE("frost, focus, iris and a wide zoom set their needs in a rig of m = 1") {
  const auto needs_with = [](const char* attribute, double from, double to) {
    fixtures::FixtureType type;
    type.id = "test/one";
    fixtures::Beam beam;
    beam.profile_power = 1;
    beam.beam_angle_deg = beam.field_angle_deg = 40;
    type.beams.push_back(beam);
    fixtures::Mode mode;
    mode.name = "one";
    mode.slot_count = 1;
    mode.geometries = fixtures::simple_geometries(0, 0);
    fixtures::Channel channel;
    channel.name = attribute;
    channel.geometry = fixtures::kSimpleHead;
    channel.slot_offsets = {0};
    fixtures::ChannelFunction function;
    function.name = function.attribute = attribute;
    function.dmx_to = 255;
    function.physical_from = from;
    function.physical_to = to;
    channel.functions.push_back(function);
    mode.channels.push_back(channel);
    type.modes.push_back(mode);
    fixtures::Rig rig;
    rig.types.push_back(type);
    rig.fixtures.emplace_back();
    rig.fixtures.back().name = "one";
    const auto compiled = fixtures::compile(rig);
    REQUIRE(compiled);
    return compiled->needs;
  };
  const auto plain = needs_with("Dimmer", 0, 1);
  CHECK_FALSE(plain.profile);
  CHECK_FALSE(plain.wide);
  CHECK_FALSE(plain.iris);
  for (const char* soft : {"Frost1", "Frost2", "Frost3", "Frost1PulseOpen", "Focus1", "Focus1Distance"}) {
    CAPTURE(soft);
    CHECK(needs_with(soft, 0, 1).profile);
  }
  for (const char* iris : {"Iris", "IrisPulse", "IrisStrobe"}) {
    CAPTURE(iris);
    CHECK(needs_with(iris, 0, 1).iris);
    CHECK_FALSE(needs_with(iris, 0, 1).profile);
  }
  CHECK_FALSE(needs_with("Zoom", 10, 89).wide);
  CHECK(needs_with("Zoom", 10, 91).wide);
  CHECK(needs_with("Zoom", 91, 10).wide);
}

TEST_CASE("the needs of a rig follow from its fixtures and its haze") {
  fixtures::Rig rig = fixtures::demo_rig();
  // Only pars: no motor and no gobo, but a flat profile and a strobe.
  std::erase_if(rig.fixtures, [&](const fixtures::PatchedFixture& fixture) {
    return rig.types[static_cast<std::size_t>(fixture.type)].id != "generic/par";
  });
  const auto pars = fixtures::compile(rig);
  REQUIRE(pars);
  CHECK(pars->needs.fixtures);
  CHECK(!pars->needs.motion);
  CHECK(pars->needs.strobe);
  CHECK(!pars->needs.gobo);
  CHECK(pars->needs.profile);
  CHECK(constants_of(plan_frame(pars->needs, {}), "step") ==
        std::vector<SpecConstant>{{FL_SPEC_MOTION, 0},
                                  {FL_SPEC_SPIN, 0},
                                  {FL_SPEC_STROBE, 1},
                                  {FL_SPEC_COLOR, 0},
                                  {FL_SPEC_OPTICS, 0},
                                  {FL_SPEC_BLADES, 0},
                                  {FL_SPEC_SHAKE, 0},
                                  {FL_SPEC_ANIMATION, 0},
                                  {FL_SPEC_STACKED, 0},
                                  {FL_SPEC_FLEX, 0},
                                  {FL_SPEC_SMOOTH, 0},
                                  {FL_SPEC_LAMP(fixtures::kLampTungsten), 0},
                                  {FL_SPEC_LAMP(fixtures::kLampLed), 0},
                                  {FL_SPEC_LAMP(fixtures::kLampDischarge), 0},
                                  {FL_SPEC_DOWSER, 0},
                                  {FL_SPEC_PULSES, 0},
                                  {FL_SPEC_MACRO, 0},
                                  {FL_SPEC_LASER, 0},
                                  {FL_SPEC_DECODED_COUNT, fixtures::kParamBasicEnd}});
  rig.haze.scattering_per_m = 0;
  rig.haze.absorption_per_m = 0;
  rig.boxes.clear();
  const auto clear = fixtures::compile(rig);
  REQUIRE(clear);
  CHECK(!clear->needs.haze);
  CHECK(!clear->needs.extinction);
  CHECK(!clear->needs.surfaces);
}

}  // namespace
}  // namespace footlight::render
