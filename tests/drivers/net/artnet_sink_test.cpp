// The Art-Net sink with devices made of bare sockets: on a second machine (a network namespace at the other end of a
// virtual cable) and on this one.
#include "drivers/net/artnet_sink.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include "drivers/net/artnet_source.h"
#include "drivers/net/bytes.h"
#include "tests/drivers/net/port_helpers.h"
#include "tests/drivers/net/private_network.h"
#include "tests/support/must.h"

namespace footlight::drivers {
namespace {

using testing::add_peer;
using testing::enter_private_network;
using testing::KeepingReceiver;
using testing::must;
using testing::OnPeer;
using testing::received;
using testing::send_bytes;
using testing::stranger;
using testing::test_levels;
using testing::universes_from;
using Bytes = std::vector<std::uint8_t>;

constexpr TimeNs kStartNs = 1'000 * kNsPerS;
constexpr std::uint32_t kOurs = 0x0A09'0001, kNodeA = 0x0A09'0002, kNodeB = 0x0A09'0003, kAll = 0x0A09'00FF;

ArtnetSinkOptions sink_options(std::vector<WireUniverse> universes, std::string interface_name = {}) {
  ArtnetSinkOptions options;
  options.name = "artnet:test-out";
  options.universes = std::move(universes);
  if (!interface_name.empty()) options.interface_names = {std::move(interface_name)};
  return options;
}

Bytes reply_of(const char* name, std::vector<int> outputs, std::uint8_t bind_index = 1, std::vector<int> inputs = {}) {
  ArtnetPollReply reply;
  reply.short_name = name;
  reply.bind_index = bind_index;
  for (const int port_address : outputs) reply.add({port_address, true, false, false});
  for (const int port_address : inputs) reply.add({port_address, false, false, false});
  Bytes packet(kArtnetPollReplyBytes);
  build_artnet_poll_reply(reply, packet);
  return packet;
}

// The wire universes of the ArtDmx among some datagrams.
std::vector<int> universes_in(const std::vector<Bytes>& datagrams) {
  std::vector<int> universes;
  for (const Bytes& bytes : datagrams) {
    const auto packet = parse_artnet_packet(bytes);
    if (!packet) continue;
    if (const auto* dmx = std::get_if<ArtnetDmx>(&*packet))
      universes.push_back(artnet_wire_universe(dmx->port_address));
  }
  return universes;
}

std::size_t count_of(const std::vector<Bytes>& datagrams, std::uint16_t op_code) {
  return static_cast<std::size_t>(std::count_if(datagrams.begin(), datagrams.end(), [&](const Bytes& bytes) {
    return bytes.size() > 9 && read_u16_le(bytes, 8) == op_code;
  }));
}

Status send_levels(Sink& sink, TimeNs now_ns, const std::vector<int>& universes, int round) {
  std::vector<Bytes> levels;
  for (const int universe : universes) levels.push_back(test_levels(universe, round));
  std::vector<FrameView> frames;
  for (std::size_t i = 0; i < universes.size(); ++i) {
    FrameView& frame = frames.emplace_back();
    frame.universe = universes[i];
    frame.slots = levels[i];
  }
  return sink.send(now_ns, frames);
}

// Two devices on a second machine, each with its own address, and the broadcasts there.
struct Devices {
  Devices() {
    if (!enter_private_network() || !add_peer("stage0", "10.9.0.1", {"10.9.0.2", "10.9.0.3"})) return;
    const OnPeer on_peer;
    a = stranger(kNodeA, kArtnetPort);
    b = stranger(kNodeB, kArtnetPort);
    air = stranger(kAll, kArtnetPort);
    REQUIRE(a);
    REQUIRE(b);
    REQUIRE(air);
  }
  [[nodiscard]] bool there() const { return static_cast<bool>(air); }
  Fd a, b, air;
};

// Answers until the sink has received that many replies.
void answer(ArtnetSink& sink, TimeNs now_ns, const Fd& device, const std::vector<Bytes>& replies) {
  const std::uint64_t before = sink.details().replies;
  for (const Bytes& reply : replies) REQUIRE(send_bytes(device, kOurs, kArtnetPort, reply));
  for (int i = 0; i < 200 && sink.details().replies < before + replies.size(); ++i) {
    pollfd waiting = {sink.poll_fd(), POLLIN, 0};
    REQUIRE(::poll(&waiting, 1, 20'000) == 1);
    REQUIRE(sink.poll(now_ns).has_value());
  }
  REQUIRE(sink.details().replies == before + replies.size());
}

}  // namespace

TEST_CASE("a sink polls every network every 2.5 to 3 s from UDP port 6454, in the shortest form") {
  Devices devices;
  if (!devices.there()) return;
  auto sink = must(ArtnetSink::create(sink_options({{1, 1}})));
  TimeNs now_ns = kStartNs;
  TimeNs last_ns = 0;
  std::vector<DurationNs> pauses;
  for (int i = 0; i < 8; ++i) {
    REQUIRE(sink->next_deadline_ns() <= now_ns + 3 * kNsPerS);
    if (i > 0) {
      pauses.push_back(sink->next_deadline_ns() - last_ns);
      now_ns = sink->next_deadline_ns();
    }
    last_ns = now_ns;
    REQUIRE(sink->poll(now_ns).has_value());
    REQUIRE(sink->poll(now_ns).has_value());  // its own poll has come back
    const auto polls = received(devices.air, true);
    REQUIRE(polls.size() == 1);
    CHECK(polls[0] == Bytes{'A', 'r', 't', '-', 'N', 'e', 't', 0, 0x00, 0x20, 0, 14, 0x02, 0});
  }
  for (const DurationNs pause_ns : pauses) {
    CHECK(pause_ns >= 2'500 * kNsPerMs);
    CHECK(pause_ns <= 3'000 * kNsPerMs);
  }
  CHECK(*std::max_element(pauses.begin(), pauses.end()) > *std::min_element(pauses.begin(), pauses.end()));
}

TEST_CASE("a universe goes by broadcast until a device takes it, and then by unicast to that device only") {
  Devices devices;
  if (!devices.there()) return;
  auto sink = must(ArtnetSink::create(sink_options(universes_from(1, 2, 1))));
  REQUIRE(sink->poll(kStartNs).has_value());
  REQUIRE(send_levels(*sink, kStartNs, {1, 2}, 0).has_value());
  CHECK(universes_in(received(devices.air, true)) == std::vector<int>{1, 2});
  CHECK(received(devices.a).empty());

  answer(*sink, kStartNs, devices.a, {reply_of("A", {0})});
  CHECK(sink->receivers_of(0) == std::vector<std::uint32_t>{kNodeA});
  CHECK(sink->receivers_of(1) == std::vector<std::uint32_t>{kAll});
  received(devices.a);
  received(devices.air);
  REQUIRE(send_levels(*sink, kStartNs, {1, 2}, 1).has_value());
  const auto got = received(devices.a, true);
  REQUIRE(universes_in(got) == std::vector<int>{1});
  const auto packet = parse_artnet_packet(got[0]);
  const Bytes levels = test_levels(1, 1);
  CHECK(std::ranges::equal(std::get<ArtnetDmx>(*packet).slots, levels));
  CHECK(universes_in(received(devices.air, true)) == std::vector<int>{2});
  CHECK(received(devices.b).empty());
}

TEST_CASE("a universe reaches every device that takes it and no other") {
  Devices devices;
  if (!devices.there()) return;
  auto sink = must(ArtnetSink::create(sink_options(universes_from(1, 3, 1))));
  REQUIRE(sink->poll(kStartNs).has_value());
  answer(*sink, kStartNs, devices.a, {reply_of("A", {0, 1})});
  answer(*sink, kStartNs, devices.b, {reply_of("B", {1, 2})});
  REQUIRE(send_levels(*sink, kStartNs, {1, 2, 3}, 0).has_value());
  CHECK(universes_in(received(devices.a, true)) == std::vector<int>{1, 2});
  CHECK(universes_in(received(devices.b, true)) == std::vector<int>{2, 3});
  CHECK(universes_in(received(devices.air)).empty());
}

TEST_CASE("every reply of a device counts, with another bind index or another sub-net") {
  Devices devices;
  if (!devices.there()) return;
  auto sink = must(ArtnetSink::create(sink_options({{1, 1}, {17, 2}, {33, 3}, {257, 4}})));
  REQUIRE(sink->poll(kStartNs).has_value());
  answer(*sink, kStartNs, devices.a,
         {reply_of("A", {0}, 1), reply_of("A", {16}, 2), reply_of("A", {32}, 2), reply_of("A", {256}, 0)});
  for (std::size_t place = 0; place < 4; ++place) {
    CHECK(sink->receivers_of(place) == std::vector<std::uint32_t>{kNodeA});
  }
}

TEST_CASE("an input port gets its universe too, but alone does not stop the broadcast") {
  Devices devices;
  if (!devices.there()) return;
  auto sink = must(ArtnetSink::create(sink_options(universes_from(1, 2, 1))));
  REQUIRE(sink->poll(kStartNs).has_value());
  answer(*sink, kStartNs, devices.a, {reply_of("A", {0})});
  answer(*sink, kStartNs, devices.b, {reply_of("B", {}, 1, {0, 1})});
  CHECK(sink->receivers_of(0) == std::vector<std::uint32_t>{kNodeA, kNodeB});
  CHECK(sink->receivers_of(1) == std::vector<std::uint32_t>{kAll});
}

TEST_CASE("a new device gets the last frame at once, without a new frame") {
  Devices devices;
  if (!devices.there()) return;
  auto sink = must(ArtnetSink::create(sink_options({{1, 1}})));
  REQUIRE(sink->poll(kStartNs).has_value());
  REQUIRE(send_levels(*sink, kStartNs, {1}, 0).has_value());
  TimeNs now_ns = kStartNs;
  for (int i = 0; i < kRepeats; ++i) REQUIRE(sink->poll(now_ns += kRepeatIntervalNs).has_value());
  answer(*sink, now_ns, devices.a, {reply_of("A", {0})});
  CHECK(universes_in(received(devices.a, true)) == std::vector<int>{1});
}

TEST_CASE(
    "a device that leaves polls unanswered for ten seconds gets no more frames, and one lost answer is tolerated") {
  Devices devices;
  if (!devices.there()) return;
  auto sink = must(ArtnetSink::create(sink_options({{1, 1}})));
  REQUIRE(sink->poll(kStartNs).has_value());
  answer(*sink, kStartNs, devices.a, {reply_of("A", {0})});
  REQUIRE(sink->poll(kStartNs + 6 * kNsPerS).has_value());
  CHECK(sink->receivers_of(0) == std::vector<std::uint32_t>{kNodeA});
  answer(*sink, kStartNs + 6 * kNsPerS, devices.a, {reply_of("A", {0})});
  REQUIRE(sink->poll(kStartNs + 15 * kNsPerS).has_value());
  CHECK(sink->receivers_of(0) == std::vector<std::uint32_t>{kNodeA});
  REQUIRE(sink->poll(kStartNs + 19 * kNsPerS).has_value());
  CHECK(sink->receivers_of(0) == std::vector<std::uint32_t>{kAll});
}

TEST_CASE("a sink with the silent option sends a universe nowhere until a device takes it, and still works") {
  Devices devices;
  if (!devices.there()) return;
  auto options = sink_options({{1, 1}});
  options.unsubscribed = ArtnetUnsubscribed::kSilent;
  auto sink = must(ArtnetSink::create(options));
  REQUIRE(sink->poll(kStartNs).has_value());
  received(devices.air, true);
  REQUIRE(send_levels(*sink, kStartNs, {1}, 0).has_value());
  REQUIRE(sink->poll(kStartNs + kNsPerS).has_value());
  CHECK(universes_in(received(devices.air)).empty());
  CHECK(sink->state() == PortState::kWaiting);
  CHECK(sink->counters().errors == 0);
  answer(*sink, kStartNs + kNsPerS, devices.a, {reply_of("A", {0})});
  CHECK(universes_in(received(devices.a, true)) == std::vector<int>{1});
  CHECK(sink->state() == PortState::kWorking);
}

TEST_CASE("more than forty devices of one universe get one broadcast") {
  if (!enter_private_network()) return;
  std::vector<std::string> addresses;
  for (int i = 2; i < 43; ++i) addresses.push_back("10.9.0." + std::to_string(i));
  if (!add_peer("stage0", "10.9.0.1", addresses)) return;
  auto sink = must(ArtnetSink::create(sink_options({{1, 1}})));
  REQUIRE(sink->poll(kStartNs).has_value());
  for (std::uint32_t i = 2; i < 43; ++i) {
    Fd device;
    {
      const OnPeer on_peer;
      device = stranger(0x0A09'0000 + i, kArtnetPort);
    }
    answer(*sink, kStartNs, device, {reply_of("one of many", {0})});
    if (i < 42) CHECK(sink->receivers_of(0).size() == i - 1);
  }
  CHECK(sink->receivers_of(0) == std::vector<std::uint32_t>{kAll});
}

TEST_CASE("with a fixed address there is no poll, and levels go there from UDP port 6454") {
  Devices devices;
  if (!devices.there()) return;
  auto options = sink_options({{1, 1}});
  options.addresses = {"10.9.0.2"};
  auto sink = must(ArtnetSink::create(options));
  CHECK(sink->poll_fd() == -1);
  CHECK(sink->next_deadline_ns() == kTimeNever);
  REQUIRE(sink->poll(kStartNs).has_value());
  REQUIRE(send_levels(*sink, kStartNs, {1}, 0).has_value());
  pollfd waiting = {devices.a.get(), POLLIN, 0};
  REQUIRE(::poll(&waiting, 1, 20'000) == 1);
  DatagramReader reader;
  REQUIRE(reader.read(devices.a.get()) == 1);
  CHECK(reader[0].from_udp_port == kArtnetPort);
  CHECK(received(devices.air).empty());
}

TEST_CASE("a resting sink repeats nothing, and sends equal levels again at the next frame") {
  Devices devices;
  if (!devices.there()) return;
  auto options = sink_options({{1, 1}});
  options.addresses = {"10.9.0.2"};
  auto sink = must(ArtnetSink::create(options));
  REQUIRE(send_levels(*sink, kStartNs, {1}, 0).has_value());
  CHECK(sink->next_deadline_ns() != kTimeNever);
  sink->rest(kStartNs);
  CHECK(sink->next_deadline_ns() == kTimeNever);
  REQUIRE(sink->poll(kStartNs + 60 * kNsPerS).has_value());
  CHECK(sink->counters().frames == 1);
  REQUIRE(send_levels(*sink, kStartNs, {1}, 0).has_value());
  CHECK(sink->counters().frames == 2);
}

TEST_CASE("an ArtSync follows each batch by broadcast only with the sync option") {
  Devices devices;
  if (!devices.there()) return;
  for (const bool sync : {true, false}) {
    CAPTURE(sync);
    auto options = sink_options(universes_from(1, 3, 1));
    options.sync = sync;
    auto sink = must(ArtnetSink::create(options));
    received(devices.a);
    REQUIRE(sink->poll(kStartNs).has_value());
    answer(*sink, kStartNs, devices.a, {reply_of("A", {0, 1, 2})});
    received(devices.air, true);
    REQUIRE(send_levels(*sink, kStartNs, {1, 2, 3}, 0).has_value());
    CHECK(universes_in(received(devices.a, true)) == std::vector<int>{1, 2, 3});
    const auto broadcast = received(devices.air, sync);
    CHECK(count_of(broadcast, 0x5200) == (sync ? 1 : 0));
    CHECK(universes_in(broadcast).empty());
    CHECK(count_of(received(devices.a), 0x5200) == 0);
    REQUIRE(sink->poll(sink->next_deadline_ns()).has_value());  // a repeat is a batch as well
    CHECK(count_of(received(devices.air, sync), 0x5200) == (sync ? 1 : 0));
  }
}

TEST_CASE("a sink answers the poll of another controller within a second, as a controller without ports") {
  Devices devices;
  if (!devices.there()) return;
  auto options = sink_options({{1, 1}});
  options.node_name = "Stage left bridge";
  auto sink = must(ArtnetSink::create(options));
  REQUIRE(sink->poll(kStartNs).has_value());
  received(devices.air, true);
  Bytes poll(kArtnetPollBytesMin);
  build_artnet_poll(0, poll);
  for (const std::uint32_t to : {kOurs, kAll}) REQUIRE(send_bytes(devices.a, to, kArtnetPort, poll));  // one answer
  pollfd waiting = {sink->poll_fd(), POLLIN, 0};
  REQUIRE(::poll(&waiting, 1, 20'000) == 1);
  const TimeNs asked_ns = kStartNs + 5 * kNsPerMs;
  REQUIRE(sink->poll(asked_ns).has_value());
  REQUIRE(sink->next_deadline_ns() <= asked_ns + kNsPerS);
  REQUIRE(sink->poll(sink->next_deadline_ns()).has_value());
  const auto got = received(devices.a, true);
  REQUIRE(got.size() == 1);
  const auto packet = parse_artnet_packet(got[0]);
  REQUIRE(packet.has_value());
  const auto& reply = std::get<ArtnetPollReply>(*packet);
  CHECK(reply.style == ArtnetPollReply::Style::kController);
  CHECK(reply.port_count == 0);
  CHECK(reply.long_name == "Stage left bridge");
  CHECK(reply.ip == std::array<std::uint8_t, 4>{10, 9, 0, 1});
}

TEST_CASE("an answer received by the source of the same program serves its sink") {
  Devices devices;
  if (!devices.there()) return;
  const auto program = std::make_shared<OwnSenders>();
  auto out = sink_options({{1, 1}});
  out.own_senders = program;
  auto sink = must(ArtnetSink::create(out));
  ArtnetSourceOptions in;
  in.name = "artnet:test-in";
  in.universes = {{9, 9}};
  in.own_senders = program;
  auto source = must(ArtnetSource::create(in));
  REQUIRE(sink->poll(kStartNs).has_value());
  REQUIRE(send_bytes(devices.a, kOurs, kArtnetPort, reply_of("A", {0})));
  KeepingReceiver receiver;
  REQUIRE(testing::poll_until(*source, kStartNs, receiver, [&] { return source->details().replies == 1; }));
  REQUIRE(send_levels(*sink, kStartNs, {1}, 0).has_value());
  CHECK(sink->receivers_of(0) == std::vector<std::uint32_t>{kNodeA});
  CHECK(universes_in(received(devices.a, true)) == std::vector<int>{1});
}

TEST_CASE("two sinks of one program poll a network once, and both use the answers") {
  Devices devices;
  if (!devices.there()) return;
  const auto program = std::make_shared<OwnSenders>();
  auto options = sink_options({{1, 1}});
  options.own_senders = program;
  auto first = must(ArtnetSink::create(options));
  options.universes = {{2, 2}};
  auto second = must(ArtnetSink::create(options));
  REQUIRE(first->poll(kStartNs).has_value());
  REQUIRE(second->poll(kStartNs).has_value());
  CHECK(count_of(received(devices.air, true), 0x2000) == 1);
  program->artnet().nodes.receive(
      [] {
        ArtnetPollReply reply;
        reply.add({0, true, false, false});
        reply.add({1, true, false, false});
        return reply;
      }(),
      [] {
        Datagram datagram;
        datagram.from_ipv4 = kNodeA;
        return datagram;
      }(),
      kStartNs);
  REQUIRE(first->poll(kStartNs).has_value());
  REQUIRE(second->poll(kStartNs).has_value());
  CHECK(first->receivers_of(0) == std::vector<std::uint32_t>{kNodeA});
  CHECK(second->receivers_of(0) == std::vector<std::uint32_t>{kNodeA});
}

TEST_CASE("two programs on one machine find each other over loopback, whoever of them holds UDP port 6454") {
  if (!enter_private_network()) return;
  auto sink = must(ArtnetSink::create(sink_options(universes_from(1, 2, 1), "lo")));
  ArtnetSourceOptions in;
  in.name = "artnet:test-in";
  in.universes = {{1, 1}};
  auto source = must(ArtnetSource::create(in));
  auto elsewhere = in;
  elsewhere.universes = {{7, 7}};
  auto third = must(ArtnetSource::create(elsewhere));  // shares the port, and must not take packets from others
  KeepingReceiver receiver, other;
  REQUIRE(sink->poll(kStartNs).has_value());
  for (Source* const each : {static_cast<Source*>(source.get()), static_cast<Source*>(third.get())}) {
    REQUIRE(testing::drain(*each, kStartNs, receiver));
    REQUIRE(each->next_deadline_ns() <= kStartNs + kNsPerS);
    REQUIRE(each->poll(kStartNs + kNsPerS, receiver).has_value());
  }
  REQUIRE(sink->poll(kStartNs + kNsPerS).has_value());
  CHECK(sink->details().replies == 2);
  CHECK(sink->receivers_of(0) == std::vector<std::uint32_t>{kLoopbackBroadcast});
  for (int round = 0; round < 20; ++round) {
    REQUIRE(send_levels(*sink, kStartNs + kNsPerS, {1, 2}, round).has_value());
  }
  REQUIRE(testing::drain(*source, kStartNs + kNsPerS, receiver));
  CHECK(receiver.frames.size() == 20);
}

TEST_CASE("a sink does not send to the source of its own program") {
  if (!enter_private_network()) return;
  const auto program = std::make_shared<OwnSenders>();
  auto out = sink_options({{1, 1}}, "lo");
  out.own_senders = program;
  out.unsubscribed = ArtnetUnsubscribed::kSilent;
  auto sink = must(ArtnetSink::create(out));
  ArtnetSourceOptions in;
  in.name = "artnet:test-in";
  in.universes = {{1, 1}};
  in.kernel_stamps = false;
  in.own_senders = program;
  auto source = must(ArtnetSource::create(in));
  KeepingReceiver receiver;
  REQUIRE(sink->poll(kStartNs).has_value());
  REQUIRE(testing::drain(*source, kStartNs, receiver));
  CHECK(source->details().own == 1);
  CHECK(source->next_deadline_ns() == kTimeNever);
  // Another program polls, and every socket here receives the answer.
  Bytes poll(kArtnetPollBytesMin);
  build_artnet_poll(0, poll);
  const Fd other = stranger(0x7F00'0001, 0);
  REQUIRE(send_bytes(other, kLoopbackBroadcast, kArtnetPort, poll));
  REQUIRE(testing::drain(*source, kStartNs + kNsPerS, receiver));
  REQUIRE(source->poll(kStartNs + 2 * kNsPerS, receiver).has_value());
  REQUIRE(testing::drain(*source, kStartNs + 2 * kNsPerS, receiver));
  REQUIRE(sink->poll(kStartNs + 2 * kNsPerS).has_value());
  CHECK(received(other).size() == 1);
  CHECK(sink->receivers_of(0).empty());
}

TEST_CASE("after 20000 damaged replies a sink still works, its device table is bounded and its frames continue") {
  if (!enter_private_network()) return;
  auto sink = must(ArtnetSink::create(sink_options({{1, 1}}, "lo")));
  REQUIRE(sink->poll(kStartNs).has_value());
  std::mt19937 random(3);
  const Bytes good = reply_of("seed", {0, 1, 2, 3}, 1, {4, 5, 6, 7});
  const Fd other = stranger(0x7F00'0001, 0);
  for (int i = 0; i < 20'000; ++i) {
    Bytes packet = good;
    for (std::size_t f = 0; f < 1 + random() % 6; ++f) {
      packet[10 + random() % (packet.size() - 10)] = static_cast<std::uint8_t>(random());
    }
    if (random() % 4 == 0) packet.resize(10 + random() % (packet.size() + 200));
    REQUIRE(send_bytes(other, 0x7F00'0001, kArtnetPort, packet));
    if (i % 50 == 49) REQUIRE(sink->poll(kStartNs).has_value());
  }
  CHECK(sink->details().replies > 15'000);
  CHECK(sink->counters().rejected > 100);
  REQUIRE(send_levels(*sink, kStartNs, {1}, 0).has_value());
  CHECK(sink->counters().frames >= 1);
}

TEST_CASE("forged devices use no memory beyond a limit") {
  ArtnetNodes nodes;
  ArtnetPollReply reply;
  reply.add({0, true, false, false});
  Datagram datagram;
  for (std::uint32_t i = 0; i < 5'000; ++i) {
    datagram.from_ipv4 = 0x0A00'0000 + i;
    nodes.receive(reply, datagram, kStartNs);
  }
  CHECK(nodes.list().size() == ArtnetNodes::kNodesMax);
  datagram.from_ipv4 = 0x0A00'0000;
  for (int i = 0; i < 0x7FFF; ++i) {
    reply.port_list[0].port_address = i;
    nodes.receive(reply, datagram, kStartNs);
  }
  CHECK(nodes.list().front().outputs.size() == ArtnetNodes::kPortsPerNodeMax);
  nodes.expire(kStartNs + kArtnetNodeTimeoutNs);
  CHECK(nodes.list().empty());
}

}  // namespace footlight::drivers
