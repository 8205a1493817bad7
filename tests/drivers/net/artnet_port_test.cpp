// Art-Net ports connected over real sockets, in a network namespace with only "lo".
#include <doctest/doctest.h>

#include <algorithm>

#include "drivers/net/artnet_sink.h"
#include "drivers/net/artnet_source.h"
#include "tests/drivers/net/port_helpers.h"
#include "tests/drivers/net/private_network.h"
#include "tests/support/must.h"

namespace footlight::drivers {
namespace {

using testing::enter_private_network;
using testing::frame_of;
using testing::KeepingReceiver;
using testing::must;
using testing::poll_until;
using testing::test_levels;
using testing::universes_from;

constexpr TimeNs kStartNs = 1'000 * kNsPerS;

ArtnetSourceOptions source_options(std::vector<WireUniverse> universes) {
  ArtnetSourceOptions options;
  options.name = "artnet:test-in";
  options.universes = std::move(universes);
  options.kernel_stamps = false;
  return options;
}

ArtnetSinkOptions sink_options(std::vector<WireUniverse> universes, std::string address = "127.0.0.1") {
  ArtnetSinkOptions options;
  options.name = "artnet:test-out";
  options.universes = std::move(universes);
  if (!address.empty()) options.addresses = {std::move(address)};
  return options;
}

void send_to_loopback(const Fd& socket, std::span<const std::uint8_t> bytes) {
  DatagramWriter writer;
  writer.add(bytes, 0x7F000001, kArtnetPort);
  REQUIRE(writer.flush(socket.get()).error_number == 0);
}

}  // namespace

TEST_CASE("nine universes cross from Art-Net sink to source by unicast and by broadcast, every level exact") {
  if (!enter_private_network()) return;
  for (const char* const address : {"127.0.0.1", "127.255.255.255"}) {
    CAPTURE(address);
    auto source = must(ArtnetSource::create(source_options(universes_from(1, 9, 1))));
    auto sink = must(ArtnetSink::create(sink_options(universes_from(1, 9, 1), address)));
    for (int round = 0; round < 300; ++round) {  // past the wrap of the sequence number
      std::vector<std::vector<std::uint8_t>> levels;
      std::vector<FrameView> frames;
      for (int u = 1; u <= 9; ++u) levels.push_back(test_levels(u, round));
      for (int u = 1; u <= 9; ++u) frames.push_back(frame_of(u, levels[static_cast<std::size_t>(u - 1)]));
      REQUIRE(sink->send(kStartNs, frames).has_value());
      KeepingReceiver receiver;
      REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return receiver.frames.size() >= 9; }));
      REQUIRE(receiver.frames.size() == 9);
      for (int u = 1; u <= 9; ++u) {
        const auto& got = receiver.frames[static_cast<std::size_t>(u - 1)];
        REQUIRE(got.view.universe == u);
        REQUIRE(got.view.sequence == static_cast<std::uint32_t>(round % 255 + 1));  // 0 would mean unnumbered
        REQUIRE(got.slots == levels[static_cast<std::size_t>(u - 1)]);
      }
    }
    CHECK(source->details().late == 0);
  }
}

TEST_CASE("universes of the show are renumbered to port addresses across the borders of sub-nets and nets") {
  if (!enter_private_network()) return;
  auto source = must(ArtnetSource::create(source_options({{16, 1}, {17, 2}, {256, 3}, {257, 4}, {32'768, 5}})));
  const Fd socket = must(open_sender({"test", 0}));
  KeepingReceiver receiver;
  const std::vector<std::uint8_t> slots = {1, 2};
  for (const int port_address : {15, 16, 255, 256, 0x7FFF, 14}) {
    ArtnetDmx dmx;
    dmx.port_address = port_address;
    dmx.slots = slots;
    std::array<std::uint8_t, kArtnetDmxBytesMax> packet;
    send_to_loopback(socket, std::span(packet).first(build_artnet_dmx(dmx, packet)));
  }
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return receiver.frames.size() >= 5; }));
  for (std::size_t i = 0; i < 5; ++i) CHECK(receiver.frames[i].view.universe == static_cast<int>(i + 1));
  REQUIRE(testing::drain(*source, kStartNs, receiver));
  CHECK(source->details().other_universe == 1);
}

TEST_CASE("Art-Net frames without a number, or with a constant one, are all accepted, late ones are not") {
  if (!enter_private_network()) return;
  auto source = must(ArtnetSource::create(source_options({{1, 1}})));
  const Fd socket = must(open_sender({"test", 0}));
  const std::vector<std::uint8_t> slots = {1, 2};
  for (const int sequence : {0, 0, 7, 7, 5, 0}) {
    ArtnetDmx dmx;
    dmx.sequence = static_cast<std::uint8_t>(sequence);
    dmx.slots = slots;
    std::array<std::uint8_t, kArtnetDmxBytesMax> packet;
    send_to_loopback(socket, std::span(packet).first(build_artnet_dmx(dmx, packet)));
  }
  KeepingReceiver receiver;
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return receiver.frames.size() >= 5; }));
  CHECK(receiver.frames.size() == 5);
  CHECK(source->details().late == 1);
}

