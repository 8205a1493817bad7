// The Art-Net source with senders and controllers made of bare sockets. Each has its own address of 127.0.0.0/8.
#include "drivers/net/artnet_source.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <set>

#include "drivers/net/artnet_sink.h"
#include "drivers/net/bytes.h"
#include "tests/drivers/net/port_helpers.h"
#include "tests/drivers/net/private_network.h"
#include "tests/support/must.h"

namespace footlight::drivers {
namespace {

using testing::drain;
using testing::enter_private_network;
using testing::KeepingReceiver;
using testing::must;
using testing::received;
using testing::send_bytes;
using testing::stranger;
using testing::universes_from;
using Bytes = std::vector<std::uint8_t>;

constexpr TimeNs kStartNs = 1'000 * kNsPerS;
constexpr std::uint32_t kThisMachine = 0x7F00'0001;

ArtnetSourceOptions source_options(std::vector<WireUniverse> universes) {
  ArtnetSourceOptions options;
  options.name = "artnet:test-in";
  options.universes = std::move(universes);
  options.kernel_stamps = false;
  options.request_names = false;
  return options;
}

void send_dmx(const Fd& from, int universe, std::uint8_t level, std::uint8_t sequence = 0) {
  const Bytes slots(4, level);
  ArtnetDmx dmx;
  dmx.port_address = artnet_port_address(universe);
  dmx.sequence = sequence;
  dmx.slots = slots;
  Bytes packet(kArtnetDmxBytesMax);
  packet.resize(build_artnet_dmx(dmx, packet));
  REQUIRE(send_bytes(from, kThisMachine, kArtnetPort, packet));
}

void send_sync(const Fd& from) {
  Bytes packet(kArtnetSyncBytes);
  build_artnet_sync(packet);
  REQUIRE(send_bytes(from, kThisMachine, kArtnetPort, packet));
}

void send_poll(const Fd& from, std::uint8_t flags = 0) {
  Bytes packet(kArtnetPollBytesMin);
  build_artnet_poll(flags, packet);
  REQUIRE(send_bytes(from, kThisMachine, kArtnetPort, packet));
}

std::vector<ArtnetPollReply> replies_in(const std::vector<Bytes>& datagrams) {
  std::vector<ArtnetPollReply> replies;
  for (const Bytes& bytes : datagrams) replies.push_back(std::get<ArtnetPollReply>(parse_artnet(bytes).value()));
  return replies;
}

}  // namespace

TEST_CASE("forty universes are forty replies, one port and one bind index each, within a second and in batches") {
  if (!enter_private_network()) return;
  auto source = must(ArtnetSource::create(source_options(universes_from(1, 40, 1))));
  const Fd console = stranger(0x7F00'0009, 0);
  send_poll(console);
  KeepingReceiver receiver;
  REQUIRE(drain(*source, kStartNs, receiver));
  CHECK(received(console).empty());  // not at once
  const TimeNs due_ns = source->next_deadline_ns();
  CHECK(due_ns > kStartNs);
  REQUIRE(due_ns < kStartNs + kNsPerS);
  REQUIRE(source->poll(due_ns, receiver).has_value());
  auto datagrams = received(console);
  CHECK(datagrams.size() == ArtnetAnswers::kRepliesAtOnce);
  REQUIRE(source->next_deadline_ns() <= due_ns + 20 * kNsPerMs);
  REQUIRE(source->poll(source->next_deadline_ns(), receiver).has_value());
  for (auto& more : received(console)) datagrams.push_back(more);
  CHECK(source->next_deadline_ns() == kTimeNever);
  REQUIRE(datagrams.size() == 40);
  const auto replies = replies_in(datagrams);
  for (int i = 0; i < 40; ++i) {
    const auto& reply = replies[static_cast<std::size_t>(i)];
    CHECK(reply.bind_index == i + 1);
    REQUIRE(reply.port_count == 1);
    CHECK(reply.port_list[0].port_address == i);
    CHECK(reply.port_list[0].output);
    CHECK_FALSE(reply.port_list[0].active);
  }
}

TEST_CASE("512 universes are all reported, four per reply, and no two replies share a bind index") {
  if (!enter_private_network()) return;
  auto source = must(ArtnetSource::create(source_options(universes_from(1, 512, 1))));
  const Fd console = stranger(0x7F00'0009, 0);
  send_poll(console);
  KeepingReceiver receiver;
  REQUIRE(drain(*source, kStartNs, receiver));
  std::vector<Bytes> datagrams;
  const TimeNs until_ns = kStartNs + 3 * kNsPerS;  // by then a controller considers us gone
  while (source->next_deadline_ns() < until_ns) {
    REQUIRE(source->poll(source->next_deadline_ns(), receiver).has_value());
    for (auto& more : received(console)) datagrams.push_back(more);
  }
  std::set<int> port_addresses, bind_indices;
  const auto replies = replies_in(datagrams);
  for (const auto& reply : replies) {
    bind_indices.insert(reply.bind_index);
    for (const auto& port : reply.ports()) port_addresses.insert(port.port_address);
  }
  CHECK(port_addresses.size() == 512);
  CHECK(*port_addresses.rbegin() == 511);
  CHECK(bind_indices.size() == replies.size());
}

TEST_CASE("a targeted poll is answered for its range only, and not outside of it") {
  if (!enter_private_network()) return;
  auto source = must(ArtnetSource::create(source_options(universes_from(1, 9, 1))));
  const Fd console = stranger(0x7F00'0009, 0);
  KeepingReceiver receiver;
  const Bytes poll = {'A', 'r', 't', '-', 'N', 'e', 't', 0, 0x00, 0x20, 0, 14, 0x20, 0, 0, 5, 0, 3};
  REQUIRE(send_bytes(console, kThisMachine, kArtnetPort, poll));
  REQUIRE(drain(*source, kStartNs, receiver));
  REQUIRE(source->poll(kStartNs + kNsPerS, receiver).has_value());
  const auto datagrams = received(console);
  std::vector<int> ports;
  for (const auto& reply : replies_in(datagrams)) ports.push_back(reply.port_list[0].port_address);
  CHECK(ports == std::vector<int>{3, 4, 5});
  Bytes elsewhere = poll;
  elsewhere[15] = elsewhere[17] = 100;
  REQUIRE(send_bytes(console, kThisMachine, kArtnetPort, elsewhere));
  REQUIRE(drain(*source, kStartNs + kNsPerS, receiver));
  REQUIRE(source->poll(kStartNs + 3 * kNsPerS, receiver).has_value());
  CHECK(received(console).empty());
}

TEST_CASE("a subscriber to changes gets replies when a universe starts, is merged and ends, others do not") {
  if (!enter_private_network()) return;
  auto source = must(ArtnetSource::create(source_options(universes_from(1, 2, 1))));
  const Fd curious = stranger(0x7F00'0009, 0), plain = stranger(0x7F00'000A, 0);
  const Fd desk = stranger(0x7F00'0002, 0), second = stranger(0x7F00'0003, 0);
  KeepingReceiver receiver;
  TimeNs now_ns = kStartNs;
  const auto wait = [&](DurationNs duration_ns) {  // polls like the pump
    const TimeNs until_ns = now_ns + duration_ns;
    REQUIRE(drain(*source, now_ns, receiver));
    while (source->next_deadline_ns() <= until_ns) {
      now_ns = source->next_deadline_ns();
      REQUIRE(source->poll(now_ns, receiver).has_value());
    }
    now_ns = until_ns;
  };
  send_poll(curious, kArtnetPollOnChange);
  send_poll(plain);
  wait(kNsPerS);
  CHECK(received(curious).size() == 2);
  CHECK(received(plain).size() == 2);

  send_dmx(desk, 2, 1);
  wait(kNsPerS);
  auto news = received(curious);
  REQUIRE(news.size() == 1);
  CHECK(replies_in(news)[0].port_list[0].port_address == 1);
  CHECK(replies_in(news)[0].port_list[0].active);
  CHECK_FALSE(replies_in(news)[0].port_list[0].merging);

  send_dmx(second, 2, 2);
  wait(kNsPerS);
  news = received(curious);
  REQUIRE(news.size() == 1);
  CHECK(replies_in(news)[0].port_list[0].merging);

  send_poll(curious, kArtnetPollOnChange);
  wait(9'500 * kNsPerMs);
  news = received(curious);
  REQUIRE(news.size() == 4);  // two replies to the poll, merging over, no more frames
  CHECK_FALSE(replies_in(news)[3].port_list[0].active);
  CHECK(received(plain).empty());
  wait(10 * kNsPerS);
  CHECK(source->next_deadline_ns() == kTimeNever);  // no subscriber is left
}

TEST_CASE("after an ArtSync frames wait for the next one and are delivered together, the newest of each universe") {
  if (!enter_private_network()) return;
  auto source = must(ArtnetSource::create(source_options(universes_from(1, 3, 1))));
  const Fd desk = stranger(0x7F00'0002, 0);
  KeepingReceiver receiver;
  send_dmx(desk, 1, 10);
  send_dmx(desk, 2, 20);
  REQUIRE(drain(*source, kStartNs, receiver));
  CHECK(receiver.frames.size() == 2);  // no ArtSync yet: at once
  send_sync(desk);
  send_dmx(desk, 1, 11);
  send_dmx(desk, 2, 21);
  send_dmx(desk, 1, 12);
  REQUIRE(drain(*source, kStartNs + kNsPerS, receiver));
  CHECK(receiver.frames.size() == 2);
  send_sync(desk);
  REQUIRE(drain(*source, kStartNs + 2 * kNsPerS, receiver));
  REQUIRE(receiver.frames.size() == 4);
  CHECK(receiver.frames[2].view.universe == 1);
  CHECK(receiver.frames[2].slots[0] == 12);
  CHECK(receiver.frames[3].slots[0] == 21);
  for (std::size_t i = 2; i < 4; ++i) CHECK(receiver.frames[i].view.stamp_ns == kStartNs + 2 * kNsPerS);
  CHECK(source->counters().dropped == 1);
}

TEST_CASE("after four seconds without ArtSync held frames are delivered, and later ones are not held") {
  if (!enter_private_network()) return;
  auto source = must(ArtnetSource::create(source_options({{1, 1}})));
  const Fd desk = stranger(0x7F00'0002, 0);
  KeepingReceiver receiver;
  send_dmx(desk, 1, 10);
  send_sync(desk);
  REQUIRE(drain(*source, kStartNs, receiver));
  send_dmx(desk, 1, 11);
  REQUIRE(drain(*source, kStartNs + kNsPerS, receiver));
  CHECK(receiver.frames.size() == 1);
  CHECK(source->next_deadline_ns() == kStartNs + 4 * kNsPerS);
  REQUIRE(source->poll(kStartNs + 4 * kNsPerS - 1, receiver).has_value());
  CHECK(receiver.frames.size() == 1);
  REQUIRE(source->poll(kStartNs + 4 * kNsPerS, receiver).has_value());
  REQUIRE(receiver.frames.size() == 2);
  CHECK(receiver.frames[1].slots[0] == 11);
  send_dmx(desk, 1, 12);
  REQUIRE(drain(*source, kStartNs + 5 * kNsPerS, receiver));
  CHECK(receiver.frames.size() == 3);
}

TEST_CASE(
    "skipped numbers of an Art-Net sender are lost and swapped ones late, and the wrap from 255 to 1 skips none") {
  if (!enter_private_network()) return;
  auto source = must(ArtnetSource::create(source_options(universes_from(5, 2, 1))));
  const Fd desk = stranger(0x7F00'0002, 0), unnumbered = stranger(0x7F00'0003, 0);
  KeepingReceiver receiver;
  for (int i = 0; i < 600; ++i) send_dmx(desk, 6, 1, static_cast<std::uint8_t>(i % 255 + 1));
  REQUIRE(drain(*source, kStartNs, receiver));
  REQUIRE(receiver.frames.size() == 600);
  const SenderId sender = receiver.frames[0].view.sender;
  CHECK(source->sender_losses(1, sender).lost == 0);
  for (const int number : {91, 92, 254, 255, 2, 1, 2, 4}) {  // from 90
    if (number == 254)
      for (int i = 93; i < 254; ++i) send_dmx(desk, 6, 1, static_cast<std::uint8_t>(i));
    send_dmx(desk, 6, 1, static_cast<std::uint8_t>(number));
  }
  for (int i = 0; i < 10; ++i) send_dmx(unnumbered, 6, 2, i % 2 == 0 ? 0 : 9);
  REQUIRE(drain(*source, kStartNs, receiver));
  CHECK(source->sender_losses(1, sender).lost == 1);  // 3
  CHECK(source->sender_losses(1, sender).late == 1);  // 1
  CHECK(source->sender_losses(0, sender).lost == 0);  // the other universe
  CHECK(source->sender_losses(1, receiver.frames.back().view.sender).lost == 0);
}

TEST_CASE("an ArtSync of a sender without frames for us changes nothing") {
  if (!enter_private_network()) return;
  auto source = must(ArtnetSource::create(source_options({{1, 1}})));
  const Fd desk = stranger(0x7F00'0002, 0), other = stranger(0x7F00'0003, 0);
  KeepingReceiver receiver;
  send_dmx(desk, 1, 10);
  send_sync(other);
  send_dmx(desk, 1, 11);
  REQUIRE(drain(*source, kStartNs, receiver));
  CHECK(receiver.frames.size() == 2);
  CHECK(source->details().sync_ignored == 1);
  send_sync(desk);
  send_dmx(desk, 1, 12);
  send_sync(other);  // does not release frames that wait for the desk
  REQUIRE(drain(*source, kStartNs, receiver));
  CHECK(receiver.frames.size() == 2);
}

TEST_CASE("a universe that two senders share is merged and not held, and held frames are delivered first") {
  if (!enter_private_network()) return;
  auto source = must(ArtnetSource::create(source_options(universes_from(1, 2, 1))));
  const Fd desk = stranger(0x7F00'0002, 0), other = stranger(0x7F00'0003, 0);
  KeepingReceiver receiver;
  send_dmx(desk, 1, 10);
  send_dmx(desk, 2, 20);
  send_sync(desk);
  send_dmx(desk, 1, 11);
  send_dmx(desk, 2, 21);
  send_dmx(other, 1, 50);
  REQUIRE(drain(*source, kStartNs, receiver));
  REQUIRE(receiver.frames.size() == 4);
  CHECK(receiver.frames[2].slots[0] == 11);
  CHECK(receiver.frames[3].slots[0] == 50);
  send_dmx(desk, 1, 12);
  REQUIRE(drain(*source, kStartNs + kNsPerS, receiver));
  CHECK(receiver.frames.size() == 5);  // at once; universe 2 still waits
  send_sync(desk);
  REQUIRE(drain(*source, kStartNs + kNsPerS, receiver));
  REQUIRE(receiver.frames.size() == 6);
  CHECK(receiver.frames[5].view.universe == 2);
}

TEST_CASE("a sender may be silent for ten seconds before the merge removes it") {
  if (!enter_private_network()) return;
  auto source = must(ArtnetSource::create(source_options({{1, 1}})));
  const Fd desk = stranger(0x7F00'0002, 0);
  KeepingReceiver receiver;
  send_dmx(desk, 1, 10);
  REQUIRE(drain(*source, kStartNs, receiver));
  REQUIRE(receiver.frames.size() == 1);
  CHECK(receiver.frames[0].view.silence_max_ns == 10 * kNsPerS);
  REQUIRE(source->poll(kStartNs + 9 * kNsPerS, receiver).has_value());
  CHECK(source->state() == PortState::kWorking);
  REQUIRE(source->poll(kStartNs + 10 * kNsPerS, receiver).has_value());
  CHECK(source->state() == PortState::kWaiting);
}

TEST_CASE("a sender's name is requested once and used") {
  if (!enter_private_network()) return;
  auto options = source_options(universes_from(1, 2, 1));
  options.request_names = true;
  auto source = must(ArtnetSource::create(options));
  const Fd desk = stranger(0x7F00'0002, 0);
  const Fd air = stranger(kLoopbackBroadcast, kArtnetPort);
  KeepingReceiver receiver;
  send_dmx(desk, 1, 10);
  send_dmx(desk, 2, 10);
  REQUIRE(drain(*source, kStartNs, receiver));
  REQUIRE(receiver.frames.size() == 2);
  const SenderId sender = receiver.frames[0].view.sender;
  CHECK(source->sender_text(sender) == "127.0.0.2");
  CHECK(received(air).size() == 1);
  ArtnetPollReply reply;
  reply.ip = {127, 0, 0, 2};
  reply.short_name = "FOH";
  reply.long_name = "FOH\x1b[31m desk\n";
  Bytes packet(kArtnetPollReplyBytes);
  build_artnet_poll_reply(reply, packet);
  REQUIRE(send_bytes(desk, kThisMachine, kArtnetPort, packet));
  REQUIRE(drain(*source, kStartNs, receiver));
  CHECK(source->sender_text(sender) == "FOH [31m desk (127.0.0.2)");  // without control characters for the terminal
  CHECK(source->sender_text(sender + 1) == "");
}

TEST_CASE("a source ignores frames and ArtSync of its own program, although they come from UDP port 6454") {
  if (!enter_private_network()) return;
  const auto program = std::make_shared<OwnSenders>();
  auto in = source_options({{1, 1}});
  in.own_senders = program;
  auto source = must(ArtnetSource::create(in));
  ArtnetSinkOptions out;
  out.name = "artnet:test-out";
  out.universes = {{1, 1}};
  out.addresses = {"127.255.255.255"};
  out.sync = true;
  auto foreign = must(ArtnetSink::create(out));
  out.own_senders = program;
  auto own = must(ArtnetSink::create(out));
  const Bytes levels(512, 9);
  FrameView frame;
  frame.universe = 1;
  frame.slots = levels;
  KeepingReceiver receiver;
  REQUIRE(own->send(kStartNs, {&frame, 1}).has_value());
  REQUIRE(drain(*source, kStartNs, receiver));
  CHECK(receiver.frames.empty());
  CHECK(source->details().own == 2);
  const Bytes other_levels(512, 10);
  frame.slots = other_levels;
  REQUIRE(foreign->send(kStartNs + kNsPerS, {&frame, 1}).has_value());
  REQUIRE(drain(*source, kStartNs + kNsPerS, receiver));
  CHECK(receiver.frames.size() == 1);
  CHECK(source->details().sync == 1);
}

TEST_CASE("after 20000 damaged datagrams a source still receives") {
  if (!enter_private_network()) return;
  auto options = source_options(universes_from(1, 9, 1));
  options.request_names = true;
  auto source = must(ArtnetSource::create(options));
  std::mt19937 random(4);
  const Fd desk = stranger(0x7F00'0002, 0);
  std::vector<Bytes> seeds(4);
  const Bytes slots(64, 7);
  ArtnetDmx dmx;
  dmx.slots = slots;
  seeds[0].resize(kArtnetDmxBytesMax);
  seeds[0].resize(build_artnet_dmx(dmx, seeds[0]));
  seeds[1].resize(kArtnetPollBytesMin);
  build_artnet_poll(kArtnetPollOnChange, seeds[1]);
  seeds[2].resize(kArtnetSyncBytes);
  build_artnet_sync(seeds[2]);
  ArtnetPollReply reply;
  reply.add({3, true, false, false});
  seeds[3].resize(kArtnetPollReplyBytes);
  build_artnet_poll_reply(reply, seeds[3]);
  KeepingReceiver receiver;
  TimeNs now_ns = kStartNs;
  for (int i = 0; i < 20'000; ++i) {
    Bytes packet = seeds[random() % seeds.size()];
    for (std::size_t f = 0; f < random() % 5; ++f)
      packet[random() % packet.size()] = static_cast<std::uint8_t>(random());
    if (random() % 5 == 0) packet.resize(1 + random() % (packet.size() + 10));
    REQUIRE(send_bytes(desk, kThisMachine, kArtnetPort, packet));
    if (i % 40 == 39) REQUIRE(source->poll(now_ns += 10 * kNsPerMs, receiver).has_value());
  }
  CHECK(source->counters().rejected > 1'000);
  CHECK(receiver.frames.size() > 500);
  const std::size_t before = receiver.frames.size();
  now_ns += 20 * kNsPerS;
  send_dmx(desk, 1, 42);
  REQUIRE(drain(*source, now_ns, receiver));
  REQUIRE(receiver.frames.size() > before);
  CHECK(receiver.frames.back().slots[0] == 42);
}

}  // namespace footlight::drivers
