// What the inspector takes over at once, and where the levels come from.
#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include <imgui/imgui.h>

#include <doctest/doctest.h>

#include "fixtures/simulate/encode.h"
#include "tests/tools/footlight/panels_test_imgui.h"
#include "tests/tools/footlight/ui_rigs.h"
#include "tools/footlight/preview/ui/channel_reading.h"
#include "tools/footlight/preview/ui/level_source.h"
#include "tools/footlight/preview/ui/pick_colour.h"

namespace footlight::tools {
namespace {

constexpr std::size_t kInspector = 3;
constexpr const char* kMixedRig = R"([rig]
name = "Colours"
[[fixture]]
name = "Spot"
type = "generic/profile"
universe = 1
address = 1
position = [0, 0, 5]
[[fixture]]
name = "Wash"
type = "generic/wash"
universe = 1
address = 101
position = [2, 0, 5]
)";

// The wash mixes by filters instead of emitters.
fixtures::Rig mixed_rig() {
  fixtures::Rig rig = testing::parsed_rig(kMixedRig);
  for (fixtures::Mode& mode : rig.types[static_cast<std::size_t>(rig.fixtures[1].type)].modes) {
    for (fixtures::Channel& channel : mode.channels) {
      for (fixtures::ChannelFunction& function : channel.functions) {
        if (function.attribute == "ColorAdd_R") function.attribute = "ColorSub_C";
        if (function.attribute == "ColorAdd_G") function.attribute = "ColorSub_M";
        if (function.attribute == "ColorAdd_B") function.attribute = "ColorSub_Y";
      }
    }
  }
  return rig;
}

class Inspector : public testing::DrawnUi {
 public:
  explicit Inspector(fixtures::Rig made)
      : imgui(1280, 720),
        rig(testing::compiled_rig(std::move(made))),
        desk(rig.rig, rig.compiled),
        levels(rig.compiled.universes.size() * kSlotCountMax) {
    for (const auto& fixture : rig.rig.fixtures) fixtures::encode_defaults(rig.rig, fixture, levels);
  }
  void draw() override {
    UiInput input = this->input();
    open.draw(desk, input, 1280, 720);
  }
  [[nodiscard]] UiInput input() const {
    UiInput input;
    input.levels = levels;
    input.stamps = stamps;
    input.status = status;
    input.now_ns = now_ns;
    return input;
  }
  void show() {
    open.set_open(kInspector, true, desk);
    for (int i = 0; i < 3; ++i) frame();
  }
  // Of the first function with an attribute of a fixture, as it is taken over.
  [[nodiscard]] std::optional<double> taken(int fixture, std::string_view attribute) {
    for (const auto& [key, raw] : desk.state().taken) {
      if (key.fixture != fixture) continue;
      const auto& type = fixtures::type_of(rig.rig, rig.rig.fixtures[static_cast<std::size_t>(fixture)]);
      const ChannelReading reading = reading_of(type, desk.index().channel(key), raw, [](int) { return 0u; });
      if (reading.function != nullptr && reading.function->attribute == attribute) return reading.value;
    }
    return std::nullopt;
  }

