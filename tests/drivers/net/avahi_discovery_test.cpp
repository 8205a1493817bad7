// Stations that find each other through a real avahi-daemon, in a network namespace. Waits for its messages, not for
// times.
#include <doctest/doctest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "drivers/net/mvr_xchange_discovery.h"
#include "sim/system_clock.h"
#include "tests/drivers/net/avahi_bed.h"
#include "tests/drivers/net/mvr_xchange_helpers.h"
#include "tests/drivers/net/private_network.h"

namespace footlight::drivers {
namespace {

using namespace footlight::testing;
using Discoveries = std::vector<MvrDiscovery*>;

// Until a condition holds; false: not within 30 s.
template <class Condition>
bool steps_until(const Discoveries& discoveries, const Condition& condition) {
  SystemClock clock;
  const TimeNs end_ns = clock.now_ns() + 30 * kNsPerS;
  std::vector<pollfd> waiting;
  while (clock.now_ns() < end_ns) {
    // A hundred times as fast, since a lost daemon is asked for every 5 s.
    const TimeNs now_ns = end_ns + (clock.now_ns() - end_ns) * 100;
    for (MvrDiscovery* const one : discoveries) one->step(now_ns);
    if (condition()) return true;
    for (const MvrDiscovery* const one : discoveries) one->add_descriptors(waiting);
    poll_some(waiting);
  }
  return false;
}

bool network_runs() { return enter_private_network() && add_interface("fl7", "10.7.0.1"); }

std::vector<MvrFound> sorted(std::vector<MvrFound> found) {
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return found;
}

TEST_CASE("stations of two groups find each other, a taken name gets a number, and those that end are gone") {
  if (!network_runs()) return;
  AvahiBed bed;
  if (!bed.runs()) return;
  auto desk = must(open_mvr_discovery());
  auto view = must(open_mvr_discovery());
  auto twin = must(open_mvr_discovery());
  desk->announce({"Desk. FOH", kDeskUuid, "Tour", 42424});
  REQUIRE(steps_until({desk.get()}, [&] { return !desk->announced_name().empty(); }));
  view->announce({"View", kViewUuid, "Rehearsal 2", 7});
  twin->announce({"Desk. FOH", kOldFile, "Tour", 8});
  const Discoveries all = {desk.get(), view.get(), twin.get()};
  REQUIRE(steps_until(all, [&] { return !twin->announced_name().empty() && view->found().size() == 3; }));
  CHECK(desk->announced_name() == "Desk. FOH");
  CHECK(twin->announced_name() == "Desk- FOH #2");
  const auto found = sorted(view->found());
  CHECK(found[0].name == "Desk. FOH");
  CHECK(found[0].group == "Tour");
  CHECK(found[2].name == "View");
  CHECK(found[2].uuid == kViewUuid);
  CHECK(found[2].group == "Rehearsal 2");
  CHECK(found[2].address.port == 7);
  const bool here = found[2].address.ipv4 == 0x7F000001 || found[2].address.ipv4 == 0x0A070001;
  CHECK(here);
  twin.reset();
  desk.reset();
  CHECK(steps_until({view.get()}, [&] { return view->found().size() == 1; }));
}

TEST_CASE("a station is announced and found again when the daemon has ended and is back") {
  if (!network_runs()) return;
  AvahiBed bed;
  if (!bed.runs()) return;
  const auto desk = must(open_mvr_discovery());
  desk->announce({"Desk", kDeskUuid, "Tour", 42424});
  REQUIRE(steps_until({desk.get()}, [&] { return desk->found().size() == 1; }));
  bed.stop_daemon();
  REQUIRE(steps_until({desk.get()}, [&] { return desk->found().empty(); }));
  CHECK(desk->announced_name().empty());
  const auto without = open_mvr_discovery();
  REQUIRE(!without);
  CHECK(without.error().code == ErrorCode::kNotFound);
  CHECK(without.error().message.find("avahi-daemon") != std::string::npos);
  REQUIRE(bed.start_daemon());
  CHECK(steps_until({desk.get()}, [&] { return desk->found().size() == 1 && !desk->announced_name().empty(); }));
}

}  // namespace
}  // namespace footlight::drivers
