#include "tools/footlight/show_file.h"

#include <doctest/doctest.h>

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
[[in]]
endpoint = "sacn:1-9%eth0"
preview = true
[[in]]
endpoint = "artnet:1=10"
priority = 150
[[in]]
endpoint = "mock:enttec-pro=11"
wait_for_device = true
[[in]]
endpoint = "log:show.dmxlog"
loop = true
start = "10s"
stop = "1m"
speed = 2.0
[[out]]
endpoint = "enttec-pro:EN1=3"
blackout_on_exit = true
wait_for_device = true
[[out]]
endpoint = "sacn:101-109=1-9"
priority = 120
source_name = "FOH"
preview = true
rate_hz_max = 30
[[out]]
endpoint = "log:out.dmxlog"
overwrite = true
)",
                               "show.toml");
  REQUIRE_MESSAGE(show.has_value(), (show ? "" : show.error().message));
  CHECK(show->universe_count == 9);
  CHECK(show->merge.timeout_ns == 1'500 * kNsPerMs);
  CHECK(show->ltp == std::vector<Universe>{2, 3});
  REQUIRE(show->ins.size() == 4);
  CHECK(show->ins[0].options.hear_preview);
  CHECK(show->ins[1].options.priority == 150);
  CHECK(show->ins[2].options.wait_for_device);
  CHECK(show->ins[3].options.log_loop);
  CHECK(show->ins[3].options.log_start_ns == 10 * kNsPerS);
  CHECK(show->ins[3].options.log_stop_ns == 60 * kNsPerS);
  CHECK(show->ins[3].options.log_speed == 2.0);
  REQUIRE(show->outs.size() == 3);
  CHECK(show->outs[0].options.blackout_on_exit);
  CHECK(show->outs[0].options.wait_for_device);
  CHECK(show->outs[1].options.priority == 120);
  CHECK(show->outs[1].options.source_name == "FOH");
  CHECK(show->outs[1].options.preview);
  CHECK(show->outs[1].options.rate_hz_max == 30.0);
  CHECK(show->outs[2].options.log_overwrite);
}

TEST_CASE("trouble in a show file is named by line") {
  CHECK(contains(refusal("[[in]]\nendpoint = \"scan:1\"\n"), "show.toml:2: scan:1: unknown scheme"));
  CHECK(contains(refusal("[[in]]\nendpoint = \"sacn:0\"\n"), "show.toml:2: sacn:0: universe 0 does not exist"));
  CHECK(contains(refusal("[[out]]\nendpoint = \"sacn:1\"\npriority = 201\n"), "show.toml:3"));
  CHECK(contains(refusal("[[in]]\nendpont = \"sacn:1\"\n"), "did you mean 'endpoint'"));
  CHECK(contains(refusal("[merge]\ntimeout = \"fast\"\n"), "show.toml:2: timeout: expected a time as in"));
  CHECK(contains(refusal("[merge]\ntimeout = \"0s\"\n"), "show.toml:2: timeout: expected a time above 0"));
  CHECK(contains(refusal("[[in]\n"), "show.toml:1"));
  CHECK(contains(refusal("universes = 64000\n"), "show.toml:1"));
}

TEST_CASE("an option that the kind of port has no use for is refused, not ignored") {
  CHECK(contains(refusal("[[out]]\nendpoint = \"artnet:1\"\nblackout_on_exit = true\n"), "blackout_on_exit"));
  CHECK(contains(refusal("[[out]]\nendpoint = \"mock:enttec-pro\"\npriority = 100\n"), "priority"));
  CHECK(contains(refusal("[[in]]\nendpoint = \"sacn:1\"\nloop = true\n"), "loop"));
}

TEST_CASE("a show without inputs or without outputs says which are missing and how to write one") {
  CHECK(contains(refusal(""), "[[in]]"));
  CHECK(contains(refusal("[[in]]\nendpoint = \"sacn:1\"\n"), "[[out]]"));
}

}  // namespace
}  // namespace footlight::tools
