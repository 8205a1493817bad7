#include "drivers/net/mvr_xchange_packet.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "drivers/net/bytes.h"

namespace footlight::drivers {
namespace {

using Octets = std::vector<std::uint8_t>;

class Collector final : public MvrPacketReceiver {
 public:
  Status receive_json(std::string_view text) override {
    jsons.emplace_back(text);
    return {};
  }
  Status receive_file_part(std::span<const std::uint8_t> bytes, std::uint64_t total) override {
    CHECK(!bytes.empty());
    part.insert(part.end(), bytes.begin(), bytes.end());
    total_bytes = total;
    return {};
  }
  Status receive_file_end() override {
    files.push_back(std::exchange(part, {}));
    return {};
  }
  std::vector<std::string> jsons;
  std::vector<Octets> files;
  Octets part;
  std::uint64_t total_bytes = 0;
};

Octets packet(const MvrPacketHeader& header, const Octets& payload) {
  const auto head = build_mvr_header(header);
  Octets bytes(head.begin(), head.end());
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  return bytes;
}

Octets octets_of(std::string_view text) { return {text.begin(), text.end()}; }

void append(Octets& bytes, const Octets& more) { bytes.insert(bytes.end(), more.begin(), more.end()); }

// A file in three packets, of 3, 0 and 2 octets.
Octets file_in_three() {
  Octets bytes = packet({0, 3, MvrPayload::kFile, 3}, {1, 2, 3});
  append(bytes, packet({1, 3, MvrPayload::kFile, 0}, {}));
  append(bytes, packet({2, 3, MvrPayload::kFile, 2}, {4, 5}));
  return bytes;
}

TEST_CASE("a header has the layout of the specification, big-endian") {
  const auto bytes = build_mvr_header({2, 7, MvrPayload::kFile, 0x0000'0001'0203'0405});
  const Octets expected = {0, 0x0B, 0xE1, 0xBA, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 7, 0, 0, 0, 1, 0, 0, 0, 1, 2, 3, 4, 5};
  CHECK(Octets(bytes.begin(), bytes.end()) == expected);
  CHECK(!parse_mvr_header(bytes));  // 4 GiB: more than is taken
  const MvrPacketHeader small{2, 7, MvrPayload::kFile, 0x0203'0405};
  CHECK(parse_mvr_header(build_mvr_header(small)) == small);
}

TEST_CASE("a JSON text is read from one packet and from several, wherever the stream is cut") {
  const std::string one = build_mvr_json("{\"a\":1}");
  Octets stream(one.begin(), one.end());
  append(stream, packet({0, 2, MvrPayload::kJson, 3}, octets_of("{\"b")));
  append(stream, packet({1, 2, MvrPayload::kJson, 4}, octets_of("\":2}")));
  append(stream, file_in_three());
  append(stream, packet({0, 1, MvrPayload::kJson, 0}, {}));
  for (std::size_t cut = 1; cut <= stream.size(); ++cut) {
    CAPTURE(cut);
    MvrPacketReader reader;
    Collector got;
    for (std::size_t at = 0; at < stream.size(); at += cut) {
      REQUIRE(reader.read(std::span(stream).subspan(at, std::min(cut, stream.size() - at)), got));
    }
    CHECK(got.jsons == std::vector<std::string>{"{\"a\":1}", "{\"b\":2}", ""});
    CHECK(got.files == std::vector<Octets>{{1, 2, 3, 4, 5}});
    CHECK(got.total_bytes == 5);
    CHECK(reader.between_messages());
  }
}

TEST_CASE("no prefix of a stream is taken for the whole") {
  const Octets stream = file_in_three();
  for (std::size_t size = 0; size < stream.size(); ++size) {
    CAPTURE(size);
    MvrPacketReader reader;
    Collector got;
    REQUIRE(reader.read(std::span(stream).first(size), got));
    CHECK(got.files.empty());
    CHECK(reader.between_messages() == (size == 0));
  }
}

TEST_CASE("a header with another mark, version, kind, number or size is refused") {
  const auto good = build_mvr_header({0, 1, MvrPayload::kJson, 2});
  REQUIRE(parse_mvr_header(good));
  const auto refused = [&](std::size_t at, std::uint32_t value) {
    auto bytes = good;
    write_u32_be(bytes, at, value);
    const auto parsed = parse_mvr_header(bytes);
    return !parsed && parsed.error().code == ErrorCode::kProtocol;
  };
  CHECK(refused(0, 0x4745'5420));          // "GET "
  CHECK(refused(4, 2));                    // version
  CHECK(refused(8, 1));                    // number 1 of 1
  CHECK(refused(12, 0));                   // of none
  CHECK(refused(12, kMvrPacketsMax + 1));  // of too many
  CHECK(refused(16, 2));                   // kind
  CHECK(refused(20, 0xFFFF'FFFF));         // length
  CHECK(refused(24, kMvrJsonBytesMax + 1));
  CHECK(!refused(24, kMvrJsonBytesMax));
}

TEST_CASE("packets out of order, of another kind or of another count are refused") {
  const auto refused = [](const MvrPacketHeader& first, const MvrPacketHeader& second) {
    Octets bytes = packet(first, {1});
    append(bytes, packet(second, {2}));
    MvrPacketReader reader;
    Collector got;
    const Status read = reader.read(bytes, got);
    return !read && read.error().code == ErrorCode::kProtocol;
  };
  const MvrPacketHeader first{0, 3, MvrPayload::kFile, 1};
  CHECK(!refused(first, {1, 3, MvrPayload::kFile, 1}));
  CHECK(refused(first, {2, 3, MvrPayload::kFile, 1}));
  CHECK(refused(first, {0, 3, MvrPayload::kFile, 1}));
  CHECK(refused(first, {1, 4, MvrPayload::kFile, 1}));
  CHECK(refused(first, {1, 3, MvrPayload::kJson, 1}));
  CHECK(refused({1, 3, MvrPayload::kFile, 1}, {2, 3, MvrPayload::kFile, 1}));  // a message begins with packet 0
}

TEST_CASE("a message whose packets are too long together is refused before they arrive") {
  MvrPacketReader reader;
  Collector got;
  const Octets half(kMvrJsonBytesMax / 2 + 1, '1');
  REQUIRE(reader.read(packet({0, 2, MvrPayload::kJson, half.size()}, half), got));
  CHECK(!reader.read(packet({1, 2, MvrPayload::kJson, half.size()}, {}), got));
  CHECK(got.jsons.empty());
}

}  // namespace
}  // namespace footlight::drivers
