// Sockets against each other, in a network namespace with nothing but "lo" in it.
#include "drivers/net/udp.h"

#include <doctest/doctest.h>

#include <array>
#include <cerrno>
#include <vector>

#include "tests/drivers/net/private_network.h"

namespace footlight::drivers {
namespace {

constexpr std::uint16_t kPort = 6454;
constexpr std::uint32_t kThisMachine = 0x7F000001, kEverybodyHere = 0x7FFFFFFF;

Fd must_open(Result<Fd> socket) {
  REQUIRE_MESSAGE(socket.has_value(), (socket ? std::string() : socket.error().message));
  return std::move(*socket);
}

void send(const Fd& from, std::uint32_t ipv4, std::vector<std::uint8_t> bytes) {
  DatagramWriter writer;
  writer.add(bytes, ipv4, kPort);
  REQUIRE(writer.flush(from.get()).error_number == 0);
}

}  // namespace

TEST_CASE("a yielding sender takes unicast only where no other socket listens, and hears every broadcast") {
  if (!testing::enter_private_network()) return;
  const Fd yielding = must_open(open_yielding_sender({"test", 0}, kPort, {}));
  const Fd other = must_open(open_sender({"test", 0}));
  DatagramReader reader;
  for (int i = 0; i < 8; ++i) send(other, kThisMachine, {1});
  CHECK(reader.read(yielding.get()) == 8);
  ReceiverSocket wanted;
  wanted.port_name = "test";
  wanted.udp_port = kPort;
  for (const bool listener_is_older : {false, true}) {
    CAPTURE(listener_is_older);
    Fd listener = must_open(open_receiver(wanted));
    const Fd second = listener_is_older ? must_open(open_yielding_sender({"test", 0}, kPort, {})) : Fd();
    for (int i = 0; i < 8; ++i) {
      const Fd stranger = must_open(open_sender({"test", 0}));  // a UDP port of its own: another hash
      send(stranger, kThisMachine, {2});
    }
    CHECK(reader.read(listener.get()) == 8);
    CHECK(reader.read(yielding.get()) == 0);
    send(other, kEverybodyHere, {3});
    CHECK(reader.read(listener.get()) == 1);
    CHECK(reader.read(yielding.get()) == 1);
  }
}

TEST_CASE("a yielding sender sends from the port that it names, and knows who wrote and where it arrived") {
  if (!testing::enter_private_network()) return;
  const Fd yielding = must_open(open_yielding_sender({"test", 0}, kPort, {}));
  send(yielding, kThisMachine, {7});
  DatagramReader reader;
  REQUIRE(reader.read(yielding.get()) == 1);
  CHECK(reader[0].from_ipv4 == kThisMachine);
  CHECK(reader[0].from_udp_port == kPort);
  CHECK(reader[0].local_ipv4 == kThisMachine);
  CHECK(reader[0].interface_index == 1);
}

TEST_CASE("a yielding sender with a filter hears only the numbers that it names") {
  if (!testing::enter_private_network()) return;
  const std::array<std::uint16_t, 2> wanted = {0x2100, 0x8134};
  const Fd yielding = must_open(open_yielding_sender({"test", 0}, kPort, wanted));
  const Fd other = must_open(open_sender({"test", 0}));
  for (const int number : {0x2100, 0x0021, 0x5000, 0x8134, 0x2101}) {
    send(other, kThisMachine,
         {1, 2, 3, 4, 5, 6, 7, 8, static_cast<std::uint8_t>(number & 0xFF), static_cast<std::uint8_t>(number >> 8)});
  }
  send(other, kThisMachine, {1, 2, 3});
  DatagramReader reader;
  REQUIRE(reader.read(yielding.get()) == 2);
  CHECK(reader[0].bytes[9] == 0x21);
  CHECK(reader[1].bytes[9] == 0x81);
}

TEST_CASE("one receiver out of reach does not keep datagrams from the others") {
  if (!testing::enter_private_network()) return;
  const Fd sender = must_open(open_sender({"test", 0}));
  const std::vector<std::uint8_t> bytes = {1};
  DatagramWriter writer;
  writer.add(bytes, 0x0A000001, kPort);  // no route
  writer.add(bytes, kThisMachine, kPort);
  writer.add(bytes, 0x0A000002, kPort);
  std::vector<int> error_numbers;
  writer.flush_each(sender.get(), error_numbers);
  CHECK(error_numbers == std::vector<int>{ENETUNREACH, 0, ENETUNREACH});
  writer.flush_each(sender.get(), error_numbers);
  CHECK(error_numbers.empty());
}

}  // namespace footlight::drivers