  testing::HeadlessImGui imgui;
  testing::UiRig rig;
  UiDesk desk;
  UiPanels open;
  std::vector<std::uint8_t> levels;
  std::vector<FrameStamp> stamps;
  const PumpStatus* status = nullptr;
  TimeNs now_ns = 10 * kNsPerS;
};

TEST_CASE("a colour is mixed by emitters in one fixture and by filters in another, as one step of undo") {
  Inspector ui(mixed_rig());
  ui.desk.select_all();
  ui.desk.begin_gesture();
  ui.desk.take_colour({1, 0.5, 0});
  int mixed = 0;
  for (int fixture = 0; fixture < 2; ++fixture) {
    if (const auto red = ui.taken(fixture, "ColorAdd_R")) {
      ++mixed;
      CHECK(*red == doctest::Approx(1).epsilon(0.01));
      CHECK(*ui.taken(fixture, "ColorAdd_G") == doctest::Approx(0.5).epsilon(0.02));
      CHECK(*ui.taken(fixture, "ColorAdd_B") == doctest::Approx(0).epsilon(0.01));
    }
    if (const auto cyan = ui.taken(fixture, "ColorSub_C")) {
      ++mixed;
      CHECK(*cyan == doctest::Approx(0).epsilon(0.01));
      CHECK(*ui.taken(fixture, "ColorSub_M") == doctest::Approx(0.5).epsilon(0.02));
      CHECK(*ui.taken(fixture, "ColorSub_Y") == doctest::Approx(1).epsilon(0.01));
    }
  }
  CHECK(mixed == 2);
  ui.desk.take_colour({0, 0, 1});  // the same gesture
  ui.desk.undo();
  CHECK(ui.desk.state().taken.empty());
}

TEST_CASE("a colour that was mixed is read back") {
  Inspector ui(mixed_rig());
  int read = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& one = ui.rig.rig.fixtures[i];
    const auto& type = fixtures::type_of(ui.rig.rig, one);
    const auto& mode = fixtures::mode_of(ui.rig.rig, one);
    const glm::dvec3 wanted(0.2, 0.9, 0.4);
    std::vector<std::uint32_t> raws(mode.channels.size());
    const auto values = channels_of_colour(type, mode, wanted);
    if (values.empty()) continue;
    ++read;
    for (const ChannelRaw& value : values) raws[static_cast<std::size_t>(value.channel)] = value.raw;
    const auto back =
        colour_of_channels(type, mode, [&](int channel) { return raws[static_cast<std::size_t>(channel)]; });
    REQUIRE(back);
    CHECK(glm::length(*back - wanted) < 0.02);
  }
  CHECK(read == 2);
  for (const double value : {0.0, 0.002, 0.2, 1.0}) {
    CHECK(linear_of_screen(screen_of_linear(value)) == doctest::Approx(value));
  }
}

TEST_CASE("the pad takes pan and tilt over in one step, and its release gives both back") {
  Inspector ui(testing::parsed_rig(testing::kUiRig));
  ui.desk.select(0, false);
  ui.desk.select(1, true);
  ui.show();
  // Its heading is closed at first: a click opens it, below the place of the fixture.
  const auto open_heading = [&] {
    for (float x : {900.0f, 1000.0f, 1100.0f}) {
      for (float y = 30; y < 400; y += 4) {
        ui.press(x, y);
        ui.desk.release_all();
        if (ui.words().find("home") != std::string::npos) return true;
      }
    }
    return false;
  };
  REQUIRE(open_heading());
  CHECK(ui.words().find("pan 0.0") != std::string::npos);
  bool took = false;
  const float heading = ImGui::GetIO().MousePos.y;  // a click on it would close the pad
  for (float y = heading + 24; y < heading + 120 && !took; y += 6) {
    ui.desk.begin_gesture();
    ui.press(1000, y);
    const bool both = ui.taken(0, "Pan") && ui.taken(0, "Tilt") && ui.desk.state().taken.size() == 4;
    took = both && ui.taken(1, "Tilt") == ui.taken(0, "Tilt");
    if (!took) ui.desk.release_all();
  }
  REQUIRE(took);
  ui.desk.undo();
  CHECK(ui.desk.state().taken.empty());
}

TEST_CASE("locate lights fixtures in white at their home position, highlight leaves where they point") {
  Inspector ui(testing::parsed_rig(testing::kUiRig));
  ui.desk.select(0, false);
  const auto& fixture = ui.rig.rig.fixtures[0];
  fixtures::encode_attribute(ui.rig.rig, fixture, "Pan", 100, ui.levels);
  fixtures::encode_attribute(ui.rig.rig, fixture, "Dimmer", 0, ui.levels);
  const auto value = [&](std::string_view attribute) {
    std::vector<std::uint8_t> levels = ui.levels;
    ui.desk.overlay(levels);
    const auto& mode = fixtures::mode_of(ui.rig.rig, fixture);
    for (std::size_t c = 0; c < mode.channels.size(); ++c) {
      const ChannelKey key{0, static_cast<int>(c)};
      const ChannelReading reading = reading_of(fixtures::type_of(ui.rig.rig, fixture), mode.channels[c],
                                                ui.desk.index().read(key, levels), [](int) { return 0u; });
      if (reading.function != nullptr && reading.function->attribute == attribute) return reading.value;
    }
    return -1e9;
  };
  ui.desk.set_highlight(true);
  CHECK(value("Dimmer") == doctest::Approx(1));
  CHECK(value("Pan") == doctest::Approx(100).epsilon(0.02));
  ui.desk.set_locate(true);
  CHECK(!ui.desk.highlights());
  CHECK(value("Dimmer") == doctest::Approx(1));
  CHECK(std::abs(value("Pan")) < 2);
  ui.desk.set_locate(false);
  CHECK(value("Dimmer") == doctest::Approx(0));
  CHECK(!ui.desk.overlays());
}

