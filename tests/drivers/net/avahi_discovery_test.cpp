// Stations that find each other through a real avahi-daemon, in a network namespace. Waits for its messages, not for
// times.
#include <doctest/doctest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <netinet/in.h>
#include <sys/socket.h>

#include "drivers/net/bytes.h"
#include "drivers/net/mvr_xchange_discovery.h"
#include "drivers/net/mvr_xchange_names.h"
#include "drivers/net/udp.h"
#include "sim/system_clock.h"
#include "tests/drivers/net/avahi_bed.h"
#include "tests/drivers/net/mvr_xchange_helpers.h"
#include "tests/drivers/net/private_network.h"
#include "tests/drivers/net/tshark.h"

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
  if (!AvahiBed::is_installed()) return;
  AvahiBed bed;
  REQUIRE(bed.runs());
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

TEST_CASE("a name that the daemon does not take is a trouble until another one is announced") {
  if (!network_runs()) return;
  if (!AvahiBed::is_installed()) return;
  AvahiBed bed;
  REQUIRE(bed.runs());
  const auto desk = must(open_mvr_discovery());
  desk->announce({"FOH \xFF", kDeskUuid, "Tour", 42424});
  REQUIRE(steps_until({desk.get()}, [&] { return !desk->trouble().empty(); }));
  CHECK(desk->announced_name().empty());
  CHECK(desk->trouble().find("choose another name") != std::string::npos);
  desk->announce({"FOH", kDeskUuid, "Tour", 42424});
  REQUIRE(steps_until({desk.get()}, [&] { return desk->announced_name() == "FOH"; }));
  CHECK(desk->trouble().empty());
}

TEST_CASE("a station is announced and found again when the daemon has ended and is back") {
  if (!network_runs()) return;
  if (!AvahiBed::is_installed()) return;
  AvahiBed bed;
  REQUIRE(bed.runs());
  const auto desk = must(open_mvr_discovery());
  desk->announce({"Desk", kDeskUuid, "Tour", 42424});
  REQUIRE(steps_until({desk.get()}, [&] { return desk->found().size() == 1; }));
  bed.stop_daemon();
  REQUIRE(steps_until({desk.get()}, [&] { return desk->found().empty() && !desk->trouble().empty(); }));
  CHECK(desk->announced_name().empty());
  CHECK(desk->trouble().find("systemctl start avahi-daemon") != std::string::npos);
  const auto without = open_mvr_discovery();
  REQUIRE(!without);
  CHECK(without.error().code == ErrorCode::kNotFound);
  CHECK(without.error().message.find("avahi-daemon") != std::string::npos);
  REQUIRE(bed.start_daemon());
  CHECK(steps_until({desk.get()}, [&] { return desk->found().size() == 1 && !desk->announced_name().empty(); }));
  CHECK(desk->trouble().empty());
}

constexpr std::uint32_t kMdnsGroup = 0xE00000FB;
constexpr std::uint16_t kMdnsPort = 5353;

TEST_CASE(
    "to Wireshark an announced station is an instance of the service and of its group, with host, port and texts") {
  if (!network_runs()) return;
  if (!AvahiBed::is_installed()) return;
  AvahiBed bed;
  REQUIRE(bed.runs());
  const Fd receiver = must(open_receiver({.port_name = "mdns", .udp_port = kMdnsPort}));
  REQUIRE(join_group(receiver, kMdnsGroup, must(find_interface("mdns", "fl7")).index) == 0);
  const auto desk = must(open_mvr_discovery());
  desk->announce({"Desk", kDeskUuid, "Tour", 42424});
  DatagramReader reader;
  std::vector<std::uint8_t> announcement;
  REQUIRE(steps_until({desk.get()}, [&] {
    for (int i = 0, count = reader.read(receiver.get()); i < count; ++i) {
      const auto bytes = reader[static_cast<std::size_t>(i)].bytes;
      const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      const bool answers = bytes.size() > 12 && (bytes[2] & 0x80) != 0;
      if (answers && text.find("StationUUID") != text.npos && text.find("Tour") != text.npos) {
        announcement.assign(bytes.begin(), bytes.end());
      }
    }
    return !announcement.empty();
  }));
  const auto fields = dissect(announcement, kMdnsPort,
                              {"dns.resp.name", "dns.ptr.domain_name", "dns.srv.port", "dns.srv.target", "dns.txt"});
  if (!fields) return;
  const auto has = [&](const char* field, std::string_view part) {
    CAPTURE(fields->at(field));
    CHECK(fields->at(field).find(part) != std::string::npos);
  };
  has("dns.resp.name", "Tour._mvrxchange._tcp.local");
  has("dns.ptr.domain_name", "Desk.Tour._mvrxchange._tcp.local,Desk.Tour._mvrxchange._tcp.local");
  has("dns.srv.port", "42424");
  has("dns.srv.target", "testbed.local");
  has("dns.txt", "StationName=Desk");
  has("dns.txt", std::string("StationUUID=") + kDeskUuid);
}

