// Text typed by users: endpoints, lists of universes, durations. The first byte selects which.
#include <algorithm>
#include <array>

#include "sim/core/endpoint.h"
#include "tests/fuzz/fuzz.h"
#include "tools/footlight/duration.h"

using namespace footlight;
using footlight::testing::require;

void footlight::testing::add_seeds(Seeds& seeds) {
  for (const char* text :
       {"sacn:1-9", "sacn:1,3,5-7@10.0.0.7:5569", "artnet:1-9@10.9.0.255", "sacn:101-109=1-9%eth0",
        "enttec-pro:EN123456=3", "enttec-pro:port-1-2.3", "mock:enttec-pro", "log:show.dmxlog", "sacn:1-9%eth0,eth1",
        "artnet:1-9@10.0.0.7,10.0.0.8", "gpio:gpiochip0/17=1.25", "vrsl:1-3=4-6@a.png?fps=30&layout=top",
        "vrsl-osc:1-9@127.0.0.1", "audio:track.flac=1.25", "audio:mock=1.1", "audio:map.toml", "osc:8000@10.0.0.7",
        "midi:mock=1.1"}) {
    std::string name = text;
    std::replace(name.begin(), name.end(), '/', '_');
    seeds.add("endpoint-" + name, "\x01" + std::string(text));
  }
  for (const char* text : {"1-9", "101-109=1-9", "1,3,7-9=2,4,8-10"}) {
    seeds.add("list-" + std::string(text), "\x02" + std::string(text));
  }
  for (const char* text : {"12.5s", "40ms", "1m30s", "2h", "7", "1h2m3s4ms5us6ns"}) {
    seeds.add("time-" + std::string(text), "\x03" + std::string(text));
  }
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  switch (data[0] % 3) {
    case 0: {
      const auto duration_ns = tools::parse_duration(text);
      if (!duration_ns) break;
      require(*duration_ns >= 0 && *duration_ns <= 10'000 * 3'600 * kNsPerS);
      require(!tools::show_duration(*duration_ns).empty());
      break;
    }
    case 1: {
      constexpr std::array<std::string_view, 3> kSchemes = {"enttec-pro", "mock", "open-dmx"};
      const auto endpoint = parse_endpoint(text, kSchemes);
      if (!endpoint) {
        require(endpoint.error().code == ErrorCode::kBadInput && !endpoint.error().message.empty());
        break;
      }
      require(endpoint->text == text);
      for (const WireUniverse& universe : endpoint->universes)
        require(is_universe(universe.show) && universe.wire >= 0);
      break;
    }
    default: {
      const auto list = parse_wire_universes(text);
      if (!list) break;
      require(!list->empty());
      for (const WireUniverse& universe : *list) require(is_universe(universe.show) && is_universe(universe.wire));
    }
  }
  return 0;
}
