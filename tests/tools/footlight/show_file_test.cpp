#include "tools/footlight/bridge/show_file.h"

#include <fstream>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "fixtures/model/rig.h"
#include "tests/tools/footlight/run_footlight.h"

namespace footlight::tools {
namespace {

constexpr const char* kPorts = "[[in]]\nendpoint = \"sacn:1\"\n[[out]]\nendpoint = \"mock:enttec-pro\"\n";

std::string refusal(const std::string& text) {
  const auto show = parse_show(text, "show.toml");
  REQUIRE_FALSE(show.has_value());
  CHECK(show.error().code == ErrorCode::kBadInput);
  return show.error().message;
}

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

TEST_CASE("a show of two ports needs two lines each, and all other keys have a default") {
  const auto show = parse_show(kPorts, "show.toml");
  REQUIRE(show.has_value());
  REQUIRE(show->ins.size() == 1);
  REQUIRE(show->outs.size() == 1);
  CHECK(show->ins[0].endpoint.text == "sacn:1");
  CHECK(show->outs[0].endpoint.target == "enttec-pro");
  CHECK_FALSE(show->outs[0].options.blackout_on_exit);
  CHECK(show->universe_count == 0);
  CHECK(show->merge.timeout_ns == kSenderTimeoutDefaultNs);
  CHECK(show->ltp.empty());
}

TEST_CASE("every key of a show file is read") {
  const auto show = parse_show(R"(
universes = 9
[merge]
timeout = "1.5s"
ltp = [2, 3]
ltp_slots = {1 = "1-24,30", 9 = "512"}
[[in]]
endpoint = "sacn:1-9%eth0"
preview = true
[[in]]
endpoint = "artnet:1=10"
priority = 150
rdm = true
[[in]]
endpoint = "mock:enttec-pro=11"
wait_for_device = true
receive_on_change = true
[[in]]
endpoint = "log:show.dmxlog"
loop = true
start = "10s"
stop = "1m"
speed = 2.0
[[out]]
endpoint = "enttec-pro:EN1=3,4"
blackout_on_exit = true
wait_for_device = true
rate_hz_max = 25
second_port = {key = "0a1B2c3D", assign = 0x10, send = 0x11, receive = 0x12, change_of_state = 0x14}
[[out]]
endpoint = "sacn:101-109=1-9"
priority = 120
source_name = "FOH"
preview = true
rate_hz_max = 30
[[out]]
endpoint = "log:out.dmxlog"
overwrite = true
[[out]]
endpoint = "artnet:1-9"
sync = true
broadcast = false
[[out]]
endpoint = "vrsl:1-3=11-13@live.png?fps=60"
overwrite = true
)",
                               "show.toml");
  REQUIRE_MESSAGE(show.has_value(), (show ? "" : show.error().message));
  CHECK(show->universe_count == 9);
  CHECK(show->merge.timeout_ns == 1'500 * kNsPerMs);
  CHECK(show->ltp == std::vector<Universe>{2, 3});
  REQUIRE(show->ltp_slots.size() == 2);
  CHECK(show->ltp_slots[0].universe == 1);
  CHECK(show->ltp_slots[0].slots.count() == 25);
  CHECK(show->ltp_slots[0].slots[0]);
  CHECK(show->ltp_slots[0].slots[23]);
  CHECK_FALSE(show->ltp_slots[0].slots[24]);
  CHECK(show->ltp_slots[0].slots[29]);
  CHECK(show->ltp_slots[1].universe == 9);
  CHECK(show->ltp_slots[1].slots[511]);
  REQUIRE(show->ins.size() == 4);
  CHECK(show->ins[0].options.hear_preview);
  CHECK(show->ins[1].options.priority == 150);
  CHECK(show->ins[1].options.rdm);
  CHECK(show->ins[2].options.wait_for_device);
  CHECK(show->ins[2].options.receive_on_change);
  CHECK(show->ins[3].options.log_loop);
  CHECK(show->ins[3].options.log_start_ns == 10 * kNsPerS);
  CHECK(show->ins[3].options.log_stop_ns == 60 * kNsPerS);
  CHECK(show->ins[3].options.log_speed == 2.0);
  REQUIRE(show->outs.size() == 5);
  CHECK(show->outs[0].options.blackout_on_exit);
  CHECK(show->outs[0].options.wait_for_device);
  CHECK(show->outs[0].options.rate_hz_max == 25.0);
  REQUIRE(show->outs[0].options.second_port);
  CHECK(show->outs[0].options.second_port->key == std::array<std::uint8_t, 4>{0x0A, 0x1B, 0x2C, 0x3D});
  CHECK(show->outs[0].options.second_port->send == 0x11);
  CHECK(show->outs[0].options.second_port->receive_mode == 0);
  CHECK(show->outs[0].options.second_port->change_of_state == 0x14);
  CHECK(show->outs[1].options.priority == 120);
  CHECK(show->outs[1].options.source_name == "FOH");
  CHECK(show->outs[1].options.preview);
  CHECK(show->outs[1].options.rate_hz_max == 30.0);
  CHECK(show->outs[2].options.log_overwrite);
  CHECK(show->outs[3].options.sync);
  CHECK_FALSE(show->outs[3].options.broadcast);
  CHECK(show->outs[4].endpoint.kind == EndpointKind::kPicture);
  CHECK(show->outs[4].endpoint.show_universes() == std::vector<Universe>{11, 12, 13});
  CHECK(show->outs[4].options.log_overwrite);
}

// One port of that endpoint with these lines, and one of the other direction.
std::string with_in(const std::string& endpoint, const std::string& lines) {
  return "[[in]]\nendpoint = \"" + endpoint + "\"\n" + lines + "[[out]]\nendpoint = \"mock:enttec-pro\"\n";
}
std::string with_out(const std::string& endpoint, const std::string& lines) {
  return "[[out]]\nendpoint = \"" + endpoint + "\"\n" + lines + "[[in]]\nendpoint = \"mock:enttec-pro\"\n";
}

InPlan in_of(const std::string& endpoint, const std::string& lines) {
  const auto show = parse_show(with_in(endpoint, lines), "show.toml");
  REQUIRE_MESSAGE(show, (show ? "" : show.error().message));
  return show->ins.at(0);
}
OutPlan out_of(const std::string& endpoint, const std::string& lines) {
  const auto show = parse_show(with_out(endpoint, lines), "show.toml");
  REQUIRE_MESSAGE(show, (show ? "" : show.error().message));
  return show->outs.at(0);
}

TEST_CASE("a network input is made with the options of the show file") {
  InPlan in = in_of("sacn:101-102=1-2%eth0,eth1", "preview = true\n");
  auto sacn = sacn_source_options(in.endpoint, in.options);
  CHECK(sacn.name == "sacn:101-102=1-2%eth0,eth1");
  CHECK(sacn.universes == std::vector<WireUniverse>{{101, 1}, {102, 2}});
  CHECK(sacn.interface_names == std::vector<std::string>{"eth0", "eth1"});
  CHECK(sacn.addresses.empty());
  CHECK(sacn.port == drivers::kSacnPort);
  CHECK(sacn.hear_preview);
  in = in_of("sacn:1@10.0.0.7:5569", "");
  sacn = sacn_source_options(in.endpoint, in.options);
  CHECK(sacn.addresses == std::vector<std::string>{"10.0.0.7"});
  CHECK(sacn.port == 5569);
  CHECK_FALSE(sacn.hear_preview);

  in = in_of("artnet:1-2=11-12@10.0.0.7,10.0.0.8", "priority = 0\n");
  auto artnet = artnet_source_options(in.endpoint, in.options);
  CHECK(artnet.universes == std::vector<WireUniverse>{{1, 11}, {2, 12}});
  CHECK(artnet.addresses == std::vector<std::string>{"10.0.0.7", "10.0.0.8"});
  CHECK(artnet.port == drivers::kArtnetPort);
  CHECK(artnet.priority == 0);
  in = in_of("artnet:1%eth0", "priority = 200\n");
  artnet = artnet_source_options(in.endpoint, in.options);
  CHECK(artnet.interface_names == std::vector<std::string>{"eth0"});
  CHECK(artnet.priority == 200);
}

TEST_CASE("a network output is made with the options of the show file") {
  OutPlan out = out_of("sacn:101-102=1-2@10.0.0.7,10.0.0.8", R"(priority = 200
preview = true
source_name = "FOH"
address_priorities = "1-2:150, 3-512:0"
sync_universe = 63999
multicast_ttl = 1
announce = false
rate_hz_max = 25.5
cid = "8fd2a1c0-1b7e-4d0a-9a52-0d6f2f3f7c1F"
)");
  auto sacn = sacn_sink_options(out.endpoint, out.options);
  CHECK(sacn.universes == std::vector<WireUniverse>{{101, 1}, {102, 2}});
  CHECK(sacn.addresses == std::vector<std::string>{"10.0.0.7", "10.0.0.8"});
  CHECK(sacn.priority == 200);
  CHECK(sacn.preview);
  CHECK(sacn.source_name == "FOH");
  REQUIRE(sacn.address_priorities.size() >= 2);
  CHECK(sacn.address_priorities[1] == 150);
  CHECK((sacn.address_priorities.size() == 2 || sacn.address_priorities[2] == 0));
  CHECK(sacn.sync_universe == 63'999);
  CHECK(sacn.multicast_ttl == 1);
  CHECK_FALSE(sacn.announce);
  CHECK(sacn.rate_hz_max == 25.5);
  CHECK(sacn.cid ==
        drivers::Cid{0x8F, 0xD2, 0xA1, 0xC0, 0x1B, 0x7E, 0x4D, 0x0A, 0x9A, 0x52, 0x0D, 0x6F, 0x2F, 0x3F, 0x7C, 0x1F});
  CHECK(drivers::sacn_cid_of(sacn) == sacn.cid);

  out = out_of("sacn:1%eth0,eth1", "");
  sacn = sacn_sink_options(out.endpoint, out.options);
  CHECK(sacn.interface_names == std::vector<std::string>{"eth0", "eth1"});
  CHECK(sacn.priority == kPriorityDefault);
  CHECK_FALSE(sacn.preview);
  CHECK(sacn.address_priorities.empty());
  CHECK(sacn.sync_universe == 0);
  CHECK(sacn.multicast_ttl == drivers::kMulticastTtlDefault);
  CHECK(sacn.announce);
  CHECK(sacn.cid == drivers::Cid{});

  out = out_of("artnet:1-9=11-19%eth0", "sync = true\nbroadcast = false\nrate_hz_max = 40\n");
  auto artnet = artnet_sink_options(out.endpoint, out.options);
  CHECK(artnet.universes.front() == WireUniverse{1, 11});
  CHECK(artnet.interface_names == std::vector<std::string>{"eth0"});
  CHECK(artnet.sync);
  CHECK(artnet.unsubscribed == drivers::ArtnetUnsubscribed::kSilent);
  CHECK(artnet.rate_hz_max == 40.0);
  out = out_of("artnet:1@10.0.0.255:6455", "");
  artnet = artnet_sink_options(out.endpoint, out.options);
  CHECK(artnet.addresses == std::vector<std::string>{"10.0.0.255"});
  CHECK(artnet.port == 6455);
  CHECK_FALSE(artnet.sync);
  CHECK(artnet.unsubscribed == drivers::ArtnetUnsubscribed::kBroadcast);
}

TEST_CASE("a wrong value of a network key is reported with its line, the key and the expected values") {
  struct Wrong {
    const char* endpoint;
    const char* line;
    const char* expected;
  };
  constexpr Wrong kIns[] = {
      {"sacn:1", "preview = 1", "preview"},      {"sacn:1", "priority = 100", "priority"},  // sACN sends its own
      {"sacn:1", "rdm = true", "rdm"},           {"artnet:1", "priority = 201", "0 to 200"},
      {"artnet:1", "priority = -1", "0 to 200"}, {"artnet:1", "priority = \"high\"", "priority"},
      {"artnet:1", "rdm = \"yes\"", "rdm"},      {"artnet:1", "preview = true", "preview"},
  };
  constexpr Wrong kOuts[] = {
      {"sacn:1", "priority = 201", "0 to 200"},
      {"sacn:1", "priority = 1.5", "priority"},
      {"sacn:1", "preview = \"no\"", "preview"},
      {"sacn:1", "source_name = 7", "source_name"},
      {"sacn:1", "address_priorities = \"1-513:100\"", "address_priorities"},
      {"sacn:1", "address_priorities = \"1-2:201\"", "address_priorities"},
      {"sacn:1", "address_priorities = \"\"", "address_priorities"},
      {"sacn:1", "address_priorities = 100", "address_priorities"},
      {"sacn:1", "sync_universe = 64000", "0 to 63999"},
      {"sacn:1", "multicast_ttl = 256", "0 to 255"},
      {"sacn:1", "announce = 0", "announce"},
      {"sacn:1", "rate_hz_max = 1001", "rate_hz_max"},
      {"sacn:1", "cid = \"8fd2a1c0\"", "32 hexadecimal digits"},
      {"sacn:1", "cid = \"8fd2a1c0-1b7e-4d0a-9a52-0d6f2f3f7c1g\"", "32 hexadecimal digits"},
      {"sacn:1", "cid = \"00000000-0000-0000-0000-000000000000\"", "32 hexadecimal digits"},
      {"sacn:1", "cid = 7", "cid"},
      {"sacn:1", "sync = true", "sync"},
      {"artnet:1", "sync = 1", "sync"},
      {"artnet:1", "broadcast = \"no\"", "broadcast"},
      {"artnet:1", "rate_hz_max = -1", "rate_hz_max"},
      {"artnet:1", "priority = 100", "priority"},
      {"artnet:1", "cid = \"8fd2a1c0-1b7e-4d0a-9a52-0d6f2f3f7c11\"", "cid"},
  };
  const auto check = [](const std::string& text, const Wrong& wrong) {
    CAPTURE(wrong.line);
    const std::string message = refusal(text);
    CAPTURE(message);
    CHECK(message.starts_with("show.toml:3:1: "));
    CHECK(contains(message, wrong.expected));
    const std::string key(wrong.line, std::string_view(wrong.line).find(' '));
    CHECK(contains(message, key));
  };
  for (const Wrong& wrong : kIns) check(with_in(wrong.endpoint, std::string(wrong.line) + "\n"), wrong);
  for (const Wrong& wrong : kOuts) check(with_out(wrong.endpoint, std::string(wrong.line) + "\n"), wrong);
}

// One [[in]] with an endpoint of the model and these lines.
std::string with_gpio(const std::string& lines) {
  return "[[in]]\nendpoint = \"gpio:mock/2=1.25\"\n" + lines + "[[out]]\nendpoint = \"mock:enttec-pro\"\n";
}

TEST_CASE("every option of a GPIO input is read, and each mode has its own defaults") {
  using drivers::StrobeMode;
  const auto options_of = [](const std::string& lines) {
    const auto show = parse_show(with_gpio(lines), "show.toml");
    REQUIRE_MESSAGE(show, (show ? "" : show.error().message));
    return show->ins.at(0).options;
  };
  const InOptions plain = options_of("");
  CHECK(plain.gpio_strobe.mode == StrobeMode::kFollow);
  CHECK(plain.gpio_strobe.hold_ns == 25 * kNsPerMs);
  CHECK(plain.gpio_strobe.flashes_hz_max == 4.0);
  CHECK_FALSE(plain.gpio_active_low);
  CHECK(options_of("mode = \"one-shot\"\n").gpio_strobe.hold_ns == 80 * kNsPerMs);
  const InOptions full = options_of(R"(mode = "one-shot"
hold = "120ms"
retrigger = "ignore"
active_low = true
bias = "pull-up"
debounce = "5ms"
on = 200
off = 3
flashes_hz_max = 10
priority = 150
wait_for_device = true
)");
  CHECK(full.gpio_strobe.mode == StrobeMode::kOneShot);
  CHECK(full.gpio_strobe.hold_ns == 120 * kNsPerMs);
  CHECK(full.gpio_strobe.retrigger == drivers::Retrigger::kIgnore);
  CHECK(full.gpio_strobe.debounce_ns == 5 * kNsPerMs);
  CHECK(full.gpio_strobe.on == 200);
  CHECK(full.gpio_strobe.off == 3);
  CHECK(full.gpio_strobe.flashes_hz_max == 10.0);
  CHECK(full.gpio_active_low);
  CHECK(full.gpio_bias == drivers::GpioBias::kPullUp);
  CHECK(full.priority == 150);
  CHECK(full.wait_for_device);
  const InOptions rate = options_of("mode = \"rate\"\nrate_hz = [0.5, 2, 20]\nrate_values = [11, 40, 250]\n");
  CHECK(rate.gpio_strobe.rate_points == std::vector<drivers::RatePoint>{{0.5, 11}, {2.0, 40}, {20.0, 250}});
}

TEST_CASE("options that do not apply to a GPIO input are refused with the line") {
  CHECK(contains(refusal(with_gpio("mode = \"blink\"\n")), "show.toml:3:1: "));
  CHECK(contains(refusal(with_gpio("mode = \"toggle\"\nhold = \"1s\"\n")), "unknown key 'hold'"));
  CHECK(contains(refusal(with_gpio("retrigger = \"ignore\"\n")), "unknown key 'retrigger'"));
  CHECK(contains(refusal(with_gpio("mode = \"rate\"\non = 1\n")), "unknown key 'on'"));
  CHECK(contains(refusal(with_gpio("flashes_hz_max = 61\n")), "show.toml:3:1: "));
  CHECK(contains(refusal(with_gpio("priority = 0\n")), "show.toml:3:1: "));
  const std::string rate = "mode = \"rate\"\n";
  CHECK(
      contains(refusal(with_gpio(rate + "rate_hz = [1, 2]\nrate_values = [1]\n")), "show.toml:4:1: rate_hz: expected"));
  CHECK(contains(refusal(with_gpio(rate + "rate_hz = [2, 1]\nrate_values = [1, 2]\n")), "rising"));
  CHECK(contains(refusal(with_gpio(rate + "rate_hz = [1, 2]\n")), "rate_values"));
  CHECK(contains(refusal(with_gpio(rate + "rate_hz = [1, \"2\"]\nrate_values = [1, 2]\n")), "numbers"));
}

TEST_CASE("only channels of a rig without intensity and mixed colour become LTP") {
  const testing::TempFolder folder;
  std::ofstream(folder.file("rig.toml")) << "[rig]\nname = \"two\"\n[[fixture]]\nname = \"head\"\n"
                                            "type = \"generic/profile\"\nuniverse = 2\naddress = 101\n"
                                            "position = [0, 0, 5]\n";
  std::ofstream(folder.file("show.toml")) << "[merge]\nltp = [3]\nltp_slots = {1 = \"7\"}\nltp_rig = \"rig.toml\"\n"
                                          << kPorts;
  const auto show = load_show(folder.file("show.toml"));
  REQUIRE_MESSAGE(show, (show ? "" : show.error().message));
  REQUIRE(show->ltp_slots.size() == 2);
  CHECK(show->ltp_slots[0].slots.count() == 1);  // from the file, for universe 1
  CHECK_FALSE(show->ltp_slots[0].from_rig);
  const LtpSlots& ltp = show->ltp_slots[1];
  CHECK(ltp.universe == 2);
  CHECK(ltp.from_rig);
  const auto rig = fixtures::load_rig(folder.file("rig.toml"));
  REQUIRE(rig);
  // Pan and tilt with two slots each, shutter, zoom, gobo and its spin; not the dimmer's two, not red, green, blue.
  SlotSet expected;
  for (const Address address : {101, 102, 103, 104, 107, 111, 112, 113, 114})
    expected.set(static_cast<std::size_t>(slot_of_address(address)));
  CHECK(ltp.slots == expected);

  fixtures::Rig moved = *rig;  // to a universe that is LTP as a whole, and to one with its own slots
  Show other;
  other.ltp = {3};
  moved.fixtures[0].universe = 3;
  add_ltp_slots(other, moved);
  CHECK(other.ltp_slots.empty());
  other.ltp_slots = {{.universe = 5, .slots = SlotSet(1)}};
  moved.fixtures[0].universe = 5;
  add_ltp_slots(other, moved);
  REQUIRE(other.ltp_slots.size() == 1);
  CHECK(other.ltp_slots[0].slots[0]);
  CHECK((other.ltp_slots[0].slots & ~SlotSet(1)) == ltp.slots);
  // Another head on the same slots, one further on: a slot that is intensity for one of them stays HTP.
  moved.fixtures.push_back(moved.fixtures[0]);
  ++moved.fixtures[1].address;
  Show shared;
  add_ltp_slots(shared, moved);
  REQUIRE(shared.ltp_slots.size() == 1);
  for (const Address address : {105, 106, 107, 108, 109, 110, 111}) {
    CAPTURE(address);
    CHECK_FALSE(shared.ltp_slots[0].slots[static_cast<std::size_t>(slot_of_address(address))]);
  }
  CHECK(shared.ltp_slots[0].slots[114]);  // the other's spin

  // By attribute, and in a break with its own address.
  fixtures::FixtureType imported;
  fixtures::Mode& mode = imported.modes.emplace_back();
  for (const char* attribute : {"Pan", "Dimmer", "ColorAdd_R", "ColorSub_C", "Color1", "NoFeature", "Gobo1"}) {
    fixtures::Channel& channel = mode.channels.emplace_back();
    channel.slot_offsets = {static_cast<int>(mode.channels.size()) - 1};
    channel.functions.emplace_back().attribute = attribute;
  }
  mode.channels.back().dmx_break = 2;
  fixtures::Rig two_breaks;
  two_breaks.types.push_back(imported);
  fixtures::PatchedFixture& fixture = two_breaks.fixtures.emplace_back();
  fixture.universe = 8;
  fixture.further_addresses.push_back({.dmx_break = 2, .universe = 9, .address = 506});
  Show by_attribute;
  add_ltp_slots(by_attribute, two_breaks);
  REQUIRE(by_attribute.ltp_slots.size() == 2);
  CHECK(by_attribute.ltp_slots[0].slots == SlotSet(0b10001));  // pan and the wheel
  CHECK(by_attribute.ltp_slots[1].universe == 9);
  CHECK(by_attribute.ltp_slots[1].slots[511]);
  CHECK(by_attribute.ltp_slots[1].slots.count() == 1);

  std::ofstream(folder.file("show.toml")) << "[merge]\nltp_rig = \"none.toml\"\n" << kPorts;
  const auto missing = load_show(folder.file("show.toml"));
  REQUIRE_FALSE(missing);
  CHECK(contains(missing.error().message, "none.toml"));
}

TEST_CASE("invalid LTP slots are refused with the line") {
  for (const char* wrong : {"{1 = \"0\"}", "{1 = \"1-513\"}", "{1 = \"5-4\"}", "{1 = \"1,\"}", "{1 = \"\"}", "{1 = 3}",
                            "{one = \"3\"}", "{0 = \"3\"}", "{64000 = \"3\"}", "{3 = \"1\"}", "\"1-24\""}) {
    const auto show = parse_show(fmt::format("[merge]\nltp = [3]\nltp_slots = {}\n[[in]]\nendpoint = \"sacn:1\"\n"
                                             "[[out]]\nendpoint = \"artnet:1\"\n",
                                             wrong),
                                 "show.toml");
    REQUIRE_FALSE(show.has_value());
    CHECK_MESSAGE(show.error().message.starts_with("show.toml:3:"), show.error().message);
  }
}

TEST_CASE("an error in a show file is reported with its line") {
  CHECK(contains(refusal("[[in]]\nendpoint = \"scan:1\"\n"), "show.toml:2:1: scan:1: unknown scheme"));
  CHECK(contains(refusal("[[in]]\nendpoint = \"sacn:0\"\n"), "show.toml:2:1: sacn:0: universe 0 does not exist"));
  CHECK(contains(refusal("[[out]]\nendpoint = \"sacn:1\"\npriority = 201\n"), "show.toml:3"));
  CHECK(contains(refusal("[[in]]\nendpont = \"sacn:1\"\n"), "did you mean 'endpoint'"));
  CHECK(contains(refusal("[merge]\ntimeout = \"fast\"\n"), "show.toml:2:1: timeout: expected a time such as"));
  CHECK(contains(refusal("[merge]\ntimeout = \"0s\"\n"), "show.toml:2:1: timeout: expected a time above 0"));
  CHECK(contains(refusal("[[in]\n"), "show.toml:1"));
  const std::string device = "[[out]]\nendpoint = \"enttec-pro=1,2\"\n";
  CHECK(contains(refusal(device + "second_port = {send = 3}\n"), "key"));
  CHECK(contains(refusal(device + "second_port = {key = \"12\"}\n"), "8 hexadecimal digits"));
  CHECK(contains(refusal(device + "second_port = {key = \"0A1B2C3G\"}\n"), "8 hexadecimal digits"));
  CHECK(contains(refusal(device + "second_port = {key = \"0A1B2C3D\", send = 256}\n"), "show.toml:3"));
  CHECK(contains(refusal("universes = 64000\n"), "show.toml:1"));
}

TEST_CASE("an option that does not apply to the kind of port is refused, not ignored") {
  CHECK(contains(refusal("[[out]]\nendpoint = \"artnet:1\"\nblackout_on_exit = true\n"), "blackout_on_exit"));
  CHECK(contains(refusal("[[out]]\nendpoint = \"artnet:1@10.0.0.7\"\nbroadcast = false\n"), "broadcast"));
  CHECK(contains(refusal("[[out]]\nendpoint = \"mock:enttec-pro\"\npriority = 100\n"), "priority"));
  CHECK(contains(refusal("[[in]]\nendpoint = \"sacn:1\"\nloop = true\n"), "loop"));
}

TEST_CASE("a show without outputs is refused with an example of the missing lines, inputs may be missing") {
  CHECK(contains(refusal(""), "[[out]]\n  endpoint = "));
  CHECK(contains(refusal("[[in]]\nendpoint = \"sacn:1\"\n"), "[[out]]\n  endpoint = "));
  const auto by_hand = parse_show("[[out]]\nendpoint = \"mock:enttec-pro\"\n", "show.toml");  // levels of `set`
  REQUIRE_MESSAGE(by_hand.has_value(), (by_hand ? "" : by_hand.error().message));
  CHECK(by_hand->ins.empty());
}

TEST_CASE("a standby is placed behind its main output, whatever the order in the file") {
  const std::string in = "[[in]]\nendpoint = \"sacn:1\"\n";
  const auto out = [](const std::string& endpoint, const std::string& standby_for) {
    return "[[out]]\nendpoint = \"" + endpoint + "\"\nstandby_for = \"" + standby_for + "\"\n";
  };
  const auto show = parse_show(
      in + out("sacn:3", "sacn:2") + out("sacn:2", "artnet:1") + "[[out]]\nendpoint = \"artnet:1\"\n", "show.toml");
  REQUIRE_MESSAGE(show.has_value(), (show ? "" : show.error().message));
  CHECK(show->outs[0].endpoint.text == "artnet:1");
  CHECK(show->outs[1].endpoint.text == "sacn:2");
  CHECK(show->outs[1].standby_for == "artnet:1");
  CHECK(show->outs[2].endpoint.text == "sacn:3");
  CHECK(contains(refusal(in + out("sacn:2", "sacn:2")), "cannot be its own standby"));
  CHECK(contains(refusal(in + out("sacn:2", "sacn:3") + out("sacn:3", "sacn:2")), "in a circle"));
  CHECK(contains(refusal(in + out("sacn:2", "sacn:9")), "expected the endpoint of another output"));
}

}  // namespace
}  // namespace footlight::tools
