// Synchronisation, discovery and priorities per address over real sockets, in a private network.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>

#include "drivers/net/sacn_discovery.h"
#include "drivers/net/sacn_port.h"
#include "tests/drivers/net/port_helpers.h"
#include "tests/drivers/net/private_network.h"
#include "tests/drivers/net/tshark.h"
#include "tests/support/must.h"

namespace footlight::drivers {
namespace {

using testing::enter_private_network;
using testing::KeepingReceiver;
using testing::must;
using testing::poll_until;
using testing::test_levels;
using testing::universes_from;

constexpr TimeNs kStartNs = 1'000 * kNsPerS;

std::unique_ptr<SacnSource> open_source(int universe_count, bool kernel_stamps = false) {
  SacnSourceOptions options;
  options.name = "sacn:test-in";
  options.universes = universes_from(1, universe_count, 1);
  options.kernel_stamps = kernel_stamps;
  return must(SacnSource::create(options));
}

SacnSinkOptions sink_options(int universe_count) {
  SacnSinkOptions options;
  options.name = "sacn:test-out";
  options.universes = universes_from(1, universe_count, 1);
  options.announce = false;
  return options;
}

void send_all(SacnSink& sink, TimeNs now_ns, int round) {
  std::vector<std::vector<std::uint8_t>> levels;
  std::vector<FrameView> frames;
  for (const Universe universe : sink.universes()) levels.push_back(test_levels(universe, round));
  for (std::size_t i = 0; i < levels.size(); ++i) {
    FrameView frame;
    frame.universe = sink.universes()[i];
    frame.slots = levels[i];
    frames.push_back(frame);
  }
  REQUIRE(sink.send(now_ns, frames).has_value());
}

// Reads the packets to a group from its own socket, as bytes.
class Eavesdropper {
 public:
  explicit Eavesdropper(int universe) {
    ReceiverSocket wanted;
    wanted.port_name = "eavesdropper";
    wanted.udp_port = kSacnPort;
    socket_ = must(open_receiver(wanted));
    for (const auto& interface : list_interfaces()) {
      REQUIRE(join_group(socket_, sacn_group_ipv4(universe), interface.index) == 0);
    }
  }
  std::vector<std::vector<std::uint8_t>> read() {
    std::vector<std::vector<std::uint8_t>> datagrams;
    for (int count; (count = reader_.read(socket_.get())) > 0;) {
      for (int i = 0; i < count; ++i) {
        const auto bytes = reader_[static_cast<std::size_t>(i)].bytes;
        datagrams.emplace_back(bytes.begin(), bytes.end());
      }
    }
    return datagrams;
  }