TEST_CASE("each channel has the name of who sets it: a sender, the user, locate, faders or nobody") {
  Inspector ui(testing::parsed_rig(testing::kUiRig));
  const ChannelKey pan{0, 0};
  CHECK(source_of_channel(ui.desk, ui.input(), pan).brief == "faders");
  ui.stamps.resize(2);
  CHECK(source_of_channel(ui.desk, ui.input(), pan).kind == SourceKind::kNobody);
  ui.stamps[0].revision = 1;
  ui.stamps[0].stamp_ns = ui.now_ns - kNsPerS;
  PumpStatus status;
  status.universes.resize(1);
  status.universes[0].universe = 1;
  status.universes[0].rate_hz = 44;
  status.universes[0].senders.resize(2);
  status.universes[0].senders[0].name = "Console A";
  status.universes[0].senders[0].wins = true;
  status.universes[0].senders[1].name = "Backup";
  ui.status = &status;
  LevelSource source = source_of_channel(ui.desk, ui.input(), pan);
  CHECK(source.brief == "Console A");
  CHECK(source.words == "Console A (priority 100), 1 outranked  44 /s");
  CHECK(source.age_ns == kNsPerS);
  CHECK(!source.silent);
  // Of two that win, the one that has set the slot.
  const auto place = ui.desk.index().place(pan);
  REQUIRE(place);
  status.universes[0].senders.push_back(status.universes[0].senders[0]);
  status.universes[0].senders[2].name = "Console C";
  status.universes[0].slot_senders.assign(kSlotCountMax, 1);
  status.universes[0].slot_senders[static_cast<std::size_t>(place->address - 1)] = 4;
  source = source_of_channel(ui.desk, ui.input(), pan);
  CHECK(source.brief == "Console C");
  CHECK(source.words == "Console C (priority 100), 1 outranked, 1 sets other slots  44 /s");
  CHECK(source_of_channel(ui.desk, ui.input(), {1, 0}).brief == "Console A");
  CHECK(source_of_universe(ui.desk, ui.input(), 0).brief == "Console A + Console C");
  status.universes[0].slot_senders.assign(kSlotCountMax, 5);
  CHECK(source_of_channel(ui.desk, ui.input(), pan).brief == "Console A + Console C");
  status.universes[0].slot_senders.assign(kSlotCountMax, 0);
  CHECK(source_of_channel(ui.desk, ui.input(), pan).brief == "no sender");
  const std::vector<SenderStatus> senders = std::exchange(status.universes[0].senders, {});
  status.universes[0].rate_hz = 0;
  CHECK(source_of_channel(ui.desk, ui.input(), pan).words == "no sender");
  status.universes[0].senders = senders;
  status.universes[0].senders.pop_back();
  status.universes[0].slot_senders.clear();
  ui.stamps[0].stamp_ns = ui.now_ns - 3 * kNsPerS;
  CHECK(source_of_channel(ui.desk, ui.input(), pan).silent);
  ui.desk.select(0, false);
  ui.show();
  CHECK(ui.words().find("Console A") != std::string::npos);
  ui.desk.take(pan, 3, ui.levels);
  CHECK(source_of_channel(ui.desk, ui.input(), pan).brief == "you");
  ui.desk.set_locate(true);
  CHECK(source_of_channel(ui.desk, ui.input(), pan).brief == "locate");
}

}  // namespace
}  // namespace footlight::tools
