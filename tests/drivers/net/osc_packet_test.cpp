#include "drivers/net/osc_packet.h"

#include <doctest/doctest.h>

#include <random>
#include <string>

#include "drivers/net/bytes.h"

namespace footlight::drivers {
namespace {

using Bytes = std::vector<std::uint8_t>;
using namespace std::string_view_literals;

Bytes bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

Bytes built(std::string_view address, std::vector<std::int32_t> numbers) {
  Bytes out(256);
  out.resize(build_osc(address, numbers, out));
  return out;
}

Bytes bundle_of(const std::vector<Bytes>& elements) {
  Bytes bundle = bytes_of("#bundle\0\0\0\0\0\0\0\0\1"sv);
  for (const Bytes& element : elements) {
    bundle.resize(bundle.size() + 4);
    write_u32_be(bundle, bundle.size() - 4, static_cast<std::uint32_t>(element.size()));
    bundle.insert(bundle.end(), element.begin(), element.end());
  }
  return bundle;
}

std::optional<OscFault> fault_of(const Bytes& packet) {
  std::vector<OscMessage> messages;
  const auto parsed = parse_osc(packet, messages);
  CHECK((parsed || messages.empty()));
  return parsed ? std::nullopt : std::optional(parsed.error());
}

}  // namespace

TEST_CASE("a built OSC message has the octets of the OSC 1.0 examples' layout") {
  // As "/oscillator/4/frequency" in the specification's examples, with an integer.
  CHECK(built("/oscillator/4/frequency", {440}) == bytes_of("/oscillator/4/frequency\0,i\0\0\0\0\x01\xB8"sv));
  CHECK(built("/VRSL", {1, 255}) == bytes_of("/VRSL\0\0\0,ii\0\0\0\0\x01\0\0\0\xFF"sv));
}

TEST_CASE("a message that does not fit is not written") {
  Bytes small(15);
  const std::vector<std::int32_t> one = {1};
  CHECK(build_osc("/VRSL", one, small) == 0);
}

TEST_CASE("numbers of all types are read, and other arguments are skipped by their size") {
  std::vector<OscMessage> messages;
  const Bytes numbers = bytes_of(
      "/a\0\0,ifhdTF\0"
      "\xFF\xFF\xFF\xFE\x3F\x80\0\0\0\0\0\1\0\0\0\2\x40\x08\0\0\0\0\0\0"sv);
  REQUIRE(parse_osc(numbers, messages).has_value());
  REQUIRE(messages.size() == 1);
  CHECK(messages[0].all_numbers);
  const std::vector<double> got(messages[0].numbers.begin(), messages[0].numbers.begin() + 6);
  CHECK(got == std::vector<double>{-2.0, 1.0, 4294967298.0, 3.0, 1.0, 0.0});
  const Bytes mixed = bytes_of("/a\0\0,sbti\0\0\0one\0\0\0\0\5abcde\0\0\0\0\0\0\0\0\0\0\1\0\0\0\7"sv);
  messages.clear();
  REQUIRE(parse_osc(mixed, messages).has_value());
  CHECK_FALSE(messages[0].all_numbers);
}

TEST_CASE("bundles give their messages in order, to a depth of eight") {
  const Bytes a = built("/a", {1}), b = built("/b", {2}), c = built("/c", {3});
  std::vector<OscMessage> messages;
  const Bytes packet = bundle_of({a, bundle_of({b}), c});
  REQUIRE(parse_osc(packet, messages).has_value());
  REQUIRE(messages.size() == 3);
  CHECK(messages[0].address == "/a");
  CHECK(messages[1].address == "/b");
  CHECK(messages[2].numbers[0] == 3.0);
  Bytes deep = a;
  for (int i = 0; i < kOscNestingMax; ++i) deep = bundle_of({deep});
  CHECK(fault_of(deep) == std::nullopt);
  CHECK(fault_of(bundle_of({deep})) == OscFault::kNesting);
}

TEST_CASE("damaged packets are rejected as a whole, with their fault") {
  const Bytes good = built("/a", {1});
  CHECK(fault_of({}) == OscFault::kEmpty);
  CHECK(fault_of(bytes_of("a\0\0\0,\0\0\0"sv)) == OscFault::kAddress);
  CHECK(fault_of(bytes_of("/abc,i\0\0\0\0\0\1"sv)) == OscFault::kTypes);  // the address takes the tags
  CHECK(fault_of(bytes_of("/a\0x,i\0\0\0\0\0\1"sv)) == OscFault::kAddress);  // padded with something else
  CHECK(fault_of(bytes_of("/abc"sv)) == OscFault::kAddress);                 // not terminated
  CHECK(fault_of(bytes_of("/a\0\0"sv)) == OscFault::kTypes);
  CHECK(fault_of(bytes_of("/a\0\0i\0\0\0\0\0\0\1"sv)) == OscFault::kTypes);  // without the comma
  CHECK(fault_of(bytes_of("/a\0\0,x\0\0"sv)) == OscFault::kTypes);
  CHECK(fault_of(bytes_of("/a\0\0,i\0\0\0\0\0\1\0\0\0\2"sv)) == OscFault::kSize);  // more than its arguments
  CHECK(fault_of(bytes_of("/a\0\0,b\0\0\xFF\xFF\xFF\xFF"sv)) == OscFault::kSize);
  CHECK(fault_of(bytes_of("#bundle\0\0\0"sv)) == OscFault::kSize);
  CHECK(fault_of(bundle_of({good, bytes_of("/b\0\0,i\0\0"sv)})) == OscFault::kSize);
}

TEST_CASE("no truncated and no randomly damaged packet is read past its end") {
  const Bytes packet = bundle_of({built("/VRSL/ch12", {1, 2, 3}), bundle_of({built("/VRSL", {4, 5})})});
  for (std::size_t size = 1; size < packet.size(); ++size) {
    const Bytes cut(packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(size));  // of its size: ASan sees more
    const bool whole_elements = size == 16 || size == 16 + 4 + built("/VRSL/ch12", {1, 2, 3}).size();
    CHECK(fault_of(cut).has_value() == !whole_elements);
  }
  std::mt19937 random(1);  // NOLINT(bugprone-random-generator-seed)
  for (int round = 0; round < 5'000; ++round) {
    Bytes damaged = packet;
    for (int i = 0; i < 3; ++i) damaged[random() % damaged.size()] = static_cast<std::uint8_t>(random());
    (void)fault_of(damaged);
  }
}

}  // namespace footlight::drivers
