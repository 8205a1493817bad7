// RDM over Art-Net: packets, and a controller with a gateway made of a bare socket and a modelled line.
#include "drivers/net/artnet_rdm.h"

#include <doctest/doctest.h>

#include <random>
#include <stop_token>
#include <thread>

#include "drivers/mock/rdm_line_model.h"
#include "drivers/rdm/rdm_controller.h"
#include "drivers/rdm/rdm_parameters.h"
#include "sim/system_clock.h"
#include "tests/drivers/net/port_helpers.h"
#include "tests/drivers/net/private_network.h"
#include "tests/drivers/net/tshark.h"

namespace footlight::drivers {
namespace {

constexpr std::uint32_t kGatewayIpv4 = 0x7F00'0002;
constexpr int kPortAddress = 0x0123;
constexpr RdmUid kOwn{0x7FF0, 0x1000'0000};

// Answers like a gateway, on its own thread.
class Gateway {
 public:
  mock::RdmLineModel line = mock::example_rdm_line();
  bool table_is_empty = false;  // until a search is requested
  bool is_mute = false;

  Gateway() : socket_(testing::stranger(kGatewayIpv4, kArtnetPort)) { REQUIRE(socket_); }
  void start() {
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }

 private:
  void run(const std::stop_token& stop) {
    DatagramReader reader;
    while (!stop.stop_requested()) {
      pollfd waiting = {socket_.get(), POLLIN, 0};
      (void)::poll(&waiting, 1, 20);
      const int count = reader.read(socket_.get());
      for (int i = 0; i < count; ++i) {
        const Datagram& datagram = reader[static_cast<std::size_t>(i)];
        const auto packet = parse_artnet_rdm_packet(datagram.bytes);
        if (packet && !is_mute) obey(*packet, datagram);
      }
    }
  }
  void obey(const ArtnetRdmPacket& packet, const Datagram& datagram) {
    if (const auto* control = std::get_if<ArtnetTodControl>(&packet)) {
      if (control->flush) table_is_empty = false;
      send_table(datagram);
    } else if (std::holds_alternative<ArtnetTodRequest>(packet)) {
      send_table(datagram);
    } else if (const auto* rdm = std::get_if<ArtnetRdm>(&packet)) {
      const Octets answer = line.answer(rdm->message);
      if (!answer.empty()) send(ArtnetRdm{kPortAddress, answer}, datagram);
    }
  }
  // In blocks of two, so that there are several.
  void send_table(const Datagram& datagram) {
    const std::size_t total = table_is_empty ? 0 : line.responders.size();
    for (std::size_t first = 0; first == 0 || first < total; first += 2) {
      ArtnetTodData data;
      data.port_address = kPortAddress;
      data.total = static_cast<std::uint16_t>(total);
      data.block = static_cast<std::uint8_t>(first / 2);
      for (std::size_t i = first; i < std::min(first + 2, total); ++i) {
        data.uids.push_back(RdmUid::of_number(line.responders[i].uid));
      }
      send(data, datagram);
    }
  }
  void send(const ArtnetRdmPacket& packet, const Datagram& datagram) {
    (void)testing::send_bytes(socket_, datagram.from_ipv4, datagram.from_udp_port, build_artnet_rdm_packet(packet));
  }

  Fd socket_;
  std::jthread thread_;
};

std::unique_ptr<ArtnetRdmLine> open_line(Clock& clock, DurationNs answer_timeout_ns = 30 * kNsPerS) {
  ArtnetRdmLine::Options options;
  options.name = "artnet:292@127.0.0.2";
  options.gateway = kGatewayIpv4;
  options.udp_port = kArtnetPort;
  options.port_address = kPortAddress;
  options.answer_timeout_ns = answer_timeout_ns;
  auto line = ArtnetRdmLine::open(options, clock);
  REQUIRE_MESSAGE(line, (line ? "" : line.error().message));
  return std::move(*line);
}

}  // namespace

TEST_CASE("Wireshark decodes our packets of RDM over Art-Net to the same fields") {
  ArtnetTodRequest request;
  request.port_addresses = {0x0123, 0x0145};
  const auto request_fields =
      testing::dissect(build_artnet_rdm_packet(request), kArtnetPort,
                       {"artnet.header.opcode", "artnet.tod_request.net", "artnet.tod_request.command",
                        "artnet.tod_request.ad_count", "artnet.tod_request.address", "_ws.malformed"});
  if (!request_fields) return;
  CHECK(request_fields->at("artnet.header.opcode") == "0x8000");
  CHECK(request_fields->at("artnet.tod_request.net") == "0x01");
  CHECK(request_fields->at("artnet.tod_request.command") == "0x00");
  CHECK(request_fields->at("artnet.tod_request.ad_count") == "2");
  CHECK(request_fields->at("artnet.tod_request.address").substr(0, 4) == "2345");
  CHECK(request_fields->at("_ws.malformed") == "");

  ArtnetTodData data;
  data.port_address = 0x0123;
  data.port = 1;
  data.total = 300;
  data.block = 1;
  data.uids = {{0x02B0, 1}, {0x7FF0, 0x12345678}};
  const auto table_fields =
      testing::dissect(build_artnet_rdm_packet(data), kArtnetPort,
                       {"artnet.header.opcode", "artnet.tod_data.port", "artnet.tod_data.net",
                        "artnet.tod_data.address", "artnet.tod_data.uid_total", "artnet.tod_data.block_count",
                        "artnet.tod_data.uid_count", "artnet.tod_data.tod", "_ws.malformed"});
  REQUIRE(table_fields.has_value());
  CHECK(table_fields->at("artnet.header.opcode") == "0x8100");
  CHECK(table_fields->at("artnet.tod_data.port") == "1");
  CHECK(table_fields->at("artnet.tod_data.net") == "0x01");
  CHECK(table_fields->at("artnet.tod_data.address") == "0x23");
  CHECK(table_fields->at("artnet.tod_data.uid_total") == "300");
  CHECK(table_fields->at("artnet.tod_data.block_count") == "1");
  CHECK(table_fields->at("artnet.tod_data.uid_count") == "2");
  CHECK(table_fields->at("artnet.tod_data.tod") == "02b000000001,7ff012345678");
  CHECK(table_fields->at("_ws.malformed") == "");

  const auto control = testing::dissect(build_artnet_rdm_packet(ArtnetTodControl{0x0123, true}), kArtnetPort,
                                        {"artnet.header.opcode", "artnet.tod_control.net", "artnet.tod_control.command",
                                         "artnet.tod_control.address", "_ws.malformed"});
  REQUIRE(control.has_value());
  CHECK(control->at("artnet.header.opcode") == "0x8200");
  CHECK(control->at("artnet.tod_control.net") == "0x01");
  CHECK(control->at("artnet.tod_control.command") == "0x01");
  CHECK(control->at("artnet.tod_control.address") == "0x23");
  CHECK(control->at("_ws.malformed") == "");

  RdmMessage message;
  message.to = {0x02B0, 1};
  message.from = kOwn;
  message.parameter = kRdmDeviceLabel;
  const auto rdm =
      testing::dissect(build_artnet_rdm_packet(ArtnetRdm{0x0123, build_rdm(message)}), kArtnetPort,
                       {"artnet.header.opcode", "artnet.rdm.net", "artnet.rdm.address", "artnet.rdm.command", "rdm.dst",
                        "rdm.pid", "rdm.checksum.status", "_ws.malformed"});
  REQUIRE(rdm.has_value());
  CHECK(rdm->at("artnet.header.opcode") == "0x8300");
  CHECK(rdm->at("artnet.rdm.net") == "0x01");
  CHECK(rdm->at("artnet.rdm.address") == "0x23");
  CHECK(rdm->at("artnet.rdm.command") == "0x00");
  CHECK(rdm->at("rdm.dst") == "02b000000001");
  CHECK(rdm->at("rdm.pid") == "0x0082");
  CHECK(rdm->at("rdm.checksum.status") == "1");
  CHECK(rdm->at("_ws.malformed") == "");
}

TEST_CASE("built packets of RDM over Art-Net parse to the same, and 20000 damaged ones crash nothing") {
  ArtnetTodData data;
  data.port_address = 0x7FFF;
  data.port = 4;
  data.bind_index = 9;
  data.available = false;
  data.total = 999;
  data.block = 3;
  for (std::uint32_t i = 0; i < kArtnetTodUidsMax; ++i) data.uids.push_back({1, i});
  const Octets whole = build_artnet_rdm_packet(data);
  REQUIRE(whole.size() <= kDatagramBytesMax);
  const auto parsed = parse_artnet_rdm_packet(whole);
  REQUIRE(parsed.has_value());
  const auto& got = std::get<ArtnetTodData>(*parsed);
  CHECK(got.port_address == 0x7FFF);
  CHECK(got.port == 4);
  CHECK(got.bind_index == 9);
  CHECK_FALSE(got.available);
  CHECK(got.total == 999);
  CHECK(got.block == 3);
  CHECK(got.uids == data.uids);

  RdmMessage message;
  message.to = {1, 2};
  const std::vector<Octets> seeds = {whole, build_artnet_rdm_packet(ArtnetTodRequest{{1, 2, 3}}),
                                     build_artnet_rdm_packet(ArtnetTodControl{7, true}),
                                     build_artnet_rdm_packet(ArtnetRdm{7, build_rdm(message)})};
  std::mt19937 random(6);
  int accepted = 0;
  for (int i = 0; i < 20'000; ++i) {
    Octets bytes = seeds[random() % seeds.size()];
    for (std::size_t f = 0; f < random() % 4; ++f) bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    if (random() % 3 == 0) bytes.resize(random() % (bytes.size() + 1));
    const Octets exact(bytes.begin(), bytes.end());
    const auto packet = parse_artnet_rdm_packet(exact);
    if (!packet) continue;
    ++accepted;
    if (const auto* tod = std::get_if<ArtnetTodData>(&*packet)) REQUIRE(tod->uids.size() <= kArtnetTodUidsMax);
    if (const auto* rdm = std::get_if<ArtnetRdm>(&*packet)) REQUIRE(rdm->message.size() <= kRdmMessageSizeMax);
  }
  CHECK(accepted > 1'000);
}

TEST_CASE("devices behind a gateway are listed from its table, read and set through it") {
  if (!testing::enter_private_network()) return;
  SystemClock clock;
  Gateway gateway;
  gateway.start();
  const auto line = open_line(clock);
  const auto found = line->discover();
  REQUIRE_MESSAGE(found.has_value(), (found ? std::string() : found.error().message));
  REQUIRE(found->size() == 3);
  const RdmUid spot = (*found)[1].uid;
  RdmController controller(*line, clock, kOwn);
  CHECK(rdm_text(controller.get(spot, kRdmDeviceLabel, {}, "DEVICE_LABEL").value()) == "Spot stage left");
  REQUIRE(controller.set(spot, kRdmDeviceLabel, Octets{'N', 'o', 'w'}, "DEVICE_LABEL").has_value());
  CHECK(rdm_text(controller.get(spot, kRdmDeviceLabel, {}, "DEVICE_LABEL").value()) == "Now");
}

TEST_CASE("a gateway with an empty table gets a search command") {
  if (!testing::enter_private_network()) return;
  SystemClock clock;
  Gateway gateway;
  gateway.table_is_empty = true;
  gateway.start();
  const auto found = open_line(clock)->discover();
  REQUIRE(found.has_value());
  CHECK(found->size() == 3);
}

TEST_CASE("a device that does not answer through a gateway gives no message after the timeout, and no error") {
  if (!testing::enter_private_network()) return;
  SystemClock clock;
  Gateway gateway;
  gateway.is_mute = true;
  gateway.start();
  const auto line = open_line(clock, 100 * kNsPerMs);
  RdmMessage request;
  request.to = {1, 2};
  request.from = kOwn;
  const TimeNs begin_ns = clock.now_ns();
  const auto answer = line->transact(request);
  REQUIRE(answer.has_value());
  CHECK_FALSE(answer->has_value());
  CHECK(clock.now_ns() - begin_ns >= 100 * kNsPerMs);
}

TEST_CASE("endpoints that are not one universe of one Art-Net address are refused for RDM, with an example") {
  SystemClock clock;
  for (const char* const wrong : {"artnet:1", "artnet:1-2@10.0.0.7", "artnet:1@10.0.0.7,10.0.0.8", "sacn:1@10.0.0.7"}) {
    const auto endpoint = parse_endpoint(wrong, {});
    REQUIRE(endpoint.has_value());
    const auto refused = open_artnet_rdm_line(*endpoint, clock);
    REQUIRE_FALSE(refused.has_value());
    CHECK(refused.error().code == ErrorCode::kBadInput);
    CHECK(refused.error().message.find("as in artnet:1@10.0.0.7") != std::string::npos);
  }
}

}  // namespace footlight::drivers