TEST_CASE("an Art-Net sink repeats an unchanged frame every 900 ms and simply stops when it closes") {
  if (!enter_private_network()) return;
  auto sink = must(ArtnetSink::create(sink_options({{1, 1}})));
  const auto levels = test_levels(1, 0);
  const std::vector<FrameView> frames = {frame_of(1, levels)};
  REQUIRE(sink->send(kStartNs, frames).has_value());
  for (int i = 0; i < 3; ++i) REQUIRE(sink->poll(sink->next_deadline_ns()).has_value());
  const TimeNs last_ns = kStartNs + 75 * kNsPerMs;
  CHECK(sink->next_deadline_ns() == last_ns + 900 * kNsPerMs);
  REQUIRE(sink->poll(last_ns + 900 * kNsPerMs).has_value());
  CHECK(sink->counters().frames == 5);
  sink->close(last_ns);
  CHECK(sink->counters().frames == 5);
  CHECK(sink->next_deadline_ns() == kTimeNever);
}

TEST_CASE("an Art-Net source ignores the sinks of its own program and receives those of others") {
  if (!enter_private_network()) return;
  const auto own_senders = std::make_shared<OwnSenders>();
  for (const char* const address : {"127.0.0.1", "127.255.255.255"}) {
    auto in = source_options({{1, 1}});
    in.own_senders = own_senders;
    auto source = must(ArtnetSource::create(in));
    auto out = sink_options({{1, 1}}, address);
    auto foreign = must(ArtnetSink::create(out));
    out.own_senders = own_senders;
    auto own = must(ArtnetSink::create(out));
    const auto levels = test_levels(1, 0);
    const std::vector<FrameView> frames = {frame_of(1, levels)};
    REQUIRE(own->send(kStartNs, frames).has_value());
    const auto other_levels = test_levels(1, 1);
    const std::vector<FrameView> other_frames = {frame_of(1, other_levels)};
    REQUIRE(foreign->send(kStartNs, other_frames).has_value());
    KeepingReceiver receiver;
    REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return !receiver.frames.empty(); }));
    REQUIRE(testing::drain(*source, kStartNs, receiver));
    REQUIRE(receiver.frames.size() == 1);
    CHECK(receiver.frames[0].slots == other_levels);
    CHECK(source->details().own == 1);
  }
}

TEST_CASE("wrong Art-Net options are refused with a message that names the port and the next step") {
  if (!enter_private_network()) return;
  const auto message = [](const auto& result) { return result ? std::string("accepted") : result.error().message; };
  CHECK(message(ArtnetSource::create(source_options({{32'769, 1}}))).find("from 1 to 32768, got 32769") !=
        std::string::npos);
  CHECK(message(ArtnetSink::create(sink_options({{1, 1}}, ""))).find("name the receivers, as in") != std::string::npos);
  CHECK(message(ArtnetSink::create(sink_options({{1, 1}}, "10.0.0"))).find("expected an IPv4 address") !=
        std::string::npos);
  CHECK(message(ArtnetSink::create(sink_options({{1, 1}}, "10.0.0.255"))).find("there is no route") !=
        std::string::npos);
}

}  // namespace footlight::drivers
