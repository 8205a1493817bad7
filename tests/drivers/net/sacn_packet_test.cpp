#include "drivers/net/sacn_packet.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numeric>
#include <random>

#include "drivers/net/bytes.h"
#include "tests/drivers/net/tshark.h"

namespace footlight::drivers {
namespace {

using Bytes = std::vector<std::uint8_t>;

Cid test_cid() {
  Cid cid;
  std::iota(cid.begin(), cid.end(), std::uint8_t{0x10});
  return cid;
}

Bytes test_slots(std::size_t count) {
  Bytes slots(count);
  for (std::size_t i = 0; i < count; ++i) slots[i] = static_cast<std::uint8_t>(i * 7 + 1);
  return slots;
}

SacnData test_data(std::span<const std::uint8_t> slots) {
  SacnData data;
  data.cid = test_cid();
  data.source_name = "House left";
  data.priority = 142;
  data.sync_universe = 7962;
  data.sequence = 213;
  data.universe = 40'961;
  data.slots = slots;
  return data;
}

Bytes built(const SacnData& data) {
  Bytes packet(kSacnDataBytesMax);
  packet.resize(build_sacn_data(data, packet));
  return packet;
}

// A file written by another implementation; empty if the test data are missing.
Bytes peer_packet(const char* file_name) {
  const char* const folder = std::getenv("FOOTLIGHT_TEST_DATA");
  if (folder == nullptr) {
    std::fprintf(stderr, "SKIPPED: FOOTLIGHT_TEST_DATA is not set; it names the folder with dmx/rustlight-sacn-raw\n");
    return {};
  }
  std::ifstream file(std::filesystem::path(folder) / "dmx" / "rustlight-sacn-raw" / file_name, std::ios::binary);
  REQUIRE_MESSAGE(file.good(), "cannot read " << file_name);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

TEST_CASE("a built sACN data packet parses to the same fields at every slot count") {
  for (const std::size_t count : {0u, 1u, 2u, 24u, 511u, 512u}) {
    const Bytes slots = test_slots(count);
    const Bytes packet = built(test_data(slots));
    CHECK(packet.size() == 126 + count);
    const auto parsed = parse_sacn(packet);
    REQUIRE(parsed.has_value());
    const auto& data = std::get<SacnData>(*parsed);
    CHECK(data.cid == test_cid());
    CHECK(data.source_name == "House left");
    CHECK(data.priority == 142);
    CHECK(data.sync_universe == 7962);
    CHECK(data.sequence == 213);
    CHECK(data.universe == 40'961);
    CHECK(data.start_code == 0);
    CHECK_FALSE(data.preview);
    CHECK_FALSE(data.terminated);
    CHECK_FALSE(data.force_sync);
    CHECK(std::equal(slots.begin(), slots.end(), data.slots.begin(), data.slots.end()));
  }
}

TEST_CASE("synchronisation and discovery packets have the octets of another implementation's") {
  const Bytes theirs_sync = peer_packet("sync-packet-raw");
  if (theirs_sync.empty()) return;
  Bytes ours(kSacnSyncBytes);
  build_sacn_sync(std::get<SacnSync>(parse_sacn(theirs_sync).value()), std::span<std::uint8_t, kSacnSyncBytes>(ours));
  CHECK(ours == theirs_sync);

  const Bytes theirs_list = peer_packet("discovery-packet-raw");
  const auto list = std::get<SacnDiscovery>(parse_sacn(theirs_list).value());
  std::vector<int> universes;
  for (std::size_t i = 0; i < list.universe_count(); ++i) universes.push_back(list.universe(i));
  ours.resize(kSacnDiscoveryBytesMax);
  ours.resize(build_sacn_discovery(list.cid, list.source_name, list.page, list.last_page, universes, ours));
  CHECK(ours == theirs_list);
}

TEST_CASE("each sACN option bit is carried alone and together with the others") {
  for (int bits = 0; bits < 8; ++bits) {
    SacnData data = test_data({});
    data.preview = (bits & 1) != 0;
    data.terminated = (bits & 2) != 0;
    data.force_sync = (bits & 4) != 0;
    const Bytes packet = built(data);
    CHECK(packet[112] == (data.preview ? 0x80 : 0) + (data.terminated ? 0x40 : 0) + (data.force_sync ? 0x20 : 0));
    const auto parsed = std::get<SacnData>(parse_sacn(packet).value());
    CHECK(parsed.preview == data.preview);
    CHECK(parsed.terminated == data.terminated);
    CHECK(parsed.force_sync == data.force_sync);
  }
}

TEST_CASE("updating a packet gives the same octets as building it again") {
  SacnData data = test_data({});
  data.preview = true;
  Bytes kept(kSacnDataBytesMax);
  build_sacn_data(data, kept);
  const Bytes slots = test_slots(300);
  std::uint8_t sequence = 254;
  for (const std::size_t count : {300u, 12u, 0u, 300u}) {
    data.sequence = sequence;
    data.terminated = count == 12;
    data.slots = std::span(slots).first(count);
    const std::size_t size = update_sacn_data(kept, sequence, data.terminated, data.slots);
    CHECK(Bytes(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(size)) == built(data));
    ++sequence;
  }
}

TEST_CASE("a source name longer than its field is cut before the character that does not fit") {
  const std::string long_name = std::string(62, 'x') + "\xC3\xA4" + "y";  // a two-octet character over octets 62 and 63
  SacnData data = test_data({});
  data.source_name = long_name;
  const Bytes packet = built(data);
  CHECK(std::get<SacnData>(parse_sacn(packet).value()).source_name == std::string(62, 'x'));
  CHECK(packet[44 + 63] == 0);
}

TEST_CASE("a source name that fills its field without a closing zero ends with the field") {
  Bytes packet = built(test_data({}));
  std::fill_n(packet.begin() + 44, 64, std::uint8_t{'n'});
  CHECK(std::get<SacnData>(parse_sacn(packet).value()).source_name == std::string(64, 'n'));
}

TEST_CASE("each broken field of a data packet is refused for its own reason") {
  const Bytes slots = test_slots(512);
  const Bytes good = built(test_data(slots));
  struct Case {
    const char* what;
    std::size_t at;
    std::uint8_t value;
    SacnFault fault;
  };
  for (const Case& c :
       {Case{"preamble", 1, 0x11, SacnFault::kNotAcn}, Case{"identifier", 12, '8', SacnFault::kNotAcn},
        Case{"root flags", 16, 0x62, SacnFault::kLength}, Case{"root length", 17, 0x6F, SacnFault::kLength},
        Case{"root vector", 21, 5, SacnFault::kVector}, Case{"framing length", 39, 0x57, SacnFault::kLength},
        Case{"framing vector", 43, 3, SacnFault::kVector}, Case{"priority", 108, 201, SacnFault::kPriority},
        Case{"sync universe", 109, 0xFA, SacnFault::kSyncUniverse}, Case{"universe", 113, 0xFA, SacnFault::kUniverse},
        Case{"DMP length", 116, 0x0A, SacnFault::kLength}, Case{"DMP vector", 117, 3, SacnFault::kVector},
        Case{"address type", 118, 0xA2, SacnFault::kPropertyFormat},
        Case{"first address", 120, 1, SacnFault::kPropertyFormat},
        Case{"increment", 122, 2, SacnFault::kPropertyFormat}, Case{"count", 124, 0x00, SacnFault::kLength},
        Case{"count above 513", 123, 0x03, SacnFault::kSlotCount}}) {
    CAPTURE(c.what);
    Bytes bad = good;
    bad[c.at] = c.value;
    const auto parsed = parse_sacn_packet(bad);
    REQUIRE_FALSE(parsed.has_value());
    CHECK(parsed.error() == c.fault);
  }
  Bytes no_universe = good;
  no_universe[113] = no_universe[114] = 0;
  CHECK(parse_sacn_packet(no_universe).error() == SacnFault::kUniverse);
  CHECK(parse_sacn(no_universe).error().message.find("universe is outside 1 to 63999") != std::string::npos);
}

TEST_CASE("no shortened or extended packet is accepted") {
  const Bytes slots = test_slots(10);
  const Bytes good = built(test_data(slots));
  for (std::size_t size = 0; size < good.size(); ++size) {
    CHECK_FALSE(parse_sacn_packet(std::span(good).first(size)).has_value());
  }
  Bytes longer = good;
  longer.push_back(0);
  CHECK_FALSE(parse_sacn_packet(longer).has_value());
}

TEST_CASE("a data packet written by another implementation parses to its fields") {
  const Bytes packet = peer_packet("data-packet-raw");
  if (packet.empty()) return;
  const auto parsed = parse_sacn(packet);
  REQUIRE(parsed.has_value());
  const auto& data = std::get<SacnData>(*parsed);
  CHECK(data.cid[0] == 0xEF);
  CHECK(data.cid[15] == 0x3E);
  CHECK(data.source_name == "Test Source");
  CHECK(data.priority == 100);
  CHECK(data.sync_universe == 4);
  CHECK(data.sequence == 0x42);
  CHECK(data.universe == 1);
  CHECK(data.slots.size() == 15);
  CHECK(data.slots[0] == 14);
  // Ours, built from these fields, has the same octets.
  CHECK(built(data) == packet);
}

TEST_CASE("sync and discovery packets written by another implementation are recognised") {
  const Bytes sync_packet = peer_packet("sync-packet-raw");
  if (sync_packet.empty()) return;
  const auto sync = std::get<SacnSync>(parse_sacn(sync_packet).value());
  CHECK(sync.sequence == 0x42);
  CHECK(sync.sync_universe == 4);

  const Bytes discovery_packet = peer_packet("discovery-packet-raw");
  const auto discovery = std::get<SacnDiscovery>(parse_sacn(discovery_packet).value());
  CHECK(discovery.source_name == "Test Source");
  CHECK(discovery.page == 0);
  CHECK(discovery.last_page == 0);
  REQUIRE(discovery.universe_count() == 3);
  CHECK(discovery.universe(0) == 1);
  CHECK(discovery.universe(2) == 4);
  for (const Bytes& packet : {sync_packet, discovery_packet}) {
    for (std::size_t size = 0; size < packet.size(); ++size) {
      CHECK_FALSE(parse_sacn_packet(std::span(packet).first(size)).has_value());
    }
  }
}

TEST_CASE("Wireshark decodes our data packet to the same fields") {
  const Bytes slots = test_slots(24);  // tshark 4.0.17 calls any data packet of fewer than 10 slots malformed
  SacnData data = test_data(slots);
  data.preview = true;
  const auto fields = testing::dissect(built(data), kSacnPort,
                                       {"acn.cid", "acn.dmx.source_name", "acn.dmx.priority", "acn.dmx.seq_number",
                                        "acn.dmx.options", "acn.dmx.universe", "acn.dmx.start_code", "acn.dmx.count",
                                        "acn.dmx.increment", "acn.pdu.length", "_ws.malformed"});
  if (!fields) return;
  CHECK(fields->at("acn.cid") == "10111213-1415-1617-1819-1a1b1c1d1e1f");
  CHECK(fields->at("acn.dmx.source_name") == "House left");
  CHECK(fields->at("acn.dmx.priority") == "142");
  CHECK(fields->at("acn.dmx.seq_number") == "213");
  CHECK(fields->at("acn.dmx.options") == "128");
  CHECK(fields->at("acn.dmx.universe") == "40961");
  CHECK(fields->at("acn.dmx.count") == "25");
  CHECK(fields->at("acn.dmx.increment") == "1");
  CHECK(fields->at("acn.pdu.length") == "134,112,35");
  CHECK(fields->at("_ws.malformed") == "");
}

TEST_CASE("20000 damaged packets crash nothing and none passes with a value out of range") {
  std::mt19937 random(1);
  const Bytes slots = test_slots(512);
  std::vector<Bytes> seeds = {built(test_data(slots)), built(test_data(std::span(slots).first(3)))};
  Bytes discovery(120 + 6);
  Bytes sync(49);
  for (Bytes* extended : {&sync, &discovery}) {
    std::copy_n(seeds[0].begin(), 16, extended->begin());
    write_u16_be(*extended, 16, static_cast<std::uint16_t>(0x7000 | (extended->size() - 16)));
    write_u32_be(*extended, 18, 8);
    write_u16_be(*extended, 38, static_cast<std::uint16_t>(0x7000 | (extended->size() - 38)));
    write_u32_be(*extended, 40, extended == &sync ? 1 : 2);
  }
  write_u16_be(sync, 45, 9);
  write_u16_be(discovery, 112, 0x7000 | 14);
  write_u32_be(discovery, 114, 1);
  for (std::uint16_t i = 0; i < 3; ++i) write_u16_be(discovery, 120u + 2u * i, static_cast<std::uint16_t>(i + 1));
  REQUIRE(parse_sacn(sync).has_value());
  REQUIRE(parse_sacn(discovery).has_value());
  seeds.push_back(sync);
  seeds.push_back(discovery);

  int accepted = 0;
  for (int i = 0; i < 20'000; ++i) {
    Bytes packet = seeds[random() % seeds.size()];
    const std::size_t flips = 1 + random() % 6;
    for (std::size_t f = 0; f < flips; ++f) {
      // Mostly the headers, where damage has the most effect.
      const std::size_t at = random() % std::min<std::size_t>(packet.size(), random() % 4 == 0 ? 640 : 130);
      packet[at] = static_cast<std::uint8_t>(random() % 3 == 0 ? 0xFF : random());
    }
    if (random() % 8 == 0) packet.resize(random() % (packet.size() + 40));
    // An exact allocation, so that a sanitizer detects a read past the end.
    const Bytes exact(packet.begin(), packet.end());
    const auto parsed = parse_sacn_packet(exact);
    if (!parsed) continue;
    ++accepted;
    if (const auto* data = std::get_if<SacnData>(&*parsed)) {
      REQUIRE(data->priority <= 200);
      REQUIRE(is_universe(data->universe));
      REQUIRE((data->sync_universe == 0 || is_universe(data->sync_universe)));
      REQUIRE(data->slots.size() <= 512);
      REQUIRE(data->slots.size() + 126 == exact.size());
    } else if (const auto* list = std::get_if<SacnDiscovery>(&*parsed)) {
      REQUIRE(list->page <= list->last_page);
      for (std::size_t u = 0; u < list->universe_count(); ++u) REQUIRE(is_universe(list->universe(u)));
    } else {
      REQUIRE(is_universe(std::get<SacnSync>(*parsed).sync_universe));
    }
  }
  CHECK(accepted > 1'000);  // damage to names, levels and the like is not detected, so both outcomes were exercised
  CHECK(accepted < 19'000);
}

TEST_CASE("the multicast group of a universe carries its number in the last two octets") {
  CHECK(sacn_group_ipv4(1) == 0xEFFF0001u);
  CHECK(sacn_group_ipv4(63'999) == 0xEFFFF9FFu);
  CHECK(sacn_group_ipv4(kSacnDiscoveryUniverse) == 0xEFFFFAD6u);
}

}  // namespace footlight::drivers
