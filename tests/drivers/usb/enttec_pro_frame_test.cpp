#include "drivers/widgets/enttec_pro_frame.h"

#include <doctest/doctest.h>

#include "drivers/transport/ftdi.h"
#include "tests/support/usb_pro_property.h"

namespace footlight::drivers {
namespace {

using Bytes = std::vector<std::uint8_t>;
using testing::parse_pieces;
using testing::ProMessages;

Bytes bytes_of(const ProMessage& message) { return {message.bytes().begin(), message.bytes().end()}; }

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

ProMessages parse(const Bytes& stream) {
  return parse_pieces(stream, [] { return std::size_t{1} << 20; }).messages;
}

TEST_CASE("an encoded request has the bytes of the specification") {
  CHECK(bytes_of(encode_get_serial()) == Bytes{0x7E, 10, 0, 0, 0xE7});
  CHECK(bytes_of(encode_get_params(508)) == Bytes{0x7E, 3, 2, 0, 0xFC, 0x01, 0xE7});
  CHECK(bytes_of(encode_receive_mode(ProReceiveMode::kOnChange)) == Bytes{0x7E, 8, 1, 0, 1, 0xE7});
}

TEST_CASE("a frame to send always carries the start code and 512 slots") {
  const Bytes message = bytes_of(encode_send_dmx(Bytes{1, 2, 3}));
  REQUIRE(message.size() == 518);
  CHECK(Bytes(message.begin(), message.begin() + 8) == Bytes{0x7E, 6, 0x01, 0x02, 0, 1, 2, 3});
  CHECK(message[8] == 0);
  CHECK(message.back() == 0xE7);
}

TEST_CASE("a message with start and end bytes in its payload parses as one") {
  const Bytes slots(512, 0x7E);
  Bytes mixed(512, 0xE7);
  mixed[100] = 0x7E;
  const ProMessages messages = parse(bytes_of(encode_send_dmx(slots)) + bytes_of(encode_send_dmx(mixed)));
  REQUIRE(messages.size() == 2);
  CHECK(messages[0].second == Bytes{0} + slots);
  CHECK(messages[1].second == Bytes{0} + mixed);
}

TEST_CASE("a stream cut at any byte parses the same") {
  const Bytes stream = Bytes{0x00, 0xE7, 0x7E, 0x05} + bytes_of(encode_get_serial()) + Bytes{0x7E, 9, 0xFF, 0xFF} +
                       bytes_of(encode_send_dmx(Bytes(512, 0xE7))) + Bytes{0x55} + bytes_of(encode_get_params());
  const testing::ProParse whole = testing::parse_whole(stream);
  REQUIRE(whole.messages.size() == 3);
  for (std::size_t cut = 1; cut < stream.size(); ++cut) {
    std::size_t call = 0;
    const auto cut_once = parse_pieces(stream, [&] { return call++ == 0 ? cut : stream.size(); });
    CHECK_MESSAGE(cut_once.messages == whole.messages, "cut after byte ", cut);
    CHECK(cut_once.garbage_byte_count == whole.garbage_byte_count);
  }
  CHECK(parse_pieces(stream, [] { return std::size_t{1}; }).messages == whole.messages);
}

TEST_CASE("a length above 600 costs only its start byte") {
  // The false header runs into a true message: label 5, length bytes 7E 0A.
  CHECK(parse(Bytes{0x7E, 5} + bytes_of(encode_get_serial())) == ProMessages{{10, {}}});
  CHECK(parse(Bytes{0x7E, 5, 0x59, 0x02} + bytes_of(encode_get_serial())) == ProMessages{{10, {}}});
}

TEST_CASE("a message of 600 bytes is accepted and one of 601 is not") {
  const Bytes payload(600, 0x11);
  CHECK(parse(bytes_of(ProMessage(static_cast<ProLabel>(77), payload))) == ProMessages{{77, payload}});
  CHECK(parse(Bytes{0x7E, 77, 0x59, 0x02} + Bytes(601, 0x11) + Bytes{0xE7}).empty());
}

TEST_CASE("messages inside a message without its end byte are found") {
  Bytes broken = Bytes{0x7E, 5, 20, 0} + bytes_of(encode_get_serial()) + bytes_of(encode_get_params()) + Bytes(30, 0);
  CHECK(parse(broken) == ProMessages{{10, {}}, {3, {0, 0}}});
}

TEST_CASE("bytes outside messages are counted as garbage") {
  ProParser parser;
  const Bytes stream = Bytes{1, 2, 3} + bytes_of(encode_get_serial()) + Bytes{0xE7, 0xE7};
  std::span<const std::uint8_t> rest = stream;
  ProMessageView message;
  CHECK(parser.next(rest, message));
  CHECK_FALSE(parser.next(rest, message));
  CHECK(parser.garbage_byte_count() == 5);
  CHECK(parser.message_count() == 1);
  CHECK(parser.rejected_count() == 0);
}

TEST_CASE("abandoning an endless message finds the messages after its start") {
  ProParser parser;
  const Bytes stream = Bytes{0x7E, 5, 0x02, 0x02, 0} + bytes_of(encode_get_serial());
  std::span<const std::uint8_t> rest = stream;
  ProMessageView message;
  CHECK_FALSE(parser.next(rest, message));
  CHECK(parser.pending());
  parser.abandon();
  REQUIRE(parser.next(rest, message));
  CHECK(message.label == 10);
  CHECK_FALSE(parser.pending());
}

TEST_CASE("after a flush no message is unfinished, whatever came before") {
  for (std::size_t length = 0; length <= 600; length += 100) {
    ProParser parser;
    const Bytes begun{0x7E, 6, static_cast<std::uint8_t>(length & 0xFF), static_cast<std::uint8_t>(length >> 8)};
    std::span<const std::uint8_t> rest = begun;
    ProMessageView message;
    CHECK_FALSE(parser.next(rest, message));
    rest = pro_flush_bytes();
    CHECK_FALSE(parser.next(rest, message));
    CHECK_FALSE(parser.pending());
  }
}

TEST_CASE("parameters are unchanged after encoding and decoding") {
  const ProParams params{.firmware = 0x0144, .break_units = 17, .mab_units = 2, .rate_hz = 30};
  const auto message = encode_set_params(params, Bytes{9, 8, 7});
  REQUIRE(message);
  CHECK(bytes_of(*message) == Bytes{0x7E, 4, 8, 0, 3, 0, 17, 2, 30, 9, 8, 7, 0xE7});
  const auto decoded = decode_params(Bytes{0x44, 0x01, 17, 2, 30});
  REQUIRE(decoded);
  CHECK(decoded->firmware == 0x0144);
  CHECK(decoded->break_units == 17);
  CHECK(decoded->mab_units == 2);
  CHECK(decoded->rate_hz == 30);
  CHECK(us_of_pro_units(9) == doctest::Approx(96.0));
}

TEST_CASE("parameters that no widget accepts are refused with their range") {
  CHECK(encode_set_params({.break_units = 8}).error().message.find("9 to 127") != std::string::npos);
  CHECK(encode_set_params({.break_units = 128}).error().code == ErrorCode::kBadInput);
  CHECK_FALSE(encode_set_params({.mab_units = 0}));
  CHECK_FALSE(encode_set_params({.rate_hz = 41}));
  CHECK(encode_set_params({.rate_hz = 0}));
  CHECK_FALSE(encode_set_params({}, Bytes(509)));
  CHECK(encode_set_params({}, Bytes(508)));
  CHECK(decode_params(Bytes{1, 2, 3, 4}).error().code == ErrorCode::kProtocol);
}

TEST_CASE("a received frame has its line errors separate from its slots") {
  const Bytes payload{2, 0, 10, 20};
  const auto received = decode_received(payload);
  REQUIRE(received);
  CHECK(received->overrun);
  CHECK_FALSE(received->queue_overflow);
  CHECK(Bytes(received->frame.begin(), received->frame.end()) == Bytes{0, 10, 20});
  CHECK(decode_received(Bytes(514)));
  CHECK_FALSE(decode_received(Bytes(515)));
  CHECK_FALSE(decode_received(Bytes{0}));
}

TEST_CASE("a change of state sets the addresses of its bits") {
  LineFrame frame{};
  frame[6] = 99;
  const auto count = apply_change_of_state(Bytes{0x00, 0x38, 0, 0, 0, 0, 0x16, 0x5D, 0x90}, frame);
  REQUIRE(count);
  CHECK(*count == 3);
  CHECK(frame[3] == 0x16);  // byte n of the frame is address n
  CHECK(frame[4] == 0x5D);
  CHECK(frame[5] == 0x90);
  CHECK(frame[6] == 99);
  CHECK(frame[2] == 0);
}

TEST_CASE("a change of state reaches address 512 and not beyond") {
  LineFrame frame{};
  CHECK(apply_change_of_state(Bytes{64, 0x01, 0, 0, 0, 0, 7}, frame));
  CHECK(frame[512] == 7);
  const LineFrame before = frame;
  CHECK_FALSE(apply_change_of_state(Bytes{64, 0x03, 0, 0, 0, 0, 7, 8}, frame));
  CHECK_FALSE(apply_change_of_state(Bytes{255, 0, 0, 0, 0, 0x80, 1}, frame));
  CHECK(frame == before);
}

TEST_CASE("a change of state with too many or too few values changes nothing") {
  LineFrame frame{};
  const LineFrame before = frame;
  CHECK_FALSE(apply_change_of_state(Bytes{0, 0x38, 0, 0, 0, 0, 1, 2}, frame));
  CHECK_FALSE(apply_change_of_state(Bytes{0, 0x38, 0, 0, 0, 0, 1, 2, 3, 4}, frame));
  CHECK_FALSE(apply_change_of_state(Bytes{0, 0x38, 0, 0, 0}, frame));
  CHECK(frame == before);
}

TEST_CASE("a serial number is read as decimal digits, lowest first") {
  CHECK(decode_serial(Bytes{0x89, 0x25, 0x17, 0x02}).value_or(0) == 2172589);
  CHECK(decode_serial(Bytes{0x99, 0x99, 0x99, 0x99}).value_or(0) == 99999999);
  CHECK(decode_serial(Bytes{0xFF, 0xFF, 0xFF, 0xFF}).error().code == ErrorCode::kProtocol);
  CHECK_FALSE(decode_serial(Bytes{1, 2, 3}));
}

TEST_CASE("receive mode and frames to send decode to the encoded values") {
  CHECK(decode_receive_mode(Bytes{1}).value_or(ProReceiveMode::kEveryFrame) == ProReceiveMode::kOnChange);
  CHECK_FALSE(decode_receive_mode(Bytes{2}));
  CHECK_FALSE(decode_receive_mode(Bytes{}));
  CHECK(decode_send_dmx(Bytes(25)));
  CHECK_FALSE(decode_send_dmx(Bytes(24)));
  CHECK_FALSE(decode_send_dmx(Bytes(514)));
}

TEST_CASE("status bytes are removed from every packet of a transfer, and no other byte") {
  Bytes transfer;
  for (int i = 0; i < 64 + 64 + 5; ++i) transfer.push_back(static_cast<std::uint8_t>(i % 64 < 2 ? 0xAA : i));
  transfer.resize(ftdi::strip_status(transfer, ftdi::kFullSpeedPacketSize));
  CHECK(transfer.size() == 62 + 62 + 3);
  CHECK(std::count(transfer.begin(), transfer.end(), 0xAA) == 0);
  CHECK(transfer[62] == 66);

  Bytes empty{0x01, 0x60};
  CHECK(ftdi::strip_status(empty, 64) == 0);
  Bytes torn{0x01};
  CHECK(ftdi::strip_status(torn, 64) == 0);
  CHECK(ftdi::strip_status({}, 64) == 0);
}

// Goal: no input breaks the parser. Method: valid streams with bytes changed, dropped, duplicated and removed, the same
// on every run; the properties are those of the fuzz target.
TEST_CASE("20000 damaged streams parse as defined and leave the next message intact") {
  const Bytes good = bytes_of(ProMessage(ProLabel::kReceived, Bytes(514, 0x7E))) + bytes_of(encode_get_serial()) +
                     bytes_of(ProMessage(ProLabel::kChangeOfState, Bytes{0, 0x38, 0, 0, 0, 0, 1, 2, 3})) +
                     bytes_of(*encode_set_params({})) + bytes_of(encode_send_dmx(Bytes(512, 0xE7)));
  std::uint64_t state = 1;
  const auto random = [&](std::size_t below) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::size_t>(state >> 33) % below;
  };
  for (int round = 0; round < 20'000; ++round) {
    Bytes stream = good;
    for (std::size_t mutation = 0, count = 1 + random(8); mutation < count && !stream.empty(); ++mutation) {
      const std::size_t at = random(stream.size());
      const auto place = stream.begin() + static_cast<std::ptrdiff_t>(at);
      constexpr std::uint8_t kTelling[] = {0x7E, 0xE7, 0x00, 0xFF, 0x02, 0x58};
      switch (random(5)) {
        case 0: *place = static_cast<std::uint8_t>(random(256)); break;
        case 1: *place = kTelling[random(std::size(kTelling))]; break;
        case 2: stream.erase(place); break;
        case 3: stream.insert(place, kTelling[random(std::size(kTelling))]); break;
        case 4: stream.erase(place, place + static_cast<std::ptrdiff_t>(random(stream.size() - at))); break;
      }
    }
    const std::string broken = testing::check_pro_stream(stream, state);
    REQUIRE_MESSAGE(broken.empty(), "round ", round, ": ", broken);
  }
}

}  // namespace
}  // namespace footlight::drivers
