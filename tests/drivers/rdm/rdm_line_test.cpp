// Discovery and requests over a line of modelled responders, without a device in between.
#include "drivers/rdm/rdm_line.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include "drivers/mock/rdm_line_model.h"
#include "drivers/rdm/rdm_controller.h"
#include "drivers/rdm/rdm_parameters.h"
#include "tests/support/fake_clock.h"

namespace footlight::drivers {
namespace {

constexpr RdmUid kOwn{0x7FF0, 0x1000'0000};

class ModelWire final : public RdmWire {
 public:
  ModelWire() : RdmWire(kOwn) {}
  mock::RdmLineModel line;
  int noise = 0;  // the number of requests answered with noise

  mock::RdmResponderModel& add(std::uint64_t uid) {
    line.responders.emplace_back().uid = uid;
    return line.responders.back();
  }

 private:
  Result<Octets> exchange(std::span<const std::uint8_t> request) override {
    if (noise > 0) {
      --noise;
      return Octets{0xFE, 0xAA, 0x12, 0x34};
    }
    return line.answer(request);
  }
};

std::vector<std::uint64_t> uids_of(const Result<std::vector<RdmFound>>& found) {
  REQUIRE_MESSAGE(found.has_value(), (found ? std::string() : found.error().message));
  std::vector<std::uint64_t> uids;
  for (const RdmFound& one : *found) uids.push_back(one.uid.number());
  return uids;
}

std::vector<std::uint64_t> uids_on(const ModelWire& wire) {
  std::vector<std::uint64_t> uids;
  for (const auto& responder : wire.line.responders) uids.push_back(responder.uid);
  std::sort(uids.begin(), uids.end());
  return uids;
}

struct Desk {
  ModelWire wire;
  testing::FakeClock clock;
  RdmController controller{wire, clock, kOwn};

  mock::RdmResponderModel& spot() { return wire.line.responders[0]; }
  Result<Octets> get(std::uint16_t parameter, Octets argument = {}) {
    return controller.get(RdmUid::of_number(spot().uid), parameter, argument, name_of_rdm_parameter(parameter));
  }
  Result<Octets> set(std::uint16_t parameter, Octets data) {
    return controller.set(RdmUid::of_number(spot().uid), parameter, data, name_of_rdm_parameter(parameter));
  }
};

std::string text_of(const Result<Octets>& data) {
  REQUIRE_MESSAGE(data.has_value(), (data ? std::string() : data.error().message));
  return {data->begin(), data->end()};
}

}  // namespace

TEST_CASE("discovery of an empty line finds no responder in three requests") {
  ModelWire wire;
  CHECK(uids_of(wire.discover()).empty());
  CHECK(wire.discovery_requests() == 3);
}

TEST_CASE("every responder is found: alone, with consecutive, distant and random UIDs") {
  std::mt19937_64 random(1);
  const std::vector<std::vector<std::uint64_t>> lines = {
      {0x7FF0'0000'0001},
      {0, 0xFFFF'FFFF'FFFE},
      {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16},
      {0x02B0'0000'0000, 0x02B0'8000'0000, 0x02B1'0000'0000},
      [&] {
        std::vector<std::uint64_t> uids;
        for (int i = 0; i < 100; ++i) uids.push_back(random() % 0xFFFF'FFFF'FFFEu);
        return uids;
      }(),
  };
  for (const auto& uids : lines) {
    ModelWire wire;
    for (const std::uint64_t uid : uids) wire.add(uid).preamble = uid % 8;
    CHECK(uids_of(wire.discover()) == uids_on(wire));
    CHECK(wire.discovery_requests() <= 3 + 100 * uids.size());
    CHECK(uids_of(wire.discover()) == uids_on(wire));  // again, although they are muted
  }
}

TEST_CASE("a lost mute or a damaged answer is requested again") {
  ModelWire wire;
  wire.add(0x7FF0'0000'0001);
  wire.add(0x7FF0'0000'0002).damages = 2;
  CHECK(uids_of(wire.discover()) == uids_on(wire));
  ModelWire noisy;
  noisy.add(0x7FF0'0000'0001);
  noisy.add(0x7FF0'0000'0009);
  noisy.noise = 7;
  CHECK(uids_of(noisy.discover()) == uids_on(noisy));
}

TEST_CASE("responders that violate the rules do not hide the others, and discovery ends") {
  ModelWire wire;
  for (std::uint64_t uid = 1; uid <= 5; ++uid) wire.add(0x7FF0'0000'0000 + uid * 3);
  wire.line.responders[1].stays_unmuted = true;
  wire.line.responders[3].never_confirms_mute = true;
  const auto found = uids_of(wire.discover());
  for (const std::size_t i : {0u, 2u, 4u}) {
    CHECK(std::count(found.begin(), found.end(), wire.line.responders[i].uid) == 1);
  }
  CHECK(std::count(found.begin(), found.end(), wire.line.responders[1].uid) <= 1);
  CHECK(wire.discovery_requests() < 2'000);

  ModelWire hopeless;
  hopeless.noise = 1'000'000;
  const auto end = hopeless.discover();
  REQUIRE_FALSE(end.has_value());
  CHECK(end.error().message.find("discovery does not end") != std::string::npos);
}

TEST_CASE("two devices whose combined answers look like a third one are both found, and the third is not") {
  // Such pairs exist: the checksum covers the doubled octets only.
  std::mt19937_64 random(2);
  int phantoms = 0;
  for (int i = 0; i < 200'000 && phantoms < 5; ++i) {
    const std::uint64_t first = random() % 0xFFFF'FFFF'FFFEu, second = random() % 0xFFFF'FFFF'FFFEu;
    const Octets one = build_discovery_answer(RdmUid::of_number(first));
    const Octets two = build_discovery_answer(RdmUid::of_number(second));
    Octets both(one.size());
    for (std::size_t at = 0; at < one.size(); ++at) both[at] = one[at] & two[at];
    const auto phantom = parse_discovery_answer(both);
    if (!phantom || phantom->number() == first || phantom->number() == second) continue;
    ++phantoms;
    ModelWire wire;
    wire.add(first);
    wire.add(second);
    CHECK(uids_of(wire.discover()) == uids_on(wire));
  }
  CHECK(phantoms == 5);
}

TEST_CASE("a responder's answer to the mute is kept") {
  ModelWire wire;
  wire.add(1).control_field = 1;
  wire.add(2).control_field = 8;
  wire.add(3).control_field = 2 | 4;
  const auto found = wire.discover();
  REQUIRE(found.has_value());
  REQUIRE(found->size() == 3);
  CHECK((*found)[0].is_proxy);
  CHECK_FALSE((*found)[0].is_proxied);
  CHECK((*found)[1].is_proxied);
  CHECK((*found)[2].has_sub_devices);
  CHECK((*found)[2].is_boot_loader);
}

TEST_CASE("a parameter is read and set, and a broadcast reaches every responder without waiting") {
  Desk desk;
  desk.wire.add(0x7FF0'0000'0001);
  desk.wire.add(0x7FF0'0000'0002);
  CHECK(text_of(desk.get(kRdmDeviceLabel)) == "Spot");
  REQUIRE(desk.set(kRdmDeviceLabel, {'F', 'O', 'H'}).has_value());
  CHECK(desk.spot().label == "FOH");
  REQUIRE(desk.controller.set(kRdmEverybody, kRdmIdentifyDevice, Octets{1}, "IDENTIFY_DEVICE").has_value());
  for (const auto& responder : desk.wire.line.responders) CHECK(responder.identifies);
  const auto broadcast = desk.controller.get(kRdmEverybody, kRdmDeviceLabel, {}, "DEVICE_LABEL");
  REQUIRE_FALSE(broadcast.has_value());
  CHECK(broadcast.error().code == ErrorCode::kBadInput);
}

TEST_CASE("two lost answers are tolerated, a third is an error that names the device and the next step") {
  Desk desk;
  desk.wire.add(0x7FF0'0000'0001).ignores = 2;
  CHECK(text_of(desk.get(kRdmDeviceLabel)) == "Spot");
  desk.spot().ignores = 3;
  const auto lost = desk.get(kRdmDeviceLabel);
  REQUIRE_FALSE(lost.has_value());
  CHECK(lost.error().code == ErrorCode::kTimeout);
  CHECK(lost.error().message.find("7FF0:00000001: DEVICE_LABEL: no answer") != std::string::npos);
  desk.spot().damages = 3;
  const auto damaged = desk.get(kRdmDeviceLabel);
  REQUIRE_FALSE(damaged.has_value());
  CHECK(damaged.error().message.find("checksum is wrong") != std::string::npos);
}

TEST_CASE("a refusal has a text, and its code matches the reason") {
  Desk desk;
  desk.wire.add(0x7FF0'0000'0001).label_is_locked = true;
  struct Case {
    Result<Octets> answer;
    ErrorCode code;
    const char* words;
  };
  for (const Case& c : {Case{desk.set(kRdmDeviceLabel, {'x'}), ErrorCode::kPermission, "write protect"},
                        Case{desk.set(kRdmDmxStartAddress, {2, 1}), ErrorCode::kBadInput, "data out of range"},
                        Case{desk.set(kRdmDmxStartAddress, {2}), ErrorCode::kBadInput, "format error"},
                        Case{desk.set(kRdmDeviceInfo, {}), ErrorCode::kUnsupported, "unsupported command class"},
                        Case{desk.get(0x0400), ErrorCode::kUnsupported, "unknown parameter"}}) {
    REQUIRE_FALSE(c.answer.has_value());
    CHECK(c.answer.error().code == c.code);
    CHECK(c.answer.error().message.find(c.words) != std::string::npos);
  }
  CHECK(desk.spot().start_address == 1);
}

TEST_CASE("a responder that requests time gets it, and its answer is fetched from its queue") {
  Desk desk;
  desk.wire.add(0x7FF0'0000'0001).ack_timer_units = 5;
  const TimeNs before_ns = desk.clock.now_ns();
  CHECK(text_of(desk.get(kRdmDeviceLabel)) == "Spot");
  CHECK(desk.clock.now_ns() - before_ns == 500 * kNsPerMs);
  desk.spot().keeps_queue = false;  // then the request is repeated
  CHECK(text_of(desk.get(kRdmDeviceLabel)) == "Spot");
  desk.spot().keeps_queue = true;
  desk.spot().ack_timer_units = 200;
  const auto late = desk.get(kRdmDeviceLabel);
  REQUIRE_FALSE(late.has_value());
  CHECK(late.error().code == ErrorCode::kTimeout);
  CHECK(late.error().message.find("requested time") != std::string::npos);
}

TEST_CASE("an answer in parts is assembled") {
  Desk desk;
  desk.wire.add(0x7FF0'0000'0001);
  const Octets whole = desk.get(kRdmSupportedParameters).value();
  REQUIRE(whole.size() == 18);
  for (const std::size_t size : {1u, 4u, 17u, 18u}) {
    desk.spot().answer_size_max = size;
    CHECK(desk.get(kRdmSupportedParameters).value() == whole);
  }
}

TEST_CASE("an answer of another device, or to another request, is ignored") {
  class Liar final : public RdmWire {
   public:
    Liar() : RdmWire(kOwn) {}
    std::function<void(RdmMessage&)> spoil;

   private:
    Result<Octets> exchange(std::span<const std::uint8_t> request) override {
      RdmMessage message = parse_rdm(request).value();
      std::swap(message.to, message.from);
      message.command = response_to(message.command);
      message.port_or_type = 0;
      spoil(message);
      return build_rdm(message);
    }
  } liar;
  RdmMessage request;
  request.to = {1, 1};
  request.from = kOwn;
  const std::vector<std::pair<std::function<void(RdmMessage&)>, bool>> cases = {
      {[](RdmMessage&) {}, true},
      {[](RdmMessage& message) { message.from.device = 2; }, false},
      {[](RdmMessage& message) { message.to.device = 2; }, false},
      {[](RdmMessage& message) { ++message.transaction; }, false},
      {[](RdmMessage& message) { message.command = RdmCommand::kSetResponse; }, false}};
  for (const auto& [spoil, taken] : cases) {
    liar.spoil = spoil;
    CHECK(liar.transact(request).value().has_value() == taken);
  }
}

}  // namespace footlight::drivers