 private:
  Fd socket_;
  DatagramReader reader_;
};

}  // namespace

TEST_CASE("50 synchronised universes arrive together in one poll once the group of their address is joined") {
  if (!enter_private_network()) return;
  auto source = open_source(50, true);
  auto options = sink_options(50);
  options.sync_universe = 7'000;
  auto sink = must(SacnSink::create(options));
  KeepingReceiver kept;
  // The first batch announces the address; the second is the first whose synchronisation packet is received.
  for (int round = 0; round < 2; ++round) {
    send_all(*sink, kStartNs, round);
    REQUIRE(poll_until(*source, kStartNs, kept,
                       [&] { return kept.frames.size() == static_cast<std::size_t>(50 * (round + 1)); }));
  }
  CHECK(source->socket_count() == 3);
  CHECK(source->details().sync == 1);
  CHECK(source->details().synchroniser.held == 0);
  for (int round = 2; round < 6; ++round) {
    kept.frames.clear();
    send_all(*sink, kStartNs, round);
    REQUIRE(source->poll(kStartNs, kept).has_value());  // one call: on "lo" all of it has arrived
    REQUIRE(kept.frames.size() == 50);
    for (const auto& frame : kept.frames) REQUIRE(frame.slots == test_levels(frame.view.universe, round));
    REQUIRE(source->details().sync == static_cast<std::uint64_t>(round));
  }
  CHECK(source->details().synchroniser.replaced == 0);
}

TEST_CASE("held universes stay held while their synchronisation packet is missing, and close() ends them at once") {
  if (!enter_private_network()) return;
  auto source = open_source(2);
  auto options = sink_options(2);
  options.sync_universe = 1;  // one of its own universes
  auto sink = must(SacnSink::create(options));
  KeepingReceiver kept;
  send_all(*sink, kStartNs, 0);
  REQUIRE(poll_until(*source, kStartNs, kept, [&] { return source->details().sync == 1; }));
  REQUIRE(kept.frames.size() == 2);
  // Data of the same sender without a following synchronisation packet, as if that one was lost.
  SacnData data;
  data.cid = sink->cid();
  data.universe = 2;
  data.sync_universe = 1;
  data.sequence = 1;
  const auto levels = test_levels(2, 9);
  data.slots = levels;
  std::array<std::uint8_t, kSacnDataBytesMax> packet;
  const std::size_t size = build_sacn_data(data, packet);
  const Fd socket = must(open_sender({"test", 0, 1}));
  DatagramWriter writer;
  writer.add(std::span(packet).first(size), 0x7F000001, kSacnPort);
  REQUIRE(writer.flush(socket.get()).error_number == 0);
  REQUIRE(poll_until(*source, kStartNs, kept, [&] { return source->details().synchroniser.held == 1; }));
  CHECK(kept.frames.size() == 2);
  sink->close(kStartNs);
  REQUIRE(poll_until(*source, kStartNs, kept, [&] { return source->details().ended_already == 4 - 1; }));
  // The sink's own number 1 of universe 2 repeats that of the packet above and is late; 2 and 3 end it.
  REQUIRE(kept.frames.size() == 4);
  CHECK(kept.frames[2].view.terminated);
  CHECK(kept.frames[3].view.terminated);
}

TEST_CASE("every batch and every keep-alive ends in one synchronisation packet, with its own numbers") {
  if (!enter_private_network()) return;
  auto options = sink_options(3);
  options.sync_universe = 7'000;
  auto sink = must(SacnSink::create(options));
  Eavesdropper eavesdropper(7'000);
  send_all(*sink, kStartNs, 0);
  send_all(*sink, kStartNs, 1);
  TimeNs now_ns = kStartNs;
  for (int i = 0; i < 5; ++i) {
    now_ns = sink->next_deadline_ns();
    REQUIRE(sink->poll(now_ns).has_value());
  }
  CHECK(now_ns - kStartNs == 3 * 25 * kNsPerMs + 2 * 900 * kNsPerMs);
  const auto datagrams = eavesdropper.read();
  REQUIRE(datagrams.size() == 7);
  for (std::size_t i = 0; i < datagrams.size(); ++i) {
    const auto packet = parse_sacn_packet(datagrams[i]);
    REQUIRE(packet.has_value());
    const auto& sync = std::get<SacnSync>(*packet);
    CHECK(sync.sequence == i);
    CHECK(sync.sync_universe == 7'000);
    CHECK(sync.cid == sink->cid());
  }
}

TEST_CASE("a sink announces its universes after 1 s and then every 10 s, in pages of 512, in order") {
  if (!enter_private_network()) return;
  auto directory_source = must(SacnDiscoverySource::create({}));
  auto options = sink_options(1'100);
  std::reverse(options.universes.begin(), options.universes.end());
  options.announce = true;
  options.source_name = "Rig";
  auto sink = must(SacnSink::create(options));
  CHECK(sink->next_deadline_ns() == kTimeNever);
  Eavesdropper eavesdropper(kSacnDiscoveryUniverse);
  std::vector<TimeNs> announced_ns;
  send_all(*sink, kStartNs, 0);
  std::vector<std::vector<std::uint8_t>> first;
  for (TimeNs now_ns = kStartNs; now_ns < kStartNs + 25 * kNsPerS;) {
    now_ns = sink->next_deadline_ns();
    REQUIRE(sink->poll(now_ns).has_value());
    const auto datagrams = eavesdropper.read();
    if (datagrams.empty()) continue;
    REQUIRE(datagrams.size() == 3);
    if (first.empty()) first = datagrams;
    announced_ns.push_back(now_ns);
  }
  REQUIRE(announced_ns.size() >= 3);
  CHECK(announced_ns[0] == kStartNs + kNsPerS);
  CHECK(announced_ns[1] == kStartNs + 11 * kNsPerS);
  CHECK(announced_ns[2] == kStartNs + 21 * kNsPerS);
  for (int page = 0; page < 3; ++page) {
    const auto packet = parse_sacn_packet(first[static_cast<std::size_t>(page)]);
    REQUIRE(packet.has_value());
    const auto& discovery = std::get<SacnDiscovery>(*packet);
    CHECK(discovery.page == page);
    CHECK(discovery.last_page == 2);
    REQUIRE(discovery.universe_count() == (page < 2 ? 512 : 76));
    for (std::size_t i = 0; i < discovery.universe_count(); ++i) {
      REQUIRE(discovery.universe(i) == 512 * page + static_cast<int>(i) + 1);
    }
  }
  KeepingReceiver nothing;
  REQUIRE(
      poll_until(*directory_source, kStartNs, nothing, [&] { return !directory_source->directory().list().empty(); }));
  const auto list = directory_source->directory().list();
  REQUIRE(list.size() == 1);
  CHECK(list[0].name == "Rig");
  CHECK(list[0].cid == sink->cid());
  CHECK(list[0].universes.size() == 1'100);
  CHECK(list[0].pages == 3);
  sink->close(announced_ns.back());
  CHECK(sink->next_deadline_ns() == kTimeNever);
}

TEST_CASE(
    "a sink without the announce option, or with addresses, does not announce, nor does any before its first frame") {
  if (!enter_private_network()) return;
  Eavesdropper eavesdropper(kSacnDiscoveryUniverse);
  auto silent = sink_options(1);
  auto unicast = sink_options(1);
  unicast.announce = true;
  unicast.addresses = {"127.0.0.1"};
  auto unused = sink_options(1);
  unused.announce = true;
  for (const auto& options : {silent, unicast, unused}) {
    auto sink = must(SacnSink::create(options));
    if (options.announce == silent.announce || options.addresses == unicast.addresses) send_all(*sink, kStartNs, 0);
    for (int i = 0; i < 20; ++i) REQUIRE(sink->poll(kStartNs + i * kNsPerS).has_value());
  }
  for (const auto& datagram : eavesdropper.read()) {  // it receives the unicast too
    const auto packet = parse_sacn_packet(datagram);
    CHECK((packet.has_value() && !std::holds_alternative<SacnDiscovery>(*packet)));
  }
}

TEST_CASE("receiving announcements takes no unicast from a source on the same port") {
  if (!enter_private_network()) return;
  auto source = open_source(1);
  auto directory_source = must(SacnDiscoverySource::create({}));
  KeepingReceiver kept;
  for (std::uint8_t i = 1; i <= 16; ++i) {  // the kernel would distribute senders over sockets of one address
    auto options = sink_options(1);
    options.addresses = {"127.0.0.1"};
    options.cid.fill(i);
    auto sink = must(SacnSink::create(options));
    send_all(*sink, kStartNs, 0);
    CHECK(poll_until(*source, kStartNs, kept, [&] { return kept.frames.size() == i; }));
  }
}

TEST_CASE("priorities per address are sent before the first four frames, then within 1 s, sharing their numbers") {
  if (!enter_private_network()) return;
  auto source = open_source(1);
  auto options = sink_options(1);
  options.address_priorities = {120, 0, 200};
  auto sink = must(SacnSink::create(options));
  TimeNs now_ns = kStartNs;
  send_all(*sink, now_ns, 0);
  for (int i = 0; i < 100; ++i) {  // a desk at 44 Hz
    now_ns += 22'727'273;
    send_all(*sink, now_ns, i + 1);
  }
  for (int i = 0; i < 6; ++i) {  // then only keep-alives
    now_ns = sink->next_deadline_ns();
    REQUIRE(sink->poll(now_ns).has_value());
  }
  Eavesdropper eavesdropper(1);
  send_all(*sink, now_ns + kNsPerS, 500);
  KeepingReceiver kept;
  REQUIRE(poll_until(*source, kStartNs, kept, [&] { return kept.frames.size() >= 108 + 8; }));
  CHECK(source->details().late == 0);
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < kept.frames.size(); ++i) {
    CHECK(kept.frames[i].view.sequence == i);
    CHECK(kept.frames[i].view.priority == kPriorityDefault);  // for receivers without support for priorities per
                                                              // address
    if (kept.frames[i].view.start_code != kStartCodePriorities) continue;
    places.push_back(i);
    REQUIRE(kept.frames[i].slots.size() == 512);
    CHECK(kept.frames[i].slots[0] == 120);
    CHECK(kept.frames[i].slots[2] == 200);
    CHECK(std::count(kept.frames[i].slots.begin(), kept.frames[i].slots.end(), 0) == 510);
  }
  // Before the first four frames, at 0.977 s and 1.886 s of the desk; then after 0.95 s of silence each.
  REQUIRE(places.size() >= 8);
  CHECK(std::vector<std::size_t>(places.begin(), places.begin() + 6) == std::vector<std::size_t>{0, 2, 4, 6, 47, 88});
  const auto datagrams = eavesdropper.read();
  REQUIRE(datagrams.size() == 2);
  if (const auto fields = testing::dissect(datagrams[0], kSacnPort, {"acn.dmx.count", "_ws.malformed"})) {
    CHECK(fields->at("acn.dmx.count") == "513");
    CHECK(fields->at("_ws.malformed").empty());
  }
}

TEST_CASE("wrong priorities and synchronisation universes are refused with their range") {
  if (!enter_private_network()) return;
  const auto message = [](const SacnSinkOptions& options) {
    const auto sink = SacnSink::create(options);
    return sink ? std::string("accepted") : sink.error().message;
  };
  auto options = sink_options(1);
  options.sync_universe = 64'000;
  CHECK(message(options).find("synchronisation universe from 1 to 63999, or 0 for none, got 64000") !=
        std::string::npos);
  options = sink_options(1);
  options.address_priorities = {100, 201};
  CHECK(message(options).find("priorities of addresses from 0 to 200, got 201") != std::string::npos);
  options.address_priorities.assign(513, 100);
  CHECK(message(options).find("at most 512 addresses, got 513") != std::string::npos);
}

}  // namespace footlight::drivers
