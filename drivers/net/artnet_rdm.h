// The RDM line behind an Art-Net gateway: the gateway does the discovery, and messages pass through it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "drivers/net/artnet_rdm_packet.h"
#include "drivers/net/udp.h"
#include "drivers/rdm/rdm_line.h"
#include "sim/core/clock.h"
#include "sim/core/endpoint.h"
#include "sim/core/result.h"

namespace footlight::drivers {

class ArtnetRdmLine final : public RdmLine {
 public:
  struct Options {
    std::string name;            // starts messages
    std::uint32_t gateway = 0;   // IPv4
    std::uint16_t udp_port = 0;  // of the gateway, and of our socket if available
    int port_address = 0;
    DurationNs answer_timeout_ns = 2 * kNsPerS;      // of one message: the gateway may serve other controllers
    DurationNs discovery_timeout_ns = 15 * kNsPerS;  // of a full search
  };
  // The clock outlives it.
  [[nodiscard]] static Result<std::unique_ptr<ArtnetRdmLine>> open(const Options& options, Clock& clock);

  [[nodiscard]] Result<std::optional<RdmMessage>> transact(const RdmMessage& request) override;
  // The gateway's table. If it is empty, requests a search and waits for it. kTimeout: the gateway does not answer.
  [[nodiscard]] Result<std::vector<RdmFound>> discover() override;

 private:
  ArtnetRdmLine(const Options& options, Fd socket, Clock& clock)
      : options_(options), socket_(std::move(socket)), clock_(clock) {}
  Status send(const ArtnetRdmPacket& packet);
  // Passes packets of the gateway to `take` until it returns true (returns true) or the deadline has passed.
  Result<bool> listen(TimeNs deadline_ns, const std::function<bool(const ArtnetRdmPacket&)>& take);

  Options options_;
  Fd socket_;
  Clock& clock_;
  DatagramReader reader_;
};

// From an endpoint with one universe and one address. kBadInput names what was expected.
[[nodiscard]] Result<std::unique_ptr<RdmLine>> open_artnet_rdm_line(const Endpoint& endpoint, Clock& clock);

}  // namespace footlight::drivers
