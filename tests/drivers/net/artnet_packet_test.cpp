#include "drivers/net/artnet_packet.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include "drivers/net/bytes.h"
#include "tests/drivers/net/tshark.h"

namespace footlight::drivers {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes built(const ArtnetDmx& dmx) {
  Bytes packet(kArtnetDmxBytesMax);
  packet.resize(build_artnet_dmx(dmx, packet));
  return packet;
}

Bytes poll_packet(std::uint8_t flags, std::uint16_t last, std::uint16_t first) {
  Bytes packet = {'A', 'r', 't', '-', 'N', 'e', 't', 0, 0x00, 0x20, 0, 14, flags, 0, 0, 0, 0, 0};
  write_u16_be(packet, 14, last);
  write_u16_be(packet, 16, first);
  return packet;
}

}  // namespace

TEST_CASE("wire universe 1 is Art-Net port address 0 and 32768 is the last") {
  CHECK(artnet_port_address(1) == 0);
  CHECK(artnet_port_address(kArtnetUniverseMax) == kArtnetPortAddressMax);
  CHECK(artnet_wire_universe(0x7FFF) == 32'768);
}

TEST_CASE("a built ArtDmx parses to the same fields for every bit of the port address") {
  const Bytes slots = {9, 8, 7, 6};
  for (int bit = 0; bit < 15; ++bit) {
    ArtnetDmx dmx;
    dmx.sequence = 77;
    dmx.physical = 3;
    dmx.port_address = 1 << bit;
    dmx.slots = slots;
    const auto parsed = parse_artnet(built(dmx));
    REQUIRE(parsed.has_value());
    const auto& got = std::get<ArtnetDmx>(*parsed);
    CHECK(got.sequence == 77);
    CHECK(got.physical == 3);
    CHECK(got.port_address == 1 << bit);
  }
}

TEST_CASE("ArtDmx is built with an even length of at least two, padded with zero") {
  for (const std::size_t count : {0u, 1u, 2u, 3u, 511u, 512u}) {
    const Bytes slots(count, 0xFF);
    ArtnetDmx dmx;
    dmx.slots = slots;
    const Bytes packet = built(dmx);
    const std::size_t length = packet.size() - 18;
    CHECK(length == std::max<std::size_t>(2, (count + 1) / 2 * 2));
    CHECK(read_u16_be(packet, 16) == length);
    for (std::size_t i = 0; i < length; ++i) CHECK(packet[18 + i] == (i < count ? 0xFF : 0));
  }
}

TEST_CASE("each broken field of an ArtDmx is refused for its own reason") {
  const Bytes slots(512, 1);
  ArtnetDmx dmx;
  dmx.slots = slots;
  const Bytes good = built(dmx);
  struct Case {
    std::size_t at;
    std::uint8_t value;
    ArtnetFault fault;
  };
  for (const Case& c : {Case{0, 'a', ArtnetFault::kNotArtnet}, Case{11, 13, ArtnetFault::kVersion},
                        Case{15, 0x80, ArtnetFault::kPortAddress}, Case{17, 1, ArtnetFault::kLength},
                        Case{16, 0, ArtnetFault::kLength}}) {
    Bytes bad = good;
    bad[c.at] = c.value;
    const auto parsed = parse_artnet_packet(bad);
    REQUIRE_FALSE(parsed.has_value());
    CHECK(parsed.error() == c.fault);
  }
  for (std::size_t size = 0; size < good.size(); ++size) {
    CHECK_FALSE(parse_artnet_packet(std::span(good).first(size)).has_value());
  }
}

TEST_CASE("an ArtDmx of odd length is accepted unchanged") {
  const Bytes slots(4, 5);
  ArtnetDmx dmx;
  dmx.slots = slots;
  Bytes packet = built(dmx);
  packet[17] = 3;
  CHECK(std::get<ArtnetDmx>(parse_artnet(packet).value()).slots.size() == 3);
}

TEST_CASE("an ArtPoll requests all ports unless it is targeted") {
  const auto all = std::get<ArtnetPoll>(parse_artnet(poll_packet(0x02, 5, 3)).value());
  CHECK(all.port_address_first == 0);
  CHECK(all.port_address_last == kArtnetPortAddressMax);
  const auto targeted = std::get<ArtnetPoll>(parse_artnet(poll_packet(0x20, 5, 3)).value());
  CHECK(targeted.port_address_first == 3);
  CHECK(targeted.port_address_last == 5);
  Bytes old = poll_packet(0x20, 5, 3);
  old.resize(14);  // as before Art-Net 4
  CHECK(std::get<ArtnetPoll>(parse_artnet(old).value()).port_address_last == kArtnetPortAddressMax);
}

TEST_CASE("Wireshark decodes our ArtDmx to the same fields") {
  const Bytes slots = {1, 2, 3};
  ArtnetDmx dmx;
  dmx.sequence = 200;
  dmx.port_address = 0x1234;
  dmx.slots = slots;
  const auto fields = testing::dissect(built(dmx), kArtnetPort,
                                       {"artnet.header.opcode", "artnet.header.protver", "artnet.output.sequence",
                                        "artnet.output.universe", "artnet.output.length", "_ws.malformed"});
  if (!fields) return;
  CHECK(fields->at("artnet.header.opcode") == "0x5000");
  CHECK(fields->at("artnet.header.protver") == "14");
  CHECK(fields->at("artnet.output.sequence") == "200");
  CHECK(fields->at("artnet.output.universe") == "4660");
  CHECK(fields->at("artnet.output.length") == "4");
  CHECK(fields->at("_ws.malformed") == "");
}

TEST_CASE("Wireshark decodes our ArtPollReply to the same fields") {
  ArtnetPollReply reply;
  reply.add({0x0120, true, true, false});
  reply.add({0x0121, true, false, false});
  reply.add({0x012F, true, true, true});
  reply.add({0x0125, false, true, false});
  reply.ip = {10, 0, 0, 5};
  reply.mac = {2, 0, 0, 0, 0, 9};
  reply.short_name = "Footlight";
  reply.long_name = "Footlight at the back of the house";
  reply.report = "#0001 [0001] receiving";
  reply.bind_index = 3;
  Bytes packet(kArtnetPollReplyBytes);
  build_artnet_poll_reply(reply, packet);
  const auto fields = testing::dissect(packet, kArtnetPort,
                                       {"artnet.header.opcode",
                                        "artnet.poll_reply.ip_address",
                                        "artnet.poll_reply.port_nr",
                                        "artnet.poll_reply.netswitch",
                                        "artnet.poll_reply.subswitch",
                                        "artnet.poll_reply.short_name",
                                        "artnet.poll_reply.long_name",
                                        "artnet.poll_reply.node_report",
                                        "artnet.poll_reply.num_ports",
                                        "artnet.poll_reply.port_types_1",
                                        "artnet.poll_reply.port_types_4",
                                        "artnet.poll_reply.swout_3",
                                        "artnet.poll_reply.good_output_1",
                                        "artnet.poll_reply.good_output_2",
                                        "artnet.poll_reply.good_output_3",
                                        "artnet.poll_reply.good_input_1",
                                        "artnet.poll_reply.swin_1",
                                        "artnet.poll_reply.style",
                                        "artnet.poll_reply.mac",
                                        "artnet.poll_reply.bind_ip_address",
                                        "artnet.poll_reply.bind_index",
                                        "_ws.malformed"});
  if (!fields) return;
  CHECK(fields->at("artnet.header.opcode") == "0x2100");
  CHECK(fields->at("artnet.poll_reply.ip_address") == "10.0.0.5");
  CHECK(fields->at("artnet.poll_reply.port_nr") == "6454");
  CHECK(fields->at("artnet.poll_reply.netswitch") == "0x01");
  CHECK(fields->at("artnet.poll_reply.subswitch") == "0x02");
  CHECK(fields->at("artnet.poll_reply.short_name") == "Footlight");
  CHECK(fields->at("artnet.poll_reply.long_name") == "Footlight at the back of the house");
  CHECK(fields->at("artnet.poll_reply.node_report") == "#0001 [0001] receiving");
  CHECK(fields->at("artnet.poll_reply.num_ports") == "3");
  CHECK(fields->at("artnet.poll_reply.port_types_1") == "0xc0");
  CHECK(fields->at("artnet.poll_reply.good_output_1") == "0x80");
  CHECK(fields->at("artnet.poll_reply.good_output_2") == "0x00");
  CHECK(fields->at("artnet.poll_reply.good_output_3") == "0x88");
  CHECK(fields->at("artnet.poll_reply.good_input_1") == "0x80");
  CHECK(fields->at("artnet.poll_reply.swin_1") == "0x05");
  CHECK(fields->at("artnet.poll_reply.style") == "0x00");
  CHECK(fields->at("artnet.poll_reply.port_types_4") == "0x00");
  CHECK(fields->at("artnet.poll_reply.swout_3") == "0x0f");
  CHECK(fields->at("artnet.poll_reply.mac") == "02:00:00:00:00:09");
  CHECK(fields->at("artnet.poll_reply.bind_ip_address") == "10.0.0.5");
  CHECK(fields->at("artnet.poll_reply.bind_index") == "0x03");
  CHECK(fields->at("_ws.malformed") == "");
}

TEST_CASE("Wireshark decodes our ArtPoll and our ArtSync to the same fields") {
  Bytes poll(kArtnetPollBytesMin);
  build_artnet_poll(kArtnetPollOnChange, poll);
  const auto fields = testing::dissect(poll, kArtnetPort,
                                       {"artnet.header.opcode", "artnet.poll.talktome_reply_change",
                                        "artnet.poll.talktome_diag", "artnet.poll.talktome_targeted", "_ws.malformed"});
  if (!fields) return;
  CHECK(fields->at("artnet.header.opcode") == "0x2000");
  CHECK(fields->at("artnet.poll.talktome_reply_change") == "1");
  CHECK(fields->at("artnet.poll.talktome_diag") == "0");
  CHECK(fields->at("artnet.poll.talktome_targeted") == "0");
  CHECK(fields->at("_ws.malformed") == "");
  Bytes sync(kArtnetSyncBytes);
  build_artnet_sync(sync);
  const auto latched =
      testing::dissect(sync, kArtnetPort, {"artnet.header.opcode", "artnet.header.protver", "_ws.malformed"});
  REQUIRE(latched.has_value());
  CHECK(latched->at("artnet.header.opcode") == "0x5200");
  CHECK(latched->at("artnet.header.protver") == "14");
  CHECK(latched->at("_ws.malformed") == "");
}

TEST_CASE("a built ArtPollReply parses to the same ports, names and style") {
  ArtnetPollReply reply;
  reply.ip = {10, 0, 0, 5};
  reply.mac = {1, 2, 3, 4, 5, 6};
  reply.short_name = "short";
  reply.long_name = "a longer name";
  reply.report = "#0001 [0001] sending";
  reply.bind_index = 200;
  reply.style = ArtnetPollReply::Style::kController;
  reply.rdm = true;
  for (const int upper : {0, 0x7FF}) {
    reply.port_count = 0;
    for (int i = 0; i < 4; ++i) {
      reply.add({upper << 4 | (15 - i), true, i % 2 == 0, i == 3});
      reply.add({upper << 4 | i, false, i % 2 == 1, false});
    }
    Bytes packet(kArtnetPollReplyBytes);
    build_artnet_poll_reply(reply, packet);
    const auto parsed = parse_artnet(packet);
    REQUIRE(parsed.has_value());
    const auto& got = std::get<ArtnetPollReply>(*parsed);
    CHECK(got.ip == reply.ip);
    CHECK(got.mac == reply.mac);
    CHECK(got.short_name == "short");
    CHECK(got.long_name == "a longer name");
    CHECK(got.report == reply.report);
    CHECK(got.bind_index == 200);
    CHECK(got.style == ArtnetPollReply::Style::kController);
    CHECK(got.rdm);
    REQUIRE(got.port_count == 8);
    for (std::size_t i = 0; i < 8; ++i) {
      CHECK(got.port_list[i].port_address == reply.port_list[i].port_address);
      CHECK(got.port_list[i].output == reply.port_list[i].output);
      CHECK(got.port_list[i].active == reply.port_list[i].active);
      CHECK(got.port_list[i].merging == reply.port_list[i].merging);
    }
  }
}

TEST_CASE("an ArtPollReply of an older version is read as far as it goes, and refused before its ports end") {
  ArtnetPollReply reply;
  reply.short_name = "old";
  reply.add({0x55, true, false, false});
  reply.bind_index = 9;
  Bytes packet(kArtnetPollReplyBytes);
  build_artnet_poll_reply(reply, packet);
  for (std::size_t size = 0; size < packet.size(); ++size) {
    CAPTURE(size);
    const Bytes exact(packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(size));
    const auto parsed = parse_artnet_packet(exact);
    CHECK(parsed.has_value() == (size >= 194));
    if (!parsed) continue;
    const auto& got = std::get<ArtnetPollReply>(*parsed);
    REQUIRE(got.port_count == 1);
    CHECK(got.port_list[0].port_address == 0x55);
    CHECK(got.bind_index == (size > 211 ? 9 : 0));
  }
}

TEST_CASE("names without a final zero end where their field ends") {
  ArtnetPollReply reply;
  Bytes packet(kArtnetPollReplyBytes);
  build_artnet_poll_reply(reply, packet);
  std::fill(packet.begin() + 26, packet.begin() + 172, 'x');
  const auto parsed = parse_artnet(packet);
  REQUIRE(parsed.has_value());
  const auto& got = std::get<ArtnetPollReply>(*parsed);
  CHECK(got.short_name.size() == 18);
  CHECK(got.long_name.size() == 64);
  CHECK(got.report.size() == 64);
}

TEST_CASE("20000 damaged Art-Net packets crash nothing and none passes with a value out of range") {
  std::mt19937 random(2);
  const Bytes slots(512, 1);
  ArtnetDmx dmx;
  dmx.slots = slots;
  const std::vector<Bytes> seeds = {built(dmx), poll_packet(0x20, 9, 1)};
  int accepted = 0;
  for (int i = 0; i < 20'000; ++i) {
    Bytes packet = seeds[random() % seeds.size()];
    for (std::size_t f = 0; f < 1 + random() % 4; ++f) packet[random() % 18] = static_cast<std::uint8_t>(random());
    if (random() % 4 == 0) packet.resize(random() % (packet.size() + 10));
    const Bytes exact(packet.begin(), packet.end());
    const auto parsed = parse_artnet_packet(exact);
    if (!parsed) continue;
    ++accepted;
    if (const auto* got = std::get_if<ArtnetDmx>(&*parsed)) {
      REQUIRE(got->port_address >= 0);
      REQUIRE(got->port_address <= kArtnetPortAddressMax);
      REQUIRE(got->slots.size() >= 1);
      REQUIRE(got->slots.size() <= 512);
      REQUIRE(got->slots.size() + 18 <= exact.size());
    }
  }
  CHECK(accepted > 1'000);
  CHECK(accepted < 19'000);
}

}  // namespace footlight::drivers
