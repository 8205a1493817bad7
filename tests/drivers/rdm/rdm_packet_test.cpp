#include "drivers/rdm/rdm_packet.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include "drivers/mock/rdm_line_model.h"
#include "tests/drivers/net/tshark.h"

namespace footlight::drivers {
namespace {

RdmMessage message_of(Octets data) {
  RdmMessage message;
  message.to = {0x02B0, 0x0001'2345};
  message.from = {0x7FF0, 0xAABB'CCDD};
  message.transaction = 200;
  message.port_or_type = 1;
  message.sub_device = 0x0102;
  message.command = RdmCommand::kSet;
  message.parameter = 0x00F0;
  message.data = std::move(data);
  return message;
}

// Wireshark decodes RDM inside ArtRdm, which has the message without its start code.
std::optional<std::map<std::string, std::string>> dissect(const RdmMessage& message,
                                                          const std::vector<std::string>& fields) {
  Octets packet = {'A', 'r', 't', '-', 'N', 'e', 't', 0, 0x00, 0x83, 0, 14, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  const Octets rdm = build_rdm(message);
  packet.insert(packet.end(), rdm.begin() + 1, rdm.end());
  return testing::dissect(packet, 6454, fields);
}

}  // namespace

TEST_CASE("a built RDM message parses to the same fields, for every length of its data") {
  for (std::size_t size = 0; size <= kRdmDataSizeMax; ++size) {
    Octets data(size);
    for (std::size_t i = 0; i < size; ++i) data[i] = static_cast<std::uint8_t>(i * 7);
    const RdmMessage message = message_of(data);
    const Octets bytes = build_rdm(message);
    REQUIRE(bytes.size() == 26 + size);
    const auto parsed = parse_rdm(bytes);
    REQUIRE(parsed.has_value());
    CHECK(parsed->to == message.to);
    CHECK(parsed->from == message.from);
    CHECK(parsed->transaction == 200);
    CHECK(parsed->port_or_type == 1);
    CHECK(parsed->sub_device == 0x0102);
    CHECK(parsed->command == RdmCommand::kSet);
    CHECK(parsed->parameter == 0x00F0);
    CHECK(parsed->data == data);
  }
}

TEST_CASE("Wireshark decodes our RDM to the same fields, checksum included") {
  const auto set = dissect(message_of({0x00, 0x11}),
                           {"rdm.dst", "rdm.src", "rdm.tn", "rdm.port_id", "rdm.sd", "rdm.cc", "rdm.pid", "rdm.pdl",
                            "rdm.pd.dmx_start_address", "rdm.checksum.status", "_ws.malformed"});
  if (!set) return;
  CHECK(set->at("rdm.dst") == "02b000012345");
  CHECK(set->at("rdm.src") == "7ff0aabbccdd");
  CHECK(set->at("rdm.tn") == "200");
  CHECK(set->at("rdm.port_id") == "1");
  CHECK(set->at("rdm.sd") == "258");
  CHECK(set->at("rdm.cc") == "0x30");
  CHECK(set->at("rdm.pid") == "0x00f0");
  CHECK(set->at("rdm.pd.dmx_start_address") == "17");
  CHECK(set->at("rdm.checksum.status") == "1");
  CHECK(set->at("_ws.malformed") == "");
}

TEST_CASE("each broken part of an RDM message is refused for its own reason, and so is every short one") {
  const Octets good = build_rdm(message_of({1, 2, 3}));
  const auto fault_with = [&](std::size_t at, std::uint8_t value) {
    Octets bad = good;
    bad[at] = value;
    if (at > 1 && at < 24) {  // with a correct checksum, so that another fault is found
      unsigned sum = 0;
      for (std::size_t i = 0; i < 27; ++i) sum += bad[i];
      bad[27] = static_cast<std::uint8_t>(sum >> 8);
      bad[28] = static_cast<std::uint8_t>(sum);
    }
    const auto parsed = parse_rdm_message(bad);
    REQUIRE_FALSE(parsed.has_value());
    return parsed.error();
  };
  CHECK(fault_with(0, 0x00) == RdmFault::kStartCode);
  CHECK(fault_with(1, 0x02) == RdmFault::kStartCode);
  CHECK(fault_with(2, 28) == RdmFault::kLength);
  CHECK(fault_with(23, 2) == RdmFault::kLength);
  CHECK(fault_with(20, 0x40) == RdmFault::kCommand);
  CHECK(fault_with(25, 9) == RdmFault::kChecksum);
  CHECK(fault_with(28, good[28] ^ 1) == RdmFault::kChecksum);
  for (std::size_t size = 0; size < good.size(); ++size) {
    CHECK_FALSE(parse_rdm_message(std::span(good).first(size)).has_value());
  }
  Octets response = build_rdm([] {
    RdmMessage message = message_of({});
    message.command = RdmCommand::kGetResponse;
    message.port_or_type = 4;
    return message;
  }());
  CHECK(parse_rdm_message(response).error() == RdmFault::kResponseType);
}

TEST_CASE("UIDs parse to the same value, and other text is refused") {
  CHECK(text_of(RdmUid{0x02B0, 0x12345}) == "02B0:00012345");
  CHECK(parse_rdm_uid("02b0:00012345").value() == RdmUid{0x02B0, 0x12345});
  CHECK(parse_rdm_uid("02B000012345").value() == RdmUid{0x02B0, 0x12345});
  CHECK(parse_rdm_uid("all").value() == kRdmEverybody);
  for (const char* const wrong : {"", "02B0", "02B0:0001234", "02B0:000123456", "02B0-00012345", "02G0:00012345",
                                  "02B0:0001234 ", "+2B0:00012345"}) {
    CAPTURE(wrong);
    CHECK_FALSE(parse_rdm_uid(wrong).has_value());
  }
}

TEST_CASE("an answer to discovery is recognised with any length of preamble, and not with one wrong bit") {
  std::mt19937_64 random(1);
  for (int i = 0; i < 200; ++i) {
    const RdmUid uid = RdmUid::of_number(random() & 0xFFFF'FFFF'FFFFu);
    const Octets answer = build_discovery_answer(uid, static_cast<std::size_t>(i % 8));
    CHECK(parse_discovery_answer(answer) == uid);
    Octets longer = answer;
    longer.push_back(0);  // a widget may receive some more
    CHECK(parse_discovery_answer(longer) == uid);
    for (std::size_t bit = 8 * static_cast<std::size_t>(i % 8); bit < 8 * answer.size(); ++bit) {
      Octets bad = answer;
      bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ 1u << bit % 8);
      CHECK(parse_discovery_answer(bad) != uid);
    }
    for (std::size_t size = 0; size < answer.size(); ++size) {
      CHECK_FALSE(parse_discovery_answer(std::span(answer).first(size)).has_value());
    }
  }
}

TEST_CASE("20000 damaged RDM messages crash nothing, and accepted ones have a correct checksum") {
  std::mt19937 random(3);
  const Octets good = build_rdm(message_of({1, 2, 3, 4, 5, 6, 7, 8}));
  int accepted = 0;
  for (int i = 0; i < 20'000; ++i) {
    Octets bytes = good;
    for (std::size_t f = 0; f < random() % 3; ++f) bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    if (random() % 4 == 0) bytes.resize(random() % 40);
    const Octets exact(bytes.begin(), bytes.end());
    const auto parsed = parse_rdm_message(exact);
    (void)parse_discovery_answer(exact);
    if (!parsed) continue;
    ++accepted;
    const Octets again = build_rdm(*parsed);
    REQUIRE(again.size() <= exact.size());
    CHECK(std::equal(again.begin(), again.end(), exact.begin()));
  }
  CHECK(accepted > 1'000);
  CHECK(accepted < 19'000);
}

}  // namespace footlight::drivers
