// Arbitrary octets of an RDM line, and of RDM over Art-Net.
//
// An accepted message is encoded to the same octets; an answer to discovery has a UID whose own answer parses to it;
// the data of a message in every format becomes text or an error.
#include <algorithm>

#include "drivers/net/artnet_rdm_packet.h"
#include "drivers/rdm/rdm_packet.h"
#include "drivers/rdm/rdm_parameters.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight;
using namespace footlight::drivers;
using footlight::testing::require;

void footlight::testing::add_seeds(Seeds& seeds) {
  RdmMessage message;
  message.to = {0x02B0, 0x0001'2345};
  message.from = {0x7FF0, 1};
  message.command = RdmCommand::kGetResponse;
  message.port_or_type = 0;
  message.parameter = kRdmDeviceInfo;
  message.data = {1, 0, 0, 7, 1, 2, 0, 1, 2, 3, 0, 16, 2, 3, 0, 17, 0, 0, 1};
  seeds.add("device-info", build_rdm(message));
  message.parameter = kRdmDeviceLabel;
  message.data = {'F', 'O', 'H'};
  seeds.add("label", build_rdm(message));
  seeds.add("artnet-rdm", build_artnet_rdm_packet(ArtnetRdm{0x123, build_rdm(message)}));
  seeds.add("discovery", build_discovery_answer(message.to));
  seeds.add("discovery-bare", build_discovery_answer(message.to, 0));
  ArtnetTodData data;
  data.total = 2;
  data.uids = {message.to, message.from};
  seeds.add("artnet-tod-data", build_artnet_rdm_packet(data));
  seeds.add("artnet-tod-request", build_artnet_rdm_packet(ArtnetTodRequest{{1, 2}}));
  seeds.add("artnet-tod-control", build_artnet_rdm_packet(ArtnetTodControl{1, true}));
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> bytes(data, size);
  if (const auto message = parse_rdm_message(bytes)) {
    const Octets again = build_rdm(*message);
    require(again.size() <= size && std::equal(again.begin(), again.end(), bytes.begin()));
    for (int form = 0; form <= static_cast<int>(RdmForm::kPowerState); ++form) {
      const auto fields = rdm_fields(static_cast<RdmForm>(form), message->data, "fuzz");
      if (!fields) continue;
      for (const RdmField& field : *fields) {
        for (const char c : field.text) require(c >= 0x20 && c < 0x7F);
      }
    }
  }
  if (const auto uid = parse_discovery_answer(bytes)) {
    require(parse_discovery_answer(build_discovery_answer(*uid)) == uid);
  }
  if (const auto packet = parse_artnet_rdm_packet(bytes)) {
    if (const auto* tod = std::get_if<ArtnetTodData>(&*packet)) require(tod->uids.size() <= kArtnetTodUidsMax);
    if (const auto* rdm = std::get_if<ArtnetRdm>(&*packet)) require(rdm->message.size() <= kRdmMessageSizeMax);
  }
  return 0;
}
