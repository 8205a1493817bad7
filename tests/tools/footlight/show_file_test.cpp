#include "tools/footlight/show_file.h"

#include <doctest/doctest.h>
#include <fmt/format.h>

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

TEST_CASE("a show of two ports needs two lines each, and everything else has a default") {
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

TEST_CASE("every option of a show file arrives") {
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
  REQUIRE(show->outs.size() == 4);
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
}

// One [[in]] with an endpoint of the model and these lines.
std::string with_gpio(const std::string& lines) {
  return "[[in]]\nendpoint = \"gpio:mock/2=1.25\"\n" + lines + "[[out]]\nendpoint = \"mock:enttec-pro\"\n";
}

TEST_CASE("every option of a GPIO input arrives, and each mode has its own defaults") {
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

TEST_CASE("what a GPIO input cannot do is refused with the line") {
  CHECK(contains(refusal(with_gpio("mode = \"blink\"\n")), "show.toml:3: "));
  CHECK(contains(refusal(with_gpio("mode = \"toggle\"\nhold = \"1s\"\n")), "unknown key 'hold'"));
  CHECK(contains(refusal(with_gpio("retrigger = \"ignore\"\n")), "unknown key 'retrigger'"));
  CHECK(contains(refusal(with_gpio("mode = \"rate\"\non = 1\n")), "unknown key 'on'"));
  CHECK(contains(refusal(with_gpio("flashes_hz_max = 61\n")), "show.toml:3: "));
  CHECK(contains(refusal(with_gpio("priority = 0\n")), "show.toml:3: "));
  const std::string rate = "mode = \"rate\"\n";
  CHECK(contains(refusal(with_gpio(rate + "rate_hz = [1, 2]\nrate_values = [1]\n")), "show.toml:4: rate_hz: expected"));
  CHECK(contains(refusal(with_gpio(rate + "rate_hz = [2, 1]\nrate_values = [1, 2]\n")), "rising"));
  CHECK(contains(refusal(with_gpio(rate + "rate_hz = [1, 2]\n")), "rate_values"));
  CHECK(contains(refusal(with_gpio(rate + "rate_hz = [1, \"2\"]\nrate_values = [1, 2]\n")), "numbers"));
}

TEST_CASE("LTP slots that are none are refused with the line") {
  for (const char* wrong : {"{1 = \"0\"}", "{1 = \"1-513\"}", "{1 = \"5-4\"}", "{1 = \"1,\"}", "{1 = \"\"}", "{1 = 3}",
                            "{one = \"3\"}", "{0 = \"3\"}", "{64000 = \"3\"}", "{3 = \"1\"}", "\"1-24\""}) {
    const auto show = parse_show(fmt::format("[merge]\nltp = [3]\nltp_slots = {}\n[[in]]\nendpoint = \"sacn:1\"\n"
                                             "[[out]]\nendpoint = \"artnet:1\"\n",
                                             wrong),
                                 "show.toml");
    REQUIRE_FALSE(show.has_value());
    CHECK_MESSAGE(show.error().message.starts_with("show.toml:3: "), show.error().message);
  }
}

TEST_CASE("trouble in a show file is named by line") {
  CHECK(contains(refusal("[[in]]\nendpoint = \"scan:1\"\n"), "show.toml:2: scan:1: unknown scheme"));
  CHECK(contains(refusal("[[in]]\nendpoint = \"sacn:0\"\n"), "show.toml:2: sacn:0: universe 0 does not exist"));
  CHECK(contains(refusal("[[out]]\nendpoint = \"sacn:1\"\npriority = 201\n"), "show.toml:3"));
  CHECK(contains(refusal("[[in]]\nendpont = \"sacn:1\"\n"), "did you mean 'endpoint'"));
  CHECK(contains(refusal("[merge]\ntimeout = \"fast\"\n"), "show.toml:2: timeout: expected a time as in"));
  CHECK(contains(refusal("[merge]\ntimeout = \"0s\"\n"), "show.toml:2: timeout: expected a time above 0"));
  CHECK(contains(refusal("[[in]\n"), "show.toml:1"));
  const std::string device = "[[out]]\nendpoint = \"enttec-pro=1,2\"\n";
  CHECK(contains(refusal(device + "second_port = {send = 3}\n"), "key"));
  CHECK(contains(refusal(device + "second_port = {key = \"12\"}\n"), "8 hexadecimal digits"));
  CHECK(contains(refusal(device + "second_port = {key = \"0A1B2C3G\"}\n"), "8 hexadecimal digits"));
  CHECK(contains(refusal(device + "second_port = {key = \"0A1B2C3D\", send = 256}\n"), "show.toml:3"));
  CHECK(contains(refusal("universes = 64000\n"), "show.toml:1"));
}

TEST_CASE("an option that the kind of port has no use for is refused, not ignored") {
  CHECK(contains(refusal("[[out]]\nendpoint = \"artnet:1\"\nblackout_on_exit = true\n"), "blackout_on_exit"));
  CHECK(contains(refusal("[[out]]\nendpoint = \"artnet:1@10.0.0.7\"\nbroadcast = false\n"), "broadcast"));
  CHECK(contains(refusal("[[out]]\nendpoint = \"mock:enttec-pro\"\npriority = 100\n"), "priority"));
  CHECK(contains(refusal("[[in]]\nendpoint = \"sacn:1\"\nloop = true\n"), "loop"));
}

TEST_CASE("a show without inputs or without outputs says which are missing and how to write one") {
  CHECK(contains(refusal(""), "[[in]]"));
  CHECK(contains(refusal("[[in]]\nendpoint = \"sacn:1\"\n"), "[[out]]"));
}

TEST_CASE("who stands by for another comes behind it, whatever the order in the file") {
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
  CHECK(contains(refusal(in + out("sacn:2", "sacn:2")), "cannot stand by for itself"));
  CHECK(contains(refusal(in + out("sacn:2", "sacn:3") + out("sacn:3", "sacn:2")), "in a circle"));
  CHECK(contains(refusal(in + out("sacn:2", "sacn:9")), "expected the endpoint of another output"));
}

}  // namespace
}  // namespace footlight::tools
