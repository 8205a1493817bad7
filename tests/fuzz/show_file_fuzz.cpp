// Arbitrary text as show files.
#include <array>

#include "tests/fuzz/fuzz.h"
#include "tools/footlight/bridge/show_file.h"

using namespace footlight;
using footlight::testing::require;

// Replaces the one in open_ports.cpp, which needs every driver.
Result<Endpoint> tools::parse_port(std::string_view text) {
  constexpr std::array<std::string_view, 2> kSchemes = {"enttec-pro", "mock"};
  return parse_endpoint(text, kSchemes);
}

void footlight::testing::add_seeds(Seeds& seeds) {
  seeds.add(
      "full",
      "universes = 9\n[merge]\ntimeout = \"2.5s\"\nltp = [2, 3]\n[[in]]\nendpoint = \"sacn:1-9\"\npreview = true\n"
      "[[in]]\nendpoint = \"log:a.dmxlog\"\nloop = true\nstart = \"10s\"\nspeed = 2.0\n[[in]]\n"
      "endpoint = \"artnet:1\"\npriority = 90\n[[out]]\nendpoint = \"enttec-pro:EN1=3\"\nblackout_on_exit = true\n"
      "wait_for_device = true\n[[out]]\nendpoint = \"sacn:1\"\nsource_name = \"FOH\"\nrate_hz_max = 40\n");
  seeds.add("small", "[[in]]\nendpoint = \"sacn:1\"\n[[out]]\nendpoint = \"mock\"\n");
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto show = tools::parse_show(std::string_view(reinterpret_cast<const char*>(data), size), "fuzz.toml");
  if (!show) {
    require(show.error().code == ErrorCode::kBadInput && show.error().message.starts_with("fuzz.toml:"));
    return 0;
  }
  require(!show->outs.empty());
  for (const tools::OutPlan& out : show->outs) require(out.options.priority >= 0 && out.options.priority <= 200);
  return 0;
}