// A response of multicast DNS with one instance.
std::vector<std::uint8_t> response(const DnsLabels& instance, std::uint32_t ttl_s) {
  const DnsLabels host = {"Other", "Tour", "_mvrxchange", "_tcp", "local"};
  std::vector<std::uint8_t> bytes = {0, 0, 0x84, 0, 0, 0, 0, 4, 0, 0, 0, 0};
  const auto add = [&](const DnsLabels& name, std::uint16_t type, const std::vector<std::uint8_t>& data) {
    const auto encoded = build_dns_name(name);
    bytes.insert(bytes.end(), encoded.begin(), encoded.end());
    std::array<std::uint8_t, 10> head = {};
    write_u16_be(head, 0, type);
    write_u16_be(head, 2, type == 12 ? 1 : 0x8001);
    write_u32_be(head, 4, ttl_s);
    write_u16_be(head, 8, static_cast<std::uint16_t>(data.size()));
    bytes.insert(bytes.end(), head.begin(), head.end());
    bytes.insert(bytes.end(), data.begin(), data.end());
  };
  add(mvr_group_name(""), 12, build_dns_name(instance));
  add(instance, 33, build_dns_srv({9999, host}));
  add(instance, 16, build_mvr_text({"Other", kViewUuid}));
  add(host, 1, {10, 8, 0, 2});
  return bytes;
}

// Multicast DNS of another machine: 10.8.0.2 at the other end of a cable.
class OtherMachine {
 public:
  [[nodiscard]] static bool connect() { return enter_private_network() && add_peer("fl8", "10.8.0.1", {"10.8.0.2"}); }
  OtherMachine() {
    const OnPeer there;
    socket_ = Fd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    sockaddr_in own = {};
    own.sin_family = AF_INET;
    own.sin_port = htons(kMdnsPort);
    own.sin_addr.s_addr = htonl(0x0A080002);
    REQUIRE(::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&own), sizeof own) == 0);
    const int ttl = 255;
    REQUIRE(::setsockopt(socket_.get(), IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl) == 0);
    REQUIRE(::setsockopt(socket_.get(), IPPROTO_IP, IP_MULTICAST_IF, &own.sin_addr, sizeof own.sin_addr) == 0);
  }
  void send(const std::vector<std::uint8_t>& bytes) const {
    sockaddr_in group = {};
    group.sin_family = AF_INET;
    group.sin_port = htons(kMdnsPort);
    group.sin_addr.s_addr = htonl(kMdnsGroup);
    REQUIRE(::sendto(socket_.get(), bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&group),
                     sizeof group) == static_cast<ssize_t>(bytes.size()));
  }

 private:
  Fd socket_;
};

TEST_CASE("a station of another machine whose instance is only its group is found, and gone after its goodbye") {
  if (!OtherMachine::connect()) return;
  if (!AvahiBed::is_installed()) return;
  AvahiBed bed;
  REQUIRE(bed.runs());
  const OtherMachine other;
  const auto view = must(open_mvr_discovery());
  view->step(0);
  other.send(response(mvr_group_name("Tour"), 120));
  REQUIRE(steps_until({view.get()}, [&] { return view->found().size() == 1; }));
  CHECK(view->found()[0] == MvrFound{"Other", kViewUuid, "Tour", {0x0A080002, 9999}});
  other.send(response(mvr_group_name("Tour"), 0));
  CHECK(steps_until({view.get()}, [&] { return view->found().empty(); }));
}

TEST_CASE("a name that another machine defends gets a number") {
  if (!OtherMachine::connect()) return;
  if (!AvahiBed::is_installed()) return;
  AvahiBed bed;
  REQUIRE(bed.runs());
  const OtherMachine other;
  const auto desk = must(open_mvr_discovery());
  desk->announce({"Desk", kDeskUuid, "Tour", 42424});
  const auto defence = response(mvr_instance_name({"Desk", "Tour"}), 120);
  CHECK(steps_until({desk.get()}, [&] {
    other.send(defence);
    return desk->announced_name() == "Desk #2";
  }));
}

}  // namespace
}  // namespace footlight::drivers
